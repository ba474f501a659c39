//! What befalls the robot, and that its encoders do not tell.

use hal_sim::{Pose2, SimOptions, Simulation, default_rig, nominal_ranges, plan_file};
use robot::{Contacts, WheelSpeeds};

const HALL: &str = "[start]\nx_m = 1.0\ny_m = 2.0\n\
    [[outline]]\npoints_m = [[0.0, 0.0], [6.0, 0.0], [6.0, 4.0], [0.0, 4.0]]\n\
    [[room]]\nname = \"hall\"\nmin_m = [0.0, 0.0]\nmax_m = [6.0, 4.0]\n";

const AHEAD: WheelSpeeds = WheelSpeeds { left_mps: 0.2, right_mps: 0.2 };

fn hall(mishaps: &str, seed: u64) -> Simulation {
    let plan = plan_file::parse("test", "test", &format!("{HALL}{mishaps}")).expect("a plan");
    Simulation::new(&plan, &default_rig(), SimOptions::default(), seed).expect("a simulation")
}

/// The pose after a drive straight ahead, with and without the mishaps.
fn after(mishaps: &str, seed: u64, seconds: f64) -> [Pose2; 2] {
    ["", mishaps].map(|mishaps| {
        let mut simulation = hall(mishaps, seed);
        for _ in 0..(25.0 * seconds) as usize {
            simulation.step(AHEAD);
        }
        simulation.pose_in_plan()
    })
}

#[test]
fn a_lifted_robot_says_so_stands_sees_nothing_and_is_put_down_elsewhere() {
    let mut simulation = hall("[[kidnap]]\nat_s = 2.0\ncarried_s = 3.0\nto_m = [4.0, 1.0]\nheading_deg = 90.0\n", 1);
    let (mut lifted_samples, mut ticks) = (0, None);
    for _ in 0..150 {
        let sample = simulation.step(AHEAD);
        if simulation.contacts().lifted {
            lifted_samples += 1;
            if simulation.time_s() > 3.0 {
                assert_eq!(*ticks.get_or_insert(sample.motion), sample.motion, "the wheels stand");
            }
        }
    }
    assert!((75..=76).contains(&lifted_samples), "three seconds at 25 Hz: {lifted_samples}");
    let pose = simulation.pose_in_plan();
    assert!((pose.x_m - 4.0).abs() < 0.02 && pose.y_m > 1.0 && pose.y_m < 1.3, "{pose:?}");
}

#[test]
fn a_place_that_is_not_named_is_drawn_from_the_seed_and_free() {
    let places = [1, 1, 2, 3].map(|seed| {
        let mut simulation = hall("[[kidnap]]\nat_s = 1.0\ncarried_s = 1.0\n", seed);
        for _ in 0..50 {
            simulation.step(WheelSpeeds::STOP);
        }
        simulation.pose_in_plan()
    });
    assert_eq!(places[0], places[1]);
    assert!(places[1] != places[2] && places[2] != places[3]);
    for Pose2 { x_m, y_m, .. } in places {
        assert!((0.17..=5.83).contains(&x_m) && (0.17..=3.83).contains(&y_m));
    }
}

#[test]
fn a_kick_moves_and_turns_the_robot_and_its_encoders_do_not_tell() {
    let [without, with] = after("[[kick]]\nat_s = 1.98\n", 5, 2.0);
    let moved = without.relative(&with);
    let (slide_m, turn_deg) = (libm::hypot(moved.x_m, moved.y_m), moved.theta_rad.to_degrees());
    assert!((slide_m - 0.10).abs() < 2e-3 && (turn_deg.abs() - 15.0).abs() < 1e-6, "{moved:?}");
    let counts = ["", "[[kick]]\nat_s = 1.0\n"].map(|mishaps| {
        let mut simulation = hall(mishaps, 5);
        for _ in 0..50 {
            simulation.step(AHEAD);
        }
        simulation.ticks()
    });
    assert_eq!(counts[0], counts[1]);
}

#[test]
fn what_happens_at_a_sample_s_time_happens() {
    for at_s in [0.0, 0.04, 1.0, 1.6, 2.0] {
        let [without, with] = after(&format!("[[kick]]\nat_s = {at_s:?}\nslide_m = 0.0\n"), 5, 2.2);
        let turned_deg = without.relative(&with).theta_rad.to_degrees();
        assert!((turned_deg.abs() - 15.0).abs() < 1e-6, "at {at_s} s it turns by {turned_deg} degrees");
    }
}

