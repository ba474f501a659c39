//! SVG, written element by element.

use std::fmt::{Display, Write as _};

/// What the attribute `xmlns` of the outermost element must say.
pub const NAMESPACE: &str = "http://www.w3.org/2000/svg";

/// Attributes of an element, in the order in which they are written.
pub type Attributes<'a> = &'a [(&'a str, &'a dyn Display)];

/// A piece of SVG.
#[derive(Clone, Debug, Default)]
pub struct Svg {
    markup: String,
}

impl Svg {
    /// Nothing yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds an element that holds nothing.
    pub fn element(&mut self, name: &str, attributes: Attributes<'_>) {
        self.tag(name, attributes);
        self.markup.push_str("/>");
    }

    /// Adds an element that holds a text.
    pub fn text(&mut self, name: &str, attributes: Attributes<'_>, text: &str) {
        self.open(name, attributes);
        self.markup.push_str(&escape(text));
        self.close(name);
    }

    /// Begins an element that holds others.
    pub fn open(&mut self, name: &str, attributes: Attributes<'_>) {
        self.tag(name, attributes);
        self.markup.push('>');
    }

    /// Ends an element.
    pub fn close(&mut self, name: &str) {
        // Writing to a String cannot fail.
        let _ = write!(self.markup, "</{name}>");
    }

    /// Adds another piece.
    pub fn add(&mut self, piece: &Svg) {
        self.markup.push_str(&piece.markup);
    }

    /// Begins a new line: nothing that is seen.
    pub fn line_break(&mut self) {
        self.markup.push('\n');
    }

    /// The markup.
    pub fn finish(self) -> String {
        self.markup
    }

    fn tag(&mut self, name: &str, attributes: Attributes<'_>) {
        let _ = write!(self.markup, "<{name}");
        for (attribute, value) in attributes {
            let _ = write!(self.markup, " {attribute}=\"{value}\"");
        }
    }
}

/// Text as markup.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The `d` of a path through points, to a tenth of a unit.
pub fn polyline(points: impl IntoIterator<Item = [f64; 2]>) -> String {
    let mut path = String::new();
    for [x, y] in points {
        let _ = write!(path, "{}{x:.1} {y:.1}", if path.is_empty() { 'M' } else { 'L' });
    }
    path
}
