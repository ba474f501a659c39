//! Kept walls that a driven path goes through, by how much.

use crate::side::Side;

/// How far a path would have to be moved so as not to go through a wall, metres; none where it does not go through.
pub(crate) fn depth_m(side: &Side, path: impl Iterator<Item = [f32; 2]> + Clone) -> Option<f32> {
    let (across, along) = (side.axis(), 1 - side.axis());
    let (mut sides_m, mut last, mut least_m) = ([0.0f32; 2], None::<[f32; 2]>, None::<f32>);
    for point in path {
        let off_m = point[across] - side.at_m;
        if (side.extent_m[0]..=side.extent_m[1]).contains(&point[along]) {
            sides_m = [sides_m[0].min(off_m), sides_m[1].max(off_m)];
        }
        if let Some(from) = last.replace(point) {
            let (a, b) = (from[across] - side.at_m, off_m);
            if a * b < 0.0 {
                let at_m = from[along] + (point[along] - from[along]) * a / (a - b);
                let inside_m = (at_m - side.extent_m[0]).min(side.extent_m[1] - at_m);
                if inside_m > 0.0 {
                    sides_m = [sides_m[0].min(a.min(b)), sides_m[1].max(a.max(b))];
                    least_m = Some(least_m.map_or(inside_m, |least: f32| least.max(inside_m)));
                }
            }
        }
    }
    least_m.map(|inside_m| inside_m.min(-sides_m[0]).min(sides_m[1]))
}