#[test]
fn a_wall_stops_a_kick() {
    for seed in 0..20 {
        let [_, with] = after("[[kick]]\nat_s = 1.0\nslide_m = 9.0\n", seed, 1.1);
        assert!((0.16..=5.84).contains(&with.x_m) && (0.16..=3.84).contains(&with.y_m), "{with:?}");
    }
}

#[test]
fn a_rug_turns_the_robot_once_each_time_it_comes_onto_it() {
    let rug = "[[rug]]\nmin_m = [1.5, 0.0]\nmax_m = [3.0, 4.0]\n";
    let turned = [1, 2, 3, 4, 5, 6].map(|seed| {
        let [without, with] = after(rug, seed, 6.0);
        without.relative(&with).theta_rad.to_degrees()
    });
    assert!(turned.iter().all(|turn| (turn.abs() - 9.0).abs() < 1e-6), "{turned:?}");
    assert!(turned.iter().any(|turn| *turn > 0.0) && turned.iter().any(|turn| *turn < 0.0), "to either side");
}

#[test]
fn a_held_robot_counts_travel_that_is_none() {
    let [without, with] = after("[[hold]]\nat_s = 2.0\nheld_s = 1.5\n", 7, 5.0);
    let short_m = without.x_m - with.x_m;
    assert!((short_m - 0.3).abs() < 0.01, "{short_m}");
}

#[test]
fn a_place_inside_something_is_refused() {
    let plan = plan_file::parse("test", "test", &format!("{HALL}[[kidnap]]\nat_s = 1.0\nto_m = [5.9, 2.0]\n"))
        .expect("a plan");
    let error = Simulation::new(&plan, &default_rig(), SimOptions::default(), 1).unwrap_err().to_string();
    assert!(error.contains("kidnap[0].to_m is 0.10 m from"), "{error}");
}

#[test]
fn a_wheel_hangs_for_a_moment_as_the_robot_drives_onto_a_sill_and_off_it() {
    let mut simulation = hall("[[sill]]\nmin_m = [1.5, 1.0]\nmax_m = [2.0, 3.0]\nhangs_s = 0.4\n", 1);
    let mut hangs = Vec::new();
    for _ in 0..250 {
        simulation.step(AHEAD);
        if simulation.contacts().lifted {
            hangs.push(simulation.pose_in_plan().x_m);
        }
    }
    // The guard has stopped the motors: the robot rolls on by a centimetre or two meanwhile, and drives on after it.
    assert!((19..=22).contains(&hangs.len()), "{hangs:?}");
    assert!(hangs.iter().all(|x_m| (1.49..1.54).contains(x_m) || (1.99..2.04).contains(x_m)), "{hangs:?}");
    assert!(simulation.pose_in_plan().x_m > 2.4);
}

#[test]
fn a_part_that_fails_tells_what_is_not_there_for_as_long_as_it_does() {
    for (part, fails) in [
        ("bump-left", Contacts { bump_left: true, ..Contacts::default() }),
        ("bump-right", Contacts { bump_right: true, ..Contacts::default() }),
        ("cliff", Contacts { cliff: true, ..Contacts::default() }),
    ] {
        let mut simulation = hall(&format!("[[fault]]\npart = \"{part}\"\nat_s = 1.0\nlasts_s = 2.0\n"), 1);
        for _ in 0..100 {
            simulation.step(AHEAD);
            let is_failing = (1.0..3.0).contains(&simulation.time_s());
            assert_eq!(simulation.contacts(), if is_failing { fails } else { Contacts::default() }, "{part}");
        }
        // It drives for half of the time.
        assert!((1.2..1.5).contains(&simulation.pose_in_plan().x_m), "{part}: {:?}", simulation.pose_in_plan());
    }
}

#[test]
fn a_sensor_that_fails_shows_nothing_or_always_the_same_with_its_noise() {
    let rig = default_rig();
    for (fault, least_m, most_m) in [("shows_m = 0.4", 0.3, 0.5), ("", f32::NAN, f32::NAN)] {
        let mut simulation = hall(&format!("[[fault]]\npart = \"sensor\"\nsensor = 2\n{fault}\n"), 1);
        let (mut shown_m, mut others) = (Vec::new(), 0);
        for _ in 0..250 {
            let ranges_m = nominal_ranges(&rig, &simulation.step(AHEAD));
            shown_m.extend(ranges_m[2]);
            others += ranges_m.iter().flatten().count();
        }
        shown_m.sort_by(f32::total_cmp);
        assert!(others > 50, "{others}");
        if fault.is_empty() {
            assert!(shown_m.len() < 5, "spikes: {shown_m:?}");
        } else {
            assert!(shown_m.len() > 240 && shown_m.first() < shown_m.last());
            assert!((least_m..most_m).contains(&shown_m[125]), "{}", shown_m[125]);
        }
    }
}

