//! A second run whose robot's power is cut in the middle: how soon it knows its place again, and whether it claims wrong ones.

use std::fmt::Write as _;
use std::ops::RangeInclusive;

use hal_sim::random_home::elsewhere;
use hal_sim::rng::Rng;
use hal_sim::{Plan, Pose2, SimOptions, plan_file};
use lab::input::built_in_robot;
use lab::input::rig_file::Robot;
use lab::input::settings::by_default;
use lab::run::{Drive, MapId, Session, clean};
use robot::{FLOOR_RECORD_BYTES, POSE_RECORD_BYTES};

/// When the second run's power is cut while it drives, and how long it stands before it is cut again, seconds.
const CUT_S: f64 = 240.0;
const STANDS_S: f64 = 2.0;

/// How long the robot may look for itself after that, and how long a place is held to be for good, seconds.
const LONGEST_S: f64 = 300.0;
const FOR_GOOD_S: f64 = 60.0;

/// How far the robot rolls on when its power goes, metres, and how far off a claim is that is wrong.
const ROLLS_M: f64 = 0.1;
const WRONG_M: f64 = 0.3;

/// Places in each home that it is carried to.
const PLACES: usize = 3;

const HEAD: &str = "\n## After a power cut\n\n\
    In the random homes 41 to 60 the power of a robot is cut four minutes into its second run, and it goes on with the map, the floor that is left and\n\
    [where it was](../explanation/kept-map.md#after-a-reset), if it knows that. *Known* is in how many runs something was written down of where it was. The robot stands where it stood, has rolled on by 0.1 m from where it drove, or\n\
    was carried to one of three places of each home while it was off. *Found* and *wrong* are as above, in five minutes.\n\n\
    | after the cut | it expects itself | runs | known | found | wrong |\n\
    |---|---|---|---|---|---|\n";

/// What is there after a power cut.
struct Cut {
    map: Vec<u8>,
    id: MapId,
    job: Option<[u8; FLOOR_RECORD_BYTES]>,
    pose: Option<[u8; POSE_RECORD_BYTES]>,
    /// Where the robot is, in the plan's frame.
    at: Pose2,
}

/// What came of a search after it: when the robot claimed a place for good, seconds, and whether it claimed a wrong one.
struct Search {
    is_known: bool,
    found_s: f64,
    is_wrong: bool,
}

/// The section of these homes.
pub fn section(page: &mut String, homes: RangeInclusive<u64>) {
    page.push_str(HEAD);
    let (robot, _) = built_in_robot().expect("the built-in robot");
    let kinds = ["stands where it stood", "rolled on", "carried"];
    let mut searches: [[Vec<Search>; 2]; 3] = Default::default();
    for home in homes {
        let plan = plan_file::load(&format!("random-{home}")).expect("a random home");
        let map = clean(&plan, SimOptions::default(), 1).expect("it fits").map.expect("a map");
        let [driving, standing] = second_run(&plan, &robot, map);
        let rolled = driving.at.compose(&Pose2::new(ROLLS_M, 0.0, 0.0));
        let mut rng = Rng::stream(home, "carried while off", 0);
        let carried = (0..PLACES).filter_map(|_| elsewhere(&plan, &mut rng)).map(|place| (2, &standing, place));
        let runs = [(0, &standing, standing.at), (1, &driving, rolled)].into_iter().chain(carried);
        for (kind, cut, at) in runs {
            for (way, of_kind) in searches[kind].iter_mut().enumerate() {
                // Where it rolled against a wall there is no room for it.
                of_kind.extend(search(&plan, &robot, cut, at, way == 0));
            }
        }
    }
    for (kind, [there, anywhere]) in kinds.iter().zip(&searches) {
        row(page, kind, "there", there);
        row(page, "", "anywhere", anywhere);
    }
}

/// Drives the second run and cuts its power as it drives, and again as it stands.
fn second_run(plan: &Plan, robot: &Robot, map: Vec<u8>) -> [Cut; 2] {
    let mut session = Session::new(robot, by_default(robot), plan.name.clone()).expect("a rig");
    session.begin_in(map).expect("a map of its own");
    let mut drive = Drive::cleaning(plan, robot, SimOptions::default(), 2).expect("it fits");
    [CUT_S, CUT_S + STANDS_S].map(|cut_s| {
        while drive.step(&mut session).t_s < cut_s {}
        drive.job().pause();
        let map = session.map().expect("a map");
        let id = MapId::of(&map).expect("a whole map");
        let (job, pose) = (drive.job_in(id), session.pose_in(id));
        Cut { map, id, job, pose, at: drive.simulation().pose_in_plan() }
    })
}

/// The robot begins here after the cut, expecting itself where it was or anywhere; none where it has no room.
fn search(plan: &Plan, robot: &Robot, cut: &Cut, at: Pose2, expects: bool) -> Option<Search> {
    let mut session = Session::new(robot, by_default(robot), plan.name.clone()).expect("a rig");
    session.begin_in(cut.map.clone()).expect("a map of its own");
    if let Some(pose) = cut.pose.filter(|_| expects) {
        session.recall(cut.id, &pose);
    }
    let options = SimOptions { start: Some(at), ..SimOptions::default() };
    let mut drive = Drive::cleaning(plan, robot, options, 3).ok()?;
    if let Some(job) = cut.job {
        drive.go_on_with(cut.id, &job).expect("the job in this map");
    }
    let (mut found_s, mut is_wrong, mut t_s) = (None, false, 0.0);
    while t_s < LONGEST_S && found_s.is_none_or(|found_s| t_s < found_s + FOR_GOOD_S) && !drive.is_over() {
        t_s = drive.step(&mut session).t_s;
        let step = session.recording().steps.last().expect("a step");
        if step.searching {
            found_s = None;
        } else if found_s.is_none() {
            found_s = Some(t_s);
            is_wrong |= step.error().is_some_and(|error| error.x_m.hypot(error.y_m) > WRONG_M);
        }
    }
    Some(Search { is_known: cut.pose.is_some(), found_s: found_s.unwrap_or(f64::INFINITY), is_wrong })
}

fn row(page: &mut String, kind: &str, way: &str, searches: &[Search]) {
    let mut found: Vec<f64> = searches.iter().map(|search| search.found_s).collect();
    found.sort_by(f64::total_cmp);
    let count = |is: fn(&Search) -> bool| searches.iter().filter(|search| is(search)).count();
    let never = count(|search| search.found_s.is_infinite());
    let worst = if never > 0 { format!("{never} never") } else { format!("{:.0}", found[found.len() - 1]) };
    let line = writeln!(
        page,
        "| {kind} | {way} | {} | {} | {:.0} ({worst}) | {} |",
        searches.len(),
        count(|search| search.is_known),
        found[found.len() / 2],
        count(|search| search.is_wrong),
    );
    line.expect("a String takes it all");
}
