//! Checked access to one TOML table: every value is asked for by name, and whatever was not asked for is an error.

use std::cell::RefCell;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use input_file::FileError;

/// What a number may be.
#[derive(Clone, Copy, Debug)]
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
    /// Above zero.
    pub const POSITIVE: Self =
        Self { min: 0.0, above_min: true, max: f64::INFINITY, below_max: false, words: "a number above 0" };
    /// Zero or more.
    pub const NOT_NEGATIVE: Self =
        Self { min: 0.0, above_min: false, max: f64::INFINITY, below_max: false, words: "a number, 0 or more" };
    /// Any finite number.
    pub const FINITE: Self = Self {
        min: f64::NEG_INFINITY,
        above_min: false,
        max: f64::INFINITY,
        below_max: false,
        words: "a finite number",
    };

    fn holds(&self, value: f64) -> bool {
        // The estimator computes in f32: what does not fit there is as impossible as infinity.
        let narrow = value as f32;
        let above = if self.above_min { narrow > self.min as f32 } else { value >= self.min };
        let below = if self.below_max { narrow < self.max as f32 } else { value <= self.max };
        narrow.is_finite() && above && below
    }
}

/// A table of a TOML file, with what is needed to say where an error is.
pub struct Table<'a> {
    file: &'a Path,
    text: &'a str,
    /// Key of the table itself, such as `wheels` or `range_sensor[2]`; empty for the file.
    path: String,
    line: usize,
    entries: &'a DeTable<'a>,
    asked: RefCell<Vec<&'static str>>,
}

/// The line, counted from one, that a byte of `text` is on.
fn line_of(text: &str, byte: usize) -> usize {
    1 + text.as_bytes()[..byte.min(text.len())].iter().filter(|b| **b == b'\n').count()
}

/// Parses a TOML file.
///
/// # Errors
/// What is not TOML.
pub fn parse<'a>(file: &Path, text: &'a str) -> Result<Spanned<DeTable<'a>>, FileError> {
    DeTable::parse(text).map_err(|cause| {
        let error = FileError::new(file, format!("is not valid TOML: {}", cause.message()));
        match cause.span() {
            Some(span) => error.at_line(line_of(text, span.start)),
            None => error,
        }
    })
}

impl<'a> Table<'a> {
    /// The file's own table.
    pub fn root(file: &'a Path, text: &'a str, entries: &'a DeTable<'a>) -> Self {
        Self { file, text, path: String::new(), line: 1, entries, asked: RefCell::default() }
    }

