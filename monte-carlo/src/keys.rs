//! The keys of an experiment file, described in `docs/reference/experiments.md`.

use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;

use input_file::{FileError, Finite, NotNegative, Number, Positive, Text, TomlFile, Whole};
use lab::input::settings::{Groups, Jacobians, Walls};
use serde::de::{DeserializeSeed, Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

use crate::bar::Statistic;
use crate::key::Key;
use crate::setting::Setting;

/// Most seeds of an experiment.
const MAX_SEEDS: i64 = 100_000;

/// The whole file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct File {
    pub title: Text,
    pub about: Option<Text>,
    pub first_seed: Option<Whole<0, { i64::MAX }>>,
    pub seeds: Whole<1, MAX_SEEDS>,
    #[serde(default)]
    pub plans: Vec<Text>,
    #[serde(default)]
    pub variants: Vec<Text>,
    #[serde(default)]
    pub series: Vec<Text>,
    pub setting: Option<Conditions<Base>>,
    #[serde(default)]
    pub case: Vec<Conditions<Case>>,
    #[serde(default)]
    pub sweep: Vec<Conditions<Sweep>>,
    #[serde(default)]
    pub variant: Vec<Variant>,
    #[serde(default)]
    pub door: Vec<Door>,
    #[serde(default)]
    pub bar: Vec<Bar>,
}

/// A `[[variant]]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct Variant {
    pub name: Text,
    pub walls: Option<Walls>,
    pub clusters: Option<Groups>,
    pub jacobians: Option<Jacobians>,
    pub calibrate_gains: Option<bool>,
    pub calibrate_scales: Option<bool>,
    pub calibrate_track: Option<bool>,
    pub gate: Option<Number<Positive>>,
    #[serde(default)]
    pub without: Vec<Text>,
    pub buffer: Option<Whole<1, 255>>,
    pub relative: Option<Text>,
    pub senses: Option<SensesName>,
    pub rays: Option<Whole<2, 720>>,
}

impl Variant {
    /// A setting of the estimator that is given; none where none is.
    pub fn setting(&self) -> Option<&'static str> {
        let settings = [
            ("walls", self.walls.is_some()),
            ("clusters", self.clusters.is_some()),
            ("jacobians", self.jacobians.is_some()),
            ("calibrate_gains", self.calibrate_gains.is_some()),
            ("calibrate_scales", self.calibrate_scales.is_some()),
            ("calibrate_track", self.calibrate_track.is_some()),
            ("gate", self.gate.is_some()),
            ("without", !self.without.is_empty()),
            ("buffer", self.buffer.is_some()),
        ];
        settings.into_iter().find(|(_, is_given)| *is_given).map(|(key, _)| key)
    }
}

/// With what a variant senses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SensesName {
    /// The rig's sensors.
    Rig,
    /// A laser.
    Laser,
    /// A ring of sonar cones.
    Sonar,
}

/// A `[[door]]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct Door {
    pub plan: Text,
    pub from_m: [Number<Finite>; 2],
    pub to_m: [Number<Finite>; 2],
}

/// A `[[bar]]`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct Bar {
    pub case: Option<Text>,
    pub variant: Option<Text>,
    #[serde(default)]
    pub plans: Vec<Text>,
    pub metric: Text,
    pub statistic: Option<Statistic>,
    pub at_most: Option<Number<NotNegative>>,
    pub at_least: Option<Number<NotNegative>>,
    pub in_band: Option<Whole<1, 1000>>,
    pub times_better: Option<Number<NotNegative>>,
    pub than: Option<Text>,
}

/// A table of quantities, which may have keys of its own.
pub trait Kind {
    /// Its own keys.
    const OWN: &'static [&'static str];
}

/// `[setting]`: what holds everywhere.
pub struct Base;
/// A `[[case]]`.
pub struct Case;
/// A `[[sweep]]`.
pub struct Sweep;

impl Kind for Base {
    const OWN: &'static [&'static str] = &[];
}

impl Kind for Case {
    const OWN: &'static [&'static str] = &["name", "plans"];
}

impl Kind for Sweep {
    const OWN: &'static [&'static str] = &["key", "values", "plans"];
}

/// A setting, and what else its table says.
pub struct Conditions<K> {
    pub name: Option<Text>,
    pub plans: Vec<Text>,
    pub key: Option<Text>,
    pub values: Vec<Number<Finite>>,
    pub setting: Setting,
    kind: PhantomData<K>,
}

