//! A robot that stands in its dock knows where it looks for itself first; one whose dock was moved is not misled for long.

use hal_sim::random_home::{random_home, with_dock};
use hal_sim::{Plan, SimOptions};
use kept_map::Record;
use lab::input::built_in_robot;
use lab::input::settings::by_default;
use lab::run::{Drive, Session, clean};
use slam_core::kept::Kept;

/// Random homes whose robot has a dock, and their docks' seeds.
const HOMES: std::ops::RangeInclusive<u64> = 501..=506;

/// When a robot that begins its job in this map knows its place, seconds, and how far off it is then, metres, by the plan that the map is of.
fn find(plan: &Plan, mapped: &Plan, map: &[u8]) -> Option<(f64, f64)> {
    let (robot, _) = built_in_robot().expect("the built-in robot");
    let mut session = Session::new(&robot, by_default(&robot), "dock").expect("a rig");
    session.begin_in(map.to_vec()).expect("a map of its own");
    let mut drive = Drive::cleaning(plan, &robot, SimOptions::default(), 2).expect("it fits");
    for _ in 0..25 * 300 {
        let t_s = drive.step(&mut session).t_s;
        if session.is_located() {
            let truth = mapped.start.relative(&drive.simulation().pose_in_plan());
            let estimate = session.slam().start_pose().inverse().compose(&session.slam().pose());
            return Some((t_s, (truth.x_m - f64::from(estimate.x_m)).hypot(truth.y_m - f64::from(estimate.y_m))));
        }
    }
    None
}

#[test]
fn in_its_dock_it_finds_itself_within_metres_and_in_a_moved_one_where_it_is() {
    let (mut docked, mut moved) = (Vec::new(), Vec::new());
    for home in HOMES {
        let plan = with_dock(&random_home(home), home).expect("a wall with room for a dock");
        let map = clean(&plan, SimOptions::default(), 1).expect("it fits").map.expect("a map");
        assert!(Record::whole(&map).expect("a record").frame().has_dock, "random-{home}");
        docked.push(find(&plan, &plan, &map).expect("it finds itself"));
        let elsewhere = with_dock(&random_home(home), home + 1000).expect("another place for a dock");
        moved.extend(find(&elsewhere, &plan, &map));
    }
    docked.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert!(docked[docked.len() / 2].0 < 25.0, "{docked:?}");
    assert!(docked.iter().all(|(_, off_m)| *off_m < 0.15), "{docked:?}");
    assert!(moved.len() >= 5, "{moved:?}");
    assert!(moved.iter().filter(|(_, off_m)| *off_m > 0.3).count() <= 1, "{moved:?}");
}
