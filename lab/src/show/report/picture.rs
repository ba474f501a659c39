//! A still picture of a finished map, for a README: legible on light and dark backgrounds.

use super::data::wall_ends;
use crate::recording::{Pose2, Recording};
use crate::show::svg::{NAMESPACE, Svg};
use slam_core::{Outcome, WallKind};
use std::{
    f64::consts::FRAC_PI_2,
    fmt::{Display, Write},
};

/// Size of the longer side of the drawing, SVG units.
const SIZE: f64 = 840.0;
const MARGIN: f64 = 24.0;
/// Room under the drawing for the legend.
const LEGEND: f64 = 34.0;
/// More hits than these are thinned out.
const HITS_MAX: usize = 6000;
/// Side of the square that one hit paints, SVG units.
const HIT: f64 = 1.8;

// Mid tones, readable on white and on near-black.
const PLAN: &str = "#8c99a6";
const GRID_WALL: &str = "#e8590c";
const FREE_WALL: &str = "#b44fd0";
const HITS: &str = "#15a38b";
const ESTIMATE: &str = "#2d8be0";
const TRUTH: &str = "#7d8590";
const ODOMETRY: &str = "#c9910a";

/// Map metres to SVG units, turned so that the wall grid is upright.
struct Frame {
    turn: [f64; 2],
    x0: f64,
    y1: f64,
    scale: f64,
    width: f64,
    height: f64,
}

impl Frame {
    /// Around everything but dead reckoning, which may wander off.
    fn around(recording: &Recording) -> Self {
        let alpha = recording.steps.iter().rev().find_map(|s| s.alpha).map_or(0.0, |(alpha, _)| f64::from(alpha));
        let (s, c) = ((alpha / FRAC_PI_2).round() * FRAC_PI_2 - alpha).sin_cos();
        let turned = |[x, y]: [f64; 2]| [c * x - s * y, s * x + c * y];
        let mut points: Vec<[f64; 2]> = recording.steps.iter().map(|s| [s.pose.x_m, s.pose.y_m]).collect();
        points.extend(recording.true_walls_in_map().iter().flat_map(|s| [s.from_m, s.to_m]));
        for [x0, y0, x1, y1] in recording.walls().iter().map(wall_ends) {
            points.extend([[x0, y0], [x1, y1]]);
        }
        let mut low = [f64::INFINITY; 2];
        let mut high = [f64::NEG_INFINITY; 2];
        for point in points.into_iter().map(turned).filter(|p| p[0].is_finite() && p[1].is_finite()) {
            for axis in 0..2 {
                low[axis] = low[axis].min(point[axis]);
                high[axis] = high[axis].max(point[axis]);
            }
        }
        if low[0] > high[0] {
            (low, high) = ([-1.0; 2], [1.0; 2]);
        }
        let extent = [(high[0] - low[0]).max(0.5), (high[1] - low[1]).max(0.5)];
        let scale = (SIZE - 2.0 * MARGIN) / extent[0].max(extent[1]);
        Self {
            turn: [c, s],
            x0: low[0] - MARGIN / scale,
            y1: high[1] + MARGIN / scale,
            scale,
            width: (extent[0] * scale + 2.0 * MARGIN).max(460.0),
            height: extent[1] * scale + 2.0 * MARGIN,
        }
    }

    fn place(&self, x_m: f64, y_m: f64) -> [f64; 2] {
        let [c, s] = self.turn;
        [(c * x_m - s * y_m - self.x0) * self.scale, (self.y1 - s * x_m - c * y_m) * self.scale]
    }

    fn line(&self, [x0, y0, x1, y1]: [f64; 4]) -> String {
        let ([ax, ay], [bx, by]) = (self.place(x0, y0), self.place(x1, y1));
        format!("M{ax:.1} {ay:.1}L{bx:.1} {by:.1}")
    }

    /// A path through poses, leaving out points that would not be seen.
    fn trace(&self, poses: impl Iterator<Item = Option<Pose2>>) -> String {
        let mut out = String::new();
        let mut last: Option<[f64; 2]> = None;
        for pose in poses {
            let Some(pose) = pose.filter(|p| p.x_m.is_finite() && p.y_m.is_finite()) else {
                last = None;
                continue;
            };
            let [x, y] = self.place(pose.x_m, pose.y_m);
            if last.is_some_and(|[lx, ly]| (x - lx).hypot(y - ly) < 3.0) {
                continue;
            }
            let _ = write!(out, "{}{x:.1} {y:.1}", if last.is_some() { 'L' } else { 'M' });
            last = Some([x, y]);
        }
        out
    }
}

