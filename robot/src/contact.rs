//! Bumper, cliff and wheel drop: inputs that stop the wheels without waiting for the estimator.

use embedded_hal::digital::InputPin;

use crate::traits::WheelSpeeds;

/// What the robot touches, or is about to fall over.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Contacts {
    /// The left half of the front bumper is pressed.
    pub bump_left: bool,
    /// The right half of the front bumper is pressed.
    pub bump_right: bool,
    /// There is no floor under the front.
    pub cliff: bool,
    /// A wheel hangs: the robot is off the floor.
    pub lifted: bool,
}

impl Contacts {
    /// Whether driving on is forbidden.
    pub fn any(&self) -> bool {
        self.touches() || self.lifted
    }

    /// Whether it touches something, or is about to fall over: not where it is off the floor.
    pub fn touches(&self) -> bool {
        self.bump_left || self.bump_right || self.cliff
    }

    /// The same where something else stops it, too, which counts as straight ahead.
    #[must_use]
    pub(crate) fn or_stopped(self, is_stopped: bool) -> Self {
        Self { bump_left: self.bump_left || is_stopped, bump_right: self.bump_right || is_stopped, ..self }
    }

    /// What is touched in one of both.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            bump_left: self.bump_left || other.bump_left,
            bump_right: self.bump_right || other.bump_right,
            cliff: self.cliff || other.cliff,
            lifted: self.lifted || other.lifted,
        }
    }

    /// Whether something is touched that was not touched before.
    pub fn struck_since(&self, before: Self) -> bool {
        let new = |now: bool, before: bool| now && !before;
        new(self.bump_left, before.bump_left)
            || new(self.bump_right, before.bump_right)
            || new(self.cliff, before.cliff)
            || new(self.lifted, before.lifted)
    }

    /// The command that may be carried out: while anything is touched the robot may turn or back off, not advance; off the
    /// floor its wheels stand.
    pub fn guard(&self, command: WheelSpeeds) -> WheelSpeeds {
        if self.lifted || (self.any() && command.is_forward()) { WheelSpeeds::STOP } else { command }
    }
}

/// Whether the robot is off the floor, and not only a wheel over a threshold.
///
/// Wheel-drop switches tell of both. A wheel that crosses an edge hangs for as long as it takes to drive over its own width, a third of a
/// second; whoever lifts the robot has it off the floor for longer than half a second. What moves it in less is a kick.
#[derive(Clone, Copy, Debug, Default)]
pub struct Lift {
    steps: u8,
}

/// A wheel hangs for so many steps at most on the floor, half a second; a contact bounces for less.
const MOMENT: u8 = 12;

impl Lift {
    /// On the floor.
    pub const NONE: Self = Self { steps: 0 };

    /// A step in which a wheel hangs, or not; whether the robot is off the floor.
    pub fn step(&mut self, hangs: bool) -> bool {
        self.steps = if hangs { self.steps.saturating_add(1) } else { 0 };
        self.steps > MOMENT
    }
}

/// A contact that bounces, such as the dock's: it has closed or opened when it did so for half a second.
#[derive(Clone, Copy, Debug, Default)]
pub struct Debounce {
    is_closed: bool,
    differs: u8,
}

impl Debounce {
    /// Open.
    pub const OPEN: Self = Self { is_closed: false, differs: 0 };

    /// A step in which the contact is found closed, or not; whether it counts as closed.
    pub fn step(&mut self, is_closed: bool) -> bool {
        self.differs = if is_closed == self.is_closed { 0 } else { self.differs + 1 };
        if self.differs >= MOMENT {
            *self = Self { is_closed, differs: 0 };
        }
        self.is_closed
    }
}

/// Whether something is touched on end, whatever the robot does about it: a bumper that is jammed, a cliff sensor under dust.
///
/// From what it runs into a robot gets away: it backs off, turns, and at last goes back the way that it came. In forty random homes nothing that
/// stood on the floor was touched for three seconds on end, and somebody who pushed the robot about for six at most.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Insistence {
    steps: u16,
}

/// So many steps on end, 10 s, are too many.
const INSISTS: u16 = 250;

impl Insistence {
    pub(crate) const NONE: Self = Self { steps: 0 };

    /// A step in which the robot tried to get away from something that it touched, or not.
    pub(crate) fn step(&mut self, is_touched: bool) {
        self.steps = if is_touched { self.steps.saturating_add(1) } else { 0 };
    }

