//! What must hold: limits on statistics of an experiment's figures.

use crate::file::Case;
use crate::keys;
use crate::row::{Metric, RunRow};
use crate::variant::{DEFAULT, Variant};
use input_file::{FileError, Text, TomlFile, Whole};
use lab::evaluate::statistics::{chi_square_mean_band, max, mean, median, rms, standard_error};
use serde::Deserialize;

/// What is made of one figure over the runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Statistic {
    /// The median.
    Median,
    /// The mean.
    Mean,
    /// The root of the mean square.
    Rms,
    /// The largest.
    Max,
    /// The smallest.
    Min,
}

/// A limit.
#[derive(Clone, Debug, PartialEq)]
pub enum Limit {
    /// At most this.
    AtMost(f64),
    /// At least this.
    AtLeast(f64),
    /// In the 95 % band of the mean of chi-square variables with this many degrees of freedom.
    InBand(usize),
    /// This many times as small as another variant's.
    TimesBetter(f64, String),
}

/// One thing that must hold.
#[derive(Clone, Debug, PartialEq)]
pub struct Bar {
    /// The case.
    pub case: String,
    /// The plans; every plan of the case where none is given.
    pub plans: Vec<String>,
    /// The variant.
    pub variant: String,
    /// The figure.
    pub metric: Metric,
    /// What is made of it.
    pub statistic: Statistic,
    /// Its limit.
    pub limit: Limit,
}

/// What became of a bar in one plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// The plan.
    pub plan: String,
    /// The bar in words.
    pub bar: String,
    /// What was found; none where there are no figures.
    pub found: Option<f64>,
    /// Whether it holds; not where a run has no figure.
    pub holds: bool,
}

impl Bar {
    /// The bar of a `[[bar]]` at this place.
    ///
    /// # Errors
    /// It is about what the experiment does not have, or has not one limit.
    pub(crate) fn of(
        toml: &TomlFile<'_>,
        place: &str,
        keys: keys::Bar,
        cases: &[Case],
        variants: &[Variant],
    ) -> Result<Self, FileError> {
        let error = |key: &str, message: String| toml.error(&format!("{place}.{key}"), message);
        let is_variant = |name: &str| variants.iter().any(|variant| variant.name == name);
        let limit = limit(&keys).map_err(|(key, message)| error(key, message.to_owned()))?;
        let case = keys.case.map_or_else(|| cases.first().map_or(String::new(), |case| case.name.clone()), Text::get);
        let Some(own) = cases.iter().find(|known| known.name == case) else {
            return Err(error("case", format!("is {case:?}, which is not one of the cases")));
        };
        let variant = keys.variant.map_or_else(|| DEFAULT.to_owned(), Text::get);
        if !is_variant(&variant) {
            return Err(error("variant", format!("is {variant:?}, which is not one of the variants")));
        }
        let plans: Vec<String> = keys.plans.into_iter().map(Text::get).collect();
        if let Some(plan) = plans.iter().find(|plan| !own.plans.contains(plan)) {
            return Err(error("plans", format!("has {plan:?}, which the case is not driven in")));
        }
        let known = || Metric::ALL.map(Metric::name).join(", ");
        let metric = Metric::of_name(keys.metric.as_ref())
            .ok_or_else(|| error("metric", format!("is not known; known are {}", known())))?;
        if let Limit::TimesBetter(_, other) = &limit
            && !is_variant(other)
        {
            return Err(error("than", format!("is {other:?}, which is not one of the variants")));
        }
        let statistic = keys.statistic.unwrap_or(Statistic::Median);
        if matches!(limit, Limit::InBand(_)) && statistic != Statistic::Mean {
            return Err(error("statistic", "must be \"mean\" with in_band, which is the band of a mean".to_owned()));
        }
        Ok(Self { case, plans, variant, metric, statistic, limit })
    }

    /// Whether it holds, in each plan that it is for.
    pub fn judge(&self, rows: &[RunRow], cases: &[Case]) -> Vec<Verdict> {
        let case = cases.iter().find(|case| case.name == self.case);
        let of_case = case.map_or(&[][..], |case| &case.plans);
        let plans = if self.plans.is_empty() { of_case } else { &self.plans };
        plans.iter().map(|plan| self.judge_plan(rows, plan.clone())).collect()
    }

