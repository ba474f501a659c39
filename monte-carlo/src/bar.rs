//! What must hold: limits on statistics of an experiment's figures.

use crate::file::Case;
use crate::row::{Metric, RunRow};
use crate::toml_table::{Allowed, Table};
use crate::variant::{DEFAULT, Variant};
use input_file::FileError;
use lab::evaluate::statistics::{chi_square_mean_band, max, mean, median, rms};

/// What is made of one figure over the runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
    /// Whether it holds.
    pub holds: bool,
}

impl Bar {
    /// Reads a `[[bar]]`.
    ///
    /// # Errors
    /// A key that is not known, or a value that is not allowed.
    pub fn read(table: &Table<'_>, cases: &[Case], variants: &[Variant]) -> Result<Self, FileError> {
        let known_variant = |name: &str| variants.iter().any(|variant| variant.name == name);
        let case =
            table.optional_text("case")?.unwrap_or_else(|| cases.first().map_or(String::new(), |c| c.name.clone()));
        if cases.iter().all(|known| known.name != case) {
            return Err(table.error("case", format!("is {case:?}, which is not one of the cases")));
        }
        let variant = table.optional_text("variant")?.unwrap_or_else(|| DEFAULT.to_owned());
        if !known_variant(&variant) {
            return Err(table.error("variant", format!("is {variant:?}, which is not one of the variants")));
        }
        let plans = table.texts("plans")?;
        let own = cases.iter().find(|known| known.name == case).map_or(&[][..], |known| &known.plans);
        if let Some(plan) = plans.iter().find(|plan| !own.contains(plan)) {
            return Err(table.error("plans", format!("has {plan:?}, which the case is not driven in")));
        }
        let known: Vec<&str> = Metric::ALL.iter().map(|metric| metric.name()).collect();
        let metric = Metric::of_name(&table.text("metric")?)
            .ok_or_else(|| table.error("metric", format!("is not known; known are {}", known.join(", "))))?;
        let limit = read_limit(table)?;
        if let Limit::TimesBetter(_, other) = &limit
            && !known_variant(other)
        {
            return Err(table.error("than", format!("is {other:?}, which is not one of the variants")));
        }
        let bar = Self { case, plans, variant, metric, statistic: read_statistic(table)?, limit };
        table.nothing_else()?;
        Ok(bar)
    }

    /// Whether it holds, in each plan that it is for.
    pub fn judge(&self, rows: &[RunRow], cases: &[Case]) -> Vec<Verdict> {
        let case = cases.iter().find(|case| case.name == self.case);
        let of_case = case.map_or(&[][..], |case| &case.plans);
        let plans = if self.plans.is_empty() { of_case } else { &self.plans };
        plans.iter().map(|plan| self.judge_plan(rows, plan.clone())).collect()
    }

    fn judge_plan(&self, rows: &[RunRow], plan: String) -> Verdict {
        let figures = |variant: &str| -> Vec<f64> {
            let own = |row: &&RunRow| row.key.plan == plan && row.key.case == self.case && row.key.variant == variant;
            rows.iter().filter(own).filter_map(|row| row.get(self.metric)).collect()
        };
        let own = figures(&self.variant);
        let found = self.statistic.of(&own);
        let (found, holds, limit) = match &self.limit {
            Limit::AtMost(limit) => (found, found.is_some_and(|found| found <= *limit), format!("at most {limit}")),
            Limit::AtLeast(limit) => (found, found.is_some_and(|found| found >= *limit), format!("at least {limit}")),
            Limit::InBand(degrees) => {
                let [low, high] = chi_square_mean_band(*degrees, own.len());
                (found, found.is_some_and(|v| (low..=high).contains(&v)), format!("from {low:.2} to {high:.2}"))
            }
            Limit::TimesBetter(times, other) => {
                let ratio = self.statistic.of(&figures(other)).zip(found).map(|(other, own)| other / own);
                let holds = ratio.is_some_and(|ratio| ratio >= *times);
                (ratio, holds, format!("{times} times better than {other}"))
            }
        };
        let bar =
            format!("{}: {} {} of {}, {limit}", self.case, self.statistic.name(), self.metric.name(), self.variant);
        Verdict { plan, bar, found, holds }
    }
}

fn read_limit(table: &Table<'_>) -> Result<Limit, FileError> {
    let number = |key: &'static str| table.optional_number(key, Allowed::NOT_NEGATIVE);
    let decimal = |value: f32| format!("{value}").parse().unwrap_or_else(|_| f64::from(value));
    let limits = [
        number("at_most")?.map(|limit| Limit::AtMost(decimal(limit))),
        number("at_least")?.map(|limit| Limit::AtLeast(decimal(limit))),
        number("in_band")?.map(|degrees| Limit::InBand(degrees as usize)),
        match number("times_better")? {
            Some(times) => Some(Limit::TimesBetter(decimal(times), table.text("than")?)),
            None => None,
        },
    ];
    let mut given = limits.into_iter().flatten();
    match (given.next(), given.next()) {
        (Some(limit), None) => Ok(limit),
        _ => Err(table.error("at_most", "one limit is needed: at_most, at_least, in_band, or times_better with than")),
    }
}

fn read_statistic(table: &Table<'_>) -> Result<Statistic, FileError> {
    match table.optional_text("statistic")?.as_deref() {
        None | Some("median") => Ok(Statistic::Median),
        Some("mean") => Ok(Statistic::Mean),
        Some("rms") => Ok(Statistic::Rms),
        Some("max") => Ok(Statistic::Max),
        Some("min") => Ok(Statistic::Min),
        Some(_) => Err(table.error("statistic", "must be \"median\", \"mean\", \"rms\", \"max\" or \"min\"")),
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
    fn nothing_found_is_nothing_held() {
        assert!(!bar(Limit::AtMost(2.0)).judge(&[], &[])[0].holds);
    }
}
