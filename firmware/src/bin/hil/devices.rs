//! The simulated board: inputs as the host said last, outputs as the tasks set them last.

use crate::stack;
use core::cell::{Cell, RefCell};
use core::convert::Infallible;
use core::future::pending;
use embassy_sync::blocking_mutex::Mutex;
use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex as Raw;
use embassy_sync::pipe::Pipe;
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use embedded_hal_async::digital::Wait;
use embedded_io_async::{ErrorType as IoErrorType, Read, Write};
use firmware::SENSORS;
use firmware::tasks::Platform;
use heapless::Vec;
use robot::{Contacts, DriveMotors, Duty, PowerSupply, WheelEncoders};
use slam_core::{RangeInput, Ticks};
use wire::Sample;

#[derive(Clone, Copy)]
struct Inputs {
    ranges: [RangeInput; SENSORS],
    ticks: Ticks,
    contacts: Contacts,
    docked: bool,
}

static INPUTS: Mutex<Raw, Cell<Inputs>> = Mutex::new(Cell::new(Inputs {
    ranges: [RangeInput::Missing; SENSORS],
    ticks: Ticks { left: 0, right: 0 },
    contacts: Contacts { bump_left: false, bump_right: false, cliff: false, lifted: false },
    docked: false,
}));
static DUTY: Mutex<Raw, Cell<Duty>> = Mutex::new(Cell::new(Duty { left: 0.0, right: 0.0 }));
static ENABLED: Mutex<Raw, Cell<bool>> = Mutex::new(Cell::new(false));
static SAID: Mutex<Raw, RefCell<Vec<u8, 2048>>> = Mutex::new(RefCell::new(Vec::new()));
static HEARD: Pipe<Raw, 256> = Pipe::new();

/// Sets what the sensors show from now on.
pub fn set_inputs(sample: &Sample) {
    let slam_core::Sample { ranges, .. } = sample.to_slam();
    let ticks = Ticks { left: sample.left_ticks, right: sample.right_ticks };
    let wire::Contacts { bump_left, bump_right, cliff, lifted, docked } = sample.contacts;
    let contacts = Contacts { bump_left, bump_right, cliff, lifted };
    INPUTS.lock(|inputs| inputs.set(Inputs { ranges, ticks, contacts, docked }));
}

/// What the motors are given now.
pub fn duty() -> Duty {
    if ENABLED.lock(Cell::get) { DUTY.lock(Cell::get) } else { Duty::default() }
}

/// Hands on what was written to the serial line since the last call. It stays where it is meanwhile: this runs above all tasks, and a
/// copy on the stack would count for the robot's.
pub fn hand_on_said(to: impl FnOnce(&[u8])) {
    SAID.lock(|said| {
        let mut said = said.borrow_mut();
        to(&said);
        said.clear();
    });
}

/// Puts bytes onto the serial line; those that find no room are lost.
pub fn hear(bytes: &[u8]) {
    // The commands task takes them before the next ones come.
    let _ = HEARD.try_write(bytes);
}

/// What the range sensors show now.
pub fn ranges() -> [RangeInput; SENSORS] {
    INPUTS.lock(Cell::get).ranges
}

/// The encoders.
pub struct Encoders;

impl WheelEncoders for Encoders {
    type Error = Infallible;

    fn ticks(&mut self) -> Result<Ticks, Infallible> {
        Ok(INPUTS.lock(Cell::get).ticks)
    }
}

/// The motors.
pub struct Motors;

/// A robot without a battery gauge, in its dock where the inputs say so.
pub struct Dock;

impl PowerSupply for Dock {
    fn battery_v(&mut self) -> Option<f32> {
        None
    }

    fn is_charging(&mut self) -> bool {
        INPUTS.lock(|inputs| inputs.get().docked)
    }
}

impl DriveMotors for Motors {
    type Error = Infallible;

    fn set_duty(&mut self, duty: Duty) -> Result<(), Infallible> {
        DUTY.lock(|cell| cell.set(duty));
        Ok(())
    }
}

/// The motor driver's enable input.
pub struct Enable;

impl ErrorType for Enable {
    type Error = Infallible;
}

impl OutputPin for Enable {
    fn set_low(&mut self) -> Result<(), Infallible> {
        ENABLED.lock(|cell| cell.set(false));
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        ENABLED.lock(|cell| cell.set(true));
        Ok(())
    }
}

/// A bumper or cliff input.
pub struct Input(pub fn(Contacts) -> bool);

impl ErrorType for Input {
    type Error = Infallible;
}

impl InputPin for Input {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(self.0(INPUTS.lock(Cell::get).contacts))
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        self.is_high().map(|high| !high)
    }
}

/// There are no edges between two moments of the clock: the guard's own look finds the level.
impl Wait for Input {
    async fn wait_for_high(&mut self) -> Result<(), Infallible> {
        pending().await
    }

    async fn wait_for_low(&mut self) -> Result<(), Infallible> {
        pending().await
    }

    async fn wait_for_rising_edge(&mut self) -> Result<(), Infallible> {
        pending().await
    }

    async fn wait_for_falling_edge(&mut self) -> Result<(), Infallible> {
        pending().await
    }

    async fn wait_for_any_edge(&mut self) -> Result<(), Infallible> {
        pending().await
    }
}

/// The serial line.
pub struct Line;

impl IoErrorType for Line {
    type Error = embedded_io_async::ErrorKind;
}

impl Write for Line {
    async fn write(&mut self, bytes: &[u8]) -> Result<usize, Self::Error> {
        let said = SAID.lock(|said| said.borrow_mut().extend_from_slice(bytes));
        said.map(|()| bytes.len()).map_err(|_| embedded_io_async::ErrorKind::OutOfMemory)
    }

    async fn flush(&mut self) -> Result<(), Self::Error> {
        Ok(())
    }
}

impl Read for Line {
    async fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Self::Error> {
        Ok(HEARD.read(bytes).await)
    }
}

/// The processor: there is no watchdog in the loop, whose clock stands still while the host thinks.
pub struct Emulated;

impl Platform for Emulated {
    fn feed_watchdog(&mut self) {}

    fn stack_used_bytes(&mut self) -> u32 {
        stack::used_bytes()
    }
}