/// The finished map of a run as a stand-alone SVG: true plan, hits, walls, paths.
pub fn map_svg(recording: &Recording) -> String {
    let frame = Frame::around(recording);
    let mut svg = begin(recording, &frame);
    let mut legend = Vec::new();
    let mut layer = |name, colour: &'static str, width: f64, style: &[(&str, &str)], path: String| {
        if path.is_empty() {
            return;
        }
        let mut attributes: Vec<(&str, &dyn Display)> = vec![("stroke", &colour), ("stroke-width", &width)];
        attributes.extend(style.iter().map(|(name, value)| (*name, value as &dyn Display)));
        attributes.push(("d", &path));
        svg.element("path", &attributes);
        svg.line_break();
        legend.push((name, colour, width));
    };
    let plan = recording.true_walls_in_map();
    let plan = plan.iter().map(|s| frame.line([s.from_m[0], s.from_m[1], s.to_m[0], s.to_m[1]]));
    layer("True plan", PLAN, 8.0, &[("stroke-opacity", "0.4")], plan.collect());
    layer("Hits", HITS, HIT, &[("stroke-linecap", "square"), ("stroke-opacity", "0.8")], hits(recording, &frame));
    let steps = &recording.steps;
    // What is told from the start pose is drawn from where that ended up in the map.
    let start = recording.start();
    layer(
        "Dead reckoning",
        ODOMETRY,
        1.0,
        &[("stroke-opacity", "0.8")],
        frame.trace(steps.iter().map(|s| Some(start.compose(&s.dead_reckoning)))),
    );
    layer("Estimated path", ESTIMATE, 1.8, &[], frame.trace(steps.iter().map(|s| Some(s.pose))));
    let truth = frame.trace(steps.iter().map(|s| Some(start.compose(&s.truth?))));
    layer("True path", TRUTH, 1.2, &[("stroke-dasharray", "5 4")], truth);
    let walls = |free: bool| {
        let kind = move |kind| (kind == WallKind::Free) == free;
        recording.walls().iter().filter(|w| kind(w.kind)).map(|w| frame.line(wall_ends(w))).collect::<String>()
    };
    layer("Estimated walls", GRID_WALL, 2.6, &[], walls(false));
    layer("Walls off the grid", FREE_WALL, 2.6, &[], walls(true));
    svg.close("g");
    svg.line_break();
    add_legend(&mut svg, &legend, frame.height + 18.0);
    svg.close("svg");
    svg.line_break();
    svg.finish()
}

/// The picture up to the group that holds the layers.
fn begin(recording: &Recording, frame: &Frame) -> Svg {
    let (width, height) = (frame.width, frame.height + LEGEND);
    let mut svg = Svg::new();
    svg.open(
        "svg",
        &[
            ("xmlns", &NAMESPACE),
            ("viewBox", &format_args!("0 0 {width:.0} {height:.0}")),
            ("role", &"img"),
            ("font-family", &"system-ui, sans-serif"),
            ("font-size", &13),
        ],
    );
    svg.line_break();
    svg.text("title", &[], &format!("Map: {}", recording.title));
    svg.line_break();
    svg.open("clipPath", &[("id", &"inside")]);
    let inside = [format!("{width:.0}"), format!("{:.0}", frame.height)];
    svg.element("rect", &[("width", &inside[0]), ("height", &inside[1])]);
    svg.close("clipPath");
    svg.line_break();
    svg.open(
        "g",
        &[
            ("clip-path", &"url(#inside)"),
            ("fill", &"none"),
            ("stroke-linecap", &"round"),
            ("stroke-linejoin", &"round"),
        ],
    );
    svg.line_break();
    svg
}

/// Every used or waiting hit, thinned out evenly, as dots.
fn hits(recording: &Recording, frame: &Frame) -> String {
    let located = (0..recording.steps.len()).filter(|step| !recording.steps[*step].searching);
    let seen: Vec<[f32; 2]> = located
        .flat_map(|step| recording.readings(step))
        .filter(|r| matches!(r.outcome, Outcome::Updated { .. } | Outcome::Gated { .. } | Outcome::Unexplained))
        .filter_map(|r| r.hit_m)
        .filter(|hit| hit[0].is_finite() && hit[1].is_finite())
        .collect();
    let stride = seen.len().div_ceil(HITS_MAX).max(1);
    let mut out = String::new();
    for hit in seen.iter().step_by(stride) {
        let [x, y] = frame.place(f64::from(hit[0]), f64::from(hit[1]));
        let _ = write!(out, "M{x:.1} {y:.1}h0");
    }
    out
}

fn add_legend(svg: &mut Svg, entries: &[(&str, &str, f64)], y: f64) {
    let mut x = MARGIN;
    for (name, colour, width) in entries {
        let path = format!("M{x:.0} {:.0}h18", y - 4.5);
        svg.element("path", &[("stroke", colour), ("stroke-width", &width.clamp(2.0, 5.0)), ("d", &path)]);
        let (text_x, text_y) = (format!("{:.0}", x + 24.0), format!("{y:.0}"));
        svg.text("text", &[("x", &text_x), ("y", &text_y), ("fill", &"#7d8590")], name);
        svg.line_break();
        x += 24.0 + 16.0 + 7.0 * name.len() as f64;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::{Segment, Step};

    #[test]
    fn an_empty_recording_makes_an_empty_picture() {
        let svg = map_svg(&Recording::default());
        assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n"));
        assert!(!svg.contains("NaN") && !svg.contains("inf"));
    }

    #[test]
    fn the_plan_is_drawn_from_where_the_start_ended_up() {
        let at = |start: Pose2, from_m: [f64; 2], to_m: [f64; 2]| {
            // Without dead reckoning, which moves with the start as well.
            let dead_reckoning = Pose2 { x_m: f64::NAN, ..Pose2::default() };
            let step = Step { start, pose: Pose2::new(1.0, 2.0, 0.0), dead_reckoning, ..Step::default() };
            map_svg(&Recording {
                steps: vec![step],
                true_walls: vec![Segment { from_m, to_m }],
                ..Recording::default()
            })
        };
        let moved = at(Pose2::new(0.25, -0.5, 0.0), [0.0, 0.0], [3.0, 4.0]);
        assert_eq!(moved, at(Pose2::default(), [0.25, -0.5], [3.25, 3.5]));
    }
}
