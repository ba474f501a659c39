//! Charts as SVG, self-contained, readable in light and dark.

use super::svg::{NAMESPACE, Svg, polyline};

/// Colours that stand out on white and on near-black.
const COLOURS: [&str; 8] = ["#7d8590", "#e8590c", "#15a38b", "#b44fd0", "#c9910a", "#2d8be0", "#d6336c", "#5c7cfa"];

const STYLE: &str = "text{font:12px system-ui,sans-serif;fill:#24292f}.paper{fill:#fff}.grid{stroke:#d0d7de}\
.axis{stroke:#57606a}.ink{fill:#24292f;stroke:#24292f}.head{font-weight:600;font-size:13px}\
@media(prefers-color-scheme:dark){text{fill:#e6edf3}.paper{fill:#0d1117}.grid{stroke:#30363d}.axis{stroke:#8b949e}\
.ink{fill:#e6edf3;stroke:#e6edf3}}";

const LEFT: f64 = 64.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 30.0;
const BOTTOM: f64 = 44.0;
const LEGEND_LINE: f64 = 18.0;

/// Width of a line.
const STROKE: &str = "1.6";

/// An axis: from where to where, and how.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    label: String,
    low: f64,
    high: f64,
    is_log: bool,
    /// Places of named ticks; numbers where there are none.
    names: Vec<(f64, String)>,
}

impl Axis {
    /// A linear axis over these values and a little more.
    pub fn linear(label: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let (low, high) = span(values.into_iter());
        let margin = if high > low { 0.04 * (high - low) } else { 0.5 };
        Self { label: label.into(), low: low - margin, high: high + margin, is_log: false, names: Vec::new() }
    }

    /// A linear axis from zero to a little above a value.
    pub fn from_zero(label: &str, high: f64) -> Self {
        Self { label: label.into(), low: 0.0, high: 1.05 * high, is_log: false, names: Vec::new() }
    }

    /// A logarithmic axis over these values; what is not above zero is left out.
    pub fn log(label: &str, values: impl IntoIterator<Item = f64>) -> Self {
        let (low, high) = span(values.into_iter().filter(|value| *value > 0.0));
        let (low, high) = if low > 0.0 { (low, high) } else { (0.1, 10.0) };
        Self { label: label.into(), low: low / 1.3, high: high * 1.3, is_log: true, names: Vec::new() }
    }

    /// One place for each name: 0, 1, 2 ...
    pub fn named(label: &str, names: &[String]) -> Self {
        let names: Vec<(f64, String)> = names.iter().enumerate().map(|(i, name)| (i as f64, name.clone())).collect();
        Self { label: label.into(), low: -0.5, high: names.len() as f64 - 0.5, is_log: false, names }
    }

    fn share(&self, value: f64) -> f64 {
        let scale = |value: f64| if self.is_log { value.max(1e-12).log10() } else { value };
        ((scale(value) - scale(self.low)) / (scale(self.high) - scale(self.low))).clamp(0.0, 1.0)
    }

    fn ticks(&self) -> Vec<(f64, String)> {
        if !self.names.is_empty() {
            return self.names.clone();
        }
        let places: Vec<f64> =
            if self.is_log { log_ticks(self.low, self.high) } else { even_ticks(self.low, self.high) };
        places.into_iter().map(|place| (place, number(place))).collect()
    }
}

fn span(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let finite = values.filter(|value| value.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if low <= high { (low, high) } else { (0.0, 1.0) }
}

fn even_ticks(low: f64, high: f64) -> Vec<f64> {
    let rough = (high - low) / 6.0;
    let decade = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].into_iter().map(|m| m * decade).find(|s| *s >= 0.999 * rough).unwrap_or(rough);
    let first = (low / step).ceil() as i64;
    let last = (high / step).floor() as i64;
    (first..=last).map(|i| i as f64 * step).collect()
}

