//! Every pin and peripheral of the robot's board.
//!
//! | pin | what | peripheral |
//! |---|---|---|
//! | PA0, PA1, PA4, PA5, PA6, PA7, PC0, PC1 | Sharp sensors, in the rig's order: 0, 45, 90, 135, 180, -135, -90, -45 degrees | ADC1 |
//! | PC6, PC7 | left encoder A, B | TIM3 |
//! | PB6, PB7 | right encoder A, B | TIM4 |
//! | PA8, PA9 | left, right motor speed, 20 kHz | TIM1 |
//! | PB12, PB13 | left motor forward, backward | |
//! | PB14, PB15 | right motor forward, backward | |
//! | PC8 | motor driver enable (standby when low) | |
//! | PB0, PB1 | bumper left, right: closed to ground until pressed | EXTI0, EXTI1 |
//! | PC4 | cliff sensor: low while it sees the floor | EXTI4 |
//! | PC5 | wheel-drop switches, in series: closed to ground while both wheels carry | EXTI5 |
//! | PC2 | battery's voltage, through 33 kOhm above and 10 kOhm below | ADC2 |
//! | PC3 | charging contact: closed to ground in the dock | |
//! | PA2, PA3 | serial line out, in, 115200 baud | USART2 |
//! | PA13, PA14 | debug probe (SWDIO, SWCLK) | |

use crate::backup_ram::{self, FloorBackup, PoseBackup};
use crate::small_sectors::SmallSectors;
use core::convert::Infallible;
use embassy_stm32::adc::{Adc, AdcChannel, AnyAdcChannel, SampleTime};
use embassy_stm32::exti::{self, ExtiInput};
use embassy_stm32::gpio::{AnyPin, Input, Level, Output, OutputType, Pull, Speed};
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::{ADC1, ADC2, DMA1_CH5, DMA1_CH6, IWDG, TIM1, TIM3, TIM4, USART2};
use embassy_stm32::time::{Hertz, khz};
use embassy_stm32::timer::qei::{self, Qei};
use embassy_stm32::timer::simple_pwm::{PwmPin, SimplePwm, SimplePwmChannel};
use embassy_stm32::usart::{self, RingBufferedUartRx, Uart, UartTx};
use embassy_stm32::wdg::IndependentWatchdog;
use embassy_stm32::{Config, Peri, Peripherals, bind_interrupts, dma, interrupt, rcc};
use firmware::SENSORS;
use firmware::burst::{BurstBank, Converter};
use robot::{ContactPins, HBridge, MotorPair, PowerSupply, WheelCounter, WheelEncoders};
use slam_core::Ticks;
use static_cell::ConstStaticCell;
use stm32_metapac::timer::vals::FilterValue;
use stm32_metapac::{FLASH, RCC};

const MOTOR_PWM: Hertz = khz(20);
const WATCHDOG_US: u32 = 2_000_000;

bind_interrupts!(struct Interrupts {
    EXTI0 => exti::InterruptHandler<interrupt::typelevel::EXTI0>;
    EXTI1 => exti::InterruptHandler<interrupt::typelevel::EXTI1>;
    EXTI4 => exti::InterruptHandler<interrupt::typelevel::EXTI4>;
    EXTI9_5 => exti::InterruptHandler<interrupt::typelevel::EXTI9_5>;
    USART2 => usart::InterruptHandler<USART2>;
    DMA1_STREAM5 => dma::InterruptHandler<DMA1_CH5>;
    DMA1_STREAM6 => dma::InterruptHandler<DMA1_CH6>;
});

static RECEIVED: ConstStaticCell<[u8; 256]> = ConstStaticCell::new([0; 256]);

/// One motor on its H-bridge.
pub type Motor = HBridge<SimplePwmChannel<'static, TIM1>, Output<'static>, Output<'static>>;

/// One of the inputs that stop the wheels.
type Contact = ExtiInput<'static, Async>;

/// Bumper, cliff and wheel drop.
pub type Contacts = ContactPins<Contact, Contact, Contact, Contact>;

