//! Turns that nothing told: what tells them is that all walls that are seen since stand askew, by the same angle.

use slam_core::{Displaced, Increment, Pose, Standing};

use super::drive::DRIVE;
use super::random::Random;
use crate::wall::Wall;
use crate::{Diary, Hit, LookBack, Progress, border_len, packed_len};

const W: usize = 16;
const B: usize = border_len(W);
type SmallDiary = Diary<64, 512, W>;
type Small = LookBack<64, W, B, { packed_len(B) }>;

/// The ends of a wall, metres. It is seen by a robot to the left of the way from the first to the second.
type Ends = [[f64; 2]; 2];

/// Three walls of the room in which the robot starts at the origin, looking along x.
const BEFORE: [Ends; 3] = [[[3.0, 1.0], [-1.5, 1.0]], [[-1.5, -1.0], [3.0, -1.0]], [[-1.5, 1.0], [-1.5, -1.0]]];

/// All four of the one that it comes to after 3 m.
const ROOM: [Ends; 4] =
    [[[9.0, 2.2], [2.9, 2.2]], [[2.9, -2.8], [9.0, -2.8]], [[9.0, -2.8], [9.0, 2.2]], [[2.9, 2.2], [2.9, 0.5]]];

/// Three of one more, after 7 m.
const NEXT: [Ends; 3] = [[[13.0, 1.5], [7.5, 1.5]], [[7.5, -1.5], [13.0, -1.5]], [[13.0, -1.5], [13.0, 1.5]]];

/// Three sides of a box on its left.
const BOX: [Ends; 3] = [[[5.5, 0.6], [4.0, 0.6]], [[4.0, 0.6], [4.0, 1.6]], [[5.5, 1.6], [5.5, 0.6]]];

/// Turned about where the second room begins.
fn askew([x, y]: [f64; 2], by_rad: f64) -> [f64; 2] {
    let (s, c) = by_rad.sin_cos();
    [3.0 + c * (x - 3.0) - s * y, s * (x - 3.0) + c * y]
}

/// A robot that drives straight on, and what it writes down.
struct World {
    diary: SmallDiary,
    random: Random,
    /// x, y, theta.
    truth: [f64; 3],
    reckoned: Pose,
    /// How a filter has walls that stand askew to its grid.
    told: Standing,
    step: u32,
}

impl World {
    fn new(told: Standing) -> Self {
        let mut diary = SmallDiary::new(&DRIVE, Pose::ORIGIN);
        diary.grid(0.0);
        let mut world = Self { diary, random: Random(3), truth: [0.0; 3], reckoned: Pose::ORIGIN, told, step: 0 };
        world.drive(75, &BEFORE, 0);
        world
    }

    /// So many steps of 4 cm past these walls, which the filter calls by numbers from `first` on.
    fn drive(&mut self, steps: u32, walls: &[Ends], first: u16) {
        for _ in 0..steps {
            self.step += 1;
            let [x, y, theta] = self.truth;
            self.truth = [x + 0.04 * theta.cos(), y + 0.04 * theta.sin(), theta];
            self.reckoned = self.reckoned.compose(&Pose::new(0.04, 0.0, 0.0));
            self.diary.travel(&Increment { forward_m: 0.04, left_m: 0.0, turn_rad: 0.0 });
            if self.diary.is_due() {
                self.diary.begin_keyframe(&self.reckoned);
            }
            walls.iter().zip(first..).for_each(|(ends, id)| self.see(*ends, id));
        }
    }

    fn see(&mut self, [[ax, ay], [bx, by]]: Ends, id: u16) {
        let [x, y, theta] = self.truth;
        if (bx - ax) * (y - ay) - (by - ay) * (x - ax) < 0.1 {
            return;
        }
        let share = f64::from(self.step * 7 % 10) / 9.0;
        let way = [ax + share * (bx - ax) - x, ay + share * (by - ay) - y];
        let range = way[0].hypot(way[1]) + 0.01 * self.random.normal();
        let bearing = way[1].atan2(way[0]) - theta;
        self.hit([(range * bearing.cos()) as f32, (range * bearing.sin()) as f32], id);
        if id >= 8 {
            self.diary.stand(id, self.told);
        }
    }

    fn hit(&mut self, end_m: [f32; 2], id: u16) {
        let (from_m, wall) = ([0.0; 2], Some(id));
        self.diary.hit(&Hit { from_m, end_m, variance_m2: 1e-4, alike: 1.0, sensor: 0, wall });
    }

    fn kick(&mut self, turned_rad: f64) {
        self.truth[2] += turned_rad;
    }

    /// Looks back: by how much the heading is off then, radians, and the place, metres.
    fn look_back(&mut self) -> [f64; 2] {
        let mut look_back = Small::new();
        look_back.begin(&self.diary);
        assert_eq!(look_back.work(&mut self.diary, u32::MAX), Progress::Done);
        let (robot, [x, y, theta]) = (self.diary.robot(), self.truth);
        [(f64::from(robot.theta_rad) - theta).abs(), (f64::from(robot.x_m) - x).hypot(f64::from(robot.y_m) - y)]
    }
}

