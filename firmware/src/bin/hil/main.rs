//! Hardware in the loop: the robot's tasks, with sensors and motors simulated at the other end of a link.
//!
//! In lock step: one [`Frame::Sample`](wire::Frame::Sample) from the host sets the inputs and the clock; the tasks run
//! until none has anything left to do at that time; what they said goes back, and [`Frame::Motors`](wire::Frame::Motors)
//! closes the answer. Nothing else moves the clock, so that a drive is the same on every machine.
#![no_std]
#![no_main]

#[cfg_attr(feature = "hil-metric", path = "metric_bank.rs")]
#[cfg_attr(not(feature = "hil-metric"), path = "analogue_bank.rs")]
mod bank;
mod clock;
mod devices;
mod executor;
mod link;
#[path = "../../stack.rs"]
mod stack;
#[cfg_attr(feature = "hil-usart", path = "usart.rs")]
#[cfg_attr(not(feature = "hil-usart"), path = "semihosting.rs")]
mod transport;

use bank::ROBOT;
use core::panic::PanicInfo;
use cortex_m_semihosting::{debug, hprintln};
use devices::{Emulated, Enable, Encoders, Input, Line, Motors};
use embassy_executor::Spawner;
use firmware::tasks;
use firmware::{Pilot, SENSORS, Shared};
use robot::{ContactPins, PilotConfig, WheelControl, WheelControlConfig};
use slam_core::{Config, RobotSlam};
use static_cell::{ConstStaticCell, StaticCell};

static SHARED: Shared = Shared::new();
static SLAM: ConstStaticCell<RobotSlam> = ConstStaticCell::new(RobotSlam::IDLE);
static PILOT: StaticCell<Pilot> = StaticCell::new();

#[cortex_m_rt::entry]
fn main() -> ! {
    let slam = SLAM.take();
    assert!(slam.start_with_config(ROBOT.rig(), config()).is_ok(), "the built-in rig is valid");
    let pilot = PILOT.init_with(|| Pilot::new(PilotConfig::default(), &ROBOT.rig()));
    let mut link = link::Link::new(transport::Transport::open());
    executor::run(|spawner| spawn(spawner, slam, pilot), || link.exchange())
}

fn config() -> Config {
    Config::for_rig::<SENSORS>(&ROBOT.rig())
}

fn spawn(spawner: Spawner, slam: &'static mut RobotSlam, pilot: &'static mut Pilot) {
    let once = "each task is spawned once";
    spawner.spawn(odometry().expect(once));
    spawner.spawn(sample().expect(once));
    spawner.spawn(estimate(slam).expect(once));
    spawner.spawn(drive(pilot).expect(once));
    spawner.spawn(guard().expect(once));
    spawner.spawn(telemetry().expect(once));
    spawner.spawn(commands().expect(once));
    spawner.spawn(supervise().expect(once));
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
async fn estimate(slam: &'static mut RobotSlam) -> ! {
    tasks::estimate(slam, config(), &SHARED).await
}

#[embassy_executor::task]
async fn drive(pilot: &'static mut Pilot) -> ! {
    let control = WheelControl::new(WheelControlConfig::default());
    tasks::drive(pilot, control, &mut Motors, &SHARED).await
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
