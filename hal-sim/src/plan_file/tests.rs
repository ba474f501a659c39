//! Plans as texts, good and bad.

use super::*;

fn error(text: &str) -> String {
    parse("home.toml", "home", text).unwrap_err().to_string()
}

/// A square home, three lines.
const HOME: &str = "[[outline]]\npoints_m = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]\n";
const START: &str = "[start]\nx_m = 1.0\ny_m = 1.0\n";

#[test]
fn every_built_in_plan_loads_and_has_rooms() {
    for (name, _) in BUILT_IN {
        let plan = load(name).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(plan.name, name);
        assert!(plan.rooms.len() >= 2, "{name}");
    }
}

#[test]
fn faces_look_into_the_room_and_out_of_the_box() {
    let text = format!(
        "{START}[[outline]]\npoints_m = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]\n\
         [[box]]\nmin_m = [1.5, 1.5]\nmax_m = [2.5, 2.5]"
    );
    let plan = parse("home.toml", "home", &text).unwrap();
    for (i, face) in plan.faces.iter().enumerate() {
        let middle = [0, 1].map(|axis| 0.5 * (face.from_m[axis] + face.to_m[axis]) - 2.0);
        let outward = middle[0] * face.normal()[0] + middle[1] * face.normal()[1];
        assert!(if i < 4 { outward < 0.0 } else { outward > 0.0 }, "{i}: {outward}");
    }
}

#[test]
fn an_outline_that_runs_clockwise_around_the_start_is_the_home() {
    let turned = HOME.replace("[4.0, 0.0], [4.0, 4.0], [0.0, 4.0]", "[0.0, 4.0], [4.0, 4.0], [4.0, 0.0]");
    let plan = parse("home.toml", "home", &format!("{START}{turned}")).unwrap();
    assert!(plan.is_inside([1.0, 1.0]) && !plan.is_inside([5.0, 1.0]));
    let around = "[[outline]]\npoints_m = [[0.5, 0.5], [0.5, 1.5], [1.5, 1.5], [1.5, 0.5]]";
    assert!(error(&format!("{START}{HOME}{around}")).contains("start: is outside"), "it starts in a pillar");
}

#[test]
fn a_pillar_closes_nothing_in_and_one_of_several_outlines_is_enough() {
    let pillar = "[[outline]]\npoints_m = [[2.0, 0.0], [2.0, 4.0], [4.0, 4.0], [4.0, 0.0]]";
    let flats = "[[outline]]\npoints_m = [[2.0, 0.0], [4.0, 0.0], [4.0, 4.0]]\n\
                 [[outline]]\npoints_m = [[0.0, 0.0], [3.0, 0.0], [0.0, 3.0]]";
    for outlines in [pillar, flats] {
        assert!(parse("home.toml", "home", &format!("{START}{outlines}")).is_ok(), "{outlines}");
    }
}

#[test]
fn what_cannot_be_is_named() {
    let cases = [
        (
            format!("{START}{HOME}[[box]]\nmin_m = [0.2, 0.2]\nmax_m = [2.0, 2.0]"),
            "home.toml:1: start: is outside the outline or in a box",
        ),
        (
            format!("{START}{HOME}[[kidnap]]\nat_s = 1.0\nto_m = [5.0, 1.0]"),
            "home.toml:8: kidnap[0].to_m: is outside the outline or in a box",
        ),
        (
            format!("{START}[[outline]]\npoints_m = [[0.0, 0.0], [4.0, 4.0], [4.0, 0.0], [0.0, 4.0]]"),
            "home.toml:5: outline[0].points_m: crosses itself: the line from point 1 and that from point 3",
        ),
        (
            format!("{START}[battery]\nlasts_min = 0\ncharges_min = 9"),
            "home.toml:5: battery.lasts_min: is 0; it must be minutes above 0 and up to 100000",
        ),
        (
            format!("{START}[battery]\ncharge = 80\nlasts_min = 60\ncharges_min = 90"),
            "home.toml:5: battery.charge: is 80; it must be a share from 0 to 1",
        ),
        (
            format!("{START}[battery]\nlasts_min = 60"),
            "home.toml:4: battery.charges_min: is missing; it must be minutes",
        ),
    ];
    for (text, expected) in cases {
        let message = error(&text);
        assert!(message.starts_with(expected), "{message}");
    }
}

#[test]
fn errors_name_file_key_and_what_is_allowed() {
    let cases = [
        (
            format!("{START}[[box]]\nmin_m = [1.0, 1.0]\nmax_m = [0.5, 2.0]"),
            "home.toml:6: box[0].max_m: both coordinates",
        ),
        (
            format!("{START}[[round]]\ncentre_m = [0.0, 0.0]\nradius_m = -1.0"),
            "home.toml:6: round[0].radius_m: is -1.0; it must be a number above 0",
        ),
        (
            format!("{START}[[outline]]\npoints_m = [[0.0, 0.0], [1.0, 0.0]]"),
            "home.toml:5: outline[0].points_m: at least three",
        ),
        (format!("{START}[[wall]]\nfrom_m = [0.0, 0.0]\nto_m = [0.0, 0.0]"), "home.toml:6: wall[0].to_m: must be"),
        (
            format!("{START}[[wall]]\nfrom_m = [nan, 0.0]\nto_m = [1.0, 0.0]"),
            "home.toml:5: wall[0].from_m[0]: is nan; it must be metres from",
        ),
        (
            format!("{START}[[outline]]\npoints_m = [[2.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 4.0]]"),
            "home.toml:1: start: is outside the outline or in a box",
        ),
        (
            // In the notch of an L.
            format!(
                "{START}[[outline]]\npoints_m = [[0.0, 0.0], [0.5, 0.0], [0.5, 2.0], [2.0, 2.0], [2.0, 3.0], [0.0, 3.0]]"
            ),
            "home.toml:1: start: is outside the outline or in a box",
        ),
        (format!("{START}[[wal]]\n"), "home.toml:4: wal: is not known here; known are name, start, outline"),
        ("[start]\nx_m = 1.0\n".into(), "home.toml:1: start.y_m: is missing; it must be metres from"),
        ("[start]\nx_m = \"left\"\ny_m = 0.0\n".into(), "home.toml:2: start.x_m: is a text; it must be metres from"),
        (START.into(), "home.toml:1: outline: is missing; a plan needs at least one"),
        ("[start\n".into(), "home.toml:1: is not valid TOML"),
        (format!("{START}[[kidnap]]\nat_s = 1.0"), "home.toml:4: kidnap[0].to_m: is missing; only where"),
        (
            format!("{START}[[kidnap]]\nat_s = 1.0\nheading_deg = 9"),
            "home.toml:6: kidnap[0].heading_deg: has a meaning with to_m only",
        ),
        (format!("{START}[[kick]]\nat_s = 1.0\nslide_m = 11.0"), "kick[0].slide_m: is 11.0; it must be metres from"),
        (format!("{START}[[hold]]\nat_s = -1.0"), "hold[0].at_s: is -1.0; it must be seconds from 0"),
    ];
    for (text, expected) in cases {
        let message = error(&text);
        assert!(message.contains(expected) && message.starts_with("home.toml:"), "{message}");
        assert!(!message.contains('\n'), "{message}");
    }
    let unknown = load("no-such-plan").unwrap_err().to_string();
    assert!(unknown.contains("no-such-plan") && unknown.contains("corridor-loop"), "{unknown}");
}
