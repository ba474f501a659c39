//! Prints `docs/results/relocation.md`: carried robots, how soon they find themselves, and what the odds of a claim are worth.
//! `cargo run --release --package tests --example relocation -- CARRIES`, so many a home and number of sensors; with `FROM TO` after that in random
//! homes of these seeds only.

use std::{env, thread};

use hal_sim::random_home::random_home;
use hal_sim::{Plan, Pose2, SimOptions, plan_file};
use lab::evaluate::score::path;
use lab::evaluate::statistics::{mean, median};
use lab::input::rig_file::Robot;
use lab::run::{Drive, Session};
use relocate::{Event, Locator, PATH_POINTS, Progress, Search, State, Step, Verdict};
use slam_core::{Config, HostSlam, angle};
use tests::carries::{Driven, carried, drive, rig};

const HOMES: [&str; 6] = ["room", "l-shape", "flat", "corridor-loop", "clutter", "diagonal"];

/// Seeds of homes drawn at random.
const RANDOM: [u64; 16] = [201, 202, 203, 204, 205, 206, 207, 208, 301, 302, 303, 304, 305, 306, 307, 308];

/// Other homes in whose maps each fresh one is searched, by turns.
const OTHERS: usize = 3;

/// Distance between two points of the path that are held against kept walls, metres: all of a drive's.
const POINTS_M: f32 = 0.35;

/// A place that is farther off is wrong, metres.
const WRONG_M: f64 = 0.3;

/// Drives in which the robot has not found itself end here, metres.
const ENOUGH_M: f64 = 20.0;

/// Estimates are scored for so long after a claim, seconds and steps.
const AFTER_S: f64 = 60.0;
const STEPS: usize = 1500;

/// Width of a class of log-odds.
const CLASS: f32 = 2.0;
const CLASSES: usize = 8;

/// A home with its kept map.
struct Home {
    plan: Plan,
    kept: Session,
    /// The map's frame in that of the plan's start, as its path lies on the true one best.
    lies: Pose2,
}

impl Home {
    /// Where the robot is in the map. The map as a whole lies turned against its start by what the heading was off when the first walls
    /// were drawn, some degrees: that is no place's error.
    fn truth(&self, in_plan: &Pose2) -> Pose2 {
        self.lies.relative(&self.plan.start.relative(in_plan))
    }
}

/// What became of a carried robot.
#[derive(Default)]
struct Carry {
    path_m: f64,
    claimed_m: Option<f64>,
    /// How far off the robot was at its claim, metres.
    off_m: f64,
    squares_m2: Vec<f64>,
    nees: Vec<f64>,
    own: Odds,
    other: Odds,
}

/// Searches by the odds that the best place was given, and those of them in which it was right.
#[derive(Clone, Copy, Default)]
struct Odds([[u32; 2]; CLASSES + 1]);

impl Odds {
    fn add(&mut self, verdict: &Verdict, is_right: bool) {
        let class = (verdict.log_odds / CLASS + 1.0).clamp(0.0, CLASSES as f32) as usize;
        self.0[class][0] += 1;
        self.0[class][1] += u32::from(is_right);
    }

    fn add_all(&mut self, other: &Self) {
        for (sum, more) in self.0.iter_mut().flatten().zip(other.0.iter().flatten()) {
            *sum += more;
        }
    }
}

