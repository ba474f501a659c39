//! A board with four sensors that report metres over a bus: the tasks map the flat, and a sensor that fails is counted.
//!
//! One test only: the clock is one for the whole process.

mod common;

use common::home::{Home, estimates};
use core::cell::Cell;
use embassy_time::{Duration, Timer};
use firmware::metric::MetricBank;
use hal_sim::board::{NoMetres, SimMetricSensor};
use robot::MetricSensor;
use robot::rig::BuiltIn;
use wire::{Command, Frame, Range, Sample};

/// A sensor at the end of a bus, whose transfers take time, and which can be unplugged.
struct OnBus<'a>(SimMetricSensor, &'a Cell<bool>);

impl MetricSensor for OnBus<'_> {
    type Error = NoMetres;

    async fn range_m(&mut self) -> Result<Option<f32>, NoMetres> {
        Timer::after(Duration::from_micros(500)).await;
        if self.1.get() { self.0.range_m().await } else { Err(NoMetres) }
    }
}

fn samples(said: &[Frame]) -> impl Iterator<Item = &Sample> {
    said.iter().filter_map(|frame| if let Frame::Sample(sample) = frame { Some(sample) } else { None })
}

#[test]
fn four_sensors_on_a_bus_map_the_flat() {
    let home = Home::new("flat", BuiltIn::TimeOfFlight);
    let plugged = [true; 4].map(Cell::new);
    let sensor = |i: usize| OnBus(home.board.metric_sensor(i), &plugged[i]);
    let bank = MetricBank::new([sensor(0), sensor(1), sensor(2), sensor(3)]);
    home.run(BuiltIn::TimeOfFlight, bank, |tasks| {
        home.command(Command::Start);
        tasks.drive(120.0);
        let (said, truth) = (home.heard(), home.truth());
        let last = estimates(&said).next_back().expect("estimates are told");
        let error_m = (f64::from(last.pose[0]) - truth.x_m).hypot(f64::from(last.pose[1]) - truth.y_m);
        assert!(error_m < 0.1, "estimate {:?}, truth {truth:?}", last.pose);
        assert!(last.walls >= 12, "{} walls", last.walls);
        let metres = |sample: &Sample| sample.ranges.iter().filter(|range| matches!(range, Range::Metres(_))).count();
        assert!(samples(&said).map(metres).sum::<usize>() > 3000, "metres travel to the workbench");
        let faults = home.shared.faults.get();
        let lost = [faults.ranges_failed, faults.samples_dropped, faults.late_tasks, faults.dead_man_stops];
        assert_eq!(lost, [0; 4], "{faults:?}");

        // One sensor is unplugged: it is counted, the others go on.
        plugged[2].set(false);
        tasks.drive(1.0);
        assert_eq!(home.shared.faults.get().ranges_failed, 25, "25 readings a second");
        assert!(samples(&home.heard()).all(|sample| sample.ranges[2] == Range::Missing));

        // All are: there is nothing to drive by.
        plugged.iter().for_each(|plug| plug.set(false));
        tasks.drive(1.0);
        let before = home.truth();
        tasks.drive(1.0);
        let after = home.truth();
        assert!((after.x_m - before.x_m).hypot(after.y_m - before.y_m) < 1e-4, "the robot stands: {after:?}");
        assert_eq!(home.shared.faults.get().dead_man_stops, 1);
    });
}
