//! Writes `docs/results/floor.md`: `cargo run --release --package lab --example floor_jobs`. With `-- SEEDS HOME...`, as in
//! `-- 11-13 flat random-101`, it prints the rows of these homes instead, and what the path was driven for; with
//! `-- mishaps` the tables of what goes wrong alone; with `-- mishaps WHAT HOME...`, as in `-- mishaps "a kick" 61 62`, how the jobs
//! in these random homes end, of that row of the second table whose name has WHAT in it.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use hal_sim::fault::{Fault, Part};
use hal_sim::mishap::{Hold, Kick, Kidnap};
use hal_sim::plan::{Battery, Door, Person, Plan};
use hal_sim::random_home::{elsewhere, shut_door, sills, somebody, with_dock};
use hal_sim::rng::Rng;
use hal_sim::{Pose2, SimOptions, plan_file};
use lab::run::{FloorDrive, clean, clean_with};
use robot::FloorState;

const MISHAPS_HEAD: &str = "\n## When something goes wrong\n\n\
    The flat, five minutes after the start, three seeds each; swept is of the floor that stays in reach. *Pose off* is how far the\n\
    estimated position was off at worst, where a place was claimed. The bar is 95 % swept. Who gives way turns round before the robot; who does not walks into it,\n\
    again and again, and pushes it along by up to a metre, unseen by its wheels.\n\n\
    | what | drives | done and back | swept, % | overlap | minutes | pose off, m |\n\
    |---|---|---|---|---|---|---|\n";
const RANDOM_MISHAPS_HEAD: &str = "\n## The same in random homes\n\n\
    The random homes 41 to 60, one drive each by a robot of its own, the moment, the door and the way of who walks drawn.\n\
    Mean, and in brackets the worst; of *pose off* the median and the worst. *Gave up* is in how many the robot\n\
    [gave its place up](../explanation/kept-map.md#a-map-that-the-readings-contradict) and looked for itself, *twice* in how many it found its home\n\
    [in its map twice](../explanation/kept-map.md#a-home-that-is-in-one-map-twice).\n\n\
    | what | drives | done and back | swept, % | at least 95 % swept | overlap | minutes | pose off, m | gave up | twice |\n\
    |---|---|---|---|---|---|---|---|---|---|\n";
const KITCHEN_DOOR: Door = Door { from_m: [2.2, 3.35], to_m: [3.1, 3.35], closes_at_s: 0.0, opens_at_s: f64::INFINITY };
/// A door is shut, or a part of the robot fails, for so long, seconds.
const SHUT_S: f64 = 300.0;
const MISHAP_SEEDS: std::ops::RangeInclusive<u64> = 1..=3;

const SEEDS: std::ops::RangeInclusive<u64> = 1..=10;
const MISHAP_HOMES: std::ops::RangeInclusive<u64> = 41..=60;
const RANDOM_HOMES: std::ops::RangeInclusive<u64> = 41..=80;