/// The robot's parts.
pub struct Board {
    /// Range sensors.
    pub ranges: BurstBank<SharpSensors>,
    /// Wheel encoders.
    pub encoders: Encoders,
    /// Motors.
    pub motors: MotorPair<Motor, Motor>,
    /// Motor driver's enable input.
    pub enable: Output<'static>,
    /// Bumper, cliff and wheel drop.
    pub contacts: Contacts,
    /// Battery gauge and charging contact.
    pub supply: Supply,
    /// Serial line, outgoing.
    pub transmitter: UartTx<'static, Async>,
    /// Serial line, incoming.
    pub receiver: RingBufferedUartRx<'static>,
    /// Where the map is kept.
    pub map_flash: SmallSectors,
    /// Where the floor that is left is written down.
    pub floor_backup: FloorBackup,
    /// Where it is written down where the robot is.
    pub pose_backup: PoseBackup,
    /// Watchdog, running.
    pub watchdog: IndependentWatchdog<'static, IWDG>,
    /// What caused this start.
    pub cause: Cause,
}

impl Board {
    /// Sets up clocks, pins and peripherals; the motors are off.
    pub fn new() -> Self {
        let p = start();
        // First of all: what panics from here on does not stay silent.
        let watchdog = watchdog(p.IWDG);
        let output = |pin: Peri<'static, AnyPin>| Output::new(pin, Level::Low, Speed::Low);
        let speeds = SimplePwm::new(
            p.TIM1,
            Some(PwmPin::new(p.PA8, OutputType::PushPull)),
            Some(PwmPin::new(p.PA9, OutputType::PushPull)),
            None,
            None,
            MOTOR_PWM,
            Default::default(),
        );
        let speeds = speeds.split();
        let (mut left, mut right) = (speeds.ch1, speeds.ch2);
        [&mut left, &mut right].into_iter().for_each(SimplePwmChannel::enable);
        let motors = MotorPair {
            left: HBridge::new(left, output(p.PB12.into()), output(p.PB13.into())),
            right: HBridge::new(right, output(p.PB14.into()), output(p.PB15.into())),
        };
        // Pulled up: an input whose cable is cut reads as touched.
        let contacts = ContactPins {
            bump_left: ExtiInput::new(p.PB0, p.EXTI0, Pull::Up, Interrupts),
            bump_right: ExtiInput::new(p.PB1, p.EXTI1, Pull::Up, Interrupts),
            cliff: ExtiInput::new(p.PC4, p.EXTI4, Pull::Up, Interrupts),
            lifted: ExtiInput::new(p.PC5, p.EXTI5, Pull::Up, Interrupts),
        };
        let sensors = [
            p.PA0.degrade_adc(),
            p.PA1.degrade_adc(),
            p.PA4.degrade_adc(),
            p.PA5.degrade_adc(),
            p.PA6.degrade_adc(),
            p.PA7.degrade_adc(),
            p.PC0.degrade_adc(),
            p.PC1.degrade_adc(),
        ];
        let (floor_backup, pose_backup) = backup_ram::parts();
        let line = Uart::new(p.USART2, p.PA3, p.PA2, p.DMA1_CH6, p.DMA1_CH5, Interrupts, serial());
        let (transmitter, receiver) = line.expect("115200 baud is possible").split();
        Self {
            ranges: BurstBank::new(SharpSensors { adc: Adc::new(p.ADC1), sensors }),
            encoders: Encoders::new(
                Qei::new(p.TIM3, p.PC6, p.PC7, encoder_inputs()),
                Qei::new(p.TIM4, p.PB6, p.PB7, encoder_inputs()),
            ),
            motors,
            enable: output(p.PC8.into()),
            contacts,
            supply: Supply {
                adc: Adc::new(p.ADC2),
                battery: p.PC2.degrade_adc(),
                contact: Input::new(p.PC3, Pull::Up),
            },
            transmitter,
            receiver: receiver.into_ring_buffered(RECEIVED.take()),
            map_flash: SmallSectors::new(p.FLASH),
            floor_backup,
            pose_backup,
            watchdog,
            cause: cause(),
        }
    }
}

/// 168 MHz from the internal oscillator, so that any crystal will do; 1 % is enough for wheels and serial line.
fn clocks() -> Config {
    let mut config = Config::default();
    config.rcc.hsi = true;
    config.rcc.pll_src = rcc::PllSource::HSI;
    config.rcc.pll = Some(rcc::Pll {
        prediv: rcc::PllPreDiv::DIV16,
        mul: rcc::PllMul::MUL336,
        divp: Some(rcc::PllPDiv::DIV2),
        divq: None,
        divr: None,
    });
    config.rcc.sys = rcc::Sysclk::PLL1_P;
    config.rcc.ahb_pre = rcc::AHBPrescaler::DIV1;
    config.rcc.apb1_pre = rcc::APBPrescaler::DIV4;
    config.rcc.apb2_pre = rcc::APBPrescaler::DIV2;
    config
}

