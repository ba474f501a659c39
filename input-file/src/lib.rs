//! A user's files: text is read whole, TOML into types that check their own values. Errors name file, line and key, and say
//! what would be right.
//!
//! ```
//! use input_file::{Number, Positive, TomlFile};
//!
//! #[derive(serde::Deserialize)]
//! #[serde(deny_unknown_fields, expecting = "a table")]
//! struct Wheel {
//!     radius_m: Number<Positive>,
//! }
//!
//! let file = TomlFile::new("wheel.toml".as_ref(), "# in metres\nradius_m = -0.2\n");
//! let error = file.read::<Wheel>().err().map(|error| error.to_string());
//! assert_eq!(error.as_deref(), Some("wheel.toml:2: radius_m: is -0.2; it must be a number above 0"));
//! ```

#![forbid(unsafe_code)]

mod error;
mod number;
mod text;
mod toml_file;

pub use error::FileError;
pub use number::{Allowed, Finite, Limits, NotNegative, Number, Positive, Whole};
pub use text::{Text, read};
pub use toml_file::TomlFile;
