//! Writes `docs/results/clean-areas.md`: `cargo run --release --package lab --example clean_areas`. With `-- 101-110` it prints a line
//! for each drive in these random homes instead.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use hal_sim::plan::{Face, Plan, Room};
use hal_sim::rng::Rng;
use hal_sim::{SimOptions, plan_file};
use lab::run::{FloorDrive, clean};
use robot::{AreaKind, FloorState};

const HOMES: std::ops::RangeInclusive<u64> = 101..=220;
/// Walls are 0.1 m thick: half of that beside a room it ends.
const BESIDE_M: f64 = 0.05;

const HEAD: &str = "# Areas to clean in other rooms\n\n\
    Written by `cargo run --release --package lab --example clean_areas`. The built-in robot is told of a `[[clean]]` area or two in rooms other than\n\
    the one that it starts in, which it has not seen: the random homes 101 to 220 that have more than one room, one drive each, from an empty\n\
    map, and the same ones with that room walled in. Done is back within 20 cm with all areas reached, *not reached* what the job\n\
    said itself. Swept is of what can be reached of the areas. Mean, and in brackets the worst.\n\n\
    | area | drives | done and back | said not to be reached | swept, % | path, m | minutes |\n\
    |---|---|---|---|---|---|---|\n";

/// Which part of another room is to be cleaned.
#[derive(Clone, Copy, PartialEq)]
enum Part {
    All,
    Some,
    More,
    Two,
    WalledIn,
}

impl Part {
    const EACH: [Self; 5] = [Self::All, Self::Some, Self::More, Self::Two, Self::WalledIn];

    fn name(self) -> &'static str {
        match self {
            Self::All => "a room",
            Self::Some => "a part of a room",
            Self::More => "a room and up to 1.5 m around it",
            Self::Two => "two rooms, less 0.2 m along their walls",
            Self::WalledIn => "a room that is walled in",
        }
    }

    /// Lower and upper corner of the area in a room, metres.
    fn area_m(self, room: &Room, rng: &mut Rng) -> [[f64; 2]; 2] {
        let sides = [0, 1].map(|axis| {
            let (low, high) = (room.min_m[axis], room.max_m[axis]);
            match self {
                Self::All | Self::WalledIn => [low, high],
                Self::Two => [low + 0.2, high - 0.2],
                Self::More => [low - rng.uniform(0.0, 1.5), high + rng.uniform(0.0, 1.5)],
                Self::Some => {
                    let size_m = rng.uniform(1.2, high - low);
                    let low = rng.uniform(low, high - size_m);
                    [low, low + size_m]
                }
            }
        });
        [0, 1].map(|end| [sides[0][end], sides[1][end]])
    }
}

fn corners([[x0, y0], [x1, y1]]: [[f64; 2]; 2]) -> [[f64; 2]; 4] {
    [[x0, y0], [x1, y0], [x1, y1], [x0, y1]]
}

/// A random home with such an area; none where it has one room.
fn home(seed: u64, part: Part) -> Option<Plan> {
    let mut plan = plan_file::load(&format!("random-{seed}")).expect("a random home");
    let mut rng = Rng::stream(seed, "areas", 0);
    let start_m = [plan.start.x_m, plan.start.y_m];
    let is_start = |room: &Room| (0..2).all(|axis| (room.min_m[axis]..room.max_m[axis]).contains(&start_m[axis]));
    let mut others: Vec<Room> = plan.rooms.iter().filter(|room| !is_start(room)).cloned().collect();
    if others.is_empty() || others.len() == plan.rooms.len() {
        return None;
    }
    let turn = rng.next_u64() as usize % others.len();
    others.rotate_left(turn);
    for room in others.iter().take(if part == Part::Two { 2 } else { 1 }) {
        let area = corners(part.area_m(room, &mut rng)).map(|corner| corner.map(|value_m| value_m as f32));
        plan.bounds.add(AreaKind::Clean, &area).expect("there is room for two");
        if part == Part::WalledIn {
            let wall = corners([room.min_m.map(|low| low - BESIDE_M), room.max_m.map(|high| high + BESIDE_M)]);
            plan.faces.extend((0..4).map(|i| Face { from_m: wall[i], to_m: wall[(i + 1) % 4], two_sided: true }));
        }
    }
    Some(plan)
}

fn job(seed: u64, part: Part) -> Option<FloorDrive> {
    home(seed, part).map(|plan| clean(&plan, SimOptions::default(), seed).expect("the robot fits"))
}

fn main() {
    if let Some(homes) = std::env::args().nth(1) {
        let (first, last) = homes.split_once('-').expect("homes as in 101-110");
        let seed = |text: &str| text.parse::<u64>().expect("a number");
        return (seed(first)..=seed(last)).for_each(print_home);
    }
    let mut page = HEAD.to_owned();
    for part in Part::EACH {
        let jobs: Vec<FloorDrive> = HOMES.filter_map(|home| job(home, part)).collect();
        row(&mut page, part, &jobs);
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/results/clean-areas.md");
    fs::write(&path, page).expect("docs/results/clean-areas.md can be written");
}

fn print_home(home: u64) {
    for part in Part::EACH {
        let Some(FloorDrive { score, progress, minutes, worst_m, .. }) = job(home, part) else { continue };
        println!(
            "{home}, {}: {}, {:.1} % of {:.1} m2, {:.0} m, {minutes:.1} minutes, {:.2} m from the start, off by {worst_m:.2} m",
            part.name(),
            progress.state.name(),
            100.0 * score.swept,
            score.floor_m2,
            score.path_m,
            score.home_m,
        );
    }
}

fn row(page: &mut String, part: Part, jobs: &[FloorDrive]) {
    let mean_and_worst = |value: fn(&FloorDrive) -> f64, worst: fn(f64, f64) -> f64| {
        let values: Vec<f64> = jobs.iter().filter(|job| job.score.floor_m2 > 0.0).map(value).collect();
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        let worst = values.iter().copied().reduce(worst);
        worst.map_or("-".to_owned(), |worst| format!("{mean:.1} ({worst:.1})"))
    };
    let back = jobs.iter().filter(|job| job.progress.state == FloorState::Done && job.score.home_m < 0.2).count();
    let unreached = jobs.iter().filter(|job| job.progress.missed != 0).count();
    let all = |value: fn(&FloorDrive) -> f64| {
        let mean = jobs.iter().map(value).sum::<f64>() / jobs.len().max(1) as f64;
        format!("{mean:.1} ({:.1})", jobs.iter().map(value).fold(0.0, f64::max))
    };
    let line = writeln!(
        page,
        "| {} | {} | {back} | {unreached} | {} | {} | {} |",
        part.name(),
        jobs.len(),
        mean_and_worst(|job| 100.0 * job.score.swept, f64::min),
        all(|job| job.score.path_m),
        all(|job| job.minutes),
    );
    line.expect("a String takes it all");
}
