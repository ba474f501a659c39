//! The robot: the tasks on its board.
#![no_std]
#![no_main]

mod board;
#[path = "../../fail_safe.rs"]
mod fail_safe;
mod interrupt_level;
mod last_words;
#[path = "../../stack.rs"]
mod stack;

use board::{Board, Contacts, Encoders, Motor, SharpSensors};
use defmt_rtt as _;
use embassy_executor::Spawner;
use embassy_stm32::gpio::Output;
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::IWDG;
use embassy_stm32::usart::{RingBufferedUartRx, UartTx};
use embassy_stm32::wdg::IndependentWatchdog;
use firmware::burst::BurstBank;
use firmware::tasks::{self, Platform};
use firmware::{Pilot, SENSORS, Shared};
use robot::rig::default_rig;
use robot::{MotorPair, PilotConfig, WheelControl, WheelControlConfig};
use slam_core::{Config, RobotSlam};
use static_cell::{ConstStaticCell, StaticCell};

static SHARED: Shared = Shared::new();
static SLAM: ConstStaticCell<RobotSlam> = ConstStaticCell::new(RobotSlam::IDLE);
static PILOT: StaticCell<Pilot> = StaticCell::new();

#[embassy_executor::main]
async fn main(spawner: Spawner) {
    let board = Board::new();
    defmt::info!("wall-slam {}, watchdog bit: {}", env!("CARGO_PKG_VERSION"), board.watchdog_bit);
    SHARED.faults.update(|faults| faults.watchdog_resets = board.watchdog_bit.into());
    let slam = SLAM.take();
    assert!(slam.start_with_config(default_rig(), config()).is_ok(), "the default rig is valid");
    let pilot = PILOT.init_with(|| Pilot::new(PilotConfig::default(), &default_rig()));
    let once = "each task is spawned once";
    interrupt_level::spawner().spawn(guard(board.contacts, board.enable).expect(once));
    spawner.spawn(odometry(board.encoders).expect(once));
    spawner.spawn(sample(board.ranges).expect(once));
    spawner.spawn(estimate(slam).expect(once));
    spawner.spawn(drive(pilot, board.motors).expect(once));
    spawner.spawn(telemetry(board.transmitter).expect(once));
    spawner.spawn(commands(board.receiver).expect(once));
    spawner.spawn(supervise(board.watchdog).expect(once));
}

fn config() -> Config {
    Config::for_rig::<SENSORS>(&default_rig())
}

#[embassy_executor::task]
async fn guard(inputs: Contacts, mut enable: Output<'static>) -> ! {
    tasks::guard(inputs, &mut enable, &SHARED).await
}

#[embassy_executor::task]
async fn odometry(mut encoders: Encoders) -> ! {
    tasks::odometry(&mut encoders, &SHARED).await
}

#[embassy_executor::task]
async fn sample(mut ranges: BurstBank<SharpSensors>) -> ! {
    tasks::sample(&mut ranges, &SHARED).await
}

#[embassy_executor::task]
async fn estimate(slam: &'static mut RobotSlam) -> ! {
    tasks::estimate(slam, config(), &SHARED).await
}

#[embassy_executor::task]
async fn drive(pilot: &'static mut Pilot, mut motors: MotorPair<Motor, Motor>) -> ! {
    let control = WheelControl::new(WheelControlConfig::default());
    tasks::drive(pilot, control, &mut motors, &SHARED).await
}

#[embassy_executor::task]
async fn telemetry(mut line: UartTx<'static, Async>) -> ! {
    tasks::telemetry(&mut line, &SHARED).await
}

#[embassy_executor::task]
async fn commands(mut line: RingBufferedUartRx<'static>) -> ! {
    tasks::commands(&mut line, &SHARED).await
}

#[embassy_executor::task]
async fn supervise(mut watchdog: IndependentWatchdog<'static, IWDG>) -> ! {
    watchdog.unleash();
    tasks::supervise(&mut Processor { watchdog }, &SHARED).await
}

struct Processor {
    watchdog: IndependentWatchdog<'static, IWDG>,
}

impl Platform for Processor {
    fn feed_watchdog(&mut self) {
        self.watchdog.pet();
    }

    fn stack_used_bytes(&mut self) -> u32 {
        stack::used_bytes()
    }
}