fn main() {
    let carries: u64 = env::args().nth(1).map_or(5, |text| text.parse().expect("a number of carries"));
    println!("{}", HEAD.replace("CARRIES", &carries.to_string()));
    println!(
        "| home | sensors | carries | drove 10 m | of these found | path to the claim, median | 95 % | wrong claims | farthest off at a claim | RMSE after | NEES after |\n\
         |---|---|---|---|---|---|---|---|---|---|---|"
    );
    let [mut own, mut other] = [Odds::default(), Odds::default()];
    let seeds: Vec<u64> = env::args().skip(2).map(|text| text.parse().expect("a seed")).collect();
    let mut turned_rad = 0.0f64;
    for sensors in [8, 4] {
        let plans: Vec<Plan> = match seeds[..] {
            [from, to] => (from..=to).map(random_home).collect(),
            _ => {
                let named = HOMES.iter().map(|name| plan_file::load(name).unwrap_or_else(|error| panic!("{error}")));
                named.chain(RANDOM.map(random_home)).collect()
            }
        };
        let homes: Vec<Home> = plans.into_iter().map(|plan| home(plan, sensors)).collect();
        turned_rad = homes.iter().fold(turned_rad, |most, home| most.max(home.lies.theta_rad.abs()));
        for there in &homes {
            // In the furnished flat the map of the empty one is kept, and the other way round, in every second carry.
            let twin = homes.iter().find(|home| is_same(home, there) && home.plan.name != there.plan.name);
            let carry = |carry: u64| {
                let kept = twin.filter(|_| carry % 2 == 1).unwrap_or(there);
                carry_there(there, kept, &homes, sensors, 20_000 + carry)
            };
            // Two cores.
            let every_second = |first: u64| (first..carries).step_by(2).map(&carry).collect::<Vec<_>>();
            let [mut done, more] = thread::scope(|scope| {
                let more = scope.spawn(|| every_second(1));
                [every_second(0), more.join().expect("no panic")]
            });
            done.extend(more);
            for carry in &done {
                own.add_all(&carry.own);
                other.add_all(&carry.other);
            }
            row(&there.plan.name, sensors, &done);
        }
    }
    println!(
        "\n{}\n\n| log-odds | in the home's own map: searches | right | in another home's: searches | right |\n|---|---|---|---|---|",
        ODDS.replace("TURNED", &format!("{:.1}", turned_rad.to_degrees()))
    );
    for (class, ([n, right], [others, none])) in own.0.iter().zip(&other.0).enumerate() {
        let from = CLASS * (class as f32 - 1.0);
        let name = match class {
            0 => "under 0".to_owned(),
            CLASSES => format!("{from} and more"),
            _ => format!("{from} to {}", from + CLASS),
        };
        println!("| {name} | {n} | {right} | {others} | {none} |");
    }
}

/// A home, and the map that a robot made of it in ten minutes.
fn home(plan: Plan, sensors: usize) -> Home {
    let rig = rig(sensors);
    let robot = Robot { names: vec![String::new(); rig.sensors.len()], rig, hand_overs: None };
    let mut session = Session::new(&robot, Config::for_rig(&robot.rig), "").expect("a rig that can be");
    let mut drive = Drive::new(&plan, &robot, SimOptions::default(), 1).expect("the robot fits");
    let (mut pairs, mut map) = (Vec::new(), (0, 0));
    while drive.simulation().time_s() < 600.0 {
        let truth = drive.step(&mut session).truth;
        let now = (session.slam().counters().second_copies, session.lost());
        if std::mem::replace(&mut map, now) != now {
            // What was driven beside a second copy, or in a map that was given up, is in no map any more.
            pairs.clear();
        }
        pairs.extend(truth.map(|truth| (session.slam().pose().into(), truth)));
    }
    Home { plan, kept: session, lies: path::align(&pairs) }
}

/// The flat and the furnished flat are one home.
fn is_same(a: &Home, b: &Home) -> bool {
    let is_flat = |home: &Home| ["flat", "clutter"].contains(&home.plan.name.as_str());
    a.plan.name == b.plan.name || (is_flat(a) && is_flat(b))
}

