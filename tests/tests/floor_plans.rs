//! Every built-in floor plan, driven with several seeds: figures beside the committed ones in `snapshots/floor_plans.csv`,
//! consistency in its band, walls missed and invented, and the bits of one drive a plan (`snapshots/floor_plans_bits.csv`).

use std::sync::LazyLock;
use std::thread;

use lab::evaluate::statistics::chi_square_mean_band;
use lab::recording::{Figures, Recording};
use tests::simulated::drive;
use tests::snapshot::{Column, Line, check, check_bits};

const SEEDS: std::ops::RangeInclusive<u64> = 1..=16;
/// As long as the drives of the experiments. The first minutes alone say less: the filter believes in slips before it has driven, and a clean
/// floor has none.
const MINUTES: f64 = 10.0;

/// Most walls that one drive may invent.
const MOST_INVENTED: usize = 2;
/// Most walls invented a drive, mean over all drives: clutter, which is the worst plan, has one in six drives.
const MEAN_INVENTED: f64 = 0.1;
/// Most true walls missed a drive, mean over all drives.
const MEAN_MISSED: f64 = 0.05;

/// What one drive came to.
struct Driven {
    figures: Figures,
    bits: u64,
}

/// The drives of each plan, seed by seed.
static PLANS: LazyLock<Vec<(&str, Vec<Driven>)>> = LazyLock::new(|| {
    let plan = |name: &'static str| (name, thread::scope(|scope| drives(scope, name)));
    hal_sim::plan_file::BUILT_IN.iter().map(|(name, _)| plan(name)).collect()
});

fn drives<'scope>(scope: &'scope thread::Scope<'scope, '_>, plan: &'static str) -> Vec<Driven> {
    let one = move |seed| {
        let recording = drive(plan, MINUTES, seed);
        Driven { bits: bits(&recording), figures: recording.figures }
    };
    let begun: Vec<_> = SEEDS.map(|seed| scope.spawn(move || one(seed))).collect();
    begun.into_iter().map(|thread| thread.join().expect("a drive ends")).collect()
}

/// FNV-1a of the bits of every pose and covariance, and of the final walls.
fn bits(recording: &Recording) -> u64 {
    let steps = recording.steps.iter().flat_map(|step| {
        let pose = [step.pose.x_m, step.pose.y_m, step.pose.theta_rad].map(f64::to_bits);
        pose.into_iter().chain(step.covariance.into_iter().flatten().map(|number| u64::from(number.to_bits())))
    });
    let map = recording.maps.last().expect("there is a map");
    let walls = map.walls.iter().flat_map(|wall| [wall.rho_m, wall.beta_rad, wall.lo_m, wall.hi_m].map(f32::to_bits));
    let words = steps.chain(walls.map(u64::from));
    words.fold(0xCBF2_9CE4_8422_2325, |hash, word| (hash ^ word).wrapping_mul(0x0000_0100_0000_01B3))
}

fn all() -> impl Iterator<Item = &'static Figures> {
    PLANS.iter().flat_map(|(_, drives)| drives).map(|driven| &driven.figures)
}

fn mean_nees(drives: &[Driven]) -> f64 {
    let score =
        |driven: &Driven| driven.figures.estimate.and_then(|score| score.nees).expect("a truth and a covariance");
    drives.iter().map(score).sum::<f64>() / drives.len() as f64
}

#[test]
fn figures_are_the_committed_ones_within_what_drives_differ_by() {
    let figure = |name| Column { name, is_error: false };
    let error = |name| Column { name, is_error: true };
    let columns = [
        figure("path_m"),
        error("ate_m"),
        error("start_m"),
        error("heading_deg"),
        figure("mean_nis"),
        error("offset_m"),
    ];
    let lines = PLANS.iter().map(|(plan, drives)| {
        let of = |value: &dyn Fn(&Figures) -> f64| drives.iter().map(|driven| value(&driven.figures)).collect();
        let score = |figures: &Figures| figures.estimate.expect("there is a truth");
        let values = vec![
            of(&|figures| figures.path_m),
            of(&|figures| score(figures).ate_m),
            of(&|figures| score(figures).start_m.expect("a start frame")),
            of(&|figures| score(figures).heading_deg),
            of(&|figures| figures.mean_nis.expect("there are updates")),
            of(&|figures| figures.map.and_then(|map| map.offset_m).expect("there is a plan")),
        ];
        Line { run: (*plan).to_owned(), values }
    });
    check("floor_plans", &columns, &lines.collect::<Vec<_>>());
}

/// Errors of one drive go together, so that a drive counts as one draw of chi-square with three degrees of freedom. That is wide: a drive's NEES is
/// a mean over ten minutes, which differs by about 1 from seed to seed where such a draw does by 2.4. Drives of one seed are of one
/// robot in every plan, and so not independent of each other: their correlation is 0.2 to 0.7.
#[test]
fn the_pose_errors_are_as_large_as_the_covariance_says() {
    for (plan, drives) in &*PLANS {
        println!("{plan}: mean NEES {:.2}", mean_nees(drives));
    }
    let means: Vec<f64> = PLANS.iter().map(|(_, drives)| mean_nees(drives)).collect();
    let mean = means.iter().sum::<f64>() / means.len() as f64;
    let [low, high] = chi_square_mean_band(3, PLANS.len() * SEEDS.count());
    assert!((low..=high).contains(&mean), "mean NEES of all drives {mean:.2}, not {low:.2} to {high:.2}");
    let [_, high] = chi_square_mean_band(3, SEEDS.count());
    for ((plan, _), mean) in PLANS.iter().zip(means) {
        assert!(mean <= high, "{plan}: mean NEES {mean:.2}, over {high:.2}");
    }
}

#[test]
fn walls_are_neither_missed_nor_invented() {
    let maps: Vec<_> = all().map(|figures| figures.map.expect("there is a plan")).collect();
    let mean = |count: &dyn Fn(usize) -> usize| (0..maps.len()).map(count).sum::<usize>() as f64 / maps.len() as f64;
    let (missed, invented) = (mean(&|at| maps[at].missed), mean(&|at| maps[at].invented));
    println!("{missed} missed and {invented} invented a drive");
    for (plan, drives) in &*PLANS {
        for (seed, driven) in SEEDS.zip(drives) {
            let invented = driven.figures.map.expect("there is a plan").invented;
            assert!(invented <= MOST_INVENTED, "{plan} seed {seed}: {invented} invented walls");
        }
    }
    assert!(missed <= MEAN_MISSED, "{missed} missed walls a drive");
    assert!(invented <= MEAN_INVENTED, "{invented} invented walls a drive");
}

#[test]
fn the_bits_are_the_committed_ones() {
    let sums = PLANS.iter().map(|(plan, drives)| ((*plan).to_owned(), drives[0].bits));
    check_bits("floor_plans_bits", &sums.collect::<Vec<_>>());
}
