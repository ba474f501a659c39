//! The studio as a user meets it, in a browser. `cargo xtask test studio` builds the page first and names its folder.

use std::path::{Path, PathBuf};

use hal_sim::{ClosedLoop, Estimate, SimOptions, Simulation, default_rig, plan_file};
use lab::input::settings::Settings;
use lab::run::{Replay, Run};
use serde_json::{Value, json};
use slam_core::{Config, RobotSlam};
use tests::browser::Browser;
use tests::devtools::{Page, serve};

/// Names the page's folder.
const VARIABLE: &str = "STUDIO_PAGE";

fn page_folder() -> PathBuf {
    std::env::var_os(VARIABLE)
        .map_or_else(|| panic!("{VARIABLE} must name the folder that `cargo xtask studio` prints"), PathBuf::from)
}

fn scratch(name: &str) -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("studio").join(name)
}

/// Where a monitor on this machine lets pages take part in a robot's line.
const RELAY: &str = "ws://127.0.0.1:";

/// Opens the studio; `hash` goes behind its address.
fn open(name: &str, hash: &str, size: [u32; 2]) -> Option<(Page, String)> {
    open_with(name, hash, size, "")
}

/// The same, after a script of ours.
fn open_with(name: &str, hash: &str, size: [u32; 2], first: &str) -> Option<(Page, String)> {
    let browser = Browser::find()?;
    let address = serve(&page_folder());
    // What the page saves is kept for the test.
    let first = format!(
        "{first}; window.saved = null;
         const make = URL.createObjectURL.bind(URL);
         URL.createObjectURL = (blob) => {{ window.saved = blob; return make(blob); }};"
    );
    let mut page = Page::open(&browser, &scratch(name), &format!("{address}{hash}"), size, &first);
    page.until("document.documentElement.dataset.ready === 'true'");
    Some((page, address))
}

/// No fault, no console message, no request to elsewhere; nothing that reads as a missing number.
fn assert_sound(page: &mut Page, address: &str) {
    assert_eq!(page.run("return document.documentElement.dataset.errors;"), json!("0"), "{:#?}", page.console);
    assert!(page.console.is_empty(), "{:#?}", page.console);
    let outside: Vec<&String> =
        page.requests.iter().filter(|request| !request.starts_with(address) && !request.starts_with(RELAY)).collect();
    assert!(outside.is_empty() && page.requests.len() >= 4, "{:?}", page.requests);
    let odd = page.run("return /NaN|undefined|null|Infinity/.test(document.querySelector('main').innerText);");
    assert_eq!(odd, json!(false));
    let unnamed = page.run(
        "return [...document.querySelectorAll('button, input, canvas, select, textarea')].filter((node) =>
            !(node.getAttribute('aria-label') || node.getAttribute('aria-hidden') || node.labels?.length || node.textContent.trim()))
            .map((node) => node.outerHTML);",
    );
    assert_eq!(unnamed, json!([]), "controls without a name");
}

fn picture(page: &mut Page, name: &str) {
    page.picture(&scratch(&format!("{name}.png")));
}

#[test]
#[ignore = "needs the built page: cargo xtask test studio"]
fn the_first_visit_shows_a_home_being_mapped_without_a_click() {
    let Some((mut page, address)) = open("first", "", [1280, 900]) else { return };
    page.until("document.querySelectorAll('#walls tbody tr').length > 5");
    let seen = page.run(
        "const text = (id) => document.getElementById(id).textContent;
         return { title: text('title'), verdict: text('verdict'), play: text('play'),
            charts: [...document.querySelectorAll('[data-chart]')].map((chart) => chart.dataset.chart),
            wide: document.documentElement.scrollWidth - innerWidth };",
    );
    assert_eq!((&seen["title"], &seen["play"]), (&json!("flat"), &json!("Pause")), "{seen}");
    assert!(seen["verdict"].as_str().unwrap().contains("walls in the map"), "{seen}");
    assert!(seen["wide"].as_i64().unwrap() <= 0, "the page scrolls sideways");
    picture(&mut page, "first");
    page.run("scrollTo(0, 1100); await new Promise((done) => setTimeout(done, 1500));");
    picture(&mut page, "first-below");
    page.run("scrollTo(0, 2200); await new Promise((done) => setTimeout(done, 1500));");
    picture(&mut page, "first-far-below");
    assert_sound(&mut page, &address);
}

