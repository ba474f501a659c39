//! Numbers of TOML files that are within their limits.

use std::fmt;
use std::marker::PhantomData;

use serde::de::{DeserializeSeed, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};

/// What a number may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Allowed {
    /// Smallest value.
    pub min: f64,
    /// Whether `min` itself is excluded.
    pub above_min: bool,
    /// Largest value.
    pub max: f64,
    /// Whether `max` itself is excluded.
    pub below_max: bool,
    /// The same in words.
    pub words: &'static str,
}

impl Allowed {
    /// From `min` to `max`, both included; `words` says so.
    pub const fn within(min: f64, max: f64, words: &'static str) -> Self {
        Self { min, above_min: false, max, below_max: false, words }
    }

    /// Whether a value is allowed.
    pub fn holds(&self, value: f64) -> bool {
        // The estimator computes in f32: what does not fit there is as impossible as infinity.
        let narrow = value as f32;
        let above = if self.above_min { narrow > self.min as f32 } else { value >= self.min };
        let below = if self.below_max { narrow < self.max as f32 } else { value <= self.max };
        narrow.is_finite() && above && below
    }
}

/// The limits of a kind of number.
pub trait Limits {
    /// What it may be.
    const ALLOWED: Allowed;
}

/// Above zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Positive;

impl Limits for Positive {
    const ALLOWED: Allowed = Allowed { above_min: true, ..Allowed::within(0.0, f64::INFINITY, "a number above 0") };
}

/// Zero or more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NotNegative;

impl Limits for NotNegative {
    const ALLOWED: Allowed = Allowed::within(0.0, f64::INFINITY, "a number, 0 or more");
}

/// Any finite number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finite;

impl Limits for Finite {
    const ALLOWED: Allowed = Allowed::within(f64::NEG_INFINITY, f64::INFINITY, "a finite number");
}

/// A number within limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Number<L>(f64, PhantomData<L>);

impl<L> Number<L> {
    /// The number.
    pub fn get(&self) -> f64 {
        self.0
    }

    /// The number in the estimator's precision.
    pub fn single(&self) -> f32 {
        self.0 as f32
    }
}

impl<'de, L: Limits> Deserialize<'de> for Number<L> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        L::ALLOWED.deserialize(deserializer).map(|number| Self(number, PhantomData))
    }
}

impl<'de> DeserializeSeed<'de> for Allowed {
    type Value = f64;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<f64, D::Error> {
        let given = Given::deserialize(deserializer, self.words)?;
        let number = match given {
            Given::Whole(number) => number as f64,
            Given::Number(number) => number,
            other => return Err(D::Error::custom(format!("is {}; it must be {}", other.kind(), self.words))),
        };
        if self.holds(number) { Ok(number) } else { Err(given.refused(self.words)) }
    }
}

/// A whole number from `MIN` to `MAX`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Whole<const MIN: i64, const MAX: i64>(i64);

impl<const MIN: i64, const MAX: i64> Whole<MIN, MAX> {
    /// The number.
    pub fn get(self) -> i64 {
        self.0
    }
}

impl<'de, const MIN: i64, const MAX: i64> Deserialize<'de> for Whole<MIN, MAX> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let allowed = format!("a whole number from {MIN} to {MAX}");
        match Given::deserialize(deserializer, &allowed)? {
            Given::Whole(number) if (MIN..=MAX).contains(&number) => Ok(Self(number)),
            wrong => Err(wrong.refused(&allowed)),
        }
    }
}

/// A value as a file gives it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Given {
    Whole(i64),
    Number(f64),
    Text(String),
    Flag(bool),
    List,
    Table,
}

impl Given {
    /// Reads whatever is there. Where nothing is, the error says what must be.
    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D, allowed: &str) -> Result<Self, D::Error> {
        // No visit fails, so that this can only be the error about a missing field.
        deserializer
            .deserialize_any(GivenVisitor)
            .map_err(|missing| D::Error::custom(format!("{}; it must be {allowed}", missing.to_string().trim_end())))
    }

    /// That this is not what must be given.
    pub(crate) fn refused<E: Error>(&self, allowed: &str) -> E {
        let shown = match self {
            Self::Whole(number) => number.to_string(),
            Self::Number(number) => format!("{number:?}").to_lowercase(),
            Self::Text(text) => format!("{text:?}"),
            Self::Flag(_) | Self::List | Self::Table => self.kind().to_owned(),
        };
        E::custom(format!("is {shown}; it must be {allowed}"))
    }

    fn kind(&self) -> &'static str {
        match self {
            Self::Whole(_) | Self::Number(_) => "a number",
            Self::Text(_) => "a text",
            Self::Flag(_) => "a true-or-false value",
            Self::List => "a list",
            Self::Table => "a table",
        }
    }
}

struct GivenVisitor;

impl<'de> Visitor<'de> for GivenVisitor {
    type Value = Given;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a value")
    }

    fn visit_i64<E>(self, number: i64) -> Result<Given, E> {
        Ok(Given::Whole(number))
    }

    // What no narrower integer holds is outside every limit.
    fn visit_i128<E>(self, number: i128) -> Result<Given, E> {
        Ok(Given::Number(number as f64))
    }

    fn visit_u64<E>(self, number: u64) -> Result<Given, E> {
        Ok(Given::Number(number as f64))
    }

    fn visit_f64<E>(self, number: f64) -> Result<Given, E> {
        Ok(Given::Number(number))
    }

    fn visit_str<E>(self, text: &str) -> Result<Given, E> {
        Ok(Given::Text(text.to_owned()))
    }

    fn visit_bool<E>(self, flag: bool) -> Result<Given, E> {
        Ok(Given::Flag(flag))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Given, A::Error> {
        while list.next_element::<IgnoredAny>()?.is_some() {}
        Ok(Given::List)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut table: A) -> Result<Given, A::Error> {
        while table.next_entry::<IgnoredAny, IgnoredAny>()?.is_some() {}
        Ok(Given::Table)
    }
}