const HEAD: &str = "# Floors swept\n\n\
    Written by `cargo run --release --package lab --example floor_jobs`. The built-in robot sweeps each home once, from an empty map,\n\
    without a dock; [what counts](../explanation/floor-job.md#what-counts). Mean, and in brackets the worst: of ten seeds a built-in\n\
    plan, and of the random homes 41 to 80 (`--plan random-SEED --seed SEED`), one drive each, by a robot of its own. Done\n\
    and back is within 20 cm of the start by the true pose. *Bars* are what is aimed at: at least 96 % swept (93 % in clutter),\n\
    overlap at most 1.5, no hole over 0.05 m2, back within 20 cm, the flat in 20 minutes.\n\n\
    | home | drives | done and back | floor, m2 | swept, % | overlap | largest hole, m2 | holes over 0.05 m2 | minutes | bumps a m2 | from the start, m |\n\
    |---|---|---|---|---|---|---|---|---|---|---|\n";

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments.first().is_some_and(|first| first == "mishaps") {
        match &arguments[1..] {
            [] => print!("{}", mishaps()),
            [what] => panic!("{what:?} goes wrong in no home: say in which, as in -- mishaps {what:?} 61 62"),
            [what, homes @ ..] => homes.iter().for_each(|home| print_mishap(what, home)),
        }
        return;
    }
    if let Some((seeds, homes)) = arguments.split_first() {
        let (first, last) = seeds.split_once('-').unwrap_or((seeds, seeds));
        let seed = |text: &str| text.parse::<u64>().expect("SEEDS is a number, or two as in 11-13");
        return homes.iter().for_each(|home| print_home(home, seed(first)..=seed(last)));
    }
    let mut page = HEAD.to_owned();
    for (name, _) in plan_file::BUILT_IN {
        let jobs: Vec<FloorDrive> = SEEDS.map(|seed| job(name, seed)).collect();
        row(&mut page, name, &jobs);
    }
    let jobs: Vec<FloorDrive> = RANDOM_HOMES.map(|home| job(&format!("random-{home}"), home)).collect();
    row(&mut page, "random", &jobs);
    page.push_str(&mishaps());
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/results/floor.md");
    fs::write(&path, page).expect("docs/results/floor.md can be written");
}

/// The page's two tables of what goes wrong.
fn mishaps() -> String {
    let mut page = MISHAPS_HEAD.to_owned();
    for mishap in Mishap::ALL {
        let jobs: Vec<FloorDrive> = MISHAP_SEEDS.map(|seed| mishap.job(seed)).collect();
        mishap_row(&mut page, mishap.name(), &jobs);
    }
    page.push_str(RANDOM_MISHAPS_HEAD);
    for mishap in Mishap::IN_RANDOM_HOMES {
        let jobs: Vec<FloorDrive> = MISHAP_HOMES.filter_map(|home| mishap.at_random(home)).collect();
        random_mishap_row(&mut page, mishap.name(), &jobs);
    }
    page
}

fn job(home: &str, seed: u64) -> FloorDrive {
    let plan = plan_file::load(home).expect("a built-in plan, or random-SEED");
    clean(&plan, SimOptions::default(), seed).expect("the robot fits")
}

/// What goes wrong in the flat, five minutes after the start or all the time.
#[derive(Clone, Copy)]
enum Mishap {
    None,
    GivesWay,
    Pushes,
    Door,
    ShutDoor,
    Slips,
    Kick,
    KickFromDock,
    Push,
    Lift,
    Carry,
    Battery,
    Held,
    Jammed,
    Sills,
    Bumper,
    Dust,
    Sensor,
    Blind,
}

impl Mishap {
    const ALL: [Self; 12] = [
        Self::None,
        Self::GivesWay,
        Self::Pushes,
        Self::Door,
        Self::ShutDoor,
        Self::Slips,
        Self::Kick,
        Self::Push,
        Self::Lift,
        Self::Battery,
        Self::Held,
        Self::Jammed,
    ];

