//! Turns that nothing told: what tells them is that all walls that are seen since stand askew, by the same angle.

use slam_core::{Increment, Pose, Standing};

use super::drive::DRIVE;
use super::random::Random;
use crate::{Diary, Hit, LookBack, Progress, border_len, packed_len};

const W: usize = 16;
const B: usize = border_len(W);
type SmallDiary = Diary<64, 512, W>;
type Small = LookBack<64, W, B, { packed_len(B) }>;

/// The ends of a wall, metres. It is seen by a robot to the left of the way from the first to the second.
type Ends = [[f64; 2]; 2];

/// Three walls of the room in which the robot starts at the origin, looking along x.
const BEFORE: [Ends; 3] = [[[3.0, 1.0], [-1.5, 1.0]], [[-1.5, -1.0], [3.0, -1.0]], [[-1.5, 1.0], [-1.5, -1.0]]];

/// All four of the one that it comes to.
const ROOM: [Ends; 4] =
    [[[9.0, 2.2], [2.9, 2.2]], [[2.9, -2.8], [9.0, -2.8]], [[9.0, -2.8], [9.0, 2.2]], [[2.9, 2.2], [2.9, 0.5]]];

/// Three sides of a box on its left.
const BOX: [Ends; 3] = [[[5.5, 0.6], [4.0, 0.6]], [[4.0, 0.6], [4.0, 1.6]], [[5.5, 1.6], [5.5, 0.6]]];

/// A robot that drives 3 m along `BEFORE`, is turned by so much unseen by its wheels, and drives 4 m on past other walls.
struct Drive {
    turned_rad: f64,
    since: &'static [Ends],
    /// Where those stand askew, by so much.
    askew_rad: f64,
    /// One wall of before is seen for some time.
    sees_one_on: bool,
    told: Standing,
}

const KICKED: Drive =
    Drive { turned_rad: -0.26, since: &ROOM, askew_rad: 0.0, sees_one_on: false, told: Standing::Unknown };

/// What came of it: by how much the last pose's heading is off, radians, its place, metres, and whether a turn was found.
fn placed(drive: &Drive) -> (f64, f64, bool) {
    let mut diary = SmallDiary::new(&DRIVE, Pose::ORIGIN);
    let hit = |diary: &mut SmallDiary, end_m, wall| {
        let (from_m, wall) = ([0.0; 2], Some(wall));
        diary.hit(&Hit { from_m, end_m, variance_m2: 1e-4, alike: 1.0, sensor: 0, wall });
    };
    diary.grid(0.0);
    let mut random = Random(3);
    let (mut truth, mut reckoned) = ([0.0_f64; 3], Pose::ORIGIN);
    for step in 0..175 {
        let is_before = step < 75;
        if step == 75 {
            truth[2] += drive.turned_rad;
        }
        let [x, y, theta] = truth;
        truth = [x + 0.04 * theta.cos(), y + 0.04 * theta.sin(), theta];
        let moved = Increment { forward_m: 0.04, left_m: 0.0, turn_rad: 0.0 };
        reckoned = reckoned.compose(&Pose::new(0.04, 0.0, 0.0));
        diary.travel(&moved);
        if diary.is_due() {
            diary.begin_keyframe(&reckoned);
        }
        if !is_before && step % 20 == 0 {
            // Where the robot has the wall that was on its left there is a chair.
            hit(&mut diary, [0.0, 1.0], 0);
        }
        let (walls, first) = if is_before { (&BEFORE[..], 0) } else { (drive.since, 8) };
        let is_askew = |id: u16| id >= 8;
        let seen_on = (!is_before && step < 105 && drive.sees_one_on).then_some((0, BEFORE[0]));
        let seen = walls.iter().zip(first..).map(|(ends, id)| (id, *ends)).chain(seen_on);
        for (id, ends) in seen {
            let askew_rad = if is_askew(id) { drive.askew_rad } else { 0.0 };
            let [[ax, ay], [bx, by]] = ends.map(|[x, y]| {
                let (s, c) = askew_rad.sin_cos();
                [3.0 + c * (x - 3.0) - s * y, s * (x - 3.0) + c * y]
            });
            let [x, y, theta] = truth;
            if (bx - ax) * (y - ay) - (by - ay) * (x - ax) < 0.1 {
                continue;
            }
            let share = f64::from(step * 7 % 10) / 9.0;
            let way = [ax + share * (bx - ax) - x, ay + share * (by - ay) - y];
            let range = way[0].hypot(way[1]) + 0.01 * random.normal();
            let bearing = way[1].atan2(way[0]) - theta;
            let end_m = [(range * bearing.cos()) as f32, (range * bearing.sin()) as f32];
            hit(&mut diary, end_m, id);
            if is_askew(id) {
                diary.stand(id, drive.told);
            }
        }
    }
    let mut look_back = Small::new();
    look_back.begin(&diary);
    assert_eq!(look_back.work(&mut diary, u32::MAX), Progress::Done);
    let robot = diary.robot();
    let off_m = (f64::from(robot.x_m) - truth[0]).hypot(f64::from(robot.y_m) - truth[1]);
    ((f64::from(robot.theta_rad) - truth[2]).abs(), off_m, diary.is_turned_back)
}

#[test]
fn a_turn_that_nothing_told_is_told_by_the_walls_that_stand_askew_since() {
    // As a filter with sensors that report metres leaves it to the direction, and as one with analogue sensors says it.
    for told in [Standing::Unknown, Standing::Off] {
        for turned_rad in [-0.35, -0.15, 0.15, 0.35] {
            let name = std::format!("{turned_rad} rad, {told:?}");
            let (off_rad, off_m, is_found) = placed(&Drive { turned_rad, told, ..KICKED });
            assert!(is_found, "{name}");
            assert!(off_rad < 0.02, "{name}: {off_rad} rad");
            // The turn may have been anywhere within a keyframe or two.
            assert!(off_m < 0.25, "{name}: {off_m} m");
        }
    }
}

#[test]
fn a_turn_is_not_told_by_less() {
    let few = |since| Drive { since, ..KICKED };
    let cases = [
        ("two walls", few(&ROOM[..2])),
        ("an angle that the heading may be off by", Drive { turned_rad: 0.05, told: Standing::Off, ..KICKED }),
        ("an angle by which nothing turns a robot", Drive { turned_rad: 0.75, ..KICKED }),
        ("the sides of one thing", few(&BOX)),
        (
            "a wing into which a wall is seen on",
            Drive { turned_rad: 0.0, askew_rad: 0.26, sees_one_on: true, ..KICKED },
        ),
        ("walls on the grid", Drive { turned_rad: 0.0, ..KICKED }),
    ];
    for (name, drive) in cases {
        let (_, _, is_found) = placed(&drive);
        assert!(!is_found, "{name}");
    }
}