fn log_ticks(low: f64, high: f64) -> Vec<f64> {
    let steps: &[f64] = match high / low {
        ratio if ratio < 30.0 => &[1.0, 2.0, 3.0, 5.0],
        ratio if ratio < 1000.0 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    let decades = low.log10().floor() as i32..=high.log10().ceil() as i32;
    let all = decades.flat_map(|decade| steps.iter().map(move |step| step * 10f64.powi(decade)));
    all.filter(|place| (low..=high).contains(place)).collect()
}

/// A tick's number: no more digits than it needs.
fn number(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// One coordinate system of a figure.
#[derive(Clone, Debug)]
pub struct Panel {
    title: String,
    x: Axis,
    y: Axis,
    width: f64,
    height: f64,
    body: Svg,
}

impl Panel {
    /// An empty panel, with its size in SVG units.
    pub fn new(title: &str, x: Axis, y: Axis, width: f64, height: f64) -> Self {
        Self { title: title.into(), x, y, width, height, body: Svg::new() }
    }

    fn at(&self, x: f64, y: f64) -> (f64, f64) {
        let (inner_w, inner_h) = (self.width - LEFT - RIGHT, self.height - TOP - BOTTOM);
        (LEFT + inner_w * self.x.share(x), TOP + inner_h * (1.0 - self.y.share(y)))
    }

    fn path(&self, points: impl Iterator<Item = (f64, f64)>) -> String {
        let finite = points.filter(|(x, y)| x.is_finite() && y.is_finite());
        polyline(finite.map(|(x, y)| self.at(x, y).into()))
    }

    /// A line through points.
    pub fn line(&mut self, points: &[(f64, f64)], colour: usize) {
        let path = self.path(points.iter().copied());
        self.body.element(
            "path",
            &[("d", &path), ("fill", &"none"), ("stroke", &colour_of(colour)), ("stroke-width", &STROKE)],
        );
    }

    /// The area between two heights: (x, low, high).
    pub fn band(&mut self, points: &[(f64, f64, f64)], colour: usize) {
        let there = points.iter().map(|(x, low, _)| (*x, *low));
        let back = points.iter().rev().map(|(x, _, high)| (*x, *high));
        let path = self.path(there.chain(back)) + "Z";
        self.body.element("path", &[("d", &path), ("fill", &colour_of(colour)), ("fill-opacity", &"0.22")]);
    }

    /// Dots.
    pub fn dots(&mut self, points: &[(f64, f64)], radius: f64, colour: usize) {
        for (x, y) in points.iter().filter(|(x, y)| x.is_finite() && y.is_finite()) {
            let (x, y) = self.at(*x, *y);
            self.body.element(
                "circle",
                &[
                    ("cx", &format_args!("{x:.1}")),
                    ("cy", &format_args!("{y:.1}")),
                    ("r", &radius),
                    ("fill", &colour_of(colour)),
                ],
            );
        }
    }

    /// A vertical stroke from one height to another.
    pub fn whisker(&mut self, x: f64, low: f64, high: f64, colour: usize) {
        let ((x, y0), (_, y1)) = (self.at(x, low), self.at(x, high));
        let path = format!("M{x:.1} {y0:.1}V{y1:.1}");
        self.body.element("path", &[("d", &path), ("stroke", &colour_of(colour)), ("stroke-width", &STROKE)]);
    }

    /// Bars standing on the lower edge: (from x, to x, height).
    pub fn bars(&mut self, bars: &[(f64, f64, f64)], colour: usize) {
        for (from, to, height) in bars {
            let ((x0, y0), (x1, y1)) = (self.at(*from, self.y.low), self.at(*to, *height));
            let (w, h) = ((x1 - x0).max(0.5), (y0 - y1).max(0.0));
            self.body.element(
                "rect",
                &[
                    ("x", &format_args!("{x0:.1}")),
                    ("y", &format_args!("{y1:.1}")),
                    ("width", &format_args!("{w:.1}")),
                    ("height", &format_args!("{h:.1}")),
                    ("fill", &colour_of(colour)),
                    ("fill-opacity", &"0.55"),
                ],
            );
        }
    }

    fn draw(&self, out: &mut Svg) {
        let (right, bottom) = (self.width - RIGHT, self.height - BOTTOM);
        out.text("text", &[("class", &"head"), ("x", &LEFT), ("y", &18)], &self.title);
        for (place, name) in self.x.ticks() {
            let (x, _) = self.at(place, self.y.low);
            out.element("path", &[("class", &"grid"), ("d", &format_args!("M{x:.1} {TOP}V{bottom}"))]);
            label(out, [x, bottom + 16.0], "middle", &name);
        }
        for (place, name) in self.y.ticks() {
            let (_, y) = self.at(self.x.low, place);
            out.element("path", &[("class", &"grid"), ("d", &format_args!("M{LEFT} {y:.1}H{right}"))]);
            label(out, [LEFT - 6.0, y + 4.0], "end", &name);
        }
        let (middle_x, middle_y) = (0.5 * (LEFT + right), 0.5 * (TOP + bottom));
        out.add(&self.body);
        let axes = format!("M{LEFT} {TOP}V{bottom}H{right}");
        out.element("path", &[("class", &"axis"), ("fill", &"none"), ("d", &axes)]);
        label(out, [middle_x, bottom + 34.0], "middle", &self.x.label);
        let upright = format!("translate(14 {middle_y:.1}) rotate(-90)");
        out.text("text", &[("transform", &upright), ("text-anchor", &"middle")], &self.y.label);
    }
}

/// A text at a place.
fn label(out: &mut Svg, [x, y]: [f64; 2], anchor: &str, text: &str) {
    let (x, y) = (format!("{x:.1}"), format!("{y:.1}"));
    out.text("text", &[("x", &x), ("y", &y), ("text-anchor", &anchor)], text);
}

fn colour_of(colour: usize) -> &'static str {
    COLOURS[colour % COLOURS.len()]
}

/// Panels below each other, with a legend of (colour, name) above them.
pub fn svg(panels: &[Panel], legend: &[(usize, String)]) -> String {
    let width = panels.iter().map(|panel| panel.width).fold(0.0, f64::max);
    let mut head = Svg::new();
    let (mut x, mut line) = (LEFT, 1.0);
    for (colour, name) in legend {
        let advance = 28.0 + 6.6 * name.chars().count() as f64;
        if x + advance > width && x > LEFT {
            (x, line) = (LEFT, line + 1.0);
        }
        let y = LEGEND_LINE * line;
        let (dot_x, dot_y) = (format!("{:.1}", x + 5.0), format!("{:.1}", y - 4.0));
        head.element("circle", &[("cx", &dot_x), ("cy", &dot_y), ("r", &5), ("fill", &colour_of(*colour))]);
        let (text_x, text_y) = (format!("{:.1}", x + 14.0), format!("{y:.1}"));
        head.text("text", &[("x", &text_x), ("y", &text_y)], name);
        x += advance;
    }
    let mut body = Svg::new();
    let mut y = if legend.is_empty() { 0.0 } else { LEGEND_LINE * line + 8.0 };
    for panel in panels {
        body.open("g", &[("transform", &format_args!("translate(0 {y:.1})"))]);
        panel.draw(&mut body);
        body.close("g");
        y += panel.height;
    }
    let mut svg = Svg::new();
    let view = format!("0 0 {width} {y}");
    svg.open("svg", &[("xmlns", &NAMESPACE), ("viewBox", &view), ("width", &width), ("height", &y)]);
    svg.text("style", &[], STYLE);
    svg.element("rect", &[("class", &"paper"), ("width", &width), ("height", &y)]);
    svg.add(&head);
    svg.add(&body);
    svg.close("svg");
    svg.line_break();
    svg.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let names = |ticks: Vec<f64>| ticks.into_iter().map(number).collect::<Vec<_>>().join(" ");
        assert_eq!(names(even_ticks(-0.1, 1.1)), "0 0.2 0.4 0.6 0.8 1");
        assert_eq!(names(log_ticks(0.5, 1200.0)), "1 10 100 1000");
        assert_eq!((number(0.25), number(-0.0), number(10.0)), ("0.25".into(), "0".into(), "10".into()));
    }

    #[test]
    fn what_is_not_finite_is_not_drawn_and_names_are_escaped() {
        let axis = || Axis::linear("x", [0.0, f64::NAN, 1.0]);
        let mut panel = Panel::new("a < b", axis(), Axis::log("y", [0.0, 1.0, 10.0]), 300.0, 200.0);
        panel.line(&[(0.0, 1.0), (0.5, f64::NAN), (1.0, 10.0)], 0);
        panel.dots(&[(f64::INFINITY, 1.0)], 2.0, 1);
        let text = svg(&[panel], &[(0, "one & two".into())]);
        assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        assert!(text.contains("a &lt; b") && text.contains("one &amp; two") && !text.contains("r=\"2\""));
    }
}