#[test]
fn a_fault_that_cannot_be_is_named() {
    for (fault, expected) in [
        ("part = \"wheel\"", "fault[0].part: must be \"bump-left\", \"bump-right\", \"cliff\" or \"sensor\""),
        ("part = \"sensor\"", "fault[0].sensor: is missing; it must be the sensor's place in the rig, from 0"),
        ("part = \"cliff\"\nsensor = 1", "fault[0].sensor: has a meaning with part = \"sensor\" only"),
        ("part = \"cliff\"\nshows_m = 1.0", "fault[0].shows_m: has a meaning with part = \"sensor\" only"),
        ("part = \"cliff\"\nlasts_s = 0.0", "fault[0].lasts_s: is 0.0; it must be a number above 0"),
    ] {
        let message =
            plan_file::parse("home.toml", "home", &format!("{HALL}[[fault]]\n{fault}\n")).unwrap_err().to_string();
        assert!(message.starts_with("home.toml:") && message.contains(expected), "{message}");
    }
    let plan = plan_file::parse("test", "test", &format!("{HALL}[[fault]]\npart = \"sensor\"\nsensor = 8\n"));
    let refused = Simulation::new(&plan.expect("a plan"), &default_rig(), SimOptions::default(), 1).unwrap_err();
    assert_eq!(refused.to_string(), "fault[0].sensor is 8; the rig has 8 range sensors, counted from 0");
}

#[test]
fn rugs_and_sills_of_a_home_that_is_rebuilt_are_those_of_the_new_plan() {
    let plan = |things: &str| plan_file::parse("test", "test", &format!("{HALL}{things}")).expect("a plan");
    let sill = "[[sill]]\nmin_m = [1.5, 1.0]\nmax_m = [2.0, 3.0]\n";
    let rug = "[[rug]]\nmin_m = [2.5, 0.0]\nmax_m = [3.5, 4.0]\n";
    let mut simulation = hall(sill, 1);
    simulation.rebuild(&plan(rug));
    let mut lifted = 0;
    for _ in 0..250 {
        simulation.step(AHEAD);
        lifted += usize::from(simulation.contacts().lifted);
    }
    let pose = simulation.pose_in_plan();
    assert_eq!(lifted, 0, "the sill was taken away");
    assert!(pose.theta_rad.abs() > 0.02, "a rug was put there: {pose:?}");
    // It is on the new one from the start: no edge is met.
    simulation.rebuild(&plan("[[rug]]\nmin_m = [0.0, 0.0]\nmax_m = [6.0, 4.0]\n"));
    for _ in 0..10 {
        simulation.step(AHEAD);
    }
    assert!((simulation.pose_in_plan().theta_rad - pose.theta_rad).abs() < 0.01);
}

#[test]
fn people_go_on_as_they_walked_in_a_home_that_is_rebuilt() {
    let person = "[[person]]\nradius_m = 0.15\nspeed_mps = 0.5\npath_m = [[2.0, 2.0], [5.0, 2.0]]\ngives_way = true\n";
    let plan = |things: &str| plan_file::parse("test", "test", &format!("{HALL}{things}")).expect("a plan");
    let mut simulation = hall(person, 1);
    let place = |simulation: &Simulation| simulation.people().next().expect("somebody").0;
    // They meet the robot, which stands before them, and turn round.
    for _ in 0..500 {
        simulation.step(AHEAD);
    }
    let by_time = plan(person).people[0].position(simulation.time_s());
    let before = place(&simulation);
    assert!((before[0] - by_time[0]).abs() > 0.05, "they turned round: {before:?} {by_time:?}");
    simulation.rebuild(&plan(&format!("{person}[[wall]]\nfrom_m = [1.0, 0.5]\nto_m = [2.0, 0.5]\n")));
    let after = place(&simulation);
    assert!((before[0] - after[0]).abs() < 1e-9, "{before:?} {after:?}");
}