#[test]
#[ignore = "needs the built page: cargo xtask test studio"]
fn a_drive_pauses_goes_faster_and_can_be_looked_back_on() {
    let Some((mut page, address)) = open("transport", "", [1280, 900]) else { return };
    page.run("document.querySelector(\"[data-speed='100']\").click();");
    page.until("Number(document.getElementById('time').max) > 1500");
    let seen = page.run(
        "const clock = () => document.getElementById('clock').textContent;
         document.getElementById('play').click();
         const paused = clock();
         await new Promise((done) => setTimeout(done, 300));
         const later = clock();
         const slider = document.getElementById('time');
         slider.value = '100';
         slider.dispatchEvent(new Event('input'));
         const back = clock();
         document.getElementById('follow-now').click();
         return { paused, later, back, end: clock(), hidden: document.getElementById('follow-now').hidden };",
    );
    assert_eq!(seen["paused"], seen["later"]);
    assert!(seen["back"].as_str().unwrap().starts_with("0:04.0 / "), "{seen}");
    // The drive may be a sample ahead of what was shown as it paused; following goes to its newest moment.
    let newest = seen["paused"].as_str().and_then(|clock| clock.split_once(" / ")).map(|(_, newest)| newest).unwrap();
    assert_eq!((&seen["end"], &seen["hidden"]), (&json!(format!("{newest} / {newest}")), &json!(true)));
    page.run(
        "const plan = document.getElementById('plan'); plan.value = 'room'; plan.dispatchEvent(new Event('change'));",
    );
    page.until(
        "document.getElementById('title').textContent === 'room' && Number(document.getElementById('time').max) > 100",
    );
    assert_sound(&mut page, &address);
}

/// Where a part of the map is in the window, shares of its width and height.
fn on_map(page: &mut Page, [x, y]: [f64; 2]) -> [f64; 2] {
    let place = page.run(&format!(
        "const box = document.getElementById('map').getBoundingClientRect();
         return [box.x + {x} * box.width, box.y + {y} * box.height];"
    ));
    [0, 1].map(|axis| place[axis].as_f64().expect("a number"))
}

#[test]
#[ignore = "needs the built page: cargo xtask test studio"]
fn a_home_is_drawn_moved_and_typed_while_the_robot_drives() {
    let Some((mut page, address)) = open("draw", "", [1280, 900]) else { return };
    page.run(
        "document.querySelector(\"[data-tool='wall']\").click(); document.getElementById('map').scrollIntoView();",
    );
    let places = [[0.5, 0.75], [0.55, 0.75], [0.65, 0.75]].map(|place| on_map(&mut page, place));
    let before = page.run("return document.getElementById('plan-text').value;");
    page.drag(&places);
    let after = page.run("return document.getElementById('plan-text').value;");
    let added = after.as_str().unwrap().strip_prefix(before.as_str().unwrap().trim_end()).unwrap();
    assert!(added.contains("[[wall]]") && added.contains("from_m") && added.contains("to_m"), "{added}");
    picture(&mut page, "draw");
    // The wall is where it was drawn: it can be taken hold of there, moved, and erased.
    page.run("document.querySelector(\"[data-tool='move']\").click();");
    let places = [[0.55, 0.75], [0.55, 0.7], [0.55, 0.65]].map(|place| on_map(&mut page, place));
    page.drag(&places);
    let moved = page.run("return document.getElementById('plan-text').value;");
    assert!(moved != after && moved.as_str().unwrap().matches("[[wall]]").count() == 1, "{moved}");
    page.run("document.querySelector(\"[data-tool='erase']\").click();");
    let place = on_map(&mut page, [0.6, 0.65]);
    page.drag(&[place, place]);
    assert!(!page.run("return document.getElementById('plan-text').value;").as_str().unwrap().contains("[[wall]]"));
    // Typed, with a mistake, and without.
    let apply = |text: &str| {
        format!(
            "const text = document.getElementById('plan-text');
             text.value += {text:?};
             document.getElementById('apply-plan').click();
             return document.getElementById('problem').textContent;"
        )
    };
    let problem = page.run(&apply("\n[[round]]\ncentre_m = [2.0, 2.0]\nradius_m = -1.0\n"));
    assert!(
        problem.as_str().unwrap().contains("radius_m: is -1") && problem.as_str().unwrap().starts_with("plan:"),
        "{problem}"
    );
    page.run("document.getElementById('plan-text').value = document.getElementById('plan-text').value.replace('-1.0', '0.2');");
    assert_eq!(page.run(&apply("")), json!(""));
    assert_sound(&mut page, &address);
}