    const IN_RANDOM_HOMES: [Self; 14] = [
        Self::None,
        Self::GivesWay,
        Self::Pushes,
        Self::ShutDoor,
        Self::Kick,
        Self::KickFromDock,
        Self::Push,
        Self::Carry,
        Self::Held,
        Self::Sills,
        Self::Bumper,
        Self::Dust,
        Self::Sensor,
        Self::Blind,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::None => "nothing",
            Self::GivesWay => "somebody walks to and fro, and gives way",
            Self::Pushes => "somebody walks to and fro, and pushes it aside",
            Self::Door => "the door to the kitchen shuts for good",
            Self::ShutDoor => "a door is shut for five minutes",
            Self::Slips => "a wheel slips by 2 cm every other metre",
            Self::Kick => "a kick, 10 cm and 15 degrees",
            Self::KickFromDock => "such a kick, and a battery for 20 minutes, half full, and a dock",
            Self::Push => "pushed aside once, by 50 cm",
            Self::Lift => "lifted for 5 s, put back 3 cm and 3 degrees off",
            Self::Carry => "carried to another place",
            Self::Battery => "the battery lasts 10 minutes, a dock charges it in 5",
            Self::Held => "held for 20 s, wheels turning",
            Self::Jammed => "held for 20 s, wheels held, too",
            Self::Sills => "a sill in every door, over which a wheel hangs for 0.3 s",
            Self::Bumper => "half of the bumper is jammed for five minutes",
            Self::Dust => "dust on the cliff sensor for five minutes",
            Self::Sensor => "a range sensor fails",
            Self::Blind => "no range sensor sees anything for five minutes",
        }
    }

    fn job(self, seed: u64) -> FloorDrive {
        let mut plan = plan_file::load("flat").expect("a built-in plan");
        if matches!(self, Self::GivesWay | Self::Pushes) {
            plan.people.push(Person {
                radius_m: 0.15,
                speed_mps: 0.5,
                path_m: vec![[1.0, 2.8], [3.6, 1.8], [2.5, 0.7]],
                gives_way: matches!(self, Self::GivesWay),
            });
        }
        if matches!(self, Self::ShutDoor) {
            plan.doors.push(Door { closes_at_s: 300.0, opens_at_s: 300.0 + SHUT_S, ..KITCHEN_DOOR });
        }
        self.befalling(plan, 300.0, seed)
    }

    /// In the random home of this number, at a moment between one minute and seven; none where nobody has room to walk, or there is no
    /// door, dock or other place.
    fn at_random(self, home: u64) -> Option<FloorDrive> {
        let mut plan = plan_file::load(&format!("random-{home}")).expect("a random home");
        if matches!(self, Self::GivesWay | Self::Pushes) {
            plan.people.push(somebody(&plan, home, matches!(self, Self::GivesWay))?);
        }
        if matches!(self, Self::KickFromDock) {
            plan = with_dock(&plan, home)?;
        }
        let at_s = Rng::stream(home, "moment", 0).uniform(60.0, 420.0);
        if matches!(self, Self::ShutDoor) {
            plan.doors.push(shut_door(home, at_s, at_s + SHUT_S)?);
        }
        if matches!(self, Self::Carry) {
            let to = elsewhere(&plan, &mut Rng::stream(home, "carried", 0))?;
            plan.mishaps.kidnaps.push(Kidnap { at_s, carried_s: 5.0, to: Some(to) });
        }
        match self {
            Self::Sills => plan.mishaps.sills = sills(home),
            Self::Bumper => plan.mishaps.faults.push(Fault { part: Part::BumpLeft, at_s, lasts_s: SHUT_S }),
            Self::Dust => plan.mishaps.faults.push(Fault { part: Part::Cliff, at_s, lasts_s: SHUT_S }),
            Self::Sensor => plan.mishaps.faults.push(Fault { part: any_sensor(home), at_s, lasts_s: f64::INFINITY }),
            Self::Blind => plan.mishaps.faults.extend((0..8).map(|index| {
                let part = Part::Sensor { index, shows_m: None };
                Fault { part, at_s, lasts_s: SHUT_S }
            })),
            _ => {}
        }
        if matches!(self, Self::Sills) && plan.mishaps.sills.is_empty() {
            return None;
        }
        Some(self.befalling(plan, at_s, home))
    }

    fn befalling(self, mut plan: Plan, at_s: f64, seed: u64) -> FloorDrive {
        let mut options = SimOptions::default();
        match self {
            Self::None | Self::ShutDoor | Self::Carry | Self::Lift | Self::GivesWay | Self::Pushes => {}
            Self::Sills | Self::Bumper | Self::Dust | Self::Sensor | Self::Blind => {}
            Self::Door => plan.doors.push(Door { closes_at_s: at_s, opens_at_s: f64::INFINITY, ..KITCHEN_DOOR }),
            Self::Slips => (options.drive.slips_per_m, options.drive.slip_m) = (0.5, 0.02),
            Self::Kick => plan.mishaps.kicks.push(kick(at_s)),
            Self::KickFromDock => {
                plan.mishaps.kicks.push(kick(at_s));
                plan.battery = Some(Battery { charge: 0.5, lasts_min: 20.0, charges_min: 5.0 });
            }
            Self::Push => plan.mishaps.kicks.push(Kick { at_s, slide_m: 0.5, turn_rad: 0.0 }),
            Self::Battery => {
                // At the southern wall, which it looks to.
                plan.start = Pose2::new(1.2, 0.185, -core::f64::consts::FRAC_PI_2);
                plan.has_dock = true;
                plan.battery = Some(Battery { charge: 1.0, lasts_min: 10.0, charges_min: 5.0 });
            }
            Self::Held | Self::Jammed => {
                let is_jammed = matches!(self, Self::Jammed);
                plan.mishaps.holds.push(Hold { at_s, held_s: 20.0, is_jammed });
            }
        }
        let mut is_lift_due = matches!(self, Self::Lift);
        let drive = clean_with(&plan, options, seed, None, |drive, _| {
            let simulation = drive.simulation();
            if is_lift_due && simulation.time_s() >= at_s {
                let pose = simulation.pose_in_plan();
                let to = Pose2 { x_m: pose.x_m + 0.03, theta_rad: pose.theta_rad + 0.05, ..pose };
                // Where there is no room just there, it is lifted a little later.
                is_lift_due = simulation.carry(Some(to), 5.0).is_err();
            }
        });
        drive.expect("the robot fits")
    }
}

