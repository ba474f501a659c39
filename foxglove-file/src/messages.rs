//! Messages with Foxglove's well-known schemas, as JSON.

use lab::recording::{Pose2, Segment};
use lab::show::report::wall_ends;
use serde_json::{Value, json};
use slam_core::{WallKind, WallView};

use super::nanoseconds;

/// The frame of everything: the robot's start pose.
const FRAME: &str = "map";
/// `LINE_LIST` of Foxglove's `LineType`: pairs of points.
const LINE_LIST: u8 = 2;
/// `FLOAT32` of Foxglove's `NumericType`.
const FLOAT32: u8 = 7;

/// Numbers of one step to plot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Figures {
    /// Distance from the true position, metres.
    pub position_error_m: Option<f64>,
    /// Heading minus true heading, radians.
    pub heading_error_rad: Option<f64>,
    /// 1-sigma along x, metres.
    pub sigma_x_m: f64,
    /// 1-sigma along y, metres.
    pub sigma_y_m: f64,
    /// 1-sigma of the heading, radians.
    pub sigma_theta_rad: f64,
    /// Normalised pose error squared; 3 is ideal.
    pub nees: Option<f64>,
    /// Walls in the map.
    pub walls: usize,
    /// How the estimator is.
    pub health: &'static str,
}

impl Figures {
    /// The message; what is not known is left out.
    pub(crate) fn message(&self, t_s: f64) -> Value {
        let mut message = json!({ "timestamp": timestamp(t_s), "walls": self.walls, "health": self.health });
        let known = [
            ("position_error_m", self.position_error_m),
            ("heading_error_rad", self.heading_error_rad),
            ("sigma_x_m", Some(self.sigma_x_m)),
            ("sigma_y_m", Some(self.sigma_y_m)),
            ("sigma_theta_rad", Some(self.sigma_theta_rad)),
            ("nees", self.nees),
        ];
        for (name, value) in known {
            if let Some(value) = value.filter(|value| value.is_finite()) {
                message[name] = json!(value);
            }
        }
        message
    }
}

fn timestamp(t_s: f64) -> Value {
    let nanoseconds = nanoseconds(t_s);
    json!({ "sec": nanoseconds / 1_000_000_000, "nsec": nanoseconds % 1_000_000_000 })
}

fn pose(pose: &Pose2) -> Value {
    let (z, w) = (0.5 * pose.theta_rad).sin_cos();
    json!({
        "position": { "x": pose.x_m, "y": pose.y_m, "z": 0.0 },
        "orientation": { "x": 0.0, "y": 0.0, "z": z, "w": w },
    })
}

fn is_number(pose: &Pose2) -> bool {
    [pose.x_m, pose.y_m, pose.theta_rad].iter().all(|number| number.is_finite())
}

/// `foxglove.PoseInFrame`; none for what is no number.
pub(crate) fn pose_in_frame(t_s: f64, given: &Pose2) -> Option<Value> {
    is_number(given).then(|| json!({ "timestamp": timestamp(t_s), "frame_id": FRAME, "pose": pose(given) }))
}

/// `foxglove.PosesInFrame`.
pub(crate) fn poses_in_frame<'a>(t_s: f64, poses: impl Iterator<Item = &'a Pose2>) -> Value {
    let poses: Vec<Value> = poses.filter(|pose| is_number(pose)).map(pose).collect();
    json!({ "timestamp": timestamp(t_s), "frame_id": FRAME, "poses": poses })
}

/// `foxglove.SceneUpdate` with the map's walls: dark on the grid, violet off it.
pub(crate) fn walls(t_s: f64, walls: &[WallView]) -> Value {
    let of = |free: bool| {
        let chosen = walls.iter().filter(move |wall| (wall.kind == WallKind::Free) == free);
        lines(chosen.map(wall_ends), if free { [0.48, 0.25, 0.66] } else { [0.91, 0.35, 0.05] }, 0.05)
    };
    scene(t_s, "walls", vec![of(false), of(true)])
}

/// `foxglove.SceneUpdate` with the true plan.
pub(crate) fn plan(t_s: f64, plan: &[Segment]) -> Value {
    let ends = plan.iter().map(|piece| [piece.from_m[0], piece.from_m[1], piece.to_m[0], piece.to_m[1]]);
    scene(t_s, "plan", vec![lines(ends, [0.55, 0.6, 0.65], 0.1)])
}

fn scene(t_s: f64, id: &str, lines: Vec<Value>) -> Value {
    json!({
        "deletions": [],
        "entities": [{
            "timestamp": timestamp(t_s),
            "frame_id": FRAME,
            "id": id,
            "lifetime": { "sec": 0, "nsec": 0 },
            "frame_locked": false,
            "metadata": [],
            "arrows": [], "cubes": [], "spheres": [], "cylinders": [], "triangles": [], "texts": [], "models": [],
            "lines": lines,
        }],
    })
}

/// `foxglove.LinePrimitive` of separate segments.
fn lines(ends: impl Iterator<Item = [f64; 4]>, [r, g, b]: [f64; 3], thickness_m: f64) -> Value {
    let points = ends
        .filter(|ends| ends.iter().all(|end| end.is_finite()))
        .flat_map(|[x0, y0, x1, y1]| [json!({ "x": x0, "y": y0, "z": 0.0 }), json!({ "x": x1, "y": y1, "z": 0.0 })]);
    json!({
        "type": LINE_LIST,
        "pose": pose(&Pose2::default()),
        "thickness": thickness_m,
        "scale_invariant": false,
        "points": points.collect::<Vec<_>>(),
        "color": { "r": r, "g": g, "b": b, "a": 1.0 },
        "colors": [],
        "indices": [],
    })
}

/// `foxglove.PointCloud` of points in the plane.
pub(crate) fn point_cloud(t_s: f64, points: &[[f32; 2]]) -> Value {
    let finite = points.iter().filter(|point| point.iter().all(|value| value.is_finite()));
    let bytes: Vec<u8> = finite.flat_map(|[x, y]| [*x, *y, 0.0]).flat_map(f32::to_le_bytes).collect();
    let field = |name: &str, offset: u32| json!({ "name": name, "offset": offset, "type": FLOAT32 });
    json!({
        "timestamp": timestamp(t_s),
        "frame_id": FRAME,
        "pose": pose(&Pose2::default()),
        "point_stride": 12,
        "fields": [field("x", 0), field("y", 4), field("z", 8)],
        "data": base64(&bytes),
    })
}

/// Bytes in base 64 (RFC 4648), as JSON messages carry them.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for part in bytes.chunks(3) {
        let word = [0, 1, 2].iter().fold(0_u32, |word, i| word << 8 | u32::from(part.get(*i).copied().unwrap_or(0)));
        for digit in 0..4 {
            let is_there = digit <= part.len();
            let index = (word >> (18 - 6 * digit)) & 63;
            text.push(if is_there { char::from(DIGITS[index as usize]) } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base_64_is_that_of_the_standard() {
        for (bytes, text) in [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")] {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }
}
