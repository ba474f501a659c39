//! The kept map is fetched, forgotten and given back over the line, and a robot that drives or a record that is damaged changes
//! nothing.
//!
//! One test only: the clock is one for the whole process.

mod common;

use common::home::{Home, Tasks};
use common::ranges::Ranges;
use kept_map::Record;
use robot::rig::BuiltIn;
use wire::{Command, Frame, MapAnswer, MapRefusal, MapRequest, PIECE_BYTES, Place, PlaceState, encode};

/// What the robot said last of its place, and its answers.
fn heard(home: &Home) -> (Option<Place>, Vec<MapAnswer>) {
    let (mut place, mut answers) = (None, Vec::new());
    for frame in home.heard() {
        match frame {
            Frame::Place(said) => place = Some(said),
            Frame::MapAnswer(answer) => answers.push(answer),
            _ => {}
        }
    }
    (place, answers)
}

/// Asks and waits for the answer, three seconds at most.
fn ask(home: &Home, tasks: &mut Tasks<'_>, request: MapRequest) -> MapAnswer {
    home.say(&encode(&Frame::MapRequest(request)).unwrap());
    for _ in 0..75 {
        tasks.drive(0.04);
        if let Some(answer) = heard(home).1.pop() {
            return answer;
        }
    }
    panic!("no answer");
}

fn get(home: &Home, tasks: &mut Tasks<'_>) -> Vec<u8> {
    let mut got = Vec::new();
    loop {
        match ask(home, tasks, MapRequest::Get { offset: got.len() as u32 }) {
            MapAnswer::Part { offset, of, bytes } => {
                assert_eq!(offset as usize, got.len());
                got.extend(bytes);
                if got.len() == of as usize {
                    return got;
                }
            }
            other => panic!("{other:?}"),
        }
    }
}

/// Puts a record; the answer to its last piece, or the first one that is no request for more.
fn put(home: &Home, tasks: &mut Tasks<'_>, record: &[u8]) -> MapAnswer {
    let mut next = 0;
    loop {
        let bytes = record[next..].iter().take(PIECE_BYTES).copied().collect();
        let answer = ask(home, tasks, MapRequest::Put { offset: next as u32, bytes });
        match answer {
            MapAnswer::Awaiting { offset } if (offset as usize) < record.len() => {
                assert!(!home.enabled.get(), "the motors are off");
                next = offset as usize;
            }
            _ => return answer,
        }
    }
}

#[test]
fn a_map_is_fetched_forgotten_and_given_back() {
    let home = Home::new("flat", BuiltIn::Sharp);
    home.run(BuiltIn::Sharp, Ranges(home.board.range_sensors()), |tasks| {
        assert_eq!(ask(&home, tasks, MapRequest::Get { offset: 0 }), MapAnswer::Refused(MapRefusal::Nothing));
        home.command(Command::Start);
        tasks.drive(120.0);
        home.command(Command::Stop);
        tasks.drive(3.0);
        assert!(heard(&home).0.unwrap().saves > 0);

        // While it drives, the map can be fetched, and nothing is written.
        home.command(Command::Start);
        tasks.drive(2.0);
        let map = get(&home, tasks);
        let record = Record::parse(&map).expect("a record");
        assert_eq!(4 * record.words(), map.len());
        let driving = MapAnswer::Refused(MapRefusal::Driving);
        assert_eq!(put(&home, tasks, &map), driving);
        assert_eq!(ask(&home, tasks, MapRequest::Forget), driving);
        assert!(home.enabled.get(), "and the motors stay on");

        home.command(Command::Stop);
        tasks.drive(3.0);
        // Damaged in the middle, of another rig, cut short: what was kept is kept.
        for (place, why) in [(map.len() / 2, MapRefusal::Damaged), (20, MapRefusal::OtherRig), (0, MapRefusal::Foreign)]
        {
            let mut spoilt = map.clone();
            spoilt[place] ^= 0x10;
            assert_eq!(put(&home, tasks, &spoilt), MapAnswer::Refused(why));
        }
        assert_eq!(put(&home, tasks, &map[..3 * PIECE_BYTES]), MapAnswer::Awaiting { offset: 3 * PIECE_BYTES as u32 });
        tasks.drive(4.0);
        let late = MapRequest::Put { offset: 3 * PIECE_BYTES as u32, bytes: [0; 4].into_iter().collect() };
        assert_eq!(ask(&home, tasks, late), MapAnswer::Awaiting { offset: 0 }, "what was begun is dropped");
        assert!(Record::parse(&get(&home, tasks)).is_ok());

        assert_eq!(ask(&home, tasks, MapRequest::Forget), MapAnswer::Forgotten);
        tasks.drive(5.0);
        let fresh = heard(&home).0.unwrap();
        assert_eq!((fresh.state, fresh.sequence), (PlaceState::Fresh, 0), "and it is not saved again as it stands");
        assert_eq!(ask(&home, tasks, MapRequest::Get { offset: 0 }), MapAnswer::Refused(MapRefusal::Nothing));

        assert_eq!(put(&home, tasks, &map), MapAnswer::Kept { sequence: 1 });
        assert!(Record::parse(&get(&home, tasks)).is_ok());
        tasks.drive(2.0);
        assert_eq!(heard(&home).0.unwrap().state, PlaceState::Searching);
        home.command(Command::Start);
        for _ in 0..20 {
            tasks.drive(10.0);
            if heard(&home).0.unwrap().state == PlaceState::Tracking {
                return;
            }
        }
        panic!("not found");
    });
}