/// One of the eight range sensors, which shows nothing, or, in three of four homes, a distance up to the end of its reach.
fn any_sensor(home: u64) -> Part {
    let mut rng = Rng::stream(home, "sensor", 0);
    let index = rng.uniform(0.0, 8.0) as usize;
    let shows_m = Some(rng.uniform(0.1, 1.5)).filter(|_| rng.uniform(0.0, 1.0) < 0.75);
    Part::Sensor { index, shows_m }
}

fn kick(at_s: f64) -> Kick {
    Kick { at_s, slide_m: 0.1, turn_rad: 15_f64.to_radians() }
}

/// How the job in the random home of this number ends where this goes wrong.
fn print_mishap(what: &str, home: &str) {
    let mishap = Mishap::IN_RANDOM_HOMES.into_iter().find(|mishap| mishap.name().contains(what));
    let mishap = mishap.unwrap_or_else(|| panic!("no {what:?} in {:?}", Mishap::IN_RANDOM_HOMES.map(Mishap::name)));
    let Some(job) = mishap.at_random(home.parse().expect("a random home's number")) else {
        return println!("{home}: nobody has room to walk, or it has no door, dock or other place");
    };
    println!(
        "{home}: {:?}, {:.1} % swept, overlap {:.2}, {:.1} min, home {:.2} m, off {:.2} m, gave up {}, {}",
        job.progress.state,
        100.0 * job.score.swept,
        job.score.overlap,
        job.minutes,
        job.score.home_m,
        job.worst_m,
        job.lost,
        time_spent(&job),
    );
}

/// How long a job was in each state.
fn time_spent(job: &FloorDrive) -> String {
    let seconds = FloorState::ALL.iter().zip(job.progress.seconds_in).filter(|(_, seconds)| *seconds > 0);
    let spent: Vec<String> = seconds.map(|(state, seconds)| format!("{} {seconds} s", state.name())).collect();
    spent.join(", ")
}

/// Whether it is done and back within 20 cm of its start by the true pose: the robot's own word is not enough.
fn is_back(job: &&FloorDrive) -> bool {
    job.progress.state == FloorState::Done && job.score.home_m < 0.2
}

