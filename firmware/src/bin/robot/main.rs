//! The robot: the tasks on its board.
#![no_std]
#![no_main]

mod backup_ram;
mod board;
#[path = "../../core_ram.rs"]
mod core_ram;
#[path = "../../fail_safe.rs"]
mod fail_safe;
mod interrupt_level;
mod last_words;
mod small_sectors;
#[path = "../../stack.rs"]
mod stack;

use backup_ram::{FloorBackup, PoseBackup};
use board::{Board, Cause, Contacts, Encoders, Motor, SharpSensors, Supply};
use defmt_rtt as _;
use embassy_executor::Spawner;
use embassy_stm32::gpio::Output;
use embassy_stm32::mode::Async;
use embassy_stm32::peripherals::IWDG;
use embassy_stm32::usart::{RingBufferedUartRx, UartTx};
use embassy_stm32::wdg::IndependentWatchdog;
use firmware::burst::BurstBank;
use firmware::tasks::{self, Platform};
use firmware::{Job, Keeper, LookBacks, SENSORS, Shared};
use look_back::RobotBackEnd;
use robot::rig::BuiltIn;
use robot::{MotorPair, WheelControl, WheelControlConfig};
use slam_core::{Config, RobotSlam};
use small_sectors::SmallSectors;
use static_cell::{ConstStaticCell, StaticCell};

/// The robot on this board.
const ROBOT: BuiltIn = BuiltIn::Sharp;

static SHARED: Shared = Shared::new();
static LOOK_BACKS: LookBacks = LookBacks::new();
static KEEPER: StaticCell<Keeper<SmallSectors>> = StaticCell::new();
static BACK_END: ConstStaticCell<RobotBackEnd> = ConstStaticCell::new(RobotBackEnd::IDLE);

#[embassy_executor::main]
async fn main(below: Spawner) {
    let board = Board::new();
    let Cause { watchdog, brown_out } = board.cause;
    defmt::info!("wall-slam {}, watchdog bit: {}, brown-out: {}", env!("CARGO_PKG_VERSION"), watchdog, brown_out);
    if board::brown_out_reset_is_off() {
        defmt::error!("brown-out reset is off: set BOR level 3 in the option bytes");
    }
    SHARED.faults.update(|faults| faults.watchdog_resets = watchdog.into());
    let slam = core_ram::SLAM.take();
    assert!(slam.start_with_config(ROBOT.rig(), config()).is_ok(), "the built-in rig is valid");
    let job = core_ram::job(ROBOT);
    let keeper = keeper(board.map_flash, slam);
    LOOK_BACKS.give_back(BACK_END.take());
    let once = "each task is spawned once";
    below.spawn(look_back().expect(once));
    let drives = interrupt_level::drive();
    drives.spawn(drive(job, board.motors, board.supply, board.floor_backup).expect(once));
    drives.spawn(commands(board.receiver).expect(once));
    drives.spawn(supervise(board.watchdog).expect(once));
    let steps = interrupt_level::step();
    steps.spawn(odometry(board.encoders).expect(once));
    steps.spawn(sample(board.ranges).expect(once));
    steps.spawn(estimate(slam, keeper, board.pose_backup).expect(once));
    steps.spawn(telemetry(board.transmitter).expect(once));
    interrupt_level::guard().spawn(guard(board.contacts, board.enable).expect(once));
}

fn config() -> Config {
    Config::for_rig::<SENSORS>(&ROBOT.rig()).with_hand_overs()
}

/// What is in this flash. What start-up needs of the stack is free again when this returns.
#[inline(never)]
fn keeper(flash: SmallSectors, slam: &RobotSlam) -> &'static mut Keeper<SmallSectors> {
    KEEPER.init_with(|| Keeper::start(flash, slam))
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
async fn estimate(
    slam: &'static mut RobotSlam,
    keeper: &'static mut Keeper<SmallSectors>,
    mut backup: PoseBackup,
) -> ! {
    tasks::estimate(slam, keeper, config(), &SHARED, &LOOK_BACKS, &mut backup).await
}

#[embassy_executor::task]
async fn look_back() -> ! {
    tasks::look_back(&LOOK_BACKS).await
}

#[embassy_executor::task]
async fn drive(
    job: &'static mut Job,
    mut motors: MotorPair<Motor, Motor>,
    mut supply: Supply,
    mut backup: FloorBackup,
) -> ! {
    let control = WheelControl::new(WheelControlConfig::default());
    tasks::drive(job, ROBOT, control, &mut motors, &mut supply, &mut backup, &SHARED).await
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
async fn supervise(watchdog: IndependentWatchdog<'static, IWDG>) -> ! {
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
