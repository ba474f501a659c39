//! Motors behind an H-bridge with one PWM input and two direction inputs (TB6612, L298 and their kin).

use embedded_hal::digital::OutputPin;
use embedded_hal::pwm::SetDutyCycle;

use crate::traits::{DriveMotors, Duty};

/// One motor: a PWM output for its speed, two outputs for its direction (both high: the motor's terminals are joined, which brakes it; both
/// low: it coasts).
#[derive(Debug)]
pub struct HBridge<P, F, B> {
    speed: P,
    forward: F,
    backward: B,
}

/// Which output failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum HBridgeError<P, F, B> {
    /// The PWM output.
    Speed(P),
    /// The forward direction output.
    Forward(F),
    /// The backward direction output.
    Backward(B),
}

type Failure<P, F, B> = HBridgeError<
    <P as embedded_hal::pwm::ErrorType>::Error,
    <F as embedded_hal::digital::ErrorType>::Error,
    <B as embedded_hal::digital::ErrorType>::Error,
>;

impl<P: SetDutyCycle, F: OutputPin, B: OutputPin> HBridge<P, F, B> {
    /// A motor on these outputs. They are not touched until the first [`HBridge::set`].
    pub fn new(speed: P, forward: F, backward: B) -> Self {
        Self { speed, forward, backward }
    }

    /// Drive with a share of the supply, -1 to 1; 0 brakes. On a change of direction the motor is braked or coasts in between.
    ///
    /// # Errors
    /// The output that could not be set.
    pub fn set(&mut self, duty: f32) -> Result<(), Failure<P, F, B>> {
        let duty = if duty.is_finite() { duty.clamp(-1.0, 1.0) } else { 0.0 };
        if duty < 0.0 {
            self.forward.set_low().map_err(HBridgeError::Forward)?;
        }
        if duty > 0.0 {
            self.backward.set_low().map_err(HBridgeError::Backward)?;
        }
        if duty >= 0.0 {
            self.forward.set_high().map_err(HBridgeError::Forward)?;
        }
        if duty <= 0.0 {
            self.backward.set_high().map_err(HBridgeError::Backward)?;
        }
        let full = self.speed.max_duty_cycle();
        // An L298 brakes while its PWM input is high only; to a TB6612 it is no matter.
        let share = if duty == 0.0 { 1.0 } else { duty.abs() };
        let counts = libm::roundf(share * f32::from(full)) as u16;
        self.speed.set_duty_cycle(counts.min(full)).map_err(HBridgeError::Speed)
    }

    /// Gives the outputs back.
    pub fn release(self) -> (P, F, B) {
        (self.speed, self.forward, self.backward)
    }
}

/// Both motors, each on its own bridge.
#[derive(Debug)]
pub struct MotorPair<L, R> {
    /// Left motor.
    pub left: L,
    /// Right motor.
    pub right: R,
}

impl<P: SetDutyCycle, F: OutputPin, B: OutputPin> DriveMotors for MotorPair<HBridge<P, F, B>, HBridge<P, F, B>> {
    type Error = Failure<P, F, B>;

    fn set_duty(&mut self, duty: Duty) -> Result<(), Self::Error> {
        // The right wheel is set even when the left one fails: a stop must reach both.
        let left = self.left.set(duty.left);
        let right = self.right.set(duty.right);
        left.and(right)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::convert::Infallible;

    #[derive(Default)]
    struct Pin(bool);
    #[derive(Default)]
    struct Pwm(u16);

    impl embedded_hal::digital::ErrorType for Pin {
        type Error = Infallible;
    }
    impl OutputPin for Pin {
        fn set_low(&mut self) -> Result<(), Infallible> {
            self.0 = false;
            Ok(())
        }
        fn set_high(&mut self) -> Result<(), Infallible> {
            self.0 = true;
            Ok(())
        }
    }
    impl embedded_hal::pwm::ErrorType for Pwm {
        type Error = Infallible;
    }
    impl SetDutyCycle for Pwm {
        fn max_duty_cycle(&self) -> u16 {
            1000
        }
        fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
            self.0 = duty;
            Ok(())
        }
    }

    fn outputs(duty: f32) -> (u16, bool, bool) {
        let mut bridge = HBridge::new(Pwm::default(), Pin::default(), Pin::default());
        bridge.set(0.7).unwrap();
        bridge.set(duty).unwrap();
        let (speed, forward, backward) = bridge.release();
        (speed.0, forward.0, backward.0)
    }

    #[test]
    fn duty_becomes_pwm_and_direction() {
        assert_eq!(outputs(0.25), (250, true, false));
        assert_eq!(outputs(-0.25), (250, false, true));
        assert_eq!(outputs(0.0), (1000, true, true), "it brakes");
    }

    #[test]
    fn impossible_duties_are_limited_or_stop() {
        assert_eq!(outputs(7.0), (1000, true, false));
        assert_eq!(outputs(-7.0), (1000, false, true));
        assert_eq!(outputs(f32::NAN), (1000, true, true));
    }
}