#[test]
#[ignore = "needs the built page: cargo xtask test studio"]
fn a_robot_is_carried_off_and_finds_itself_again() {
    let Some((mut page, address)) = open("carry", "", [1280, 900]) else { return };
    page.run("document.querySelector(\"[data-speed='100']\").click();");
    page.until("Number(document.getElementById('time').max) > 5000");
    page.run("document.querySelector(\"[data-speed='10']\").click(); document.getElementById('carry').click();");
    page.until("document.getElementById('status').textContent.includes('Searching')");
    picture(&mut page, "searching");
    page.run("document.querySelector(\"[data-speed='100']\").click();");
    page.until("document.getElementById('status').textContent.includes('Located.')");
    picture(&mut page, "located");
    page.run(
        "for (const id of ['kick', 'hold']) document.getElementById(id).click();
        const cover = document.getElementById('cover'); cover.value = '2'; cover.dispatchEvent(new Event('change'));",
    );
    page.run("document.getElementById('cut-power').click();");
    page.until("document.getElementById('eyebrow').textContent.includes('power was cut')");
    assert_sound(&mut page, &address);
}

#[test]
#[ignore = "needs the built page: cargo xtask test studio"]
fn a_scene_is_shared_as_a_link_and_a_bad_link_is_said() {
    let Some((mut page, address)) = open("share", "", [1280, 900]) else { return };
    let hash = page.run(
        "document.getElementById('seed').value = '7';
         const knob = document.getElementById('knob-sensors');
         knob.value = '4';
         knob.dispatchEvent(new Event('change'));
         document.getElementById('share').click();
         while (!location.hash) await new Promise((done) => setTimeout(done, 20));
         return location.hash;",
    );
    assert_sound(&mut page, &address);
    let Some((mut other, address)) = open("shared", hash.as_str().unwrap(), [1280, 900]) else { return };
    let seen = other
        .run("return [document.getElementById('seed').value, document.querySelectorAll('#trace tbody tr').length];");
    assert_eq!(seen, json!(["7", 4]));
    assert_sound(&mut other, &address);
    let Some((mut bad, address)) = open("bad-link", "#scene=%%%", [1280, 900]) else { return };
    assert!(
        bad.run("return document.getElementById('problem').textContent;").as_str().unwrap().contains("cannot be read")
    );
    assert_sound(&mut bad, &address);
}

#[test]
#[ignore = "needs the built page: cargo xtask test studio"]
fn a_phone_shows_it_without_scrolling_sideways() {
    let Some((mut page, address)) = open("phone", "", [390, 840]) else { return };
    page.until("document.querySelectorAll('#walls tbody tr').length > 3");
    assert!(page.run("return document.documentElement.scrollWidth - innerWidth;").as_i64().unwrap() <= 0);
    picture(&mut page, "phone");
    assert_sound(&mut page, &address);
}

