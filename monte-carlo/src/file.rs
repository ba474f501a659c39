//! Experiment files: TOML, described in `docs/reference/experiments.md`.

use std::collections::{BTreeSet, HashSet};
use std::path::Path;

use crate::bar::Bar;
use crate::key::Key;
use crate::keys::{self, Conditions};
use crate::plan::DoorLeaf;
use crate::setting::Setting;
use crate::variant::{DEFAULT, NAMED, Variant};
use input_file::{FileError, Text, TomlFile, Whole};

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
        let toml = TomlFile::new(file, text);
        let keys: keys::File = toml.read()?;
        let base = keys.setting.map(|table| table.setting).unwrap_or_default();
        let plans = plans(&toml, "plans", keys.plans)?;
        if plans.is_empty() {
            let message = "is missing or empty; it must be a list of built-in plans or plan files";
            return Err(toml.error("plans", message));
        }
        let variants = variants(&toml, keys.variants, keys.variant)?;
        let cases = cases(&toml, keys.case, keys.sweep, &base, &plans)?;
        let bar = |(i, keys)| Bar::of(&toml, &format!("bar[{i}]"), keys, &cases, &variants);
        Ok(Self {
            title: keys.title.get(),
            about: keys.about.map_or(String::new(), Text::get),
            first_seed: keys.first_seed.map_or(1, Whole::get) as u64,
            seeds: keys.seeds.get() as u64,
            series: series(&toml, keys.series, &variants)?,
            doors: keys.door.into_iter().map(door).collect(),
            bars: keys.bar.into_iter().enumerate().map(bar).collect::<Result<_, _>>()?,
            cases,
            variants,
            text: text.to_owned(),
        })
    }

    /// Every seed.
    pub fn seed_range(&self) -> std::ops::Range<u64> {
        self.first_seed..self.first_seed + self.seeds
    }

    /// The rig and plan files that its cases name, each once.
    pub(crate) fn files(&self) -> BTreeSet<&str> {
        let plans = self.cases.iter().flat_map(|case| &case.plans).map(String::as_str);
        let rigs = self.cases.iter().filter_map(|case| case.setting.rig_file());
        plans.filter(|plan| !hal_sim::plan_file::is_built_in(plan)).chain(rigs).collect()
    }
}

/// The plans of a list, which must all be there: a sweep should not end at its last plan.
fn plans(toml: &TomlFile<'_>, place: &str, plans: Vec<Text>) -> Result<Vec<String>, FileError> {
    let plans: Vec<String> = plans.into_iter().map(Text::get).collect();
    for plan in &plans {
        hal_sim::plan_file::load(plan)
            .map_err(|error| toml.error(place, format!("plan {plan:?} cannot be used: {error}")))?;
    }
    Ok(plans)
}

fn variants(toml: &TomlFile<'_>, named: Vec<Text>, described: Vec<keys::Variant>) -> Result<Vec<Variant>, FileError> {
    let unknown = |name: &str| toml.error("variants", format!("has {name:?}; known are {}", NAMED.join("; ")));
    let named = named.iter().map(|name| Variant::named(name.as_ref()).ok_or_else(|| unknown(name.as_ref())));
    let described =
        described.into_iter().enumerate().map(|(i, keys)| Variant::of(toml, &format!("variant[{i}]"), keys));
    let mut variants: Vec<Variant> = named.chain(described).collect::<Result<_, _>>()?;
    if variants.is_empty() {
        variants.extend(Variant::named(DEFAULT));
    }
    match repeated(variants.iter().map(|variant| variant.name.as_str())) {
        Some(name) => Err(toml.error("variants", format!("has {name:?} twice; each has its own name"))),
        None => Ok(variants),
    }
}

/// The first name that is there a second time.
fn repeated<'a>(mut names: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let mut seen = HashSet::new();
    names.find(|name| !seen.insert(*name))
}

