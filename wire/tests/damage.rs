//! Frames survive the line or are refused: none arrives changed.

use proptest::prelude::*;
use slam_core::RangeInput;
use wire::{
    BoardFaults, Calibration, Command, Contacts, Decoder, Estimate, Factor, Faults, Floor, Frame, Health, LookBack,
    MapAnswer, MapRefusal, MapRequest, Motors, Parameter, Place, PlaceState, Range, Sample, SlamFaults, Wall, WallKind,
    encode,
};

fn sample() -> impl Strategy<Value = Frame> {
    let range =
        prop_oneof![Just(Range::Missing), any::<u16>().prop_map(Range::Counts), any::<f32>().prop_map(Range::Metres)];
    let ranges = prop::collection::vec(range, 0..=wire::SENSORS);
    (any::<u64>(), any::<[i32; 2]>(), ranges, any::<[bool; 5]>()).prop_map(|(time_us, ticks, ranges, touched)| {
        let [bump_left, bump_right, cliff, lifted, docked] = touched;
        Frame::Sample(Sample {
            time_us,
            left_ticks: ticks[0],
            right_ticks: ticks[1],
            ranges: ranges.into_iter().collect(),
            contacts: Contacts { bump_left, bump_right, cliff, lifted, docked },
        })
    })
}

fn estimate() -> impl Strategy<Value = Frame> {
    let health = prop::sample::select(vec![Health::Well, Health::Unexplained, Health::Degenerate]);
    (any::<u64>(), any::<[f32; 12]>(), any::<Option<[f32; 2]>>(), any::<u8>(), health, any::<[u32; 2]>()).prop_map(
        |(time_us, f, alpha, walls, health, [epoch, late_us])| {
            Frame::Estimate(Estimate {
                time_us,
                pose: [f[0], f[1], f[2]],
                covariance: [f[3], f[4], f[5], f[6], f[7], f[8]],
                alpha,
                dead_reckoning: [f[9], f[10], f[11]],
                walls,
                health,
                epoch,
                late_us,
            })
        },
    )
}

fn wall() -> impl Strategy<Value = Frame> {
    let kind = prop::sample::select(vec![WallKind::Free, WallKind::Snapped, WallKind::Grid]);
    (any::<[u8; 2]>(), any::<u16>(), kind, any::<[f32; 5]>(), any::<u32>()).prop_map(|(place, id, kind, f, updates)| {
        let [rho_m, beta_rad, lo_m, hi_m, sigma_rho_m] = f;
        let [index, of] = place;
        Frame::Wall(Wall { index, of, id, kind, rho_m, beta_rad, lo_m, hi_m, sigma_rho_m, updates })
    })
}

fn calibration() -> impl Strategy<Value = Frame> {
    let factor = (any::<u8>(), any::<[f32; 2]>()).prop_map(|(sensor, [estimate, sigma])| Factor {
        parameter: if sensor == 0 { Parameter::Track } else { Parameter::Gain(sensor) },
        estimate,
        sigma,
    });
    prop::collection::vec(factor, 0..=11)
        .prop_map(|factors| Frame::Calibration(Calibration { factors: factors.into_iter().collect() }))
}

fn faults() -> impl Strategy<Value = Frame> {
    (any::<[u32; slam_core::Refusal::COUNT]>(), any::<[u32; 4]>()).prop_map(|(refused, c)| {
        let slam = SlamFaults { refused, steps: c[0], bad_motion: c[1], ..SlamFaults::default() };
        let board = BoardFaults { ranges_failed: c[2], late_tasks: c[3], ..BoardFaults::default() };
        Frame::Faults(Faults { slam, board })
    })
}

