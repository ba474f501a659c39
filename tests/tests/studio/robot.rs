//! Robot: a serial port and a monitor's socket, fed by the real wire crate.

use hal_sim::{ClosedLoop, Estimate, SimOptions, Simulation, default_rig, plan_file};
use serde_json::{Value, json};
use slam_core::{Config, RobotSlam};
use tests::devtools::Page;

use super::{assert_sound, open, open_with, picture};

/// What a robot sends over its line while it drives: the frames of the real crate, as the firmware does.
fn robot_bytes(seconds: f64) -> Vec<u8> {
    let plan = plan_file::load("flat").expect("it is built in");
    let (wide, narrow) = (default_rig(), robot::rig::default_rig());
    let simulation = Simulation::new(&plan, &wide, SimOptions::default(), 1).expect("it can be simulated");
    let mut robot = ClosedLoop::new(simulation, &wide, robot::PilotConfig::default());
    let config = Config::for_rig(&narrow);
    let mut slam = Box::new(RobotSlam::with_config(narrow, config).expect("the built-in rig"));
    let mut bytes = Vec::new();
    robot.record(seconds, &mut |sample| {
        let sent = wire::Sample::of(sample).expect("the built-in robot has encoders");
        let report = slam.step(&sent.to_slam());
        let estimate = wire::Estimate::of(&slam, sample.time_us);
        // A wall with each sample, the rest once a second.
        let (walls, step): (Vec<_>, _) = (slam.walls().collect(), slam.counters().steps as usize);
        let wall = walls.get(step % walls.len().max(1));
        let wall = wall.map(|wall| wire::Wall::of(wall, (step % walls.len()) as u8, walls.len() as u8));
        let calibration = wire::Frame::Calibration(wire::Calibration::of(&slam));
        let faults = wire::Frame::Faults(wire::Faults { slam: slam.counters().into(), ..wire::Faults::default() });
        let now_and_then = [calibration, faults].into_iter().filter(|_| step % 25 == 0);
        let frames = [wire::Frame::Sample(sent), wire::Frame::Estimate(estimate)];
        for frame in frames.into_iter().chain(wall.map(wire::Frame::Wall)).chain(now_and_then) {
            bytes.extend(wire::encode(&frame).expect("it fits"));
        }
        Estimate::new(slam.pose(), &report)
    });
    bytes
}

/// A serial port that gives what the test feeds it and keeps what is written to it.
const FAKE_SERIAL: &str = "
    window.written = [];
    const port = {
        async open(options) {
            window.opened = options;
            this.readable = new ReadableStream({ start: (controller) => { window.feed = (bytes) => controller.enqueue(bytes); } });
            this.writable = new WritableStream({ write: (bytes) => { window.written.push(...bytes); } });
        },
        async close() { window.portClosed = true; },
    };
    Object.defineProperty(navigator, 'serial', { value: { requestPort: async () => port } });";

fn feed(page: &mut Page, bytes: &[u8]) {
    page.run(&format!("window.feed(new Uint8Array({}));", json!(bytes)));
}

/// Waits until the page has taken in so many bytes in all.
fn until_taken_in(page: &mut Page, bytes: usize) {
    page.until(&format!(
        "document.getElementById('status').textContent.replace(/(\\d)\\s(?=\\d)/g, '$1').includes(' {bytes} bytes')"
    ));
}

#[test]
#[ignore = "needs the built page: cargo xtask test studio"]
fn a_robot_at_a_serial_port_is_shown_steered_and_recorded() {
    let Some((mut page, address)) = open_with("robot", "", [1280, 900], FAKE_SERIAL) else { return };
    page.run("document.querySelector(\"[data-mode-choice='robot']\").click(); document.getElementById('connect-serial').click();");
    page.until("window.opened?.baudRate === 115200 && !document.getElementById('robot-start').disabled");
    let bytes = robot_bytes(30.0);
    for part in bytes.chunks(16 * 1024) {
        feed(&mut page, part);
    }
    page.until("document.getElementById('clock').textContent.endsWith('/ 0:30.0')");
    page.until("document.getElementById('status').textContent.includes('says the same, bit for bit')");
    page.until("document.querySelectorAll('#walls tbody tr').length > 3");
    picture(&mut page, "robot");
    // Commands arrive as the real crate's frames.
    page.run(
        "document.getElementById('robot-start').click();
         const pad = document.getElementById('drive-pad');
         pad.focus();
         pad.dispatchEvent(new KeyboardEvent('keydown', { key: 'w' }));
         pad.dispatchEvent(new KeyboardEvent('keyup', { key: 'w' }));",
    );
    page.until("window.written.length > 20");
    let written: Vec<u8> = serde_json::from_value(page.run("return window.written;")).expect("bytes");
    let mut decoder = wire::Decoder::new();
    let commands: Vec<_> = written.iter().filter_map(|byte| decoder.push(*byte)).collect();
    let spins = matches!(commands[1], Ok(wire::Frame::Command(wire::Command::Spin { left, right })) if left == right && left > 0.0);
    assert!(spins, "{commands:?}");
    assert_eq!(commands[0], Ok(wire::Frame::Command(wire::Command::Start)));
    assert_eq!(commands.last(), Some(&Ok(wire::Frame::Command(wire::Command::Stop))));
    // The log is what the robot sensed.
    page.run("document.getElementById('save-robot-log').click();");
    let log = page.run("return await window.saved.text();");
    assert_eq!(log.as_str().unwrap().lines().count(), 1 + 751);
    // Damaged and foreign bytes are counted, and a robot that floods the line does not stop the page.
    let mut damaged = bytes[..300].to_vec();
    damaged.iter_mut().step_by(40).for_each(|byte| *byte ^= 0x55);
    feed(&mut page, &damaged);
    page.until("/ [1-9][0-9]* damaged/.test(document.getElementById('status').textContent)");
    page.run("for (let i = 0; i < 40; i++) window.feed(new Uint8Array(16384).fill(7));");
    page.until("document.getElementById('status').textContent.includes('came too fast and were dropped')");
    assert_eq!(page.run("document.getElementById('disconnect').click(); return true;"), Value::Bool(true));
    page.until("window.portClosed === true");
    assert_sound(&mut page, &address);
}

