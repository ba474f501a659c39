//! A bare program that sweeps three rooms and the corridors between them, and drives through them by the pilot, and prints what a step of
//! either costs. It is a program of its own: beside the estimator's cases the memory would not do.
#![no_std]
#![no_main]
#![forbid(unsafe_code)]

#[path = "cases/floor_home.rs"]
mod floor_home;

use floor_home::FloorHome;
use instruction_count::{Bench, finish};
use robot::{FloorConfig, FloorJob, FloorState, Pilot, PilotConfig, Senses, WheelSpeeds};
use static_cell::StaticCell;

/// More steps than the job takes.
const MOST_STEPS: u32 = 80_000;
/// Steps of the pilot: as many as it takes for two rounds and more.
const PILOT_STEPS: u32 = 10_000;

static JOB: StaticCell<FloorJob<8>> = StaticCell::new();
static PILOT: StaticCell<Pilot<8>> = StaticCell::new();

/// Instructions of steps.
#[derive(Default)]
struct Costs {
    speeds: WheelSpeeds,
    worst: u32,
    sum: u64,
    steps: u32,
}

impl Costs {
    /// Drives on for a period, and counts what is decided.
    fn step(&mut self, bench: &Bench, home: &mut FloorHome, mut decide: impl FnMut(&Senses<8>) -> WheelSpeeds) {
        let senses = home.next(self.speeds);
        let (speeds, cost) = bench.measure(|| decide(&senses));
        self.speeds = speeds;
        self.worst = self.worst.max(cost);
        self.sum += u64::from(cost);
        self.steps += 1;
    }

    fn average(&self) -> u32 {
        (self.sum / u64::from(self.steps.max(1))) as u32
    }
}

#[cortex_m_rt::entry]
fn main() -> ! {
    let bench = Bench::start();
    let rig = robot::rig::default_rig::<8>();
    let job = JOB.init_with(|| FloorJob::new(FloorConfig::default(), &rig));
    job.align(0.0);
    let (mut home, mut costs) = (FloorHome::new(rig.clone()), Costs::default());
    while !job.is_over() {
        assert!(costs.steps < MOST_STEPS, "the job is at {:?} after {MOST_STEPS} steps", job.progress());
        costs.step(&bench, &mut home, |senses| job.step(senses));
    }
    let progress = job.progress();
    assert!(progress.state == FloorState::Done && progress.share() > 0.9, "{progress:?}");
    bench.print("floor_job_average", costs.average());
    bench.print("floor_job_worst", costs.worst);
    let pilot = PILOT.init_with(|| Pilot::new(PilotConfig::default(), &rig));
    let (mut home, mut costs) = (FloorHome::new(rig), Costs::default());
    (0..PILOT_STEPS).for_each(|_| costs.step(&bench, &mut home, |senses| pilot.step(senses)));
    assert!(pilot.rounds() >= 2, "{} rounds", pilot.rounds());
    bench.print("pilot_average", costs.average());
    bench.print("pilot_worst", costs.worst);
    finish()
}