fn carry_there(there: &Home, kept: &Home, homes: &[Home], sensors: usize, seed: u64) -> Carry {
    let mut carry = Carry::default();
    let mut locator = Locator::new(State::Searching);
    let (mut next_m, mut trail_m) = (2.0, Vec::new());
    let others: Vec<&Home> = homes.iter().filter(|home| !is_same(home, there)).collect();
    let mut turn = seed as usize;
    let mut restarts = 0;
    drive(&carried(&there.plan, seed), &rig(sensors), 300.0, seed, |Driven { slam, path_m, in_plan, .. }| {
        let travelled_m = (path_m - std::mem::replace(&mut carry.path_m, path_m)) as f32;
        if carry.claimed_m.is_some() {
            carry.score(slam, kept, &in_plan);
            return carry.nees.len() < STEPS && !carry.is_wrong();
        }
        if std::mem::replace(&mut restarts, slam.counters().restarts) != restarts {
            // Another frame.
            locator.lost();
            trail_m.clear();
        }
        let position_m = [slam.state_mean(0), slam.state_mean(1)];
        let is_far = |last: &[f32; 2]| (last[0] - position_m[0]).hypot(last[1] - position_m[1]) > POINTS_M;
        if trail_m.last().is_none_or(is_far) {
            trail_m.push(position_m);
        }
        if path_m >= next_m {
            next_m += 1.0;
            turn += OTHERS;
            for home in homes.iter().filter(|home| is_same(home, there)) {
                let Some(verdict) = verdict(slam, home, &trail_m) else { continue };
                let is_right = is_there(slam, home, &verdict, &home.truth(&in_plan));
                carry.own.add(&verdict, is_right);
            }
            for home in others.iter().cycle().skip(turn % others.len()).take(OTHERS) {
                let Some(verdict) = verdict(slam, home, &trail_m) else { continue };
                carry.other.add(&verdict, false);
            }
        }
        let step = Step::moved(position_m, travelled_m);
        if let Some(Event::Found(found)) = locator.step(&*slam, Some(kept.kept.slam()), &step, u32::MAX) {
            slam.take_up(kept.kept.slam(), &found).expect("a map to go on in");
            carry.claimed_m = Some(path_m);
            carry.off_m = apart_m(&slam.pose().into(), &kept.truth(&in_plan));
        }
        path_m < ENOUGH_M
    });
    carry
}

/// A search of this map, in which the robot drove along this path, in a home's.
fn verdict(slam: &HostSlam, home: &Home, trail_m: &[[f32; 2]]) -> Option<Verdict> {
    let mut search = Search::IDLE;
    // As much of the path as a robot keeps.
    let of_late_m = &trail_m[trail_m.len().saturating_sub(PATH_POINTS)..];
    search.begin(slam, home.kept.slam(), of_late_m);
    while search.work(home.kept.slam(), u32::MAX) == Progress::Working {}
    search.verdict()
}

/// Whether the robot is where a search puts it.
fn is_there(slam: &HostSlam, home: &Home, verdict: &Verdict, truth: &Pose2) -> bool {
    const ALPHA: usize = 3;
    let (fresh_rad, kept_rad) = (slam.state_mean(ALPHA), home.kept.slam().state_mean(ALPHA));
    let turn_rad = f64::from(kept_rad - fresh_rad) + f64::from(verdict.best.quarters) * std::f64::consts::FRAC_PI_2;
    let shift = verdict.best.shift_m.map(f64::from);
    let [x_m, y_m] = Pose2::new(0.0, 0.0, kept_rad.into()).transform(shift);
    // Of a robot that began its map anew the pose goes on in the map's first frame; walls and states of both maps are in the filter's.
    let at = Pose2::new(x_m, y_m, turn_rad).compose(&slam.filter_pose().into());
    let kept: Pose2 = home.kept.slam().filter_pose().into();
    let at = Pose2::from(home.kept.slam().pose()).compose(&kept.relative(&at));
    let off_rad = angle::wrap((at.theta_rad - truth.theta_rad) as f32);
    apart_m(&at, truth) < WRONG_M && off_rad.abs() < 0.3
}

fn apart_m(a: &Pose2, b: &Pose2) -> f64 {
    (a.x_m - b.x_m).hypot(a.y_m - b.y_m)
}

