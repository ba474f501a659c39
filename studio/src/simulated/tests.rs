use super::*;

fn scene(plan: &str) -> Scene {
    Scene { plan: plan.into(), seed: 1, ..Scene::default() }
}

#[test]
fn a_drive_in_pieces_is_the_drive_of_the_program() {
    let mut pieces = Simulated::new(&scene("room")).unwrap();
    for i in 1..=100 {
        pieces.advance(f64::from(i) * 0.3, 5);
        pieces.steps();
    }
    let (robot, _) = robot_of("").unwrap();
    let plan = plan_file::load("room").unwrap();
    let mut drive = Drive::new(&plan, &robot, SimOptions::default(), 1).unwrap();
    let mut session = Session::new(&robot, by_default(&robot), "room").unwrap();
    while session.recording().steps.len() < pieces.recording().steps.len() {
        drive.step(&mut session);
    }
    assert!(pieces.recording().steps.len() > 400, "{}", pieces.recording().steps.len());
    assert_eq!(pieces.recording().steps, session.recording().steps);
}

#[test]
fn a_robot_that_was_carried_says_so_and_finds_its_map_again() {
    let mut simulated = Simulated::new(&scene("flat")).unwrap();
    simulated.advance(200.0, 10_000);
    assert!(simulated.carry(Some([-3.0, 0.0])).is_ok(), "outside is free, if odd");
    assert!(simulated.carry(Some([0.0, 0.0])).is_err(), "a corner has no room");
    let mut simulated = Simulated::new(&scene("flat")).unwrap();
    simulated.advance(200.0, 10_000);
    simulated.carry(Some([2.5, 1.0])).unwrap();
    simulated.advance(202.0, 100);
    assert_eq!((&simulated.state()["lifted"], &simulated.state()["searching"]), (&json!(true), &json!(true)));
    // One of the places that a search takes for possible is the true one.
    let mut was_near = false;
    for _ in 0..10_000 {
        simulated.advance(400.0, 1);
        let state = simulated.state();
        let at = |key: &str, axis: usize| state[key][axis].as_f64().unwrap();
        let places = state["places"].as_array().unwrap();
        let off_m = |place: &Value| {
            let [x, y] = [0, 1].map(|axis| place[axis].as_f64().unwrap() - at("truth", axis));
            x.hypot(y)
        };
        was_near |= places.iter().any(|place| off_m(place) < 0.15 && place[3].as_f64().unwrap() > 0.3);
        assert!(places.is_empty() || state["searching"] == true);
        assert!(places.iter().map(|place| place[3].as_f64().unwrap()).sum::<f64>() <= 1.0 + 1e-9, "{state}");
    }
    assert!(was_near && simulated.sought().is_none());
    assert_eq!(simulated.state()["searching"], false);
    let error = simulated.recording().steps.last().and_then(|step| step.error()).expect("it is located");
    assert!(error.x_m.hypot(error.y_m) < 0.1, "{error:?}");
}

#[test]
fn a_robot_without_power_begins_anew_in_its_map() {
    let mut simulated = Simulated::new(&scene("flat")).unwrap();
    assert!(simulated.cut_power().is_err());
    simulated.advance(120.0, 10_000);
    let map = simulated.kept_map();
    assert!(simulated.begin_in(map[..map.len() - 9].to_vec()).is_err(), "half a map");
    simulated.cut_power().unwrap();
    assert_eq!(simulated.kept_map(), map, "it keeps what it began with until it knows where it is");
    let walls = simulated.sought().unwrap();
    assert!(walls.as_array().unwrap().len() > 5, "{walls}");
    simulated.advance(1.0, 30);
    assert!(simulated.recording().steps.len() <= 30 && simulated.recording().steps.iter().all(|step| step.searching));
}

#[test]
fn a_robot_without_power_goes_on_with_the_floor_that_was_left() {
    let mut simulated = Simulated::new(&Scene { job: Job::Clean, ..scene("l-shape") }).unwrap();
    simulated.advance(300.0, 100_000);
    let before = simulated.state()["swept"].clone();
    simulated.cut_power().unwrap();
    simulated.advance(1.0, 100);
    assert_eq!((&simulated.state()["doing"], &simulated.state()["searching"]), (&json!("lost"), &json!(true)));
    simulated.advance(LONGEST_S, 100_000);
    let after = simulated.state();
    assert_eq!((&after["over"], &after["doing"]), (&json!(true), &json!("done")), "{after}");
    let [swept, twice] = [0, 1].map(|index| after["swept"][index].as_f64().unwrap() - before[index].as_f64().unwrap());
    assert!(swept > 0.2 && twice < 0.5, "{before} {after}");
    assert!(after["swept"][0].as_f64().unwrap() > 0.95, "{after}");
}

#[test]
fn a_covered_sensor_sees_nothing_and_a_new_wall_is_seen() {
    let mut simulated = Simulated::new(&scene("room")).unwrap();
    (0..8).for_each(|sensor| simulated.cover(sensor, true));
    simulated.advance(5.0, 1000);
    assert_eq!(simulated.recording().walls().len(), 0);
    (0..8).for_each(|sensor| simulated.cover(sensor, false));
    let (_, text) = plan_file::BUILT_IN[0];
    let faces = simulated.plan.faces.len();
    simulated.rebuild(&format!("{text}\n[[wall]]\nfrom_m = [1.0, 2.0]\nto_m = [2.0, 2.0]\n")).unwrap();
    assert_eq!(simulated.plan.faces.len(), faces + 1);
    assert!(simulated.rebuild("[[wall]]").is_err());
    simulated.advance(30.0, 1000);
    assert!(simulated.recording().walls().len() > 1);
}

#[test]
fn a_robot_that_cleans_sweeps_the_floor_and_stops_when_it_is_back() {
    let mut simulated = Simulated::new(&Scene { job: Job::Clean, ..scene("room") }).unwrap();
    simulated.advance(60.0, 10_000);
    let early = simulated.state();
    let seen = simulated.floor().chunks(2).filter(|at_s| at_s[0] <= 60.0).count() as f64;
    let floor = simulated.floor().chunks(2).filter(|at_s| !at_s[0].is_nan()).count() as f64;
    assert!((early["swept"][0].as_f64().unwrap() - seen / floor).abs() < 1e-9, "{early}");
    simulated.advance(LONGEST_S, 100_000);
    let late = simulated.state();
    assert_eq!((&late["over"], &late["doing"]), (&json!(true), &json!("done")), "{late}");
    assert!(late["swept"][0].as_f64().unwrap() > 0.9, "{late}");
    let steps = simulated.recording().steps.len();
    simulated.advance(LONGEST_S, 10);
    assert_eq!(simulated.recording().steps.len(), steps);
}

#[test]
fn one_call_does_no_more_than_it_may() {
    let mut simulated = Simulated::new(&scene("flat")).unwrap();
    simulated.advance(1e9, 10);
    assert_eq!(simulated.recording().steps.len(), 10);
}

#[test]
fn a_bad_plan_is_said_with_its_place() {
    let error = Simulated::new(&scene("[start]\nx_m = 1\ny_m = 1\nheading = 3\n")).err().unwrap();
    assert!(error.starts_with("plan:4: start: heading") || error.contains("heading"), "{error}");
}