/// A short simulated run's folder.
fn a_run(name: &str) -> PathBuf {
    let out = scratch(name).join("run");
    let config = Config::for_rig(&default_rig());
    let run = Run {
        plan: "flat".into(),
        job: lab::run::Job::Explore,
        minutes: 1.0,
        seed: 5,
        rig: None,
        out: out.clone(),
        map: None,
        start: None,
        settings: Settings::Exactly(config),
        trace: false,
    };
    run.run(|_| {}).expect("it runs");
    out
}

#[test]
#[ignore = "needs the built page: cargo xtask test studio"]
fn a_log_replays_to_the_bits_of_the_program_and_a_bad_one_is_named() {
    let Some((mut page, address)) = open("replay", "", [1280, 900]) else { return };
    let run = a_run("replay-files");
    let out = scratch("replay-files").join("replayed");
    let replay = Replay {
        log: run.join("log.csv"),
        rig: run.join("rig.toml"),
        out: out.clone(),
        truth: None,
        map: None,
        settings: Settings::Exactly(Config::for_rig(&default_rig())),
        trace: false,
    };
    replay.run(|_| {}).expect("it replays");
    page.run("document.querySelector(\"[data-mode-choice='replay']\").click();");
    page.choose_files("#files", &[run.join("log.csv"), run.join("rig.toml")]);
    page.until("document.getElementById('status').textContent.startsWith('1\u{202f}501 rows.')");
    let verdict = page.run("return document.getElementById('verdict').textContent;");
    assert!(verdict.as_str().unwrap().contains("closer than dead reckoning"), "{verdict}");
    page.run("document.getElementById('save-estimate').click();");
    let saved = page.run("return await window.saved.text();");
    let expected = std::fs::read_to_string(out.join("estimate.csv")).expect("it was written");
    assert!(saved == json!(expected), "the page's estimate is not that of lab replay");
    page.run("await new Promise((done) => setTimeout(done, 500));");
    picture(&mut page, "replay");
    // The report is the program's own page.
    page.run("document.getElementById('save-report').click();");
    let report = page.run("return await window.saved.text();");
    assert!(report.as_str().unwrap().contains("id=\"verdict\""));
    // A bad line is named with file, line and column; what came before it is shown.
    let text = std::fs::read_to_string(run.join("log.csv")).unwrap();
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    lines[100] = lines[100].replacen(',', ",ten,", 1).trim_end_matches(|c| c != ',').trim_end_matches(',').to_owned();
    let bad = scratch("replay-files").join("bad.csv");
    std::fs::write(&bad, lines.join("\n")).unwrap();
    page.choose_files("#files", &[bad]);
    page.until("!document.getElementById('problem').hidden");
    let problem = page.run("return document.getElementById('problem').textContent;");
    assert!(problem.as_str().unwrap().starts_with("bad.csv:101: left_ticks: is \"ten\""), "{problem}");
    let rig = scratch("replay-files").join("odd.toml");
    std::fs::write(&rig, "[wheels]\ntrack_m = 0.2\n").unwrap();
    page.choose_files("#files", &[run.join("log.csv"), rig]);
    page.until("document.getElementById('problem').textContent.startsWith('odd.toml')");
    assert_sound(&mut page, &address);
}

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
        let ranges = sample.ranges.iter().take(wire::SENSORS).map(|range| wire::Range::from(*range)).collect();
        let slam_core::Motion::Ticks(ticks) = sample.motion else { panic!("the built-in robot has encoders") };
        let sent = wire::Sample {
            time_us: sample.time_us,
            left_ticks: ticks.left,
            right_ticks: ticks.right,
            ranges,
            contacts: wire::Contacts::default(),
        };
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
        let mut ranges_m = [None; hal_sim::MAX_SENSORS];
        ranges_m.iter_mut().zip(report.readings).for_each(|(wide, reading)| *wide = reading.range_m);
        Estimate { pose: slam.pose(), ranges_m }
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
