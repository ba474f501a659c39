//! `floor.csv` and `floor.pgm`: what a sweeping robot swept, over time and from above.

use std::fmt::Write as _;

use hal_sim::floor::{FloorPicture, FloorScore};

use crate::numbers::shortest;

/// `floor.csv`: the shares swept, about once a second.
pub fn progress(score: &FloorScore) -> String {
    let mut text = String::from("t_s,swept,twice\n");
    for at in &score.progress {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{}", [at.t_s, at.swept, at.twice].map(shortest).join(","));
    }
    text
}

/// `floor.pgm`: a grey picture, the plan's y up; its comment says where it lies in the plan.
pub fn picture(picture: &FloorPicture) -> Vec<u8> {
    let FloorPicture { corner_m: [x_m, y_m], cell_m, columns, cells, .. } = picture;
    let rows = cells.len() / (*columns).max(1);
    let grey = |code: &u8| 85 * (*code).min(3);
    let mut bytes = format!("P5\n# corner_m {x_m} {y_m} cell_m {cell_m}\n{columns} {rows}\n255\n").into_bytes();
    bytes.extend(cells.chunks((*columns).max(1)).rev().flatten().map(grey));
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_upper_row_of_the_picture_comes_first() {
        let floor = FloorPicture {
            corner_m: [-0.5, 1.0],
            cell_m: 0.025,
            columns: 2,
            cells: vec![0, 1, 2, 3],
            ..FloorPicture::default()
        };
        let bytes = picture(&floor);
        let head = b"P5\n# corner_m -0.5 1 cell_m 0.025\n2 2\n255\n";
        assert!(bytes.starts_with(head));
        assert_eq!(bytes[head.len()..], [170, 255, 0, 85]);
    }
}
