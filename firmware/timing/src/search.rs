//! A bare program that finds itself again in a full map and prints what the search costs, step by step. It is a program of its own:
//! beside the estimator's cases the memory would not do.
#![no_std]
#![no_main]
#![forbid(unsafe_code)]

#[path = "cases/home.rs"]
mod home;

use home::{Drive, rig};
use instruction_count::{Bench, finish};
use kept_map::{Record, Writer};
use relocate::{COMPARISONS, Locator, State, Step};
use slam_core::{Config, RobotSlam};
use static_cell::ConstStaticCell;

static ESTIMATOR: ConstStaticCell<RobotSlam> = ConstStaticCell::new(RobotSlam::IDLE);
static KEPT: ConstStaticCell<[u8; 16 * 1024]> = ConstStaticCell::new([0; 16 * 1024]);

/// What the map holds.
const WALLS: usize = 64;
/// More steps than the way up takes.
const MOST_STEPS: u32 = 4_000;
/// Steps of the search on the way down.
const SEARCHED_STEPS: u32 = 1_500;

#[cortex_m_rt::entry]
fn main() -> ! {
    let bench = Bench::start();
    let slam = ESTIMATOR.take();
    slam.start_with_config(rig(), Config::default()).expect("the rig is a valid one");
    let mut home = Drive::new();
    for _ in 0..MOST_STEPS {
        if slam.walls().count() == WALLS {
            break;
        }
        slam.step(&home.next(false));
    }
    let kept = KEPT.take();
    let mut written = 0;
    Writer::new(&*slam, 1, 0).bytes(|piece| {
        kept[written..written + piece.len()].copy_from_slice(piece);
        written += piece.len();
    });
    let record = Record::parse(&kept[..written]).expect("what was written is a record");
    home.turn_back();
    slam.restart_map();
    let mut locator = Locator::new(State::Searching);
    // Of the search under way, and of the costliest.
    let (mut search, mut full, mut slice) = (0_u32, 0, 0);
    for _ in 0..SEARCHED_STEPS {
        slam.step(&home.next(false));
        let step = Step::moved([slam.state_mean(0), slam.state_mean(1)], 0.02);
        let was_searching = locator.is_searching();
        let (event, cost) = bench.measure(|| locator.step(&*slam, Some(&record), &step, COMPARISONS));
        search = if was_searching { search.saturating_add(cost) } else { cost };
        full = full.max(search);
        slice = slice.max(cost);
        if event.is_some() {
            break;
        }
    }
    assert!(locator.verdict().is_some(), "no search ended");
    bench.print("search_full", full);
    bench.print("search_slice", slice);
    finish()
}
