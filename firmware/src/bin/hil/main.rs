//! Hardware in the loop: the robot's tasks, with sensors and motors simulated at the other end of a link.
//!
//! In lock step: one [`Frame::Sample`](wire::Frame::Sample) from the host sets the inputs and the clock; the tasks run
//! until none has anything left to do at that time; what they said goes back, and [`Frame::Motors`](wire::Frame::Motors)
//! closes the answer. Nothing else moves the clock, so that a drive is the same on every machine. With the feature `hil-timed` the
//! same is exchanged every 20 ms of the processor's own clock, and tasks preempt the back end as on the robot.
#![no_std]
#![no_main]

#[cfg_attr(feature = "hil-metric", path = "metric_bank.rs")]
#[cfg_attr(not(feature = "hil-metric"), path = "analogue_bank.rs")]
mod bank;
#[path = "../../core_ram.rs"]
mod core_ram;
mod devices;
#[cfg_attr(feature = "hil-usart", path = "no_flash.rs")]
#[cfg_attr(not(feature = "hil-usart"), path = "host_flash.rs")]
mod flash;
mod link;
#[cfg_attr(feature = "hil-timed", path = "timed/mod.rs")]
#[cfg_attr(not(feature = "hil-timed"), path = "lock_step/mod.rs")]
mod schedule;
#[path = "../../stack.rs"]
mod stack;
#[cfg_attr(feature = "hil-usart", path = "usart.rs")]
#[cfg_attr(not(feature = "hil-usart"), path = "semihosting.rs")]
mod transport;

use bank::ROBOT;
use core::panic::PanicInfo;
use cortex_m_semihosting::{debug, hprintln};
use devices::{Dock, Emulated, Enable, Encoders, Input, Line, Motors};
use embassy_executor::Spawner;
use firmware::tasks;
use firmware::{Job, Keeper, LookBacks, SENSORS, Shared};
use flash::Flash;
use look_back::RobotBackEnd;
use robot::{ContactPins, WheelControl, WheelControlConfig};
use slam_core::{Config, RobotSlam};
use static_cell::{ConstStaticCell, StaticCell};

static SHARED: Shared = Shared::new();
static LOOK_BACKS: LookBacks = LookBacks::new();
static KEEPER: StaticCell<Keeper<Flash>> = StaticCell::new();
static BACK_END: ConstStaticCell<RobotBackEnd> = ConstStaticCell::new(RobotBackEnd::IDLE);

#[cortex_m_rt::entry]
fn main() -> ! {
    let config = Config { hand_overs: hand_overs(), ..Config::for_rig::<SENSORS>(&ROBOT.rig()) };
    let slam = core_ram::SLAM.take();
    assert!(slam.start_with_config(ROBOT.rig(), config).is_ok(), "the built-in rig is valid");
    let job = core_ram::job(ROBOT);
    let keeper = keeper(slam);
    LOOK_BACKS.give_back(BACK_END.take());
    let link = link::Link::new(transport::Transport::open());
    schedule::run(|levels| spawn(levels, Robot { slam, keeper, job }, config), link)
}

/// What the flash has. What start-up needs of the stack is free again when this returns.
#[inline(never)]
fn keeper(slam: &RobotSlam) -> &'static mut Keeper<Flash> {
    KEEPER.init_with(|| Keeper::start(Flash::open(), slam))
}

/// Whether hand-overs are taken: unless the emulator's command line has the word `no-hand-overs`.
fn hand_overs() -> bool {
    let mut text = [0; 256];
    transport::command_line(&mut text).split(|byte| *byte == b' ').all(|word| word != b"no-hand-overs")
}

/// Where tasks are spawned: each level goes before the next one.
struct Levels {
    step: Spawner,
    drive: Spawner,
    below: Spawner,
}

/// What tasks own for ever.
struct Robot {
    slam: &'static mut RobotSlam,
    keeper: &'static mut Keeper<Flash>,
    job: &'static mut Job,
}

fn spawn(levels: Levels, robot: Robot, config: Config) {
    let Levels { step, drive: drives, below } = levels;
    let Robot { slam, keeper, job } = robot;
    let once = "each task is spawned once";
    // The guard has looked before a sample is put together, as on the robot, where it is a level above.
    step.spawn(guard().expect(once));
    step.spawn(odometry().expect(once));
    step.spawn(sample().expect(once));
    step.spawn(estimate(slam, keeper, config).expect(once));
    step.spawn(telemetry().expect(once));
    drives.spawn(drive(job).expect(once));
    drives.spawn(commands().expect(once));
    drives.spawn(supervise().expect(once));
    below.spawn(look_back().expect(once));
}

#[embassy_executor::task]
async fn odometry() -> ! {
    tasks::odometry(&mut Encoders, &SHARED).await
}

#[embassy_executor::task]
async fn sample() -> ! {
    tasks::sample(&mut bank::bank(), &SHARED).await
}

#[embassy_executor::task]
async fn estimate(slam: &'static mut RobotSlam, keeper: &'static mut Keeper<Flash>, config: Config) -> ! {
    tasks::estimate(slam, keeper, config, &SHARED, &LOOK_BACKS, &mut [0; 0]).await
}

#[embassy_executor::task]
async fn look_back() -> ! {
    tasks::look_back(&LOOK_BACKS).await
}

#[embassy_executor::task]
async fn drive(job: &'static mut Job) -> ! {
    let control = WheelControl::new(WheelControlConfig::default());
    tasks::drive(job, ROBOT, control, &mut Motors, &mut Dock, &mut [0; 0], &SHARED).await
}

#[embassy_executor::task]
async fn guard() -> ! {
    let inputs = ContactPins {
        bump_left: Input(|contacts| contacts.bump_left),
        bump_right: Input(|contacts| contacts.bump_right),
        cliff: Input(|contacts| contacts.cliff),
        lifted: Input(|contacts| contacts.lifted),
    };
    tasks::guard(inputs, &mut Enable, &SHARED).await
}

#[embassy_executor::task]
async fn telemetry() -> ! {
    tasks::telemetry(&mut Line, &SHARED).await
}

#[embassy_executor::task]
async fn commands() -> ! {
    tasks::commands(&mut Line, &SHARED).await
}

#[embassy_executor::task]
async fn supervise() -> ! {
    tasks::supervise(&mut Emulated, &SHARED).await
}

#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    hprintln!("{}", info);
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
