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

/// The mean of the battery's voltage over two seconds: motors that start pull it down.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Battery {
    mean_v: f32,
}

impl Battery {
    /// Empty.
    pub(crate) const ZERO: Self = Self { mean_v: 0.0 };

    /// Nothing is known of it.
    pub(crate) const UNKNOWN: Self = Self { mean_v: f32::NAN };

    /// A step of 40 ms.
    pub(crate) fn step(&mut self, condition: &Condition) {
        let Some(battery_v) = condition.battery_v.filter(|battery_v| battery_v.is_finite()) else { return };
        let before_v = if self.mean_v.is_nan() { battery_v } else { self.mean_v };
        self.mean_v = before_v + 0.02 * (battery_v - before_v);
    }

    /// Whether it is below this voltage, volts; not where it is not measured.
    pub(crate) fn is_below(self, least_v: f32) -> bool {
        self.mean_v < least_v
    }
}

/// From which duty on a motor is driven hard.
const HARD_DUTY: f32 = 0.6;
/// A wheel that turns slower than this share of what its duty gives without load is held; one that turns against a hard duty faster than
/// this share of full speed runs away, for the control soon drives it as hard as it can. A robot that is pushed along brakes gently.
const SLOW_SHARE: f32 = 0.2;
/// So long a motor may be driven hard with its wheel held, seconds: starting against the friction of carpet takes half of that. A wheel that
/// changes its direction at full speed turns against its duty for a tenth of a second.
const STALL_S: f32 = 0.4;
/// So long no wheel is driven on that way after that, seconds: the time to back off.
const REST_S: f32 = 0.5;
/// So long both wheels stand after one ran away, seconds. Its motor or its encoder is wired the wrong way round: the next try ends the same way.
const RUNAWAY_REST_S: f32 = 10.0;

/// Watches for wheels that are driven hard and do not turn, whose motors would burn, and for wheels that run against what drives them, which
/// the control would drive ever harder.
#[derive(Clone, Debug)]
pub struct StallWatch {
    metres_per_tick: f32,
    full_speed_mps: f32,
    last: Option<Ticks>,
    held_s: [f32; 2],
    rest_s: f32,
    /// The way that each wheel was driven when it stalled, while the motors rest: 1 forward, -1 backward, 0 where it did not.
    pressed: [i8; 2],
    is_runaway: bool,
}

impl StallWatch {
    /// A watch over wheels with this travel per tick (metres) and this speed at full duty without load (m/s).
    pub fn new(metres_per_tick: f32, full_speed_mps: f32) -> Self {
        let (held_s, pressed) = ([0.0; 2], [0; 2]);
        Self { metres_per_tick, full_speed_mps, last: None, held_s, rest_s: 0.0, pressed, is_runaway: false }
    }

    /// The counts now, after a period (seconds) at this duty; whether a wheel stalls or runs away, or did just now.
    pub fn update(&mut self, duty: Duty, ticks: Ticks, period_s: f32) -> bool {
        let last = self.last.replace(ticks).unwrap_or(ticks);
        if !(period_s > 0.0 && period_s < 1.0) {
            return self.is_stalled();
        }
        self.rest_s = (self.rest_s - period_s).max(0.0);
        if !self.is_stalled() {
            (self.pressed, self.is_runaway) = ([0; 2], false);
        }
        let turned = [ticks.left.wrapping_sub(last.left), ticks.right.wrapping_sub(last.right)];
        let wheels = self.held_s.iter_mut().zip(&mut self.pressed);
        for (((held_s, pressed), turned), duty) in wheels.zip(turned).zip([duty.left, duty.right]) {
            let along_mps = turned as f32 * self.metres_per_tick / period_s * duty.signum();
            let is_held = duty.abs() > HARD_DUTY && along_mps < SLOW_SHARE * duty.abs() * self.full_speed_mps;
            *held_s = if is_held { *held_s + period_s } else { 0.0 };
            if *held_s > STALL_S {
                (*held_s, *pressed) = (0.0, if duty > 0.0 { 1 } else { -1 });
                self.is_runaway |= along_mps < -SLOW_SHARE * self.full_speed_mps;
                self.rest_s = if self.is_runaway { RUNAWAY_REST_S } else { REST_S };
            }
        }
        self.is_stalled()
    }

    /// Whether a wheel stalls or runs away, or did just now.
    pub fn is_stalled(&self) -> bool {
        self.rest_s > 0.0
    }

    /// The command that may be carried out: after a stall no wheel presses on the way that it stalled; after one ran away both stand.
    pub fn guard(&self, command: WheelSpeeds) -> WheelSpeeds {
        let speeds_mps = [command.left_mps, command.right_mps];
        let presses_on = self.pressed.iter().zip(speeds_mps).any(|(pressed, mps)| f32::from(*pressed) * mps > 0.0);
        if self.is_runaway || presses_on { WheelSpeeds::STOP } else { command }
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

    /// A watch of which the left wheel, driven like this, stood until it stalled, while the right one turned as it was driven.
    fn stalled(left: f32, right: f32) -> StallWatch {
        let mut watch = StallWatch::new(0.000_445, 0.6);
        let mut ticks = Ticks { left: 0, right: 0 };
        while !watch.update(Duty { left, right }, ticks, PERIOD_S) {
            ticks.right += if right > 0.0 { 20 } else { -20 };
        }
        watch
    }

    #[test]
    fn after_a_stall_no_wheel_presses_on_and_then_all_goes_on() {
        let command = |left_mps: f32, right_mps: f32| WheelSpeeds { left_mps, right_mps };
        let (on, back) = (command(0.1, 0.1), command(-0.1, -0.1));
        let (to_left, to_right) = (command(-0.1, 0.1), command(0.1, -0.1));
        let allowed = |watch: &StallWatch| [on, back, to_left, to_right].map(|command| watch.guard(command) == command);
        assert_eq!(allowed(&stalled(0.9, 0.9)), [false, true, true, false]);
        assert_eq!(allowed(&stalled(-0.9, -0.9)), [true, false, false, true], "backward, too");
        assert_eq!(allowed(&stalled(-0.9, 0.9)), [true, false, false, true], "and in a turn");
        let mut watch = stalled(0.9, 0.9);
        (0..30).for_each(|_| {
            watch.update(Duty::default(), Ticks { left: 0, right: 0 }, PERIOD_S);
        });
        assert_eq!(allowed(&watch), [true; 4]);
    }

    /// Its encoder or its motor is wired the wrong way round.
    #[test]
    fn a_wheel_that_runs_against_its_duty_stops_both_for_long() {
        let mut watch = StallWatch::new(0.000_445, 0.6);
        let forward = Duty { left: 0.7, right: 0.7 };
        let runs = (1..100).take_while(|n| !watch.update(forward, Ticks { left: -10 * n, right: 10 * n }, PERIOD_S));
        assert_eq!(runs.count(), 19);
        for command in [0.1, -0.1].map(|mps| WheelSpeeds { left_mps: mps, right_mps: mps }) {
            assert_eq!(watch.guard(command), WheelSpeeds::STOP);
        }
        let stands = |watch: &mut StallWatch| watch.update(Duty::default(), Ticks { left: -210, right: 210 }, PERIOD_S);
        let rests = (0..1000).take_while(|_| stands(&mut watch)).count();
        assert!((490..=500).contains(&rests), "{rests} periods");
    }
}
