//! Where the robot must not go, and what it is to clean.

use input_file::{FileError, TomlFile};
use robot::floor::{AREAS, CORNERS};
use robot::{AreaKind, Bounds};

use super::closed_line;
use super::keys::File;
use crate::options::SimOptions;
use crate::plan::Plan;
use crate::pose::Pose2;
use crate::world::World;

/// The areas of a plan, in its own frame.
pub(super) fn bounds(toml: &TomlFile<'_>, file: &File) -> Result<Bounds, FileError> {
    let mut bounds = Bounds::default();
    let kinds = [("keep_out", AreaKind::KeepOut, &file.keep_out), ("clean", AreaKind::Clean, &file.clean)];
    for (name, kind, areas) in kinds {
        for (i, area) in areas.iter().enumerate() {
            let place = format!("{name}[{i}].points_m");
            let points_m = closed_line(toml, &place, area)?;
            add(&mut bounds, kind, &points_m).map_err(|what| toml.error(&place, &what))?;
        }
    }
    Ok(bounds)
}

fn add(bounds: &mut Bounds, kind: AreaKind, points_m: &[[f64; 2]]) -> Result<(), String> {
    let corners: Vec<[f32; 2]> = points_m.iter().map(|point| point.map(|value_m| value_m as f32)).collect();
    bounds.add(kind, &corners).map_err(|_| {
        format!(
            "is one too many: a robot remembers {AREAS} areas to keep out of or to clean, with {CORNERS} corners in all"
        )
    })
}

/// The robot fits where it starts, and some of each area to clean is floor.
pub(super) fn check(toml: &TomlFile<'_>, plan: &Plan) -> Result<(), FileError> {
    check_start(plan, &plan.start).map_err(|what| toml.error("start", &what))?;
    for (i, corners) in plan.bounds.areas(AreaKind::Clean).enumerate() {
        let corners_m: Vec<[f64; 2]> = corners.iter().map(|corner| corner.map(f64::from)).collect();
        if !plan.reaches_inside(&corners_m) {
            let what = "is outside the home; some of it must be within the outline and in no box";
            return Err(toml.error(&format!("clean[{i}].points_m"), what));
        }
    }
    Ok(())
}

/// Why a robot that knows the areas cannot start at a place.
pub(super) fn check_start(plan: &Plan, start: &Pose2) -> Result<(), String> {
    let start_m = [start.x_m, start.y_m];
    let fenced =
        Plan { faces: plan.fences(), rounds: Vec::new(), doors: Vec::new(), people: Vec::new(), ..plan.clone() };
    let radius_m = SimOptions::default().body_radius_m;
    if plan.bounds.is_out(start_m.map(|value_m| value_m as f32)) || World::new(&fenced).clearance_m(start_m) < radius_m
    {
        return Err(format!(
            "is in a keep_out or less than {radius_m} m beside it; the robot must start where it may go"
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::plan_file::parse;

    const HOME: &str = "[start]\nx_m = 1.0\ny_m = 1.0\n[[wall]]\nfrom_m = [0.0, 0.0]\nto_m = [4.0, 0.0]\n";

    #[test]
    fn a_bad_area_is_named() {
        let area = |kind: &str, points: &str| format!("[[{kind}]]\npoints_m = [{points}]\n");
        let cases = [
            (area("keep_out", "[2.0, 2.0], [3.0, 2.0]"), "home.toml:8: keep_out[0].points_m: at least three"),
            (area("clean", "[2.0, 2.0], [2.0, 2.0], [3.0, 2.0]"), "clean[0].points_m[0]: must be at least 1 mm from"),
            (
                area("keep_out", "[0.5, 0.5], [2.0, 0.5], [2.0, 2.0], [0.5, 2.0]"),
                "home.toml:1: start: is in a keep_out",
            ),
            (
                area("keep_out", "[1.1, 0.5], [2.0, 0.5], [2.0, 2.0], [1.1, 2.0]"),
                "home.toml:1: start: is in a keep_out or less than",
            ),
            (
                area("keep_out", "[2.0, 2.0], [3.0, 3.0], [3.0, 2.0], [2.0, 3.0]"),
                "home.toml:8: keep_out[0].points_m: crosses itself: the line from point 1 and that from point 3",
            ),
            (
                area("outline", "[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]")
                    + &area("clean", "[5.0, 1.0], [6.0, 1.0], [6.0, 2.0]"),
                "home.toml:10: clean[0].points_m: is outside the home",
            ),
            (area("clean", "[5.0, 5.0], [6.0, 5.0], [6.0, 6.0]").repeat(9), "clean[8].points_m: is one too many"),
        ];
        for (text, expected) in cases {
            let error = parse("home.toml", "home", &format!("{HOME}{text}")).unwrap_err().to_string();
            assert!(error.contains(expected), "{error}");
        }
    }

    #[test]
    fn areas_are_fenced() {
        let text = format!("{HOME}[[keep_out]]\npoints_m = [[2.0, 2.0], [3.0, 2.0], [3.0, 3.0]]\n");
        let plan = parse("home.toml", "home", &text).unwrap();
        assert!(plan.bounds.is_out([2.8, 2.2]) && !plan.bounds.is_out([2.2, 2.8]));
        assert_eq!(plan.fences().len(), 3);
    }
}
