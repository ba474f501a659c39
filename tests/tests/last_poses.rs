//! A robot whose power was cut knows where it was, and looks for itself there first; one that was carried meanwhile is not misled.

use hal_sim::random_home::random_home;
use hal_sim::{Plan, Pose2, SimOptions};
use lab::input::built_in_robot;
use lab::input::rig_file::Robot;
use lab::input::settings::by_default;
use lab::run::{Drive, MapId, Session, clean};
use robot::FLOOR_RECORD_BYTES;
use tests::carries::carried;

/// Random homes.
const HOMES: std::ops::RangeInclusive<u64> = 513..=536;

/// What a robot has after its power was cut, and where it is in the plan.
struct Cut {
    map: Vec<u8>,
    job: Option<[u8; FLOOR_RECORD_BYTES]>,
    pose: Option<Vec<u8>>,
    at: Pose2,
}

fn begin(robot: &Robot) -> Session {
    Session::new(robot, by_default(robot), "power").expect("a rig")
}

/// Cuts the power of a robot that sweeps a second time, in this map of the first, after four minutes; of one that stands where that is asked for.
fn cut(plan: &Plan, robot: &Robot, map: &[u8], stands: bool) -> Cut {
    let mut session = begin(robot);
    session.begin_in(map.to_vec()).expect("a map of its own");
    let after_s = 240.0;
    let mut drive = Drive::cleaning(plan, robot, SimOptions::default(), 1).expect("it fits");
    while drive.step(&mut session).t_s < after_s {}
    if stands {
        drive.job().pause();
        while drive.step(&mut session).t_s < after_s + 2.0 {}
    }
    let map = session.map().expect("a map");
    let pose = session.pose_in(MapId::of(&map).expect("a whole map"));
    let job = drive.job_in(MapId::of(&map).expect("a whole map"));
    Cut { map, job, pose: pose.map(Vec::from), at: drive.simulation().pose_in_plan() }
}

/// When a robot that begins here knows its place, seconds, and how far off it is then, metres; it has this record of where it was.
fn find(plan: &Plan, robot: &Robot, cut: &Cut, at: Pose2, record: &[u8]) -> Option<(f64, f64)> {
    let mut session = begin(robot);
    session.begin_in(cut.map.clone()).expect("a map of its own");
    let id = MapId::of(&cut.map).expect("a whole map");
    session.recall(id, record);
    let options = SimOptions { start: Some(at), ..SimOptions::default() };
    let mut drive = Drive::cleaning(plan, robot, options, 2).expect("it fits");
    drive.go_on_with(id, &cut.job.expect("a job")).expect("the job in this map");
    for _ in 0..25 * 240 {
        let t_s = drive.step(&mut session).t_s;
        if session.is_located() {
            let error = session.recording().steps.last().and_then(lab::recording::Step::error).expect("a true pose");
            return Some((t_s, error.x_m.hypot(error.y_m)));
        }
    }
    None
}

#[test]
fn after_a_power_cut_it_finds_itself_sooner_where_it_was_and_not_in_a_wrong_place_elsewhere() {
    let (robot, _) = built_in_robot().expect("the built-in robot");
    // Seconds with and without the record, of robots that stood and that drove, and what was found after others were carried.
    let (mut times_s, mut carried_off) = ([[0.0; 2]; 2], Vec::new());
    for home in HOMES {
        let plan = random_home(home);
        let map = clean(&plan, SimOptions::default(), 1).expect("it fits").map.expect("a map");
        for (stands, sum_s) in [true, false].into_iter().zip(&mut times_s) {
            let cut = cut(&plan, &robot, &map, stands);
            let pose = cut.pose.clone().expect("it knows where it is");
            let mut torn = pose.clone();
            torn[20] ^= 1;
            let [with, without, damaged] = [&pose[..], &[], &torn]
                .map(|record| find(&plan, &robot, &cut, cut.at, record).expect("it finds itself"));
            assert_eq!(without, damaged, "a damaged record says nothing");
            // The drive is the same until it claims a place, and nothing speaks against the right one that did not before.
            assert!(with.0 <= without.0, "random-{home}: {with:?} {without:?}");
            assert!(with.1 < 0.3 && without.1 < 0.3, "random-{home}: {with:?} {without:?}");
            *sum_s = [sum_s[0] + with.0, sum_s[1] + without.0];
            if stands {
                carried_off.extend(find(&plan, &robot, &cut, carried(&plan, home).start, &pose));
            }
        }
    }
    assert!(times_s.iter().all(|[with_s, without_s]| with_s < without_s), "{times_s:?}");
    let [with_s, without_s] = [0, 1].map(|i| times_s[0][i] + times_s[1][i]);
    assert!(with_s < 0.75 * without_s, "{times_s:?}");
    assert!(carried_off.len() >= 10 && carried_off.iter().all(|(_, off_m)| *off_m < 0.3), "{carried_off:?}");
}

#[test]
fn a_robot_that_is_lifted_searching_or_on_probation_knows_no_last_pose() {
    let (robot, _) = built_in_robot().expect("the built-in robot");
    let plan = random_home(501);
    let map = clean(&plan, SimOptions::default(), 1).expect("it fits").map.expect("a map");
    let id = MapId::of(&map).expect("a whole map");
    let mut session = begin(&robot);
    session.begin_in(map).expect("a map of its own");
    let mut drive = Drive::cleaning(&plan, &robot, SimOptions::default(), 2).expect("it fits");
    let mut path_m = 0.0;
    let mut found = None;
    // Sure of its place three metres after it claimed it.
    while session.pose_in(id).is_none() {
        let before = drive.simulation().pose();
        let t_s = drive.step(&mut session).t_s;
        assert!(t_s < 240.0, "it finds itself");
        if session.is_located() {
            found.get_or_insert(t_s);
            let now = drive.simulation().pose();
            path_m += (now.x_m - before.x_m).hypot(now.y_m - before.y_m);
        }
    }
    assert!(found.is_some() && (2.5..4.0).contains(&path_m), "{path_m}");
    // A wheel that hangs for half a second is over a threshold.
    (0..12).for_each(|_| session.lift(true));
    assert!(session.pose_in(id).is_some());
    session.lift(true);
    assert_eq!(session.pose_in(id), None);
}
