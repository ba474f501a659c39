//! What the robot feels of its own body besides contacts: battery, charger, wheels that stall.

use slam_core::Ticks;

use crate::traits::{Duty, WheelSpeeds};

/// The state of the robot's own body at one time. The default is that of a robot without a battery gauge and a dock, all well.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Condition {
    /// The battery's voltage, volts; none where it is not measured.
    pub battery_v: Option<f32>,
    /// The charging contact is closed: the robot is in its dock.
    pub is_charging: bool,
    /// A wheel stalls.
    pub is_stalled: bool,
    /// The pose is not in the frame of the map so far: the robot was carried and has not found itself again.
    pub is_lost: bool,
}

/// The battery's voltage and the charging contact.
pub trait PowerSupply {
    /// The battery's voltage, volts; none where it cannot be read.
    fn battery_v(&mut self) -> Option<f32>;

    /// Whether the charging contact is closed. One that cannot be read is open: the robot goes on looking for its dock.
    fn is_charging(&mut self) -> bool;
}

/// A robot without a battery gauge and a charging contact.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoSupply;

impl PowerSupply for NoSupply {
    fn battery_v(&mut self) -> Option<f32> {
        None
    }

    fn is_charging(&mut self) -> bool {
        false
    }
}

/// From which duty on a motor is driven hard.
const HARD_DUTY: f32 = 0.6;
/// A wheel that turns slower than this share of what its duty gives without load is held.
const SLOW_SHARE: f32 = 0.2;
/// So long a motor may be driven hard with its wheel held, seconds: starting against the friction of carpet takes half of that.
const STALL_S: f32 = 0.4;
/// So long the wheels are not driven forward after that, seconds: the time to back off.
const REST_S: f32 = 0.5;

/// Watches for wheels that are driven hard and do not turn: their motors would burn.
#[derive(Clone, Debug)]
pub struct StallWatch {
    metres_per_tick: f32,
    full_speed_mps: f32,
    last: Option<Ticks>,
    held_s: [f32; 2],
    rest_s: f32,
}

impl StallWatch {
    /// A watch over wheels with this travel per tick (metres) and this speed at full duty without load (m/s).
    pub fn new(metres_per_tick: f32, full_speed_mps: f32) -> Self {
        Self { metres_per_tick, full_speed_mps, last: None, held_s: [0.0; 2], rest_s: 0.0 }
    }

    /// The counts now, after a period (seconds) at this duty; whether a wheel stalls, or did just now.
    pub fn update(&mut self, duty: Duty, ticks: Ticks, period_s: f32) -> bool {
        let last = self.last.replace(ticks).unwrap_or(ticks);
        if !(period_s > 0.0 && period_s < 1.0) {
            return self.is_stalled();
        }
        self.rest_s = (self.rest_s - period_s).max(0.0);
        let turned = [ticks.left.wrapping_sub(last.left), ticks.right.wrapping_sub(last.right)];
        for ((held_s, turned), duty) in self.held_s.iter_mut().zip(turned).zip([duty.left, duty.right]) {
            let speed_mps = (turned as f32 * self.metres_per_tick / period_s).abs();
            let is_held = duty.abs() > HARD_DUTY && speed_mps < SLOW_SHARE * duty.abs() * self.full_speed_mps;
            *held_s = if is_held { *held_s + period_s } else { 0.0 };
            if *held_s > STALL_S {
                (*held_s, self.rest_s) = (0.0, REST_S);
            }
        }
        self.is_stalled()
    }

    /// Whether a wheel stalls, or did just now.
    pub fn is_stalled(&self) -> bool {
        self.rest_s > 0.0
    }

    /// The command that may be carried out: after a stall the robot may turn or back off, not advance.
    pub fn guard(&self, command: WheelSpeeds) -> WheelSpeeds {
        if self.is_stalled() && command.is_forward() { WheelSpeeds::STOP } else { command }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD_S: f32 = 0.02;

    /// Whether it stalls at the end of so many periods at this duty with so many ticks in each.
    fn stalls(duty: f32, ticks_a_period: i32, periods: i32) -> bool {
        let mut watch = StallWatch::new(0.000_445, 0.6);
        let both = Duty { left: duty, right: duty };
        let update = |period| {
            let ticks = Ticks { left: 20 * period, right: ticks_a_period * period };
            watch.update(both, ticks, PERIOD_S)
        };
        (0..periods).map(update).last().unwrap_or(false)
    }

    #[test]
    fn a_wheel_that_is_driven_hard_and_stands_stalls_after_a_while() {
        assert!(stalls(0.8, 0, 22) && stalls(-0.8, 0, 22));
        assert!(!stalls(0.8, 0, 18), "it may be starting");
        assert!(!stalls(0.5, 0, 100), "so little the motor bears");
        assert!(!stalls(0.8, 10, 100), "it turns");
    }

    #[test]
    fn after_a_stall_it_may_back_off_and_then_go_on() {
        let mut watch = StallWatch::new(0.000_445, 0.6);
        let still = Ticks { left: 0, right: 0 };
        let hard = Duty { left: 0.9, right: 0.9 };
        while !watch.update(hard, still, PERIOD_S) {}
        let on = WheelSpeeds { left_mps: 0.1, right_mps: 0.1 };
        let back = WheelSpeeds { left_mps: -0.1, right_mps: -0.1 };
        assert_eq!([watch.guard(on), watch.guard(back)], [WheelSpeeds::STOP, back]);
        (0..30).for_each(|_| {
            watch.update(Duty::default(), still, PERIOD_S);
        });
        assert_eq!(watch.guard(on), on);
    }
}