fn mishap_row(page: &mut String, name: &str, jobs: &[FloorDrive]) {
    let swept = || jobs.iter().map(|job| 100.0 * job.score.swept);
    let back = jobs.iter().filter(is_back).count();
    let mean = |sum: f64| sum / jobs.len() as f64;
    let line = writeln!(
        page,
        "| {name} | {} | {back} | {:.1} ({:.1}) | {:.2} | {:.1} | {:.2} |",
        jobs.len(),
        mean(swept().sum()),
        swept().fold(f64::INFINITY, f64::min),
        mean(jobs.iter().map(|job| job.score.overlap).sum()),
        mean(jobs.iter().map(|job| job.minutes).sum()),
        jobs.iter().map(|job| job.worst_m).fold(0.0, f64::max),
    );
    line.expect("a String takes it all");
}

fn random_mishap_row(page: &mut String, name: &str, jobs: &[FloorDrive]) {
    let mean = |value: fn(&FloorDrive) -> f64| jobs.iter().map(value).sum::<f64>() / jobs.len() as f64;
    let mut off_m: Vec<f64> = jobs.iter().map(|job| job.worst_m).collect();
    off_m.sort_by(f64::total_cmp);
    let line = writeln!(
        page,
        "| {name} | {} | {} | {:.1} ({:.1}) | {} | {:.2} | {:.1} | {:.2} ({:.2}) | {} | {} |",
        jobs.len(),
        jobs.iter().filter(is_back).count(),
        mean(|job| 100.0 * job.score.swept),
        jobs.iter().map(|job| 100.0 * job.score.swept).fold(f64::INFINITY, f64::min),
        jobs.iter().filter(|job| job.score.swept >= 0.95).count(),
        mean(|job| job.score.overlap),
        mean(|job| job.minutes),
        off_m[off_m.len() / 2],
        off_m.last().copied().unwrap_or_default(),
        jobs.iter().filter(|job| job.lost > 0).count(),
        jobs.iter().filter(|job| job.second_copies > 0).count(),
    );
    line.expect("a String takes it all");
}

/// The row of one home, and what its path was driven for: metres, and square metres swept for the first time.
fn print_home(home: &str, seeds: std::ops::RangeInclusive<u64>) {
    let jobs: Vec<FloorDrive> = seeds.map(|seed| job(home, seed)).collect();
    let mut text = String::new();
    row(&mut text, home, &jobs);
    for way in jobs.iter().flat_map(|job| &job.score.ways) {
        let _ = write!(text, "{} {:.1}/{:.2}  ", way.doing, way.path_m, way.new_m2);
    }
    for job in &jobs {
        let _ = write!(text, "\n{:?} off by {:.2} m, {}", job.progress.state, job.worst_m, time_spent(job));
    }
    println!("{text}");
}

fn row(page: &mut String, name: &str, jobs: &[FloorDrive]) {
    let values = |value: fn(&FloorDrive) -> f64| jobs.iter().map(value).collect::<Vec<_>>();
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let high = |values: &[f64]| values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let low = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
    let swept = values(|done| 100.0 * done.score.swept);
    let overlap = values(|done| done.score.overlap);
    let hole = values(|done| done.score.largest_hole_m2);
    let minutes = values(|done| done.minutes);
    let bumps = values(|done| f64::from(done.score.bumps) / done.score.floor_m2);
    let home = values(|done| done.score.home_m);
    let back = jobs.iter().filter(is_back).count();
    let line = writeln!(
        page,
        "| {name} | {} | {back} | {:.1} | {:.1} ({:.1}) | {:.2} ({:.2}) | {:.3} ({:.3}) | {} | {:.1} ({:.1}) | {:.1} ({:.1}) | {:.2} ({:.2}) |",
        jobs.len(),
        mean(&values(|done| done.score.floor_m2)),
        mean(&swept),
        low(&swept),
        mean(&overlap),
        high(&overlap),
        mean(&hole),
        high(&hole),
        hole.iter().filter(|hole| **hole > 0.05).count(),
        mean(&minutes),
        high(&minutes),
        mean(&bumps),
        high(&bumps),
        mean(&home),
        high(&home),
    );
    line.expect("a String takes it all");
}