/// Starts the clocks. At 168 MHz a read of the flash takes six cycles: prefetch and caches, which are off then, are for that.
fn start() -> Peripherals {
    let peripherals = embassy_stm32::init(clocks());
    FLASH.acr().modify(|access| {
        access.set_prften(true);
        access.set_icen(true);
        access.set_dcen(true);
    });
    peripherals
}

/// The watchdog, running.
fn watchdog(part: Peri<'static, IWDG>) -> IndependentWatchdog<'static, IWDG> {
    let mut watchdog = IndependentWatchdog::new(part, WATCHDOG_US);
    watchdog.unleash();
    watchdog
}

/// 115200 baud, 8N1; a line that is not connected is silent.
fn serial() -> usart::Config {
    let mut config = usart::Config::default();
    config.rx_pull = Pull::Up;
    config
}

/// What caused a start; neither where the supply came, the reset input was pulled, or a debug probe did it.
#[derive(Clone, Copy)]
pub struct Cause {
    /// The watchdog bit.
    pub watchdog: bool,
    /// The supply broke in, and did not go altogether.
    pub brown_out: bool,
}

/// Reads and clears the cause of the last reset.
fn cause() -> Cause {
    let flags = RCC.csr().read();
    RCC.csr().modify(|csr| csr.set_rmvf(true));
    Cause { watchdog: flags.wdgrstf(), brown_out: flags.borrstf() && !flags.porrstf() }
}

/// Whether the processor runs on with a supply that is too low for its flash, as it does until its option bytes say otherwise.
pub fn brown_out_reset_is_off() -> bool {
    FLASH.optcr().read().bor_lev() == 0b11
}

/// The Sharp sensors on the converter.
pub struct SharpSensors {
    adc: Adc<'static, ADC1>,
    sensors: [AnyAdcChannel<'static, ADC1>; SENSORS],
}

impl Converter for SharpSensors {
    type Error = NoSuchSensor;

    fn convert(&mut self, sensor: usize) -> Result<u16, NoSuchSensor> {
        let pin = self.sensors.get_mut(sensor).ok_or(NoSuchSensor)?;
        Ok(self.adc.blocking_read(pin, SampleTime::CYCLES84))
    }
}

/// The battery behind its divider, and the charging contact.
pub struct Supply {
    adc: Adc<'static, ADC2>,
    battery: AnyAdcChannel<'static, ADC2>,
    contact: Input<'static>,
}

/// Volts of the battery a count of the converter: 3.3 V full scale, 12 bits, 33 kOhm above 10 kOhm.
const BATTERY_V_PER_COUNT: f32 = 3.3 / 4095.0 * 4.3;

impl PowerSupply for Supply {
    fn battery_v(&mut self) -> Option<f32> {
        Some(f32::from(self.adc.blocking_read(&mut self.battery, SampleTime::CYCLES84)) * BATTERY_V_PER_COUNT)
    }

    fn is_charging(&mut self) -> bool {
        self.contact.is_low()
    }
}

/// There are fewer sensors.
#[derive(Debug)]
pub struct NoSuchSensor;

/// Both encoders, counting in hardware.
pub struct Encoders {
    left: (Qei<'static, TIM3>, WheelCounter),
    right: (Qei<'static, TIM4>, WheelCounter),
}

/// Encoders with open collectors need the pull-up resistors, those that drive their outputs do not mind.
fn encoder_inputs() -> qei::Config {
    qei::Config { ch1_pull: Pull::Up, ch2_pull: Pull::Up, ..Default::default() }
}

impl Encoders {
    fn new(left: Qei<'static, TIM3>, right: Qei<'static, TIM4>) -> Self {
        // An edge counts when it lasted for eight samples, 3 us: shorter ones are the motors'. At full speed edges are 700 us apart.
        for timer in [stm32_metapac::TIM3, stm32_metapac::TIM4] {
            timer.ccmr_input(0).modify(|inputs| (0..2).for_each(|n| inputs.set_icf(n, FilterValue::FDTS_DIV32_N8)));
        }
        let counters = [left.count(), right.count()].map(WheelCounter::starting_at);
        Self { left: (left, counters[0]), right: (right, counters[1]) }
    }
}

impl WheelEncoders for Encoders {
    type Error = Infallible;

    fn ticks(&mut self) -> Result<Ticks, Infallible> {
        let (left, right) = (self.left.0.count(), self.right.0.count());
        Ok(Ticks { left: self.left.1.update(left), right: self.right.1.update(right) })
    }
}
