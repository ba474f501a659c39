//! Robots that are put down somewhere in a home of which a map is kept: how soon they know where, by the grid and by the project's own
//! search; then, from where the search put them, how well the given walls and the estimator track them in that map.

use std::path::Path;
use std::time::Instant;

use hal_sim::{Plan, Pose2, plan_file};
use lab::evaluate::score::path;
use lab::evaluate::statistics::{mean, median};
use relatives::Relative as _;
use relatives::front::Front;
use relatives::geometry::{Line, Pose, Segment};
use relatives::known::Known;
use relatives::rows::range_hough::RangeHough;
use relocate::{Event, Locator, State, Step};
use slam_core::HostSlam;
use tests::carries::{Driven, SENSORS, carried, drive, rig};

use crate::grid::{Belief, Localiser, is_same};
use crate::rows::{self, Row};

/// The file of what was found.
pub const FILE: &str = "carried.csv";

/// The homes.
pub const HOMES: [&str; 3] = ["room", "l-shape", "flat"];

/// Figures of one carry, in the order of the file.
pub const FIGURES: [&str; 8] =
    ["ours_m", "ours_right", "grid_m", "grid_right", "ours_rmse_m", "given_rmse_m", "driven_m", "grid_us"];

/// Sensors of the robot; seconds of the drive that leaves the map.
const SENSORS_USED: usize = 8;
const MAP_S: f64 = 600.0;
/// A carry ends here, metres and seconds; tracking is scored for so long.
const ENOUGH_M: f64 = 20.0;
const CARRY_S: f64 = 300.0;
const AFTER: usize = 1500;
/// The grid says where it is when it gives a place this probability twice in a row.
const SURE: f64 = 0.9;

/// A home and its kept map.
struct Home {
    plan: Plan,
    kept: Box<HostSlam>,
    walls: Vec<Segment>,
    /// The map's frame in that of the plan's start, as its path lies on the true one best.
    lies: Pose2,
}

/// Carries what is not in the file yet.
///
/// # Errors
/// The file cannot be written.
pub fn run(file: &Path, seeds: u64) -> Result<(), String> {
    for name in HOMES {
        let mut home = None;
        rows::missing(file, name, seeds, |seed| {
            let home = home.get_or_insert_with(|| Home::new(name));
            carry(home, seed).to_vec()
        })?;
    }
    Ok(())
}

fn to_pose(pose: &Pose2) -> Pose {
    Pose::new(pose.x_m, pose.y_m, pose.theta_rad)
}

impl Home {
    fn new(name: &str) -> Self {
        let plan = plan_file::load(name).unwrap_or_else(|error| panic!("{error}"));
        let mut pairs = Vec::new();
        let kept = drive(&plan, &rig(SENSORS_USED), MAP_S, 1, |Driven { slam, in_plan, .. }| {
            pairs.push((slam.pose().into(), plan.start.relative(&in_plan)));
            true
        });
        let line = |rho: f32, a: f32| Line { rho: rho.into(), a: a.into() };
        let walls = kept.walls().map(|w| line(w.rho_m, w.beta_rad).piece([w.lo_m.into(), w.hi_m.into()])).collect();
        Self { plan, kept, walls, lies: path::align(&pairs) }
    }

    /// Where the robot is in the map.
    fn truth(&self, in_plan: &Pose2) -> Pose {
        to_pose(&self.lies).relative(&to_pose(&self.plan.start.relative(in_plan)))
    }
}

/// A robot after it was found: the tracker that is given the map's walls from there, and errors of both.
struct Tracked {
    found: Pose,
    given: RangeHough,
    squares: [Vec<f64>; 2],
}

impl Tracked {
    fn new(home: &Home, found: Pose) -> Self {
        let from =
            |wall: &Segment| Segment { from: found.inverse_transform(wall.from), to: found.inverse_transform(wall.to) };
        let walls: Vec<Segment> = home.walls.iter().map(from).collect();
        Self { found, given: RangeHough::new(Known::new(&walls, 0.0, 0.0, 1)), squares: [Vec::new(), Vec::new()] }
    }

    fn rmse(&self, which: usize) -> f64 {
        mean(&self.squares[which]).map_or(f64::NAN, f64::sqrt)
    }
}