    /// Whether it is no use.
    pub(crate) fn is_for_good(self) -> bool {
        self.steps > INSISTS
    }
}

/// Bumper switches, cliff sensor and wheel-drop switches on digital inputs with pull-up resistors: a switch that is not
/// pressed, a sensor that sees the floor and a wheel that carries hold their input low. An input is high when touched, and
/// just so when its cable is cut.
#[derive(Debug)]
pub struct ContactPins<L, R, C, D> {
    /// Left half of the bumper.
    pub bump_left: L,
    /// Right half of the bumper.
    pub bump_right: R,
    /// Cliff sensor.
    pub cliff: C,
    /// Wheel-drop switches, all in series.
    pub lifted: D,
}

impl<L: InputPin, R: InputPin, C: InputPin, D: InputPin> ContactPins<L, R, C, D> {
    /// The state of all four. An input that cannot be read counts as touched: the robot stands rather than falls.
    pub fn read(&mut self) -> Contacts {
        Contacts {
            bump_left: self.bump_left.is_high().unwrap_or(true),
            bump_right: self.bump_right.is_high().unwrap_or(true),
            cliff: self.cliff.is_high().unwrap_or(true),
            lifted: self.lifted.is_high().unwrap_or(true),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_release_strikes_nothing() {
        let left = Contacts { bump_left: true, ..Contacts::default() };
        let both = Contacts { cliff: true, ..left };
        assert!(left.struck_since(Contacts::default()) && both.struck_since(left));
        assert!(!left.struck_since(both) && !left.struck_since(left) && !Contacts::default().struck_since(both));
    }

    #[test]
    fn a_wheel_over_a_threshold_is_no_lift() {
        let mut lift = Lift::NONE;
        let steps = |lift: &mut Lift, hangs: bool, steps: usize| (0..steps).filter(|_| lift.step(hangs)).count();
        assert_eq!(steps(&mut lift, true, 12), 0);
        assert!(!lift.step(false));
        assert_eq!(steps(&mut lift, true, 312), 300);
        assert!(!lift.step(false));
    }

    #[test]
    fn a_contact_that_bounces_stays_as_it_was_until_it_settles() {
        let mut contact = Debounce::OPEN;
        let mut steps = |is_closed: bool, steps: usize| (0..steps).filter(|_| contact.step(is_closed)).count();
        assert_eq!(steps(true, 11), 0);
        assert_eq!(steps(false, 1), 0, "one sample is none");
        assert_eq!(steps(true, 20), 9);
        assert_eq!(steps(false, 11), 11);
        assert_eq!(steps(true, 1), 1);
        assert_eq!(steps(false, 20), 11);
    }

    #[test]
    fn an_input_that_cannot_be_read_counts_as_touched() {
        struct Broken;
        impl embedded_hal::digital::ErrorType for Broken {
            type Error = embedded_hal::digital::ErrorKind;
        }
        impl InputPin for Broken {
            fn is_high(&mut self) -> Result<bool, Self::Error> {
                Err(embedded_hal::digital::ErrorKind::Other)
            }
            fn is_low(&mut self) -> Result<bool, Self::Error> {
                Err(embedded_hal::digital::ErrorKind::Other)
            }
        }
        let mut pins = ContactPins { bump_left: Broken, bump_right: Broken, cliff: Broken, lifted: Broken };
        assert_eq!(pins.read(), Contacts { bump_left: true, bump_right: true, cliff: true, lifted: true });
    }

    #[test]
    fn a_pressed_bumper_lets_the_robot_back_off_and_turn_only() {
        let touched = Contacts { bump_left: true, ..Contacts::default() };
        let back = WheelSpeeds { left_mps: -0.1, right_mps: -0.1 };
        let turn = WheelSpeeds { left_mps: -0.1, right_mps: 0.1 };
        let on = WheelSpeeds { left_mps: 0.1, right_mps: 0.2 };
        assert_eq!(touched.guard(on), WheelSpeeds::STOP);
        assert_eq!(touched.guard(back), back);
        assert_eq!(touched.guard(turn), turn);
        assert_eq!(Contacts::default().guard(on), on);
        let lifted = Contacts { lifted: true, ..Contacts::default() };
        assert_eq!([back, turn, on].map(|command| lifted.guard(command)), [WheelSpeeds::STOP; 3]);
    }
}