fn cases(
    toml: &TomlFile<'_>,
    described: Vec<Conditions<keys::Case>>,
    sweeps: Vec<Conditions<keys::Sweep>>,
    base: &Setting,
    plans: &[String],
) -> Result<Vec<Case>, FileError> {
    let mut cases: Vec<Case> = Vec::new();
    for (i, keys) in described.into_iter().enumerate() {
        let place = format!("case[{i}]");
        let name = toml.required(&format!("{place}.name"), keys.name, Text::ALLOWED)?;
        let plans = own_plans(toml, &place, keys.plans, plans)?;
        cases.push(Case {
            name: keys::table_name(toml, &place, name)?,
            setting: base.overlaid(&keys.setting),
            plans,
            point: None,
        });
    }
    for (i, keys) in sweeps.into_iter().enumerate() {
        cases.extend(sweep(toml, &format!("sweep[{i}]"), keys, base, plans)?);
    }
    if cases.is_empty() {
        cases.push(Case { name: "default".to_owned(), setting: base.clone(), plans: plans.to_vec(), point: None });
    }
    match repeated(cases.iter().map(|case| case.name.as_str())) {
        Some(name) => Err(toml.error("case", format!("has {name:?} twice; each has its own name"))),
        None => Ok(cases),
    }
}

/// A table's own plans, or everybody's.
fn own_plans(toml: &TomlFile<'_>, place: &str, own: Vec<Text>, all: &[String]) -> Result<Vec<String>, FileError> {
    let own = plans(toml, &format!("{place}.plans"), own)?;
    Ok(if own.is_empty() { all.to_vec() } else { own })
}

/// One case for each value of a sweep.
fn sweep(
    toml: &TomlFile<'_>,
    place: &str,
    keys: Conditions<keys::Sweep>,
    base: &Setting,
    plans: &[String],
) -> Result<Vec<Case>, FileError> {
    let at = |key: &str| format!("{place}.{key}");
    let name = toml.required(&at("key"), keys.key, Text::ALLOWED)?.get();
    let key = Key::of_name(&name).ok_or_else(|| {
        toml.error(&at("key"), format!("is {name:?}; known are {}", Key::ALL.map(Key::name).join(", ")))
    })?;
    let allowed = key.allowed();
    if keys.values.is_empty() {
        let message = format!("is missing or empty; it must be a list of {}", allowed.words);
        return Err(toml.error(&at("values"), message));
    }
    if let Some((i, value)) = keys.values.iter().enumerate().find(|(_, value)| !key.holds(value.get())) {
        let message = format!("is {}; it must be {}", value.get(), allowed.words);
        return Err(toml.error(&at(&format!("values[{i}]")), message));
    }
    if keys.setting.get(key).is_some() || keys.setting.draws.contains_key(&key) {
        return Err(toml.error(&at("key"), format!("is {name:?}, which the table also sets or draws, to no effect")));
    }
    let plans = own_plans(toml, place, keys.plans, plans)?;
    // Whatever else the table sets holds at every point of the sweep.
    let fixed = base.overlaid(&keys.setting);
    let point = |value: f64| Case {
        name: format!("{} = {value}", key.name()),
        setting: fixed.overlaid(&Setting { values: [(key, value)].into(), ..Setting::default() }),
        plans: plans.clone(),
        point: Some((key, value)),
    };
    Ok(keys.values.iter().map(|value| point(value.get())).collect())
}

fn series(toml: &TomlFile<'_>, names: Vec<Text>, variants: &[Variant]) -> Result<Vec<String>, FileError> {
    let series: Vec<String> = names.into_iter().map(Text::get).collect();
    match series.iter().find(|name| variants.iter().all(|variant| variant.name != **name)) {
        Some(unknown) => Err(toml.error("series", format!("has {unknown:?}, which is not one of the variants"))),
        None => Ok(series),
    }
}

fn door(keys: keys::Door) -> DoorLeaf {
    let [from_m, to_m] = [keys.from_m, keys.to_m].map(|point| point.map(|metres| metres.get()));
    DoorLeaf { plan: keys.plan.get(), from_m, to_m }
}
