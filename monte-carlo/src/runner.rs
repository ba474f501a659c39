//! Runs an experiment: all cores, skipping what is finished.

use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::figures;
use crate::file::Experiment;
use crate::row::RunRow;
use crate::samples::ErrorSample;
use crate::store::Store;
use crate::unit::{Outcome, Unit};
use crate::variant::Variant;
use input_file::FileError;

/// A part of an experiment: every n-th unit of work from the k-th on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which part, from 1.
    pub k: usize,
    /// Number of parts.
    pub n: usize,
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
        match parts {
            Some((k, n)) if 1 <= k && k <= n => Ok(Self { k, n }),
            _ => Err("it must be k/n with k from 1 to n, such as 2/8".to_owned()),
        }
    }
}

impl Shard {
    /// The whole experiment.
    pub const WHOLE: Self = Self { k: 1, n: 1 };
}

/// How to run it.
#[derive(Clone, Debug)]
pub struct Runner {
    /// The output folder.
    pub out: PathBuf,
    /// The part to do.
    pub shard: Shard,
    /// Threads.
    pub jobs: usize,
}

impl Runner {
    /// Runs what is not finished; `progress` is told the units done and their number.
    ///
    /// # Errors
    /// The folder cannot be used, or a drive cannot be simulated. What was done before stays done.
    pub fn run(&self, experiment: &Experiment, progress: &(dyn Fn(usize, usize) + Sync)) -> Result<(), FileError> {
        let store = Store::open(&self.out, experiment)?;
        let units: Vec<Unit<'_>> = units(experiment).into_iter().skip(self.shard.k - 1).step_by(self.shard.n).collect();
        let missing = |unit: &Unit<'_>| -> Vec<&Variant> {
            experiment.variants.iter().filter(|variant| !store.has(&unit.key(variant))).collect()
        };
        let todo: Vec<(&Unit<'_>, Vec<&Variant>)> =
            units.iter().map(|unit| (unit, missing(unit))).filter(|(_, missing)| !missing.is_empty()).collect();
        let work = Work {
            experiment,
            next: AtomicUsize::new(0),
            done: AtomicUsize::new(units.len() - todo.len()),
            failed: Mutex::new(None),
            store: Mutex::new(store),
            out: &self.out,
        };
        progress(work.done.load(Ordering::Relaxed), units.len());
        std::thread::scope(|scope| {
            for _ in 0..self.jobs.max(1) {
                scope.spawn(|| work.take_turns(&todo, &|done| progress(done, units.len())));
            }
        });
        match work.failed.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner) {
            Some(error) => Err(error),
            None => Ok(()),
        }
    }
}

/// Every unit of work, seeds first: a run that is stopped early has a little of everything.
pub fn units(experiment: &Experiment) -> Vec<Unit<'_>> {
    let of_seed = |seed: u64| {
        experiment
            .cases
            .iter()
            .flat_map(move |case| case.plans.iter().map(move |plan| Unit { plan: plan.as_str(), case, seed }))
    };
    experiment.seed_range().flat_map(of_seed).collect()
}

/// What the threads share.
struct Work<'a> {
    experiment: &'a Experiment,
    next: AtomicUsize,
    done: AtomicUsize,
    failed: Mutex<Option<FileError>>,
    store: Mutex<Store>,
    out: &'a Path,
}

impl Work<'_> {
    fn take_turns(&self, todo: &[(&Unit<'_>, Vec<&Variant>)], progress: &dyn Fn(usize)) {
        loop {
            let turn = self.next.fetch_add(1, Ordering::Relaxed);
            let Some((unit, variants)) = todo.get(turn) else { return };
            if let Err(error) = self.take(unit, variants) {
                *self.failed.lock().unwrap_or_else(std::sync::PoisonError::into_inner) = Some(error);
                // Nobody begins another one.
                self.next.store(todo.len(), Ordering::Relaxed);
                return;
            }
            progress(self.done.fetch_add(1, Ordering::Relaxed) + 1);
        }
    }

    fn take(&self, unit: &Unit<'_>, variants: &[&Variant]) -> Result<(), FileError> {
        let outcomes = unit.run(self.experiment, variants).map_err(|error| {
            let run = format!("plan {}, case {}, seed {}: {error}", unit.plan, unit.case.name, unit.seed);
            FileError::new(self.out, run)
        })?;
        if unit.seed == self.experiment.first_seed {
            let drawn = |outcome: &&Outcome| self.experiment.series.contains(&outcome.row.key.variant);
            for outcome in outcomes.iter().filter(drawn) {
                figures::write_series(self.out, outcome)?;
            }
        }
        let samples: Vec<ErrorSample> =
            outcomes.iter().flat_map(|outcome| ErrorSample::of(&outcome.row.key, &outcome.track.steps)).collect();
        let rows: Vec<RunRow> = outcomes.into_iter().map(|outcome| outcome.row).collect();
        self.store.lock().unwrap_or_else(std::sync::PoisonError::into_inner).push(&rows, &samples)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_parsed_or_refused() {
        assert_eq!("2/8".parse(), Ok(Shard { k: 2, n: 8 }));
        for wrong in ["0/2", "3/2", "1", "a/b", "1/0", "-1/2", ""] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }
}
