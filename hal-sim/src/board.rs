//! The simulated board in parts: what a firmware's tasks own, each behind the trait it has on a real board.
//!
//! Motors are H-bridges on simulated PWM and direction outputs, bumper and cliff are digital inputs, the encoders are
//! 16-bit counters. Time passes when [`Board::advance`] is called, or when a task waits on the board's delay.

use core::cell::RefCell;
use core::convert::Infallible;
use std::rc::Rc;

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{ErrorType as DigitalError, InputPin, OutputPin};
use embedded_hal::pwm::{ErrorType as PwmError, SetDutyCycle};
use robot::{
    ContactPins, Contacts, Duty, HBridge, MetricSensor, MotorPair, RangeSensorBank, WheelCounter, WheelEncoders,
};
use slam_core::{RangeInput, Ticks};

use crate::simulation::{MAX_SENSORS, Simulation};

/// Full scale of the simulated PWM.
const FULL_DUTY: u16 = 1000;

#[derive(Clone, Copy, Debug, Default)]
struct MotorOutputs {
    speed: u16,
    forward: bool,
    backward: bool,
}

impl MotorOutputs {
    fn duty(self) -> f32 {
        let speed = f32::from(self.speed) / f32::from(FULL_DUTY);
        match (self.forward, self.backward) {
            (true, false) => speed,
            (false, true) => -speed,
            _ => 0.0,
        }
    }
}

struct Shared {
    simulation: Simulation,
    motors: [MotorOutputs; 2],
    cut: Contacts,
}

impl Shared {
    fn advance(&mut self, period_s: f64) {
        self.simulation.set_duty(Duty { left: self.motors[0].duty(), right: self.motors[1].duty() });
        self.simulation.advance(period_s);
    }
}

/// A simulated board whose parts can be handed out.
#[derive(Clone)]
pub struct Board {
    shared: Rc<RefCell<Shared>>,
}

/// One motor of the simulated board.
pub type SimMotor = HBridge<SimPwm, SimOutput, SimOutput>;

impl Board {
    /// A board in this simulation.
    pub fn new(simulation: Simulation) -> Self {
        let (motors, cut) = ([MotorOutputs::default(); 2], Contacts::default());
        Self { shared: Rc::new(RefCell::new(Shared { simulation, motors, cut })) }
    }

    /// Lets time pass, seconds.
    pub fn advance(&self, period_s: f64) {
        self.shared.borrow_mut().advance(period_s);
    }

    /// Looks at the simulation: truth, coverage, time.
    pub fn with_simulation<T>(&self, look: impl FnOnce(&Simulation) -> T) -> T {
        look(&self.shared.borrow().simulation)
    }

    /// The range sensors.
    pub fn range_sensors(&self) -> SimRanges {
        SimRanges { board: self.clone() }
    }

    /// The sensor with this index, which reports metres.
    pub fn metric_sensor(&self, index: usize) -> SimMetricSensor {
        SimMetricSensor { board: self.clone(), index }
    }

    /// The encoders, counting from zero.
    pub fn encoders(&self) -> SimEncoders {
        let raw = self.with_simulation(Simulation::raw_counters);
        SimEncoders { board: self.clone(), counters: raw.map(WheelCounter::starting_at) }
    }

    /// Both motors on their H-bridges.
    pub fn motors(&self) -> MotorPair<SimMotor, SimMotor> {
        let output = |wheel, backward| SimOutput { board: self.clone(), wheel, backward };
        let motor =
            |wheel| HBridge::new(SimPwm { board: self.clone(), wheel }, output(wheel, false), output(wheel, true));
        MotorPair { left: motor(0), right: motor(1) }
    }

    /// Cuts the cables of these inputs: their pull-up resistors are all that is left.
    pub fn cut(&self, cables: Contacts) {
        self.shared.borrow_mut().cut = cables;
    }

    /// Bumper, cliff and wheel-drop inputs.
    pub fn contacts(&self) -> ContactPins<SimInput, SimInput, SimInput, SimInput> {
        let input = |read| SimInput { board: self.clone(), read };
        ContactPins {
            bump_left: input(|c| c.bump_left),
            bump_right: input(|c| c.bump_right),
            cliff: input(|c| c.cliff),
            lifted: input(|c| c.lifted),
        }
    }

    /// A delay that lets simulated time pass.
    pub fn delay(&self) -> SimDelay {
        SimDelay { board: self.clone() }
    }
}

/// The range sensors behind the simulated converter or bus, all read at once.
pub struct SimRanges {
    board: Board,
}

impl RangeSensorBank<MAX_SENSORS> for SimRanges {
    type Error = Infallible;

    async fn read(&mut self) -> [Result<RangeInput, Infallible>; MAX_SENSORS] {
        self.board.shared.borrow_mut().simulation.read_ranges().map(Ok)
    }
}

/// One sensor that reports metres, on the simulated bus.
pub struct SimMetricSensor {
    board: Board,
    index: usize,
}

impl MetricSensor for SimMetricSensor {
    type Error = NoMetres;

    async fn range_m(&mut self) -> Result<Option<f32>, NoMetres> {
        match self.board.shared.borrow_mut().simulation.read_ranges().get(self.index) {
            Some(RangeInput::Metres(metres)) => Ok(Some(*metres)),
            Some(RangeInput::Missing) => Ok(None),
            Some(RangeInput::Counts(_)) | None => Err(NoMetres),
        }
    }
}

/// The rig has no sensor with this index that reports metres.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoMetres;

/// The simulated encoders.
pub struct SimEncoders {
    board: Board,
    counters: [WheelCounter; 2],
}

impl WheelEncoders for SimEncoders {
    type Error = Infallible;

    fn ticks(&mut self) -> Result<Ticks, Infallible> {
        let [left, right] = self.board.with_simulation(Simulation::raw_counters);
        Ok(Ticks { left: self.counters[0].update(left), right: self.counters[1].update(right) })
    }
}

/// A simulated PWM output.
pub struct SimPwm {
    board: Board,
    wheel: usize,
}

impl PwmError for SimPwm {
    type Error = Infallible;
}

impl SetDutyCycle for SimPwm {
    fn max_duty_cycle(&self) -> u16 {
        FULL_DUTY
    }

    fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Infallible> {
        self.board.shared.borrow_mut().motors[self.wheel].speed = duty.min(FULL_DUTY);
        Ok(())
    }
}

/// A simulated direction output of an H-bridge.
pub struct SimOutput {
    board: Board,
    wheel: usize,
    backward: bool,
}

impl SimOutput {
    fn set(&mut self, high: bool) {
        let motor = &mut self.board.shared.borrow_mut().motors[self.wheel];
        *if self.backward { &mut motor.backward } else { &mut motor.forward } = high;
    }
}

impl DigitalError for SimOutput {
    type Error = Infallible;
}

impl OutputPin for SimOutput {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.set(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.set(true);
        Ok(())
    }
}

/// A simulated digital input.
pub struct SimInput {
    board: Board,
    read: fn(Contacts) -> bool,
}

impl DigitalError for SimInput {
    type Error = Infallible;
}

impl InputPin for SimInput {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        let shared = self.board.shared.borrow();
        Ok((self.read)(shared.simulation.contacts()) || (self.read)(shared.cut))
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        self.is_high().map(|high| !high)
    }
}

/// A delay in simulated time.
pub struct SimDelay {
    board: Board,
}

impl DelayNs for SimDelay {
    fn delay_ns(&mut self, ns: u32) {
        self.board.advance(f64::from(ns) * 1e-9);
    }
}
