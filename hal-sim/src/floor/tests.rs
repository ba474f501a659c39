//! Floors swept by hand-made paths.

use super::*;
use crate::plan_file;

const ROOM: &str = "[start]\nx_m = 0.5\ny_m = 0.5\n\
    [[outline]]\npoints_m = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]\n\
    [[wall]]\nfrom_m = [1.0, 0.0]\nto_m = [1.0, 1.0]\n";

pub(super) fn moment(t_s: f64, x_m: f64) -> Moment {
    Moment { t_s, pose: Pose2::new(x_m, 0.5, 0.0), doing: "lanes", is_pressed: false, is_on_floor: true }
}

pub(super) fn room() -> FloorRaster {
    let plan = plan_file::parse("home.toml", "home", ROOM).unwrap();
    FloorRaster::new(&plan, 0.17, plan.start)
}

#[test]
fn the_floor_is_what_the_brush_reaches_on_this_side_of_the_wall() {
    // A square of 1 m less a rim of 4.5 cm, its corners as round as the brush.
    let area_m2 = 0.91 * 0.91 - (4.0 - core::f64::consts::PI) * 0.125 * 0.125;
    let score = room().score();
    // The raster may take a cell's width off each side.
    assert!((score.floor_m2 - area_m2).abs() < 4.0 * 0.91 * CELL_M, "{} is not {area_m2}", score.floor_m2);
    assert!((score.largest_hole_m2 - score.floor_m2).abs() < 1e-9);
    for (found_m, rim_m) in score.hole_m.unwrap().iter().flatten().zip([0.045, 0.045, 0.955, 0.955]) {
        assert!((found_m - rim_m).abs() <= CELL_M, "{:?}", score.hole_m);
    }
}

#[test]
fn there_and_back_is_swept_twice() {
    let mut raster = room();
    let there = (0..=50).map(|i| moment(0.04 * f64::from(i), 0.2 + 0.01 * f64::from(i)));
    there.for_each(|moment| raster.record(&moment));
    let once = raster.score();
    let strip_m2 = 0.5 * 0.25 + core::f64::consts::PI * 0.125 * 0.125;
    assert!((once.swept * once.floor_m2 - strip_m2).abs() < 0.01, "{once:?}");
    assert_eq!(once.twice, 0.0);
    assert!((once.overlap - 0.5 * 0.25 / (once.swept * once.floor_m2)).abs() < 1e-9);
    let back = (0..=50).map(|i| moment(10.0 + 0.04 * f64::from(i), 0.7 - 0.01 * f64::from(i)));
    back.for_each(|moment| raster.record(&moment));
    let twice = raster.score();
    assert!((twice.twice - twice.swept).abs() < 1e-9 && (twice.swept - once.swept).abs() < 1e-9);
    assert!(twice.home_m > 0.29 && twice.home_m < 0.31);
    // The middle of the strip came under the brush on the way there, half a second in, and on the way back.
    let [column, row] = [0, 1].map(|axis| ((0.45 - twice.picture.corner_m[axis]) / CELL_M) as usize);
    let [first_s, again_s] = twice.picture.swept_s[row * twice.picture.columns + column];
    assert!((0.3..1.0).contains(&first_s) && (10.3..11.5).contains(&again_s), "{first_s} {again_s}");
}

#[test]
fn who_is_carried_sweeps_nothing_on_the_way() {
    let mut raster = room();
    raster.record(&moment(0.0, 0.2));
    raster.record(&moment(0.04, 0.8));
    assert_eq!(raster.score().path_m, 0.0);
}
