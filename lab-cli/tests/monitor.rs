//! `lab monitor` on recorded bytes.

mod common;

use common::Place;
use predicates::prelude::*;
use predicates::str::contains;
use wire::{BoardFaults, Estimate, Faults, Frame, Sample, SlamFaults, encode};

/// What a robot that stands still says in two seconds, joined in the middle of a frame.
fn recorded() -> Vec<u8> {
    let mut bytes = vec![3, 1, 4, 0];
    for step in 1..=50_u64 {
        let time_us = step * 40_000;
        let counts = (0..8).map(|i| Some(900 + (step as u16 % 3) * 5 + i)).collect();
        let sample = Sample { time_us, left_ticks: 7, right_ticks: -7, counts, ..Sample::default() };
        let estimate = Estimate { time_us, pose: [1.25, -0.5, 0.1], ..Estimate::default() };
        let board = BoardFaults { contact_stops: 2, ..BoardFaults::default() };
        let faults = Faults { slam: SlamFaults::default(), board };
        for frame in [Frame::Sample(sample), Frame::Estimate(estimate), Frame::Faults(faults)] {
            bytes.extend(encode(&frame).unwrap());
        }
    }
    bytes
}

#[test]
fn it_shows_the_robot_and_records_a_log_that_replays() {
    let place = Place::new();
    std::fs::write(place.path("line"), recorded()).unwrap();
    place
        .lab()
        .args(["monitor", "--port", "line", "--out", "seen"])
        .assert()
        .success()
        .stdout(contains("x 1.250 m   y -0.500 m").and(contains("contact stops 2")).and(contains("1 damaged")));
    assert_eq!(place.get("seen/log.csv").lines().count(), 51);
    place.lab().args(["replay", "seen/log.csv", "--rig", "seen/rig.toml", "--out", "replayed"]).assert().success();
    assert_eq!(place.summary("replayed")["rows"], 50);
}

#[test]
fn a_port_that_is_not_there_is_named() {
    let place = Place::new();
    place
        .lab()
        .args(["monitor", "--port", "/dev/no-such-port"])
        .assert()
        .failure()
        .stderr(contains("/dev/no-such-port"));
}