impl Carry {
    fn is_wrong(&self) -> bool {
        self.off_m > WRONG_M
    }

    fn score(&mut self, slam: &HostSlam, kept: &Home, in_plan: &Pose2) {
        let estimate = slam.estimate();
        let (pose, truth) = (Pose2::from(estimate.pose), kept.plan.start.relative(in_plan));
        let off_rad = f64::from(angle::wrap((pose.theta_rad - truth.theta_rad) as f32));
        let error = nalgebra::Vector3::new(pose.x_m - truth.x_m, pose.y_m - truth.y_m, off_rad);
        self.squares_m2.push(apart_m(&pose, &kept.truth(in_plan)).powi(2));
        if let Some(inverse) = estimate.covariance.map(f64::from).try_inverse() {
            self.nees.push((error.transpose() * inverse * error).x);
        }
    }
}

fn row(home: &str, sensors: usize, carries: &[Carry]) {
    let drove: Vec<&Carry> = carries.iter().filter(|carry| carry.claimed_m.is_some() || carry.path_m > 10.0).collect();
    let mut claimed_m: Vec<f64> = drove.iter().filter_map(|carry| carry.claimed_m).collect();
    claimed_m.sort_by(f64::total_cmp);
    let nth = |share: f64| claimed_m.get((share * claimed_m.len() as f64) as usize).copied();
    let metres = |value: Option<f64>| value.map_or_else(|| "-".to_owned(), |value| format!("{value:.1} m"));
    let right = || carries.iter().filter(|carry| !carry.is_wrong());
    let squares: Vec<f64> = right().flat_map(|carry| carry.squares_m2.iter().copied()).collect();
    let nees: Vec<f64> = right().filter_map(|carry| mean(&carry.nees)).collect();
    let centimetres =
        mean(&squares).map_or_else(|| "-".to_owned(), |square| format!("{:.1} cm", 100.0 * square.sqrt()));
    println!(
        "| {home} | {sensors} | {} | {} | {} | {} | {} | {} | {:.0} cm | {centimetres} | {} |",
        carries.len(),
        drove.len(),
        claimed_m.len(),
        metres(median(&claimed_m)),
        metres(nth(0.95)),
        carries.iter().filter(|carry| carry.is_wrong()).count(),
        carries.iter().map(|carry| 100.0 * carry.off_m).fold(0.0, f64::max),
        mean(&nees).map_or_else(|| "-".to_owned(), |nees| format!("{nees:.1}")),
    );
}

const HEAD: &str = "\
# Carried robots

Printed by `cargo run --release --package tests --example relocation -- CARRIES`. A robot is put down at a random free place of a
home, begins a fresh map and searches the map that a ten-minute drive left ([how](../explanation/kept-map.md)). Each carry is
another robot of the same rig: its gains, wheels and track are drawn anew. In `flat` and `clutter`, one home with other furniture, every
second robot has the other one's map. The `random` homes are drawn by a seed and chose nothing of the method. *Drove 10 m*: others were
put down where the pilot found no way out, and had not found themselves before. Errors are those in the
kept map, which is laid on the true home as its own path lies best on the true one. A claim is *wrong* that is more than 0.3 m off. *RMSE* and NEES (3 is ideal)
are those of the minute after the claim; NEES in the frame of the map's start, which has the map's error, too.
";

const ODDS: &str = "\
As a whole the kept maps lie turned against their start by TURNED degrees at most: by what the heading was off when the first walls were drawn.

Every search, one a metre of path until the claim, in the home's own map and in those of three other homes by turns, by the natural
logarithm of the odds that its best place was given against all others and elsewhere together; a claim needs 6.9, 1000 to 1, twice.
What is right is within 0.3 m and 0.3 radians of the true place.
";

const _: () = assert!(AFTER_S as usize * 25 == STEPS);
