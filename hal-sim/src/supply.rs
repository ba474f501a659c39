//! The simulated battery, and the dock that charges it.

use crate::plan::{Battery, Plan};
use crate::pose::Pose2;

/// Voltage of three lithium cells, empty and full, volts: taken as a straight line between.
const EMPTY_V: f64 = 9.9;
const FULL_V: f64 = 12.6;

/// The contacts meet within this far to each side, metres: what the dock's funnel forgives.
const FUNNEL_M: f64 = 0.03;
/// The contacts meet from so far before the dock's end, metres, up to it.
const REACH_M: f64 = 0.005;
/// And within this angle, radians.
const FUNNEL_RAD: f64 = 0.17;

/// Battery and dock.
#[derive(Clone, Debug)]
pub(crate) struct Supply {
    /// Where a docked robot is.
    dock: Option<Pose2>,
    battery: Option<Battery>,
    is_charging: bool,
}

impl Supply {
    pub(crate) fn new(plan: &Plan, start: Pose2) -> Self {
        let dock = plan.has_dock.then_some(plan.start);
        Self { dock, battery: plan.battery, is_charging: dock == Some(start) }
    }

    /// After a step of the physics from `before`: the dock's end stops the robot, its contacts charge the battery, which drives the
    /// robot where it is not empty.
    pub(crate) fn advance(&mut self, before: &Pose2, pose: &mut Pose2, period_s: f64) {
        if let Some(dock) = self.dock {
            let [ahead_m, left_m] = dock.inverse_transform([pose.x_m, pose.y_m]);
            let [ahead_before_m, _] = dock.inverse_transform([before.x_m, before.y_m]);
            let off_rad = libm::remainder(pose.theta_rad - dock.theta_rad, core::f64::consts::TAU);
            let is_within = left_m.abs() < FUNNEL_M && off_rad.abs() < FUNNEL_RAD;
            if is_within && ahead_m > 0.0 && ahead_before_m < 0.5 * FUNNEL_M {
                let [x_m, y_m] = dock.transform([0.0, left_m]);
                (pose.x_m, pose.y_m) = (x_m, y_m);
            }
            self.is_charging = is_within && (-REACH_M..=REACH_M).contains(&ahead_m.min(0.0));
        }
        if let Some(battery) = &mut self.battery {
            let change = if self.is_charging { 1.0 / battery.charges_min } else { -1.0 / battery.lasts_min };
            battery.charge = (battery.charge + change * period_s / 60.0).clamp(0.0, 1.0);
        }
    }

    /// Whether the motors have no power.
    pub(crate) fn is_empty(&self) -> bool {
        self.battery.is_some_and(|battery| battery.charge <= 0.0)
    }

    pub(crate) fn is_charging(&self) -> bool {
        self.is_charging
    }

    pub(crate) fn battery_v(&self) -> Option<f32> {
        self.battery.map(|battery| (EMPTY_V + battery.charge * (FULL_V - EMPTY_V)) as f32)
    }
}
