//! The board's parts as a firmware's tasks use them.
use core::pin::pin;
use core::task::{Context, Poll, Waker};
use embedded_hal::delay::DelayNs;
use hal_sim::board::NoMetres;
use hal_sim::{Board, SimOptions, Simulation, default_rig, plan_file};
use robot::rig::time_of_flight_rig;
use robot::{
    Contacts, DriveMotors, Duty, MetricSensor, RangeSensorBank, WheelControl, WheelControlConfig, WheelEncoders,
    WheelSpeeds,
};
use slam_core::RangeInput;

/// What comes of a future that waits for nothing.
fn now<T>(future: impl Future<Output = T>) -> T {
    let Poll::Ready(value) = pin!(future).poll(&mut Context::from_waker(Waker::noop())) else { panic!("it waits") };
    value
}

fn board(plan: &str) -> Board {
    let plan = plan_file::parse("test", "test", plan).unwrap();
    Board::new(Simulation::new(&plan, &default_rig(), SimOptions::default(), 3).unwrap())
}

const HALL: &str = "[start]\nx_m = 1.0\ny_m = 1.0\n[[outline]]\n\
                    points_m = [[0.0, 0.0], [5.0, 0.0], [5.0, 2.0], [0.0, 2.0]]\n";

#[test]
fn wheel_control_through_the_h_bridges_reaches_its_speed() {
    let board = board(HALL);
    let (mut motors, mut encoders, mut delay) = (board.motors(), board.encoders(), board.delay());
    let mut control = WheelControl::new(WheelControlConfig::default());
    let target = WheelSpeeds { left_mps: 0.25, right_mps: 0.25 };
    assert_eq!(encoders.ticks().unwrap(), slam_core::Ticks::default());
    for _ in 0..200 {
        let duty = control.update(target, encoders.ticks().unwrap(), 0.02);
        motors.set_duty(duty).unwrap();
        delay.delay_ms(20);
    }
    let before = encoders.ticks().unwrap();
    delay.delay_ms(1000);
    let after = encoders.ticks().unwrap();
    let speed_mps = (after.left - before.left) as f32 * 0.000_445;
    assert!((speed_mps - 0.25).abs() < 0.01, "{speed_mps}");
    assert!((board.with_simulation(Simulation::time_s) - 5.0).abs() < 1e-9);
    motors.stop().unwrap();
    delay.delay_ms(1000);
    let stopped = encoders.ticks().unwrap();
    delay.delay_ms(1000);
    assert_eq!(encoders.ticks().unwrap(), stopped);
}

#[test]
fn range_sensors_are_converter_counts_in_the_rig_s_order() {
    let ranges = now(board(HALL).range_sensors().read());
    assert!(ranges[..8].iter().all(|range| matches!(range, Ok(RangeInput::Counts(1..4095)))));
    assert!(ranges[8..].iter().all(|range| *range == Ok(RangeInput::Missing)));
    assert_eq!(now(board(HALL).metric_sensor(0).range_m()), Err(NoMetres));
}

#[test]
fn sensors_that_report_metres_are_read_one_by_one() {
    let plan = plan_file::parse("test", "test", HALL).unwrap();
    let board = Board::new(Simulation::new(&plan, &time_of_flight_rig(), SimOptions::default(), 3).unwrap());
    // Ahead 4 m, left 1 m, back 1 m, right 1 m; the sensors sit 10 cm nearer and reach 2 m.
    for (index, expected_m) in [(0, None), (1, Some(0.9)), (2, Some(0.9)), (3, Some(0.9_f32))] {
        let range_m = now(board.metric_sensor(index).range_m()).unwrap();
        let near = range_m.zip(expected_m).map(|(range_m, expected_m)| (range_m - expected_m).abs() < 0.1);
        assert_eq!((range_m.is_some(), near), (expected_m.is_some(), expected_m.map(|_| true)), "{index}: {range_m:?}");
    }
    assert_eq!(now(board.metric_sensor(4).range_m()), Ok(None));
}

#[test]
fn the_bumper_is_pressed_on_the_side_of_the_obstacle_and_the_body_stops() {
    for (y_m, left, right) in [(1.12, true, false), (0.88, false, true), (1.0, true, true)] {
        let board = board(&format!("{HALL}[[round]]\ncentre_m = [2.0, {y_m}]\nradius_m = 0.02\n"));
        let mut contacts = board.contacts();
        assert_eq!(contacts.read(), Contacts::default());
        board.motors().set_duty(Duty { left: 0.4, right: 0.4 }).unwrap();
        let mut touched = Contacts::default();
        for _ in 0..600 {
            board.advance(0.01);
            touched = contacts.read();
            if touched.any() {
                break;
            }
        }
        assert_eq!((touched.bump_left, touched.bump_right), (left, right), "{y_m}");
        let clear_m = board.with_simulation(|s| f64::hypot(2.0 - s.pose_in_plan().x_m, y_m - s.pose_in_plan().y_m));
        assert!(clear_m > 0.17 + 0.02 - 1e-6 && clear_m < 0.2, "{clear_m}");
    }
}

#[test]
fn the_cliff_input_sees_the_stairs_before_the_wheels_do() {
    let board = board(&format!("{HALL}[[cliff]]\nmin_m = [2.0, 0.0]\nmax_m = [3.0, 2.0]\n"));
    let mut contacts = board.contacts();
    board.motors().set_duty(Duty { left: 0.4, right: 0.4 }).unwrap();
    while !contacts.read().cliff {
        board.advance(0.01);
        assert!(board.with_simulation(Simulation::time_s) < 10.0);
    }
    let x_m = board.with_simulation(|s| s.pose_in_plan().x_m);
    assert!(x_m > 1.8 && x_m < 1.9, "{x_m}");
}

#[test]
fn a_cut_cable_reads_as_touched() {
    let board = board(HALL);
    let mut contacts = board.contacts();
    assert_eq!(contacts.read(), Contacts::default());
    for cables in [
        Contacts { bump_left: true, ..Contacts::default() },
        Contacts { bump_right: true, ..Contacts::default() },
        Contacts { cliff: true, ..Contacts::default() },
        Contacts { lifted: true, ..Contacts::default() },
    ] {
        board.cut(cables);
        assert_eq!(contacts.read(), cables);
    }
}
