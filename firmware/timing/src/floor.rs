//! A bare program that sweeps two rooms and the corridor between them and prints what a step of the floor job costs. It is a program
//! of its own: beside the estimator's cases the memory would not do.
#![no_std]
#![no_main]
#![forbid(unsafe_code)]

#[path = "cases/floor_home.rs"]
mod floor_home;

use floor_home::FloorHome;
use instruction_count::{Bench, finish};
use robot::{FloorConfig, FloorJob, FloorState, WheelSpeeds};
use static_cell::StaticCell;

/// More steps than the job takes.
const MOST_STEPS: u32 = 40_000;

static JOB: StaticCell<FloorJob<8>> = StaticCell::new();

#[cortex_m_rt::entry]
fn main() -> ! {
    let bench = Bench::start();
    let rig = robot::rig::default_rig::<8>();
    let job = JOB.init_with(|| FloorJob::new(FloorConfig::default(), &rig));
    job.align(0.0);
    let mut home = FloorHome::new(rig);
    let (mut speeds, mut worst, mut sum, mut steps) = (WheelSpeeds::STOP, 0, 0_u64, 0);
    while !job.is_over() {
        assert!(steps < MOST_STEPS, "the job is at {:?} after {MOST_STEPS} steps", job.progress());
        let senses = home.next(speeds);
        let (command, cost) = bench.measure(|| job.step(&senses));
        speeds = command;
        worst = worst.max(cost);
        sum += u64::from(cost);
        steps += 1;
    }
    let progress = job.progress();
    assert!(progress.state == FloorState::Done && progress.share() > 0.9, "{progress:?}");
    bench.print("floor_job_average", (sum / u64::from(steps.max(1))) as u32);
    bench.print("floor_job_worst", worst);
    finish()
}
