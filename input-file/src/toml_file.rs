//! TOML files read by serde, and where in them an error is.

use std::ops::Range;
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::FileError;

/// A TOML file's text.
#[derive(Clone, Copy, Debug)]
pub struct TomlFile<'a> {
    file: &'a Path,
    text: &'a str,
}

impl<'a> TomlFile<'a> {
    /// A text; `file` is for messages.
    pub fn new(file: &'a Path, text: &'a str) -> Self {
        Self { file, text }
    }

    /// What the file holds.
    ///
    /// # Errors
    /// It is not TOML, or a key is missing, unknown or has a value that cannot be.
    pub fn read<T: Deserialize<'a>>(&self) -> Result<T, FileError> {
        let document = toml::Deserializer::parse(self.text).map_err(|cause| self.not_toml(&cause))?;
        serde_path_to_error::deserialize(document).map_err(|error| {
            let place = error.path().to_string();
            let (key, message) = plain(error.inner().message());
            // Serde is at the table when it misses a key or does not know one.
            let place = if place == "." { String::new() } else { place };
            match key {
                Some(key) if place.is_empty() => self.error(&key, message),
                Some(key) if place != key && !place.ends_with(&format!(".{key}")) => {
                    self.error(&format!("{place}.{key}"), message)
                }
                _ => self.error(&place, message),
            }
        })
    }

    /// An error about the key at a place such as `range_sensor[2].name`; at the line of the table that would hold it where
    /// it is not there.
    pub fn error(&self, place: &str, message: impl Into<String>) -> FileError {
        let error = FileError::new(self.file, message).at_line(self.line_of(place));
        if place.is_empty() { error } else { error.at(place) }
    }

    /// The value at a place, which must be there.
    ///
    /// # Errors
    /// It is not there; `allowed` says what must be.
    pub fn required<T>(&self, place: &str, value: Option<T>, allowed: &str) -> Result<T, FileError> {
        value.ok_or_else(|| self.error(place, format!("is missing; it must be {allowed}")))
    }

    fn not_toml(&self, cause: &toml::de::Error) -> FileError {
        let error = FileError::new(self.file, format!("is not valid TOML: {}", cause.message().replace('\n', "; ")));
        match cause.span() {
            Some(span) => error.at_line(self.line(&span)),
            None => error,
        }
    }

    /// The line, counted from one, that a span begins on.
    fn line(&self, span: &Range<usize>) -> usize {
        1 + self.text.as_bytes()[..span.start.min(self.text.len())].iter().filter(|byte| **byte == b'\n').count()
    }

    fn line_of(&self, place: &str) -> usize {
        self.find(place).map_or(1, |(span, _)| self.line(&span))
    }

    /// What the file has at a place, as it is written there; none where it has nothing.
    pub fn given(&self, place: &str) -> Option<&'a str> {
        let (span, _) = self.find(place).filter(|(_, is_whole)| *is_whole)?;
        self.text.get(span)
    }

    /// Where the value at a place is, or of the last table on the way there; whether it is the value itself.
    fn find(&self, place: &str) -> Option<(Range<usize>, bool)> {
        let document = DeTable::parse(self.text).ok()?;
        let mut found: Option<&Spanned<DeValue<'_>>> = None;
        let mut is_whole = true;
        for segment in place.split(['.', '[']) {
            let inner = match (found.map(Spanned::get_ref), segment.strip_suffix(']')) {
                (None, None) => document.get_ref().get(segment),
                (Some(DeValue::Table(table)), None) => table.get(segment),
                (Some(DeValue::Array(list)), Some(index)) => index.parse::<usize>().ok().and_then(|i| list.get(i)),
                _ => None,
            };
            let Some(inner) = inner else {
                is_whole = false;
                break;
            };
            found = Some(inner);
        }
        found.map(|value| (value.span(), is_whole))
    }
}

/// Serde's own messages in the words of this program, with the key that they are about where they name one.
fn plain(message: &str) -> (Option<String>, String) {
    let message = message.trim_end().replace('\n', "; ");
    let quoted = |start: &str| message.strip_prefix(start).and_then(|rest| rest.split_once('`'));
    if let Some((key, rest)) = quoted("missing field `") {
        return (Some(key.to_owned()), format!("is missing{rest}"));
    }
    if let Some((key, rest)) = quoted("unknown field `") {
        return (Some(key.to_owned()), format!("is not known here; known are {}", names(rest)));
    }
    if let Some((given, rest)) = quoted("unknown variant `") {
        return (None, format!("is {given:?}; it must be one of {}", names(rest)));
    }
    if let Some((given, expected)) =
        message.strip_prefix("invalid type: ").and_then(|rest| rest.split_once(", expected "))
    {
        let given = match given.split_whitespace().next() {
            Some("integer" | "floating") => "a number",
            Some("string") => "a text",
            Some("boolean") => "a true-or-false value",
            Some("sequence") => "a list",
            Some("map") => "a table",
            _ => given,
        };
        let expected = match expected {
            "a boolean" => "true or false",
            "a sequence" => "a list",
            "f64" => "a number",
            "a string" => "a text",
            other => other,
        };
        return (None, format!("must be {expected}, not {given}"));
    }
    (None, message)
}

