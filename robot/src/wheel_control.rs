//! Wheel-speed control: one PI controller per wheel with feed-forward.

use slam_core::Ticks;

use crate::condition::StallWatch;
use crate::traits::{Duty, WheelSpeeds};

/// Gains and limits, the same for both wheels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelControlConfig {
    /// Travel of a wheel per encoder tick, metres.
    pub metres_per_tick: f32,
    /// Speed at full duty without load, m/s: the feed-forward.
    pub full_speed_mps: f32,
    /// Duty per m/s of error.
    pub proportional: f32,
    /// Duty per metre of accumulated error.
    pub integral: f32,
}

impl Default for WheelControlConfig {
    fn default() -> Self {
        Self { metres_per_tick: 0.000_445, full_speed_mps: 0.6, proportional: 0.4, integral: 2.5 }
    }
}

/// Holds the speed of both wheels.
#[derive(Clone, Debug)]
pub struct WheelControl {
    config: WheelControlConfig,
    last: Option<Ticks>,
    integral: [f32; 2],
}

impl WheelControl {
    /// A controller at rest.
    pub fn new(config: WheelControlConfig) -> Self {
        Self { config, last: None, integral: [0.0; 2] }
    }

    /// A watch over the same wheels.
    pub fn stall_watch(&self) -> StallWatch {
        StallWatch::new(self.config.metres_per_tick, self.config.full_speed_mps)
    }

    /// The duty for the next period: `ticks` are the counts now, `period_s` the time since the last call.
    pub fn update(&mut self, target: WheelSpeeds, ticks: Ticks, period_s: f32) -> Duty {
        let last = self.last.replace(ticks).unwrap_or(ticks);
        if target == WheelSpeeds::STOP || period_s.is_nan() || period_s <= 0.0 {
            self.integral = [0.0; 2];
            return Duty::default();
        }
        let speed = |now: i32, before: i32| now.wrapping_sub(before) as f32 * self.config.metres_per_tick / period_s;
        let left_mps = speed(ticks.left, last.left);
        let right_mps = speed(ticks.right, last.right);
        Duty {
            left: self.wheel(0, target.left_mps, left_mps, period_s),
            right: self.wheel(1, target.right_mps, right_mps, period_s),
        }
    }

    fn wheel(&mut self, wheel: usize, target_mps: f32, speed_mps: f32, period_s: f32) -> f32 {
        if !target_mps.is_finite() {
            return 0.0;
        }
        let error_mps = target_mps - speed_mps;
        let integral = self.integral[wheel] + error_mps * period_s;
        let duty = target_mps / self.config.full_speed_mps
            + self.config.proportional * error_mps
            + self.config.integral * integral;
        let limited = duty.clamp(-1.0, 1.0);
        // Anti-windup: the integral grows only while the output can follow, or when it leads out of the limit.
        if duty == limited || error_mps * duty < 0.0 {
            self.integral[wheel] = integral;
        }
        limited
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A motor with lag and friction; returns the speed after each 20 ms.
    fn run(target_mps: f32, steps: usize, control: &mut WheelControl, blocked: bool) -> f32 {
        let (mut speed, mut travel) = (0.0_f32, 0.0_f32);
        for _ in 0..steps {
            let ticks = (travel / control.config.metres_per_tick) as i32;
            let target = WheelSpeeds { left_mps: target_mps, right_mps: target_mps };
            let duty = control.update(target, Ticks { left: ticks, right: ticks }, 0.02).left;
            assert!(duty.abs() <= 1.0);
            let drive = if duty.abs() < 0.05 { 0.0 } else { duty * 0.5 };
            speed += 0.2 * (drive - speed);
            if blocked {
                speed = 0.0;
            }
            travel += speed * 0.02;
        }
        speed
    }

    #[test]
    fn the_speed_is_reached_with_a_weaker_motor_than_assumed() {
        for target in [0.05, 0.25, -0.25] {
            let mut control = WheelControl::new(WheelControlConfig::default());
            let speed = run(target, 300, &mut control, false);
            assert!((speed - target).abs() < 0.02, "{target}: {speed}");
        }
    }

    #[test]
    fn a_blocked_wheel_does_not_wind_up_without_limit() {
        let mut control = WheelControl::new(WheelControlConfig::default());
        run(0.3, 3000, &mut control, true);
        assert!(control.integral[0] * control.config.integral < 1.1);
    }

    #[test]
    fn stop_is_zero_duty_at_once_and_forgets() {
        let mut control = WheelControl::new(WheelControlConfig::default());
        run(0.3, 100, &mut control, true);
        let ticks = Ticks { left: 1000, right: 1000 };
        assert_eq!(control.update(WheelSpeeds::STOP, ticks, 0.02), Duty::default());
        assert_eq!(control.integral, [0.0; 2]);
    }
}