#[test]
#[cfg(unix)]
#[ignore = "needs the built page: cargo xtask test studio"]
fn a_robot_at_a_monitor_is_shown_and_steered_through_its_socket() {
    use std::io::{Read as _, Write as _};
    let Some((mut page, address)) = open("socket", "#", [390, 840]) else { return };
    let (mut robot, line) = std::os::unix::net::UnixStream::pair().expect("a pipe");
    let line = (Box::new(line.try_clone().expect("its other end")) as _, Box::new(line) as _);
    let ((mut heard, _), at) = robot_tools::relay::relay(line, "127.0.0.1:0", None).expect("a free port");
    page.run(&format!(
        "document.querySelector(\"[data-mode-choice='robot']\").click();
         document.getElementById('socket').value = 'ws://{at}';
         document.getElementById('connect-socket').click();"
    ));
    page.until("!document.getElementById('robot-stop').disabled");
    page.run("document.getElementById('robot-stop').click();");
    let mut command = [0; 9];
    robot.read_exact(&mut command).expect("the command");
    assert_eq!(
        command.as_slice(),
        wire::encode(&wire::Frame::Command(wire::Command::Stop)).expect("it fits").as_slice()
    );
    std::thread::spawn(move || while heard.read(&mut [0; 4096]).is_ok_and(|count| count > 0) {});
    robot.write_all(&robot_bytes(10.0)).expect("the page listens");
    page.until("document.getElementById('clock').textContent.endsWith('/ 0:10.0')");
    page.run("document.querySelector(\"[data-theme-choice='dark']\").click(); scrollTo(0, 300);");
    page.run("await new Promise((done) => setTimeout(done, 500));");
    picture(&mut page, "robot-phone-dark");
    assert!(page.run("return document.documentElement.scrollWidth - innerWidth;").as_i64().unwrap() <= 0);
    // Where nobody answers, that is said.
    page.run("document.getElementById('disconnect').click();");
    assert_sound(&mut page, &address);
}

/// Frames that the page has written since it was asked last.
fn written(page: &mut Page) -> Vec<wire::Frame> {
    let bytes: Vec<u8> = serde_json::from_value(page.run("return window.written.splice(0);")).expect("bytes");
    let mut decoder = wire::Decoder::new();
    bytes.iter().filter_map(|byte| decoder.push(*byte)).map(|frame| frame.expect("undamaged")).collect()
}

/// A map as a robot keeps it.
fn a_map() -> Vec<u8> {
    let (robot, _) = lab::input::built_in_robot().expect("it is built in");
    let plan = plan_file::load("room").expect("it is built in");
    let mut drive = lab::run::Drive::new(&plan, &robot, SimOptions::default(), 1).expect("it can be simulated");
    let mut session = lab::run::Session::new(&robot, Config::for_rig(&robot.rig), "room").expect("a good rig");
    for _ in 0..500 {
        drive.step(&mut session);
    }
    session.map().expect("a map")
}

fn answer(page: &mut Page, answer: wire::MapAnswer) {
    feed(page, &wire::encode(&wire::Frame::MapAnswer(answer)).expect("it fits"));
}