#[test]
fn a_turn_that_nothing_told_is_told_by_the_walls_that_stand_askew_since() {
    // As a filter with sensors that report metres leaves it to the direction, and as one with analogue sensors says it.
    for told in [Standing::Unknown, Standing::Off] {
        for turned_rad in [-0.35, -0.15, 0.15, 0.35] {
            let name = std::format!("{turned_rad} rad, {told:?}");
            let mut world = World::new(told);
            world.kick(turned_rad);
            for _ in 0..5 {
                world.drive(20, &ROOM, 8);
                // Where the robot has the wall that was on its left there is a chair.
                world.hit([0.0, 1.0], 0);
            }
            let [off_rad, off_m] = world.look_back();
            assert!(world.diary.turned.is_new, "{name}");
            assert!(off_rad < 0.02, "{name}: {off_rad} rad");
            // The turn may have been anywhere within a keyframe or two.
            assert!(off_m < 0.25, "{name}: {off_m} m");
        }
    }
}

#[test]
fn a_turn_is_not_told_by_less() {
    let wing = ROOM.map(|ends| ends.map(|end| askew(end, 0.26)));
    let cases: [(&str, f64, &[Ends], u32); 6] = [
        ("two walls", -0.26, &ROOM[..2], 0),
        ("an angle that the heading may be off by", 0.05, &ROOM, 0),
        ("an angle by which nothing turns a robot", 0.75, &ROOM, 0),
        ("the sides of one thing", -0.26, &BOX, 0),
        ("a wing into which a wall is seen on", 0.0, &wing, 30),
        ("walls on the grid", 0.0, &ROOM, 0),
    ];
    for (name, turned_rad, since, seen_on) in cases {
        // On the grid is what a filter does not say is off it.
        let told = if turned_rad == 0.0 { Standing::Unknown } else { Standing::Off };
        let mut world = World::new(told);
        world.kick(turned_rad);
        for _ in 0..seen_on {
            world.drive(1, since, 8);
            world.see(BEFORE[0], 0);
        }
        world.drive(100 - seen_on, since, 8);
        world.look_back();
        assert!(!world.diary.turned.is_new, "{name}");
    }
}

/// What was taken for a turn was a wing, and the robot is back: by the walls that it draws there, or by its readings.
#[test]
fn a_robot_that_comes_back_turned_by_as_much_was_in_a_wing() {
    for told in [Standing::Unknown, Standing::Off] {
        for is_found_by_readings in [false, true] {
            let name = std::format!("{told:?}, {is_found_by_readings}");
            let mut world = World::new(told);
            world.drive(100, &ROOM.map(|ends| ends.map(|end| askew(end, 0.26))), 8);
            let [off_rad, _] = world.look_back();
            assert!(world.diary.turned.is_new && (off_rad - 0.26).abs() < 0.03, "{name}: {off_rad} rad off");
            // The filter takes it over.
            world.diary.turned.is_new = false;
            if is_found_by_readings {
                world.reckoned = world.reckoned.compose(&Pose::new(0.0, 0.0, 0.26));
                world.diary.go_on_elsewhere(&world.reckoned, Displaced::Jolted);
                world.told = Standing::Unknown;
            }
            world.drive(75, &NEXT, 12);
            let [off_rad, off_m] = world.look_back();
            assert!(world.diary.turned.is_new, "{name}");
            assert!(off_rad < 0.02 && off_m < 0.1, "{name}: {off_rad} rad, {off_m} m");
        }
    }
}

/// Of furniture it takes three.
#[test]
fn two_walls_tell_a_turn_where_one_is_longer_than_furniture() {
    let walls = |length_m: f64| [[[2.9 + length_m, 1.2], [2.9, 1.2]], [[2.9, -1.8], [2.9 + length_m, -1.8]]];
    for (length_m, is_told) in [(2.0, false), (4.0, true)] {
        let mut world = World::new(Standing::Off);
        world.kick(-0.26);
        // A look back knows of walls how long the one before found them.
        for _ in 0..2 {
            world.drive(50, &walls(length_m), 8);
            world.look_back();
        }
        assert_eq!(world.diary.turned.is_new, is_told, "{length_m} m");
    }
}

#[test]
fn a_turn_leaves_a_wall_that_is_older_than_the_diary_where_it_is() {
    let mut world = World::new(Standing::Off);
    // Its hits are forgotten.
    let older = Wall { rho_m: 2.0, beta_rad: 0.0, is_placed: true, ..Wall::NEW };
    *world.diary.walls.last_mut().unwrap() = Some(older);
    world.kick(-0.26);
    world.drive(100, &ROOM, 8);
    world.look_back();
    assert!(world.diary.turned.is_new);
    let left = world.diary.walls.last().unwrap().expect("it is kept");
    assert_eq!((left.rho_m, left.beta_rad), (2.0, 0.0));
}
