//! A map that the readings contradict is saved before it is forgotten, though the robot drives: its motors are held off for that, and it goes on
//! afterwards, looking for itself.
//!
//! One test only: the clock is one for the whole process.

mod common;

use common::home::{Home, place};
use common::ranges::Ranges;
use core::cell::Cell;
use core::convert::Infallible;
use firmware::SENSORS;
use robot::RangeSensorBank;
use robot::rig::BuiltIn;
use slam_core::RangeInput;
use wire::{Command, PlaceState};

/// Range sensors that see the home, or anything else, as those of a robot that was carried elsewhere do.
struct Astray<'a> {
    ranges: Ranges,
    is_astray: &'a Cell<bool>,
    readings: u32,
}

impl RangeSensorBank<SENSORS> for Astray<'_> {
    type Error = Infallible;

    async fn read(&mut self) -> [Result<RangeInput, Infallible>; SENSORS] {
        let seen = self.ranges.read().await;
        let is_astray = self.is_astray.get();
        seen.map(|range| {
            self.readings = self.readings.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            match range {
                // Something stands before the wall or behind it, at another place each time.
                Ok(RangeInput::Counts(counts)) if is_astray => {
                    let times = 0.5 + 1.5 * (self.readings >> 8) as f32 / (1 << 24) as f32;
                    Ok(RangeInput::Counts((f32::from(counts) * times).min(4000.0) as u16))
                }
                other => other,
            }
        })
    }
}

#[test]
fn a_contradicted_map_is_saved_before_it_is_forgotten() {
    let (home, is_astray) = (Home::new("flat", BuiltIn::Sharp), Cell::new(false));
    let ranges = Astray { ranges: Ranges(home.board.range_sensors()), is_astray: &is_astray, readings: 1 };
    home.run(BuiltIn::Sharp, ranges, |tasks| {
        home.command(Command::Start);
        tasks.drive(180.0);
        // It may save its map for other reasons before that is contradicted.
        let mut driving = place(&home.heard()).expect("the place is told");
        assert_eq!(driving.state, PlaceState::Tracking);
        is_astray.set(true);
        let mut saved = None;
        let mut off_ms = 0;
        for _ in 0..6000 {
            tasks.drive(0.02);
            off_ms += if home.enabled.get() { 0 } else { 20 };
            match place(&home.heard()) {
                Some(place) if place.state == PlaceState::Tracking => (driving, off_ms) = (place, 0),
                Some(place) if place.saves > driving.saves => {
                    saved = Some(place);
                    break;
                }
                _ => {}
            }
        }
        let saved = saved.expect("the map is saved");
        assert_eq!(
            (saved.state, saved.saves, saved.failed, saved.lost),
            (PlaceState::Searching, driving.saves + 1, 0, 1)
        );
        assert!(off_ms > 0, "with its motors off");
        is_astray.set(false);
        let before = home.truth();
        tasks.drive(10.0);
        let after = home.truth();
        assert!(home.enabled.get(), "and they are on again");
        let moved_m = (after.x_m - before.x_m).hypot(after.y_m - before.y_m);
        assert!(moved_m > 0.2, "it goes on: {moved_m} m");
    });
}
