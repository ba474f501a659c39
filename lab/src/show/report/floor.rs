//! What was swept of the floor, as compact JSON; `floor.js` of the view modules is the other end.

use hal_sim::floor::{FloorPicture, FloorScore};
use robot::AreaKind;
use serde_json::{Value, json};

/// Code of a cell that is out of reach, in place of the second in which it was swept.
const OUT_OF_REACH: i64 = -2;
/// Code of a cell that was not swept.
const NEVER: i64 = -1;

/// The floor for the page: figures, shares over time, and when each cell was swept first and again. Metres in the plan's
/// frame, seconds.
pub fn floor(score: &FloorScore) -> Value {
    let FloorPicture { corner_m, cell_m, columns, origin, .. } = &score.picture;
    let areas = |kind| score.picture.bounds.areas(kind).collect::<Vec<_>>();
    let share = |value: f64| (value * 1e4).round() / 1e4;
    json!({
        "floor_m2": score.floor_m2,
        "swept": score.swept,
        "twice": score.twice,
        "overlap": score.overlap,
        "bumps": score.bumps,
        "home_m": score.home_m,
        "hole_m2": score.largest_hole_m2,
        "hole_m": score.hole_m,
        "time": score.time,
        "t": score.progress.iter().map(|at| share(at.t_s)).collect::<Vec<_>>(),
        "shares": score.progress.iter().map(|at| share(at.swept)).collect::<Vec<_>>(),
        "shares_twice": score.progress.iter().map(|at| share(at.twice)).collect::<Vec<_>>(),
        "corner": corner_m,
        "cell": cell_m,
        "columns": columns,
        "keep_out": areas(AreaKind::KeepOut),
        "clean": areas(AreaKind::Clean),
        "origin": [origin.x_m, origin.y_m, origin.theta_rad],
        "first": runs(&score.picture, 0),
        "again": runs(&score.picture, 1),
    })
}

/// Runs of [second or code, length] over the cells, row by row: when each was swept first (0) or again (1).
fn runs(picture: &FloorPicture, pass: usize) -> Vec<i64> {
    let mut runs: Vec<[i64; 2]> = Vec::new();
    for (cell, swept_s) in picture.cells.iter().zip(&picture.swept_s) {
        let value = match (cell, swept_s[pass]) {
            (0, _) => OUT_OF_REACH,
            (_, at_s) if at_s.is_finite() => at_s.ceil() as i64,
            _ => NEVER,
        };
        match runs.last_mut() {
            Some(run) if run[0] == value => run[1] += 1,
            _ => runs.push([value, 1]),
        }
    }
    runs.concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_in_a_row_that_were_swept_in_one_second_are_one_run() {
        let never = [f32::INFINITY; 2];
        let picture = FloorPicture {
            cells: vec![0, 1, 2, 2, 3],
            swept_s: vec![never, never, [3.2, f32::INFINITY], [3.9, f32::INFINITY], [4.0, 60.5]],
            ..FloorPicture::default()
        };
        assert_eq!(runs(&picture, 0), [OUT_OF_REACH, 1, NEVER, 1, 4, 3]);
        assert_eq!(runs(&picture, 1), [OUT_OF_REACH, 1, NEVER, 3, 61, 1]);
    }
}
