//! Experiment files: TOML, described in `docs/reference/experiments.md`.

use std::path::Path;

use crate::bar::Bar;
use crate::key::Key;
use crate::plan::DoorLeaf;
use crate::setting::Setting;
use crate::toml_table::{Allowed, Table, parse};
use crate::variant::{DEFAULT, NAMED, Variant};
use input_file::FileError;

/// Most seeds of an experiment.
const MAX_SEEDS: i64 = 100_000;

/// One condition under which every plan is driven with every seed.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// What tables call it.
    pub name: String,
    /// How it differs from the default.
    pub setting: Setting,
    /// The plans that it is driven in.
    pub plans: Vec<String>,
    /// The sweep that it is a point of, and the value there.
    pub point: Option<(Key, f64)>,
}

/// A whole experiment.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// Its title.
    pub title: String,
    /// What it is for; may be empty.
    pub about: String,
    /// First seed.
    pub first_seed: u64,
    /// Number of seeds.
    pub seeds: u64,
    /// The conditions.
    pub cases: Vec<Case>,
    /// The estimators.
    pub variants: Vec<Variant>,
    /// Names of the variants whose errors over time are drawn, for the first seed of each plan and case.
    pub series: Vec<String>,
    /// Doors that settings can close.
    pub doors: Vec<DoorLeaf>,
    /// What must hold.
    pub bars: Vec<Bar>,
    /// The file's text.
    pub text: String,
}

impl Experiment {
    /// Reads an experiment file.
    ///
    /// # Errors
    /// It cannot be read, is not TOML, or a value is missing, unknown or impossible.
    pub fn read(file: &Path) -> Result<Self, FileError> {
        let text = input_file::read(file)?;
        Self::parse(file, &text)
    }

    /// Reads an experiment file's text; `file` is for messages.
    ///
    /// # Errors
    /// The text is not TOML, or a value is missing, unknown or impossible.
    pub fn parse(file: &Path, text: &str) -> Result<Self, FileError> {
        let document = parse(file, text)?;
        let root = Table::root(file, text, document.get_ref());
        let base = match root.table("setting")? {
            Some(table) => {
                let setting = Setting::read(&table)?;
                table.nothing_else()?;
                setting
            }
            None => Setting::default(),
        };
        let plans = read_plans(&root)?;
        let variants = read_variants(&root)?;
        let cases = read_cases(&root, &base, &plans)?;
        let experiment = Self {
            title: root.text("title")?,
            about: root.optional_text("about")?.unwrap_or_default(),
            first_seed: if root.has("first_seed") { root.integer("first_seed", 0, i64::MAX)? as u64 } else { 1 },
            seeds: root.integer("seeds", 1, MAX_SEEDS)? as u64,
            series: read_series(&root, &variants)?,
            doors: root.tables("door")?.iter().map(read_door).collect::<Result<_, _>>()?,
            bars: root
                .tables("bar")?
                .iter()
                .map(|table| Bar::read(table, &cases, &variants))
                .collect::<Result<_, _>>()?,
            cases,
            variants,
            text: text.to_owned(),
        };
        root.nothing_else()?;
        Ok(experiment)
    }

    /// Every seed.
    pub fn seed_range(&self) -> std::ops::Range<u64> {
        self.first_seed..self.first_seed + self.seeds
    }
}

/// Checks that every plan of a list is there, so that a sweep does not end at its last plan.
fn check_plans(table: &Table<'_>, plans: &[String]) -> Result<(), FileError> {
    for plan in plans {
        hal_sim::plan_file::load(plan)
            .map_err(|error| table.error("plans", format!("plan {plan:?} cannot be used: {error}")))?;
    }
    Ok(())
}

fn read_plans(root: &Table<'_>) -> Result<Vec<String>, FileError> {
    let plans = root.texts("plans")?;
    if plans.is_empty() {
        return Err(root.error("plans", "is missing or empty; it must be a list of built-in plans or plan files"));
    }
    check_plans(root, &plans)?;
    Ok(plans)
}