fn look_back() -> impl Strategy<Value = Frame> {
    (any::<[u16; 2]>(), any::<bool>(), any::<[u32; 5]>(), any::<[u32; slam_core::NotTaken::COUNT]>()).prop_map(
        |([keyframes, groups], is_working, [done, fruitless, outdated, taken_over, late], not_taken)| {
            let diary = LookBack { keyframes, groups, is_working, ..LookBack::default() };
            Frame::LookBack(LookBack { done, fruitless, outdated, taken_over, not_taken, late, ..diary })
        },
    )
}

fn place() -> impl Strategy<Value = Frame> {
    let state = prop::sample::select(vec![PlaceState::Fresh, PlaceState::Searching, PlaceState::Doubtful]);
    (state, any::<[u32; 5]>(), any::<Option<f32>>()).prop_map(
        |(state, [sequence, saves, failed, found, lost], log_odds)| {
            Frame::Place(Place { state, sequence, saves, failed, found, lost, log_odds })
        },
    )
}

fn floor() -> impl Strategy<Value = Frame> {
    (any::<u8>(), any::<[f32; 2]>(), any::<u32>())
        .prop_map(|(state, [swept_m2, left_m2], seconds)| Frame::Floor(Floor { state, swept_m2, left_m2, seconds }))
}

fn kept_map() -> impl Strategy<Value = Frame> {
    let piece = prop::collection::vec(any::<u8>(), 0..=wire::PIECE_BYTES);
    let why = prop::sample::select(vec![MapRefusal::Nothing, MapRefusal::Driving, MapRefusal::Flash]);
    (any::<[u32; 2]>(), piece, why, 0..8).prop_map(|([offset, of], piece, why, which)| {
        let bytes = piece.into_iter().collect();
        match which {
            0 => Frame::MapRequest(MapRequest::Get { offset }),
            1 => Frame::MapRequest(MapRequest::Put { offset, bytes }),
            2 => Frame::MapRequest(MapRequest::Forget),
            3 => Frame::MapAnswer(MapAnswer::Part { offset, of, bytes }),
            4 => Frame::MapAnswer(MapAnswer::Awaiting { offset }),
            5 => Frame::MapAnswer(MapAnswer::Kept { sequence: of }),
            6 => Frame::MapAnswer(MapAnswer::Forgotten),
            _ => Frame::MapAnswer(MapAnswer::Refused(why)),
        }
    })
}

fn small() -> impl Strategy<Value = Frame> {
    (any::<u64>(), any::<[f32; 2]>(), 0..6).prop_map(|(time_us, [left, right], which)| match which {
        0 => Frame::Motors(Motors { time_us, left, right }),
        1 => Frame::Command(Command::Spin { left, right }),
        2 => Frame::Command(Command::Start),
        3 => Frame::Command(Command::Stop),
        4 => Frame::Command(Command::Clean { anew: time_us % 2 == 0 }),
        _ => Frame::Command(Command::ResetMap),
    })
}

fn frame() -> impl Strategy<Value = Frame> {
    prop_oneof![
        sample(),
        estimate(),
        wall(),
        calibration(),
        faults(),
        look_back(),
        place(),
        floor(),
        kept_map(),
        small()
    ]
}

/// The frames found in a stream, errors left out.
fn received(bytes: &[u8]) -> Vec<Frame> {
    let mut decoder = Decoder::new();
    bytes.iter().filter_map(|byte| decoder.push(*byte)).filter_map(Result::ok).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn a_frame_arrives_as_it_was_sent(frame in frame()) {
        prop_assert_eq!(received(&encode(&frame).unwrap()), vec![frame]);
    }

    #[test]
    fn a_damaged_frame_is_refused_and_the_next_arrives(
        first in frame(), second in frame(), at in any::<prop::sample::Index>(), flip in 1..=u8::MAX,
    ) {
        let mut stream = encode(&first).unwrap().to_vec();
        let at = at.index(stream.len() - 1);
        stream[at] ^= flip;
        stream.extend(encode(&second).unwrap());
        let frames = received(&stream);
        prop_assert!(frames.iter().all(|frame| *frame == second), "{:?}", frames);
        prop_assert!(!frames.is_empty());
    }

    #[test]
    fn lost_bytes_lose_frames_but_change_none(
        frames in prop::collection::vec(frame(), 1..6), lost in prop::collection::vec(any::<prop::sample::Index>(), 1..4),
    ) {
        let mut stream: Vec<u8> = frames.iter().flat_map(|frame| encode(frame).unwrap()).collect();
        for index in lost {
            stream.remove(index.index(stream.len()));
        }
        prop_assert!(received(&stream).iter().all(|frame| frames.contains(frame)));
    }

    #[test]
    fn noise_before_a_frame_costs_no_more_than_the_noise(
        noise in prop::collection::vec(any::<u8>(), 0..1000), frame in frame(),
    ) {
        let mut stream = noise;
        stream.push(0);
        stream.extend(encode(&frame).unwrap());
        let frames = received(&stream);
        prop_assert_eq!(frames.last(), Some(&frame));
    }
}

