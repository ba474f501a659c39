//! Areas to clean in rooms that the robot has not seen: it finds them, or says that it did not.

use hal_sim::{SimOptions, plan_file};
use lab::run::{FloorDrive, clean};
use robot::FloorState;

/// Three rooms in a row and furniture; the robot starts in the first one.
const ROW: &str = "[start]\nx_m = 1.0\ny_m = 1.0\nheading_deg = 90.0\n\
    [[outline]]\npoints_m = [[0.0, 0.0], [10.4, 0.0], [10.4, 4.0], [0.0, 4.0]]\n\
    [[box]]\nmin_m = [3.4, 0.0]\nmax_m = [3.5, 0.5]\n[[box]]\nmin_m = [3.4, 1.35]\nmax_m = [3.5, 4.0]\n\
    [[box]]\nmin_m = [0.0, 3.4]\nmax_m = [1.8, 4.0]\n[[box]]\nmin_m = [4.4, 0.0]\nmax_m = [5.6, 0.6]\n";
/// The wall of the third room, with a door and without.
const OPEN: &str =
    "[[box]]\nmin_m = [6.9, 0.0]\nmax_m = [7.0, 2.6]\n[[box]]\nmin_m = [6.9, 3.45]\nmax_m = [7.0, 4.0]\n";
const CLOSED: &str = "[[box]]\nmin_m = [6.9, 0.0]\nmax_m = [7.0, 4.0]\n";

/// Lower and upper corners of areas in the second and third room.
const SECOND: [f64; 4] = [3.9, 1.5, 6.3, 3.8];
const THIRD: [f64; 4] = [7.3, 0.2, 10.2, 2.5];

fn job(home: &str, areas: &[[f64; 4]], seed: u64) -> FloorDrive {
    let mut text = home.to_owned();
    for [x0, y0, x1, y1] in areas {
        text += &format!("[[clean]]\npoints_m = [[{x0}, {y0}], [{x1}, {y0}], [{x1}, {y1}], [{x0}, {y1}]]\n");
    }
    let plan = plan_file::parse("home.toml", "home", &text).expect("a good plan");
    clean(&plan, SimOptions::default(), seed).expect("the robot fits")
}

fn assert_swept(drive: &FloorDrive, what: &str) {
    assert_eq!((drive.progress.state, drive.progress.missed), (FloorState::Done, 0), "{what}");
    // What is off by a decimetre is the map of rooms that were hardly seen.
    assert!(drive.score.swept > 0.9, "{what}: {} of the area", drive.score.swept);
    assert!(drive.score.largest_hole_m2 < 0.4, "{what}: a hole of {} m2", drive.score.largest_hole_m2);
    assert!(drive.score.home_m < 0.2, "{what}: {} m from where it started", drive.score.home_m);
}

/// Seeds with which the map turned by 3 to 5 degrees about the start in the first twenty seconds when the job took areas from its first one.
#[test]
fn an_area_behind_one_door_or_two_is_found_and_swept() {
    for seed in [8, 17, 39] {
        for area in [SECOND, THIRD, [5.0, 1.0, 9.0, 3.5]] {
            assert_swept(&job(&format!("{ROW}{OPEN}"), &[area], seed), &format!("{area:?}, seed {seed}"));
        }
    }
}

#[test]
fn of_two_areas_in_different_rooms_none_is_left_out() {
    let home = format!("{ROW}{OPEN}");
    let drive = job(&home, &[SECOND, THIRD], 1);
    assert_swept(&drive, "second and third room");
    assert_swept(&job(&home, &[[0.2, 0.2, 3.0, 3.0], THIRD], 1), "first and third room");
}

#[test]
fn an_area_that_no_way_leads_to_is_said_not_to_be_reached() {
    for seed in 1..=2 {
        let drive = job(&format!("{ROW}{CLOSED}"), &[SECOND, THIRD], seed);
        assert_eq!((drive.progress.state, drive.progress.missed), (FloorState::Unreached, 0b10));
        assert!(drive.score.swept > 0.9, "{} of the area in reach", drive.score.swept);
        assert!(drive.minutes < 15.0, "{} minutes", drive.minutes);
        assert!(drive.score.home_m < 0.2, "{} m from where it started", drive.score.home_m);
    }
}

/// The picture of the home reaches 6.2 m from where the job began.
#[test]
fn an_area_beyond_the_picture_is_found_and_so_is_the_way_back() {
    let mut home = "[start]\nx_m = 1.0\ny_m = 1.0\nheading_deg = 90.0\n\
        [[outline]]\npoints_m = [[0.0, 0.0], [20.0, 0.0], [20.0, 4.0], [0.0, 4.0]]\n"
        .to_owned();
    for (room, x_m) in [3.4, 6.8, 10.2, 13.6, 17.0].into_iter().enumerate() {
        // Doors are at one end of the walls and at the other.
        let [low_m, high_m] = if room % 2 == 0 { [2.6, 3.5] } else { [0.6, 1.5] };
        for [from_m, to_m] in [[0.0, low_m], [high_m, 4.0]] {
            home += &format!("[[box]]\nmin_m = [{x_m}, {from_m}]\nmax_m = [{}, {to_m}]\n", x_m + 0.1);
        }
    }
    let drives = [1, 2, 3, 4, 5, 6, 7, 8].map(|seed| job(&home, &[[17.2, 0.2, 19.8, 3.8]], seed));
    for drive in &drives {
        assert_eq!((drive.progress.state, drive.progress.missed), (FloorState::Done, 0));
    }
    // Its map of six rooms in a row, each seen from a door only, is off by decimetres at the end, now more and now less.
    let mean = |of: fn(&FloorDrive) -> f64| drives.iter().map(of).sum::<f64>() / drives.len() as f64;
    let [swept, home_m] = [mean(|drive| drive.score.swept), mean(|drive| drive.score.home_m)];
    assert!(swept > 0.9, "{swept} of the sixth room");
    assert!(home_m < 0.1, "{home_m} m from where it started");
}