impl<'de, K: Kind> Deserialize<'de> for Conditions<K> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(ConditionsVisitor(PhantomData))
    }
}

struct ConditionsVisitor<K>(PhantomData<K>);

impl<'de, K: Kind> Visitor<'de> for ConditionsVisitor<K> {
    type Value = Conditions<K>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a table")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut table: A) -> Result<Conditions<K>, A::Error> {
        let mut conditions = Conditions {
            name: None,
            plans: Vec::new(),
            key: None,
            values: Vec::new(),
            setting: Setting::default(),
            kind: PhantomData,
        };
        while let Some(name) = table.next_key::<String>()? {
            match name.as_str() {
                "rig" => conditions.setting.rig = Some(table.next_value::<Text>()?.get()),
                "draw" => conditions.setting.draws = table.next_value_seed(Draws)?,
                own if K::OWN.contains(&own) => match own {
                    "name" => conditions.name = Some(table.next_value()?),
                    "plans" => conditions.plans = table.next_value()?,
                    "key" => conditions.key = Some(table.next_value()?),
                    _ => conditions.values = table.next_value()?,
                },
                quantity => {
                    let key = key(quantity, K::OWN)?;
                    conditions.setting.values.insert(key, table.next_value_seed(ValueOf(key))?);
                }
            }
        }
        let Setting { values, draws, .. } = &conditions.setting;
        match values.keys().find(|key| draws.contains_key(key)) {
            Some(key) => {
                Err(A::Error::custom(format!("has {} both set and drawn; one of them has no effect", key.name())))
            }
            None => Ok(conditions),
        }
    }
}

/// The quantity of this name.
fn key<E: Error>(name: &str, own: &[&str]) -> Result<Key, E> {
    Key::of_name(name).ok_or_else(|| {
        let known = own.iter().copied().chain(["rig", "draw"]).chain(Key::ALL.map(Key::name));
        let known: Vec<String> = known.map(|known| format!("`{known}`")).collect();
        E::custom(format!("unknown field `{name}`, expected one of {}", known.join(", ")))
    })
}

/// Reads a value of a quantity.
#[derive(Clone, Copy)]
struct ValueOf(Key);

impl<'de> DeserializeSeed<'de> for ValueOf {
    type Value = f64;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<f64, D::Error> {
        let value = self.0.allowed().deserialize(deserializer)?;
        if self.0.holds(value) {
            return Ok(value);
        }
        Err(D::Error::custom(format!("is {value}; it must be {}", self.0.allowed().words)))
    }
}

/// Reads `[setting.draw]` and its like: the least and the most of each quantity.
struct Draws;

impl<'de> DeserializeSeed<'de> for Draws {
    type Value = BTreeMap<Key, [f64; 2]>;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Self::Value, D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for Draws {
    type Value = BTreeMap<Key, [f64; 2]>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a table")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut table: A) -> Result<Self::Value, A::Error> {
        let mut draws = BTreeMap::new();
        while let Some(name) = table.next_key::<String>()? {
            let key = key(&name, &[])?;
            draws.insert(key, table.next_value_seed(LeastAndMost(key))?);
        }
        Ok(draws)
    }
}

struct LeastAndMost(Key);

impl<'de> DeserializeSeed<'de> for LeastAndMost {
    type Value = [f64; 2];

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<[f64; 2], D::Error> {
        if self.0 == Key::Sensors {
            return Err(D::Error::custom("cannot be drawn: there are 8, 6, 4 or 2"));
        }
        deserializer.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for LeastAndMost {
    type Value = [f64; 2];

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the least and the most: two {}", self.0.allowed().words)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<[f64; 2], A::Error> {
        let short = || A::Error::custom(format!("must be the least and the most: two {}", self.0.allowed().words));
        let least = list.next_element_seed(ValueOf(self.0))?.ok_or_else(short)?;
        let most = list.next_element_seed(ValueOf(self.0))?.ok_or_else(short)?;
        match list.next_element_seed(ValueOf(self.0))? {
            Some(_) => Err(short()),
            None => Ok([least, most]),
        }
    }
}

/// A name that the tables can carry.
pub fn table_name(toml: &TomlFile<'_>, place: &str, name: Text) -> Result<String, FileError> {
    if name.as_ref().contains(['"', '\n', '|']) {
        let message = "holds a quote, line break or |, which the tables cannot carry";
        return Err(toml.error(&format!("{place}.name"), message));
    }
    Ok(name.get())
}