#[test]
fn the_longest_frames_fit() {
    let factor = Factor { parameter: Parameter::Gain(255), estimate: -1e-30, sigma: 1e30 };
    let calibration = Calibration { factors: (0..11).map(|_| factor).collect() };
    let counts = SlamFaults {
        steps: u32::MAX,
        updates: u32::MAX,
        refused: [u32::MAX; slam_core::Refusal::COUNT],
        buffered: u32::MAX,
        overwritten: u32::MAX,
        births: u32::MAX,
        map_full: u32::MAX,
        merges: u32::MAX,
        prunes: u32::MAX,
        bad_motion: u32::MAX,
        restarts: u32::MAX,
    };
    let board = BoardFaults {
        ranges_failed: u32::MAX,
        encoders_failed: u32::MAX,
        motors_failed: u32::MAX,
        samples_dropped: u32::MAX,
        frames_dropped: u32::MAX,
        commands_dropped: u32::MAX,
        bytes_lost: u32::MAX,
        contact_stops: u32::MAX,
        dead_man_stops: u32::MAX,
        watchdog_resets: u32::MAX,
        late_tasks: u32::MAX,
        stack_used_bytes: u32::MAX,
    };
    let sample = Sample {
        time_us: u64::MAX,
        left_ticks: i32::MIN,
        right_ticks: i32::MIN,
        ranges: [Range::Metres(f32::MIN); wire::SENSORS].into_iter().collect(),
        contacts: Contacts::default(),
    };
    let faults = Faults { slam: counts, board };
    let bytes = [0xAA; wire::PIECE_BYTES].into_iter().collect();
    let part = Frame::MapAnswer(MapAnswer::Part { offset: u32::MAX, of: u32::MAX, bytes });
    for frame in [Frame::Sample(sample), Frame::Calibration(calibration), Frame::Faults(faults), part] {
        assert_eq!(received(&encode(&frame).unwrap()), [frame]);
    }
}

#[test]
fn both_kinds_of_range_reach_the_estimator() {
    let ranges = [Range::Counts(1234), Range::Missing, Range::Metres(0.75)];
    let sample = Sample { ranges: ranges.into_iter().collect(), ..Sample::default() };
    let [Frame::Sample(heard)] = &received(&encode(&Frame::Sample(sample)).unwrap())[..] else { panic!("one sample") };
    let inputs = heard.to_slam().ranges;
    assert_eq!(inputs[..3], [RangeInput::Counts(1234), RangeInput::Missing, RangeInput::Metres(0.75)]);
    assert!(inputs[3..].iter().all(|input| *input == RangeInput::Missing));
    let sent = Sample::of(&heard.to_slam()).expect("it has encoders");
    assert_eq!(sent.ranges[..3], ranges);
    assert_eq!(sent.to_slam(), heard.to_slam());
    let travelled = slam_core::Motion::Increment(slam_core::Increment::default());
    assert_eq!(Sample::of(&slam_core::Sample { motion: travelled, ..heard.to_slam() }), None);
}
