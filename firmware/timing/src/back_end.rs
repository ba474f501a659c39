//! A bare program that drives with a back end beside the estimator and prints what writing a step down costs, and handing over.
//! It is a program of its own: beside the estimator's cases the memory would not do.
#![no_std]
#![no_main]
#![forbid(unsafe_code)]

#[path = "cases/home.rs"]
mod home;

use home::{Drive, rig};
use instruction_count::{Bench, finish};
use look_back::{BackEnd, ROBOT_KEYFRAMES, ROBOT_WALLS, STEP_US, border_len, packed_len};
use slam_core::{Config, Outcome, RobotSlam, StepReport};
use static_cell::ConstStaticCell;

const BORDER: usize = border_len(ROBOT_WALLS);
/// A robot's keyframes and walls, and half its groups: there is no memory for more beside the estimator, and no cost here depends
/// on them.
type HalfBackEnd = BackEnd<ROBOT_KEYFRAMES, 512, ROBOT_WALLS, BORDER, { packed_len(BORDER) }>;

static ESTIMATOR: ConstStaticCell<RobotSlam> = ConstStaticCell::new(RobotSlam::IDLE);
static BACK_END: ConstStaticCell<HalfBackEnd> = ConstStaticCell::new(HalfBackEnd::IDLE);

/// Steps up the stairs and back.
const STEPS: u32 = 8_000;
/// What the map holds.
const WALLS: usize = 64;

#[cortex_m_rt::entry]
fn main() -> ! {
    let bench = Bench::start();
    let (slam, back_end) = (ESTIMATOR.take(), BACK_END.take());
    slam.start_with_config(rig(), Config::default()).expect("the rig is a valid one");
    let (mut home, mut is_up) = (Drive::new(), true);
    // Writing down eight hits where nothing has to make room: times, and all of their cost; and the costliest where something has.
    let (mut times, mut cost) = (0, 0);
    let (mut costliest, mut hand_over, mut handing_over, mut work) = (0, 0, 0, Work::default());
    for _ in 0..STEPS {
        let report = slam.step(&home.next(false));
        let before = back_end.diary().losses();
        let ((), recorded) = bench.measure(|| back_end.record(slam, &report));
        if before != back_end.diary().losses() {
            costliest = costliest.max(recorded);
        } else if hits(&report) == 8 {
            times += 1;
            cost += recorded;
        }
        let worked = work.add(&bench, back_end);
        if let (Some(_), taken) = bench.measure(|| back_end.hand_over(slam)) {
            hand_over = hand_over.max(taken);
            handing_over = handing_over.max(worked + taken);
        }
        if is_up && slam.walls().count() == WALLS {
            is_up = false;
            home.turn_back();
        }
    }
    let (taken, refused) = (slam.counters().taken_over, slam.counters().not_taken);
    assert!(taken > 2 && times > 600, "{} taken over, refused {:?}; {} steps with eight hits", taken, refused, times);
    bench.print("diary_step", cost / times);
    bench.print("diary_thin", costliest);
    bench.print("hand_over", hand_over);
    bench.print("back_end_slice", work.slice);
    bench.print("back_end_step", work.step);
    bench.print("back_end_handing_over", handing_over);
    finish()
}

/// What the back end does between two steps.
#[derive(Default)]
struct Work {
    /// The costliest slice.
    slice: u32,
    /// All slices between two steps, where these are costliest.
    step: u32,
}

impl Work {
    /// Does that of one step, and says what it took.
    fn add(&mut self, bench: &Bench, back_end: &mut HalfBackEnd) -> u32 {
        let (mut longest, mut all) = (0, 0);
        back_end.work_by(STEP_US, |back_end| {
            let (operations, taken) = bench.measure(|| back_end.slice());
            longest = longest.max(taken);
            all += taken;
            operations
        });
        self.slice = self.slice.max(longest);
        self.step = self.step.max(all);
        all
    }
}

fn hits(report: &StepReport<8>) -> usize {
    report.readings.iter().filter(|reading| !matches!(reading.outcome, Outcome::Missing | Outcome::Refused(_))).count()
}