    fn full_key(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) }
    }

    fn look(&self, key: &'static str) -> Option<&'a Spanned<DeValue<'a>>> {
        self.asked.borrow_mut().push(key);
        self.entries.get(key)
    }

    fn line_of_value(&self, value: &Spanned<DeValue<'_>>) -> usize {
        line_of(self.text, value.span().start)
    }

    fn child(&self, path: String, value: &'a Spanned<DeValue<'a>>) -> Result<Table<'a>, FileError> {
        let line = self.line_of_value(value);
        let DeValue::Table(entries) = value.get_ref() else {
            let error = FileError::new(self.file, format!("must be a table, not a {}", kind_of(value.get_ref())));
            return Err(error.at_line(line).at(path));
        };
        Ok(Table { file: self.file, text: self.text, path, line, entries, asked: RefCell::default() })
    }

    /// Whether a key is there.
    pub fn has(&self, key: &'static str) -> bool {
        self.look(key).is_some()
    }

    /// An error about a key of this table, at its line where it is there.
    pub fn error(&self, key: &str, message: impl Into<String>) -> FileError {
        let line = self.entries.get(key).map_or(self.line, |value| self.line_of_value(value));
        FileError::new(self.file, message).at_line(line).at(self.full_key(key))
    }

    /// A table inside this one.
    ///
    /// # Errors
    /// It is something else.
    pub fn table(&self, key: &'static str) -> Result<Option<Table<'a>>, FileError> {
        self.look(key).map(|value| self.child(self.full_key(key), value)).transpose()
    }

    /// An array of tables inside this one; empty when absent.
    ///
    /// # Errors
    /// It is something else.
    pub fn tables(&self, key: &'static str) -> Result<Vec<Table<'a>>, FileError> {
        let Some(value) = self.look(key) else { return Ok(Vec::new()) };
        let DeValue::Array(items) = value.get_ref() else {
            return Err(self.error(key, format!("must be a list of tables, each under its own [[{key}]]")));
        };
        items.iter().enumerate().map(|(i, item)| self.child(format!("{}[{i}]", self.full_key(key)), item)).collect()
    }

    /// A number that must be there.
    ///
    /// # Errors
    /// It is missing, not a number or not allowed.
    pub fn number(&self, key: &'static str, allowed: Allowed) -> Result<f32, FileError> {
        self.optional_number(key, allowed)?
            .ok_or_else(|| self.error(key, format!("is missing; it must be {}", allowed.words)))
    }

    /// A number that may be absent.
    ///
    /// # Errors
    /// It is not a number or not allowed.
    pub fn optional_number(&self, key: &'static str, allowed: Allowed) -> Result<Option<f32>, FileError> {
        let Some(value) = self.look(key) else { return Ok(None) };
        let number = match value.get_ref() {
            DeValue::Integer(digits) => i64::from_str_radix(digits.as_str(), digits.radix()).ok().map(|n| n as f64),
            DeValue::Float(digits) => digits.as_str().parse::<f64>().ok(),
            other => {
                return Err(self.error(key, format!("is a {}; it must be {}", kind_of(other), allowed.words)));
            }
        };
        match number {
            Some(number) if allowed.holds(number) => Ok(Some(number as f32)),
            _ => Err(self.error(key, format!("is {}; it must be {}", shown(value.get_ref()), allowed.words))),
        }
    }

    /// A whole number that must be there, in `min..=max`.
    ///
    /// # Errors
    /// It is missing, not a whole number or not in the range.
    pub fn integer(&self, key: &'static str, min: i64, max: i64) -> Result<i64, FileError> {
        let allowed = format!("a whole number from {min} to {max}");
        let Some(value) = self.look(key) else {
            return Err(self.error(key, format!("is missing; it must be {allowed}")));
        };
        let number = match value.get_ref() {
            DeValue::Integer(digits) => i64::from_str_radix(digits.as_str(), digits.radix()).ok(),
            _ => None,
        };
        match number {
            Some(number) if (min..=max).contains(&number) => Ok(number),
            _ => Err(self.error(key, format!("is {}; it must be {allowed}", shown(value.get_ref())))),
        }
    }

    /// A text that must be there and not be empty.
    ///
    /// # Errors
    /// It is missing, not a text or empty.
    pub fn text(&self, key: &'static str) -> Result<String, FileError> {
        let allowed = "a text in quotes that is not empty";
        match self.look(key).map(Spanned::get_ref) {
            Some(DeValue::String(text)) if !text.trim().is_empty() => Ok(text.to_string()),
            Some(other) => Err(self.error(key, format!("is {}; it must be {allowed}", shown(other)))),
            None => Err(self.error(key, format!("is missing; it must be {allowed}"))),
        }
    }

    /// A text that may be absent.
    ///
    /// # Errors
    /// It is not a text, or empty.
    pub fn optional_text(&self, key: &'static str) -> Result<Option<String>, FileError> {
        if self.has(key) { self.text(key).map(Some) } else { Ok(None) }
    }

    /// A truth value that may be absent.
    ///
    /// # Errors
    /// It is something else.
    pub fn optional_flag(&self, key: &'static str) -> Result<Option<bool>, FileError> {
        match self.look(key).map(Spanned::get_ref) {
            None => Ok(None),
            Some(DeValue::Boolean(value)) => Ok(Some(*value)),
            Some(other) => Err(self.error(key, format!("is {}; it must be true or false", shown(other)))),
        }
    }

    /// A list of texts; empty when absent.
    ///
    /// # Errors
    /// It is something else.
    pub fn texts(&self, key: &'static str) -> Result<Vec<String>, FileError> {
        self.list(key, "texts in quotes", |item| match item {
            DeValue::String(text) if !text.trim().is_empty() => Some(text.to_string()),
            _ => None,
        })
    }

    /// A list of numbers; empty when absent.
    ///
    /// # Errors
    /// It is something else, or a number is not allowed.
    pub fn numbers(&self, key: &'static str, allowed: Allowed) -> Result<Vec<f64>, FileError> {
        self.list(key, &format!("values, each {}", allowed.words), |item| {
            let number = match item {
                DeValue::Integer(digits) => i64::from_str_radix(digits.as_str(), digits.radix()).ok()? as f64,
                DeValue::Float(digits) => digits.as_str().parse().ok()?,
                _ => return None,
            };
            allowed.holds(number).then_some(number)
        })
    }

    fn list<T>(
        &self,
        key: &'static str,
        of: &str,
        read: impl Fn(&DeValue<'_>) -> Option<T>,
    ) -> Result<Vec<T>, FileError> {
        let Some(value) = self.look(key) else { return Ok(Vec::new()) };
        let wrong = |what: String| self.error(key, format!("{what}; it must be a list of {of}"));
        let DeValue::Array(items) = value.get_ref() else {
            return Err(wrong(format!("is {}", shown(value.get_ref()))));
        };
        let item = |item: &Spanned<DeValue<'_>>| {
            read(item.get_ref()).ok_or_else(|| wrong(format!("holds {}", shown(item.get_ref()))))
        };
        items.iter().map(item).collect()
    }

    /// Checks that every key of the table was asked for.
    ///
    /// # Errors
    /// The first key that was not.
    pub fn nothing_else(&self) -> Result<(), FileError> {
        let asked = self.asked.borrow();
        for key in self.entries.keys() {
            let name = key.get_ref().as_ref();
            if !asked.contains(&name) {
                let error = FileError::new(self.file, format!("is not known here; known are {}", asked.join(", ")));
                return Err(error.at_line(line_of(self.text, key.span().start)).at(self.full_key(name)));
            }
        }
        Ok(())
    }
}

fn kind_of(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "text",
        DeValue::Integer(_) | DeValue::Float(_) => "number",
        DeValue::Boolean(_) => "true-or-false value",
        DeValue::Datetime(_) => "date",
        DeValue::Array(_) => "list",
        DeValue::Table(_) => "table",
    }
}

fn shown(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => format!("{text:?}"),
        DeValue::Integer(digits) => digits.to_string(),
        DeValue::Float(digits) => digits.to_string(),
        other => format!("a {}", kind_of(other)),
    }
}