/// The names that serde lists after "expected".
fn names(rest: &str) -> String {
    rest.split('`').skip(1).step_by(2).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Number, Positive, Text, Whole};

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields, expecting = "a table")]
    struct Home {
        name: Text,
        #[serde(default)]
        rooms: Vec<Room>,
        floors: Option<Whole<1, 3>>,
        heated: Option<bool>,
        kind: Option<Kind>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields, expecting = "a table")]
    struct Room {
        area_m2: Number<Positive>,
        corner_m: Option<[Number<Positive>; 2]>,
    }

    #[derive(Debug, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    enum Kind {
        Flat,
        TownHouse,
    }

    fn error(text: &str) -> String {
        match TomlFile::new(Path::new("home.toml"), text).read::<Home>() {
            Ok(home) => panic!("accepted as {home:?}"),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn errors_name_file_line_and_key_and_what_would_be_right() {
        let number = "it must be a number above 0";
        let cases = [
            ("", "home.toml:1: name: is missing; it must be a text in quotes that is not empty".to_owned()),
            ("name = 7", "home.toml:1: name: is 7; it must be a text in quotes that is not empty".into()),
            ("name = \"a\"\n\nrooms = [\n{},\n]", format!("home.toml:4: rooms[0].area_m2: is missing; {number}")),
            (
                "name = \"a\"\n[[rooms]]\n[[rooms]]\narea_m2 = 1",
                format!("home.toml:2: rooms[0].area_m2: is missing; {number}"),
            ),
            ("name = \"a\"\n[[rooms]]\narea_m2 = -1", format!("home.toml:3: rooms[0].area_m2: is -1; {number}")),
            ("name = \"a\"\n[[rooms]]\narea_m2 = [1]", format!("home.toml:3: rooms[0].area_m2: is a list; {number}")),
            ("name = \"a\"\n[[rooms]]\narea_m2 = nan", format!("home.toml:3: rooms[0].area_m2: is nan; {number}")),
            (
                "name = \"a\"\n[[rooms]]\narea_m2 = 1\ncorner_m = [1, 0]",
                format!("home.toml:4: rooms[0].corner_m[1]: is 0; {number}"),
            ),
            ("name = \"a\"\nrooms = 3", "home.toml:2: rooms: must be a list, not a number".into()),
            ("name = \"a\"\nrooms = [3]", "home.toml:2: rooms[0]: must be a table, not a number".into()),
            ("name = \"a\"\nfloors = 4", "home.toml:2: floors: is 4; it must be a whole number from 1 to 3".into()),
            ("name = \"a\"\nheated = \"yes\"", "home.toml:2: heated: must be true or false, not a text".into()),
            (
                "name = \"a\"\nkind = \"tent\"",
                "home.toml:2: kind: is \"tent\"; it must be one of flat, town-house".into(),
            ),
            (
                "name = \"a\"\nroof = 1",
                "home.toml:2: roof: is not known here; known are name, rooms, floors, heated, kind".into(),
            ),
            (
                "name = \"a\"\n[[rooms]]\narea_cm2 = 1",
                "home.toml:3: rooms[0].area_cm2: is not known here; known are area_m2, corner_m".into(),
            ),
            ("name = \"a\"\nname = \"b\"", "home.toml:2: is not valid TOML: duplicate key".into()),
            ("name = ", "home.toml:1: is not valid TOML: ".into()),
        ];
        for (text, expected) in cases {
            let message = error(text);
            assert!(message.starts_with(&expected), "{message}\ninstead of\n{expected}");
            assert!(!message.contains('\n'), "{message}");
        }
    }

    #[test]
    fn what_is_right_is_read() {
        let text = "name = \"a\"\nfloors = 2\nkind = \"town-house\"\n[[rooms]]\narea_m2 = 0x10\ncorner_m = [1, 2.5]";
        let home: Home = TomlFile::new(Path::new("home.toml"), text).read().expect("a home");
        assert_eq!((home.name.get(), home.floors.map(Whole::get)), ("a".to_owned(), Some(2)));
        assert!(matches!(home.kind, Some(Kind::TownHouse)) && home.heated.is_none());
        let [room] = &home.rooms[..] else { panic!("{:?}", home.rooms) };
        assert_eq!(
            (room.area_m2.single(), room.corner_m.map(|m| m.map(|number| number.get()))),
            (16.0, Some([1.0, 2.5]))
        );
        assert!(!matches!(home.kind, Some(Kind::Flat)));
        let file = TomlFile::new(Path::new("home.toml"), text);
        assert_eq!((file.given("rooms[0].area_m2"), file.given("rooms[0].roof")), (Some("0x10"), None));
    }
}