fn read_variants(root: &Table<'_>) -> Result<Vec<Variant>, FileError> {
    let mut variants = Vec::new();
    for name in root.texts("variants")? {
        let named = Variant::named(&name)
            .ok_or_else(|| root.error("variants", format!("has {name:?}; known are {}", NAMED.join("; "))))?;
        variants.push(named);
    }
    for table in root.tables("variant")? {
        variants.push(Variant::read(&table)?);
    }
    if variants.is_empty() {
        variants.extend(Variant::named(DEFAULT));
    }
    for (i, variant) in variants.iter().enumerate() {
        if variants[..i].iter().any(|other| other.name == variant.name) {
            return Err(root.error("variants", format!("has {:?} twice; each has its own name", variant.name)));
        }
    }
    Ok(variants)
}

fn read_cases(root: &Table<'_>, base: &Setting, plans: &[String]) -> Result<Vec<Case>, FileError> {
    let mut cases: Vec<Case> = Vec::new();
    for table in root.tables("case")? {
        let setting = base.overlaid(&Setting::read(&table)?);
        let own = table.texts("plans")?;
        check_plans(&table, &own)?;
        let name = table.text("name")?;
        if name.contains(['"', '\n', '|']) {
            return Err(table.error("name", "holds a quote, line break or |, which the tables cannot carry"));
        }
        table.nothing_else()?;
        let plans = if own.is_empty() { plans.to_vec() } else { own };
        cases.push(Case { name, setting, plans, point: None });
    }
    for table in root.tables("sweep")? {
        cases.extend(read_sweep(&table, base, plans)?);
    }
    if cases.is_empty() {
        cases.push(Case { name: "default".to_owned(), setting: base.clone(), plans: plans.to_vec(), point: None });
    }
    for (i, case) in cases.iter().enumerate() {
        if cases[..i].iter().any(|other| other.name == case.name) {
            return Err(root.error("case", format!("has {:?} twice; each has its own name", case.name)));
        }
    }
    Ok(cases)
}

/// One case for each value of a sweep.
fn read_sweep(table: &Table<'_>, base: &Setting, plans: &[String]) -> Result<Vec<Case>, FileError> {
    let name = table.text("key")?;
    let key = Key::of_name(&name).ok_or_else(|| {
        let known: Vec<&str> = Key::ALL.iter().map(|key| key.name()).collect();
        table.error("key", format!("is {name:?}; known are {}", known.join(", ")))
    })?;
    let values = table.numbers("values", key.allowed())?;
    if values.is_empty() {
        return Err(table.error("values", format!("is missing or empty; it must be a list of {}", key.allowed().words)));
    }
    let own = table.texts("plans")?;
    check_plans(table, &own)?;
    // Whatever else the table sets holds at every point of the sweep.
    let fixed = base.overlaid(&Setting::read(table)?);
    table.nothing_else()?;
    let point = |value: f64| Case {
        name: format!("{} = {value}", key.name()),
        setting: fixed.overlaid(&Setting { values: [(key, value)].into(), ..Setting::default() }),
        plans: if own.is_empty() { plans.to_vec() } else { own.clone() },
        point: Some((key, value)),
    };
    Ok(values.into_iter().map(point).collect())
}

fn read_series(root: &Table<'_>, variants: &[Variant]) -> Result<Vec<String>, FileError> {
    let series = root.texts("series")?;
    match series.iter().find(|name| variants.iter().all(|variant| variant.name != **name)) {
        Some(unknown) => Err(root.error("series", format!("has {unknown:?}, which is not one of the variants"))),
        None => Ok(series),
    }
}

fn read_door(table: &Table<'_>) -> Result<DoorLeaf, FileError> {
    let point = |key: &'static str| match table.numbers(key, Allowed::FINITE)?[..] {
        [x, y] => Ok([x, y]),
        _ => Err(table.error(key, "must be two numbers: x and y in the plan's frame, metres")),
    };
    let leaf = DoorLeaf { plan: table.text("plan")?, from_m: point("from_m")?, to_m: point("to_m")? };
    table.nothing_else()?;
    Ok(leaf)
}