#[test]
#[ignore = "needs the built page: cargo xtask test studio"]
fn a_robot_gives_its_map_and_takes_one() {
    let Some((mut page, address)) = open_with("robot-map", "", [1280, 900], FAKE_SERIAL) else { return };
    page.run("document.querySelector(\"[data-mode-choice='robot']\").click(); document.getElementById('connect-serial').click();");
    page.until("!document.getElementById('fetch-map').disabled");
    feed(&mut page, &robot_bytes(4.0));
    let map = a_map();
    // Fetched piece by piece, as they are asked for.
    page.run("document.getElementById('fetch-map').click();");
    for (index, piece) in map.chunks(wire::PIECE_BYTES).enumerate() {
        page.until("window.written.length > 0");
        let offset = (index * wire::PIECE_BYTES) as u32;
        assert_eq!(written(&mut page), [wire::Frame::MapRequest(wire::MapRequest::Get { offset })]);
        let bytes = piece.iter().copied().collect();
        answer(&mut page, wire::MapAnswer::Part { offset, of: map.len() as u32, bytes });
    }
    page.until("window.saved !== null");
    let saved: Vec<u8> =
        serde_json::from_value(page.run("return [...new Uint8Array(await window.saved.arrayBuffer())];"))
            .expect("bytes");
    assert!(saved == map, "another map was saved");
    page.until("document.getElementById('map-said').textContent.includes('map is fetched')");
    // Half a map is refused before anything is sent; a whole one is sent as it is, and a robot that drives refuses it.
    let [half, whole] = ["half.bin", "whole.bin"].map(|name| super::scratch("robot-map").join(name));
    std::fs::write(&half, &map[..map.len() / 2]).expect("a file");
    std::fs::write(&whole, &map).expect("a file");
    page.choose_files("#store-map", &[half]);
    page.until("document.getElementById('problem').textContent.startsWith('half.bin: is a damaged kept map')");
    page.choose_files("#store-map", std::slice::from_ref(&whole));
    page.until("window.written.length > 0");
    let first = map.iter().take(wire::PIECE_BYTES).copied().collect();
    assert_eq!(written(&mut page), [wire::Frame::MapRequest(wire::MapRequest::Put { offset: 0, bytes: first })]);
    answer(&mut page, wire::MapAnswer::Refused(wire::MapRefusal::Driving));
    page.until("document.getElementById('map-said').textContent.includes('stop it first')");
    page.choose_files("#store-map", &[whole]);
    let mut put: Vec<u8> = Vec::new();
    while put.len() < map.len() {
        page.until("window.written.length > 0");
        let [wire::Frame::MapRequest(wire::MapRequest::Put { offset, bytes })] = &written(&mut page)[..] else {
            panic!("a piece is put")
        };
        assert_eq!(*offset as usize, put.len());
        put.extend(bytes);
        let is_last = put.len() == map.len();
        let taken = wire::MapAnswer::Awaiting { offset: put.len() as u32 };
        answer(&mut page, if is_last { wire::MapAnswer::Kept { sequence: 8 } } else { taken });
    }
    assert!(put == map);
    page.until("document.getElementById('map-said').textContent.includes('as its number 8')");
    picture(&mut page, "robot-map");
    assert_sound(&mut page, &address);
}

#[test]
#[ignore = "needs the built page: cargo xtask test studio"]
fn a_robot_is_examined_and_its_calibration_told() {
    let Some((mut page, address)) = open_with("doctor", "", [1280, 1100], FAKE_SERIAL) else { return };
    page.run("document.querySelector(\"[data-mode-choice='robot']\").click(); document.getElementById('connect-serial').click();");
    page.until("!document.getElementById('doctor-begin').disabled");
    let bytes = robot_bytes(60.0);
    let (first, rest) = bytes.split_at(bytes.len() * 3 / 4);
    for part in first.chunks(16 * 1024) {
        feed(&mut page, part);
    }
    page.until("document.querySelectorAll('#walls tbody tr').length > 3");
    page.run("document.querySelectorAll('#doctor, #calibrate').forEach((part) => (part.open = true));");
    until_taken_in(&mut page, first.len());
    // Eight gains, two wheels.
    page.until("document.querySelectorAll('#calibrate-factors li').length === 10");
    page.run("document.getElementById('doctor-begin').click();");
    page.until("document.getElementById('doctor-now').textContent.includes('middle of the room')");
    assert_eq!(written(&mut page), [wire::Frame::Command(wire::Command::Stop)]);
    page.run("document.getElementById('doctor-done').click();");
    page.until("document.getElementById('doctor-now').textContent.startsWith('Listening')");
    let (middle, rest) = rest.split_at(rest.len() / 2);
    feed(&mut page, middle);
    page.until("document.getElementById('doctor-now').textContent.includes('in front of sensor 0')");
    // What comes late would be taken for what the sensor reads of the board.
    until_taken_in(&mut page, first.len() + middle.len());
    page.run("document.getElementById('doctor-done').click();");
    page.until("document.getElementById('doctor-now').textContent.startsWith('Listening')");
    feed(&mut page, rest);
    page.until("document.querySelectorAll('#doctor-found li').length === 1");
    picture(&mut page, "doctor");
    page.run("document.getElementById('doctor-end').click();");
    page.until("document.getElementById('doctor-end').hidden");
    assert_eq!(written(&mut page), [wire::Frame::Command(wire::Command::Stop)]);
    assert_sound(&mut page, &address);
}