    fn judge_plan(&self, rows: &[RunRow], plan: String) -> Verdict {
        // A run that came to no figure is no better than the others: one that is missing breaks the bar.
        let figures = |variant: &str| -> (Vec<f64>, bool) {
            let own = |row: &&RunRow| row.key.plan == plan && row.key.case == self.case && row.key.variant == variant;
            let all: Vec<Option<f64>> = rows.iter().filter(own).map(|row| row.get(self.metric)).collect();
            (all.iter().copied().flatten().collect(), all.iter().all(Option::is_some))
        };
        let (own, is_whole) = figures(&self.variant);
        let found = self.statistic.of(&own);
        let (found, holds, limit) = match &self.limit {
            Limit::AtMost(limit) => (found, found.is_some_and(|found| found <= *limit), format!("at most {limit}")),
            Limit::AtLeast(limit) => (found, found.is_some_and(|found| found >= *limit), format!("at least {limit}")),
            Limit::InBand(degrees) => {
                let [low, high] = chi_square_mean_band(*degrees, own.len());
                let error =
                    standard_error(&own).map_or(String::new(), |error| format!("; its standard error is {error:.2}"));
                (found, found.is_some_and(|v| (low..=high).contains(&v)), format!("from {low:.2} to {high:.2}{error}"))
            }
            Limit::TimesBetter(times, other) => {
                let (others, is_other_whole) = figures(other);
                let ratio = self.statistic.of(&others).zip(found).map(|(other, own)| other / own);
                let holds = is_other_whole && ratio.is_some_and(|ratio| ratio >= *times);
                (ratio, holds, format!("{times} times better than {other}"))
            }
        };
        let bar =
            format!("{}: {} {} of {}, {limit}", self.case, self.statistic.name(), self.metric.name(), self.variant);
        Verdict { plan, bar, found, holds: holds && is_whole }
    }
}

/// The one limit of a bar; an error is a key and what is wrong with it.
fn limit(keys: &keys::Bar) -> Result<Limit, (&'static str, &'static str)> {
    let times_better = match (&keys.times_better, &keys.than) {
        (Some(times), Some(than)) => Some(Limit::TimesBetter(times.get(), than.as_ref().to_owned())),
        (Some(_), None) => return Err(("than", "is missing; it must be the variant that is to be bettered")),
        (None, _) => None,
    };
    let limits = [
        keys.at_most.as_ref().map(|limit| Limit::AtMost(limit.get())),
        keys.at_least.as_ref().map(|limit| Limit::AtLeast(limit.get())),
        keys.in_band.map(|degrees| Limit::InBand(Whole::get(degrees) as usize)),
        times_better,
    ];
    let mut given = limits.into_iter().flatten();
    match (given.next(), given.next()) {
        (Some(limit), None) => Ok(limit),
        _ => Err(("at_most", "one limit is needed: at_most, at_least, in_band, or times_better with than")),
    }
}

impl Statistic {
    /// Its value over runs; none of none.
    pub fn of(self, figures: &[f64]) -> Option<f64> {
        match self {
            Self::Median => median(figures),
            Self::Mean => mean(figures),
            Self::Rms => rms(figures),
            Self::Max => max(figures),
            Self::Min => figures.iter().copied().min_by(f64::total_cmp),
        }
    }

    const fn name(self) -> &'static str {
        match self {
            Self::Median => "median",
            Self::Mean => "mean",
            Self::Rms => "RMS",
            Self::Max => "largest",
            Self::Min => "smallest",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::RunKey;

    fn rows(variant: &str, figures: &[f64]) -> Vec<RunRow> {
        let row = |(seed, figure): (usize, &f64)| {
            let key =
                RunKey { plan: "flat".into(), case: "default".into(), seed: seed as u64, variant: variant.into() };
            let mut row = RunRow::new(key);
            row.set(Metric::Ate, *figure);
            row
        };
        figures.iter().enumerate().map(row).collect()
    }

    fn bar(limit: Limit) -> Bar {
        Bar {
            case: "default".into(),
            plans: vec!["flat".into()],
            variant: "own".into(),
            metric: Metric::Ate,
            statistic: Statistic::Median,
            limit,
        }
    }

    #[test]
    fn limits_hold_on_their_own_side() {
        let mut all = rows("own", &[1.0, 2.0, 9.0]);
        all.extend(rows("other", &[6.5, 6.0, 7.0]));
        let holds = |limit: Limit| bar(limit).judge(&all, &[])[0].holds;
        assert!(holds(Limit::AtMost(2.0)) && !holds(Limit::AtMost(1.9)));
        assert!(holds(Limit::AtLeast(2.0)) && !holds(Limit::AtLeast(2.1)));
        assert!(holds(Limit::TimesBetter(3.25, "other".into())) && !holds(Limit::TimesBetter(3.3, "other".into())));
        assert!(holds(Limit::InBand(3)), "the band of three runs is wide");
    }

    #[test]
    fn a_run_without_a_figure_breaks_its_bar() {
        let mut all = rows("own", &[1.0, f64::NAN, 1.0]);
        let verdict = |all: &[RunRow], limit| bar(limit).judge(all, &[])[0].clone();
        assert_eq!(
            (verdict(&all, Limit::AtMost(2.0)).found, verdict(&all, Limit::AtMost(2.0)).holds),
            (Some(1.0), false)
        );
        all = rows("own", &[1.0, 1.0, 1.0]);
        all.extend(rows("other", &[9.0, f64::NAN, 9.0]));
        assert!(verdict(&all, Limit::AtMost(2.0)).holds);
        assert!(verdict(&rows("own", &[2.5, 3.5]), Limit::InBand(3)).bar.ends_with("; its standard error is 0.50"));
        assert!(!verdict(&all, Limit::TimesBetter(3.0, "other".into())).holds);
    }

    #[test]
    fn nothing_found_is_nothing_held() {
        assert!(!bar(Limit::AtMost(2.0)).judge(&[], &[])[0].holds);
    }
}
