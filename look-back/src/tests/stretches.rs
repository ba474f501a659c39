use slam_core::{Increment, Pose};

use super::drive::DRIVE;
use super::groups::gains;
use super::random::Random;
use crate::gains::Gains;
use crate::group::Group;
use crate::{Diary, Hit, LookBack, Progress, border_len, packed_len};

const W: usize = 8;
const B: usize = border_len(W);
type SmallDiary = Diary<64, 256, W>;
type Small = LookBack<64, W, B, { packed_len(B) }>;

/// A corridor along x, before the middle of its wall a shelf: the wall's number, its ends, metres.
const FACES: [(u16, [[f64; 2]; 2]); 5] = [
    (0, [[-4.0, 1.5], [-0.7, 1.5]]),
    (0, [[0.7, 1.5], [4.0, 1.5]]),
    (1, [[-0.7, 1.35], [0.7, 1.35]]),
    (2, [[4.0, -1.0], [4.0, 1.5]]),
    (3, [[-4.0, -1.0], [-4.0, 1.5]]),
];

/// Noise of the beams: where two walls are so near to each other is known to the thirtieth part of what is between them.
const SIGMA_M: f64 = 0.03;

/// Directions of the beams.
const BEAMS: [f64; 7] = [-0.2, 0.2, 0.8, 1.57, 2.34, 2.94, 3.34];

/// The wall that a beam meets, and how far away that is, metres.
fn look(x_m: f64, beam: f64) -> Option<(u16, f64)> {
    let (sin, cos) = beam.sin_cos();
    let met = FACES.iter().filter_map(|(wall, [a, b])| {
        let is_across = (a[0] - b[0]).abs() > 0.0;
        let range_m = if is_across { a[1] / sin } else { (a[0] - x_m) / cos };
        let [at, ends] = if is_across { [x_m + range_m * cos, 0.0] } else { [range_m * sin, 1.0] };
        let axis = ends as usize;
        (range_m > 0.0 && range_m < 3.0 && a[axis] <= at && at <= b[axis]).then_some((*wall, range_m))
    });
    met.min_by(|a, b| a.1.total_cmp(&b.1))
}

#[test]
fn a_shelf_stays_before_its_wall() {
    for gains in [Gains::KNOWN, gains(BEAMS.len())] {
        drive_past(gains);
    }
}

fn drive_past(gains: Gains) {
    let (mut random, mut diary) = (Random(1), SmallDiary::IDLE);
    diary.begin(&DRIVE, gains, Pose::ORIGIN);
    let mut look_back = Small::new();
    let (mut x_m, mut ahead) = (0.0f64, 0.04);
    for step in 0..2000 {
        ahead = if x_m.abs() > 2.5 { -0.04 * x_m.signum() } else { ahead };
        x_m += ahead;
        diary.travel(&Increment { forward_m: ahead as f32, left_m: 0.0, turn_rad: 0.0 });
        if diary.is_due() {
            diary.begin_keyframe(&Pose::new(x_m as f32, 0.0, 0.0));
        }
        for (sensor, beam) in BEAMS.iter().enumerate() {
            let Some((wall, range_m)) = look(x_m, *beam) else { continue };
            let range_m = range_m + SIGMA_M * random.normal();
            let end_m = [(range_m * beam.cos()) as f32, (range_m * beam.sin()) as f32];
            let variance_m2 = (SIGMA_M * SIGMA_M) as f32;
            diary.hit(&Hit {
                from_m: [0.0; 2],
                end_m,
                variance_m2,
                alike: 1.0,
                sensor: sensor as u8,
                wall: Some(wall),
            });
        }
        if step % 200 == 199 {
            look_back.begin(&diary);
            assert_eq!(look_back.work(&mut diary, u32::MAX), Progress::Done);
            let seen: std::vec::Vec<_> = diary.walls().filter(|(_, wall)| wall.hits > 0).collect();
            assert_eq!(seen.len(), 4, "after {step} steps: {seen:?}");
        }
    }
    assert!(diary.losses().thinned > 100, "{:?}", diary.losses());
    let behind = diary.walls().map(|(_, wall)| wall.rho_m).filter(|rho_m| (rho_m - 1.5).abs() < 0.01).count();
    assert_eq!(behind, 1, "{:?}", diary.walls().collect::<std::vec::Vec<_>>());
}

#[test]
fn hits_beside_a_gap_are_several_stretches_and_stay_so() {
    let along = |from_m: f32, to_m: f32| {
        let at = |i: u8| [from_m + f32::from(i) / 10.0 * (to_m - from_m), 1.0];
        let one = |i: u8| Group::of([0.0; 2], at(i), 1e4, 1.0, 0);
        (1..=10).fold(one(0), |mut all, i| {
            all.add(&one(i));
            all
        })
    };
    let (mut left, right) = (along(-1.5, -0.5), along(0.5, 1.5));
    assert!(left.is_one_stretch_with(&along(-0.3, 0.2)) && !left.is_one_stretch_with(&right));
    left.take_in(right, &Gains::KNOWN);
    assert!(!left.is_stretch() && left.sensor() == 0);
    left.take_in(along(-0.5, 0.5), &Gains::KNOWN);
    assert!(!left.is_stretch() && left.hits == 33);
}