fn carry(home: &Home, seed: u64) -> [f64; FIGURES.len()] {
    let (rig, place) = (rig(SENSORS_USED), carried(&home.plan, seed));
    let mut grid = Localiser::new(&Known::new(&home.walls, 0.0, 0.0, 1));
    let mut front = Front::<SENSORS>::new(rig.clone());
    let mut locator = Locator::new(State::Searching);
    let (mut last_m, mut cost) = (0.0, Vec::new());
    let mut beliefs: Vec<(f64, Belief, bool)> = Vec::new();
    let mut ours: Option<(f64, bool)> = None;
    let mut tracked: Option<Tracked> = None;
    drive(&place, &rig, CARRY_S, seed, |Driven { slam, sample, path_m, in_plan, .. }| {
        let truth = home.truth(&in_plan);
        let travelled_m = (path_m - std::mem::replace(&mut last_m, path_m)) as f32;
        let input = front.read(sample, None);
        let before = Instant::now();
        if let Some(belief) = grid.step(&input) {
            cost.push(1e6 * before.elapsed().as_secs_f64());
            beliefs.push((path_m, belief, is_same(&belief.pose, &truth)));
        }
        if let Some(tracked) = &mut tracked {
            let given = tracked.found.compose(&tracked.given.step(&input).pose);
            for (squares, pose) in tracked.squares.iter_mut().zip([to_pose(&slam.pose().into()), given]) {
                squares.push((pose.at - truth.at).norm_squared());
            }
            return tracked.squares[0].len() < AFTER || path_m < ENOUGH_M;
        }
        let position_m = [slam.state_mean(0), slam.state_mean(1)];
        let step = Step::moved(position_m, travelled_m);
        if let Some(Event::Found(found)) = locator.step(&*slam, Some(&*home.kept), &step, u32::MAX) {
            slam.take_up(&*home.kept, &found).expect("a map to go on in");
            let pose = to_pose(&slam.pose().into());
            ours = Some((path_m, is_same(&pose, &truth)));
            tracked = Some(Tracked::new(home, pose));
        }
        path_m < ENOUGH_M
    });
    let sure = beliefs.windows(2).find(|two| two.iter().all(|(_, belief, _)| belief.mass > SURE)).map(|two| two[1]);
    let flag = |is_right: bool| f64::from(u8::from(is_right));
    [
        ours.map_or(f64::NAN, |ours| ours.0),
        ours.map_or(f64::NAN, |ours| flag(ours.1)),
        sure.map_or(f64::NAN, |sure| sure.0),
        sure.map_or(f64::NAN, |sure| flag(sure.2)),
        tracked.as_ref().map_or(f64::NAN, |tracked| tracked.rmse(0)),
        tracked.as_ref().map_or(f64::NAN, |tracked| tracked.rmse(1)),
        last_m,
        median(&cost).unwrap_or(f64::NAN),
    ]
}

/// Where the grid is ahead of the search, as lines of the page's table of losses.
pub fn losses(found: &[Row]) -> String {
    let line = |home: &&str| {
        let of = |figure: usize| {
            let own = found.iter().filter(|row| row.name == **home).map(|row| row.figures[figure]);
            median(&own.filter(|value| value.is_finite()).collect::<Vec<_>>())
        };
        let (ours, grid) = (of(0)?, of(2)?);
        let next = "claims by the odds of every place from the first wall on, as the grid has them";
        let line = format!(
            "| {home}, carried | path to the claim | {ours:.1} m | {grid:.1} m | after Grossmann and Poli | {next} |\n"
        );
        (grid < ours).then_some(line)
    };
    HOMES.iter().filter_map(line).collect()
}

/// The section of the page.
pub fn section(found: &[Row]) -> String {
    let mut text = crate::words::CARRIED.to_owned();
    for home in HOMES {
        let own: Vec<&Row> = found.iter().filter(|row| row.name == home).collect();
        if own.is_empty() {
            continue;
        }
        let of = |figure: usize| -> Vec<f64> {
            own.iter().map(|row| row.figures[figure]).filter(|value| value.is_finite()).collect()
        };
        let number =
            |value: Option<f64>, scale: f64| value.map_or_else(|| "–".to_owned(), |v| format!("{:.1}", scale * v));
        let found = |metres: usize, right: usize| {
            let wrong = of(right).iter().filter(|right| **right == 0.0).count();
            format!("{} | {} | {wrong}", of(metres).len(), number(median(&of(metres)), 1.0))
        };
        text += &format!(
            "| {home} | {} | {} | {} | {} | {} | {} |\n",
            own.len(),
            found(0, 1),
            found(2, 3),
            number(median(&of(4)), 100.0),
            number(median(&of(5)), 100.0),
            number(of(7).into_iter().reduce(f64::min), 1e-3),
        );
    }
    text + "\n"
}
