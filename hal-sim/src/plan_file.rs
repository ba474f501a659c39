//! Floor plans as TOML: the built-in ones and the user's own. The format is described in `docs/reference/plans.md`.

mod check;
mod schema;

use core::fmt;
use std::path::Path;

use crate::plan::{Cliff, Door, Face, Person, Plan, Room, Round};
use crate::pose::TruePose;
use check::Check;
use schema::{Cuboid, File};

/// The built-in plans: name and text.
pub const BUILT_IN: [(&str, &str); 6] = [
    ("room", include_str!("../plans/room.toml")),
    ("l-shape", include_str!("../plans/l-shape.toml")),
    ("flat", include_str!("../plans/flat.toml")),
    ("corridor-loop", include_str!("../plans/corridor-loop.toml")),
    ("clutter", include_str!("../plans/clutter.toml")),
    ("diagonal", include_str!("../plans/diagonal.toml")),
];

/// Why a plan cannot be used.
#[derive(Clone, Debug, PartialEq)]
pub enum PlanError {
    /// The name is not a built-in plan's and there is no such file either.
    Unknown(String),
    /// The file cannot be read.
    Unreadable {
        /// File.
        file: String,
        /// What the system says.
        reason: String,
    },
    /// The file is no TOML, or has an unknown, missing or mistyped key.
    Syntax {
        /// File.
        file: String,
        /// Where and what, with the line.
        message: String,
    },
    /// A value that cannot be.
    Value {
        /// File.
        file: String,
        /// Key, such as `box[2].min_m`.
        key: String,
        /// What is allowed.
        allowed: &'static str,
    },
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown(name) => {
                let names: Vec<_> = BUILT_IN.iter().map(|(name, _)| *name).collect();
                write!(f, "plan \"{name}\": no such file, and no built-in plan; built in are {}", names.join(", "))
            }
            Self::Unreadable { file, reason } => write!(f, "{file}: cannot be read: {reason}"),
            Self::Syntax { file, message } => write!(f, "{file}: {message}"),
            Self::Value { file, key, allowed } => write!(f, "{file}: {key}: {allowed}"),
        }
    }
}

impl std::error::Error for PlanError {}

/// The plan with this built-in name, or else the plan in the file of this name.
///
/// # Errors
/// Neither exists, or the file is not a plan.
pub fn load(name_or_file: &str) -> Result<Plan, PlanError> {
    if let Some((name, text)) = BUILT_IN.iter().find(|(name, _)| *name == name_or_file) {
        return parse(&format!("built-in plan {name}"), name, text);
    }
    let path = Path::new(name_or_file);
    if !path.exists() {
        return Err(PlanError::Unknown(name_or_file.into()));
    }
    let unreadable = |e: std::io::Error| PlanError::Unreadable { file: name_or_file.into(), reason: e.to_string() };
    let text = std::fs::read_to_string(path).map_err(unreadable)?;
    let stem = path.file_stem().map_or_else(|| name_or_file.into(), |stem| stem.to_string_lossy().into_owned());
    parse(name_or_file, &stem, &text)
}

/// The plan in a TOML text. `file` is what errors call it, `name` the plan's name where the text gives none.
///
/// # Errors
/// The text is no TOML, or a key is unknown, missing, mistyped or impossible.
pub fn parse(file: &str, name: &str, text: &str) -> Result<Plan, PlanError> {
    let parsed: File =
        toml::from_str(text).map_err(|e| PlanError::Syntax { file: file.into(), message: syntax_message(text, &e) })?;
    let check = Check { file };
    check.point("start", [parsed.start.x_m, parsed.start.y_m])?;
    if !parsed.start.heading_deg.is_finite() {
        return check.fail("start.heading_deg".into(), "a finite number of degrees is allowed");
    }
    let mut plan = Plan {
        name: parsed.name.clone().unwrap_or_else(|| name.into()),
        start: TruePose::new(parsed.start.x_m, parsed.start.y_m, parsed.start.heading_deg.to_radians()),
        faces: faces(&check, &parsed)?,
        rounds: Vec::new(),
        rooms: Vec::new(),
        doors: Vec::new(),
        people: Vec::new(),
        cliffs: Vec::new(),
    };
    add_areas(&check, &parsed, &mut plan)?;
    add_moving(&check, &parsed, &mut plan)?;
    if plan.faces.is_empty() && plan.rounds.is_empty() {
        return check.fail("outline".into(), "a plan needs at least one outline, box, wall or round");
    }
    Ok(plan)
}

/// One line: the line number, and what is wrong with it.
fn syntax_message(text: &str, error: &toml::de::Error) -> String {
    let message = error.message().replace('\n', "; ");
    match error.span() {
        Some(span) => {
            let before = &text[..span.start.min(text.len())];
            let line = before.matches('\n').count() + 1;
            let column = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
            format!("line {line}, column {column}: {message}")
        }
        None => message,
    }
}

fn faces(check: &Check, file: &File) -> Result<Vec<Face>, PlanError> {
    let mut faces = Vec::new();
    for (i, outline) in file.outline.iter().enumerate() {
        let key = format!("outline[{i}].points_m");
        if outline.points_m.len() < 3 {
            return check.fail(key, "at least three points are needed");
        }
        let next = outline.points_m.iter().cycle().skip(1);
        for (from_m, to_m) in outline.points_m.iter().zip(next) {
            check.segment(&key, *from_m, *to_m)?;
            faces.push(Face { from_m: *from_m, to_m: *to_m, two_sided: false });
        }
    }
    for (i, cuboid) in file.boxes.iter().enumerate() {
        let key = format!("box[{i}]");
        check.rectangle(&key, cuboid.min_m, cuboid.max_m)?;
        if !cuboid.turn_deg.is_finite() {
            return check.fail(format!("{key}.turn_deg"), "a finite number of degrees is allowed");
        }
        faces.extend(cuboid.faces());
    }
    for (i, wall) in file.wall.iter().enumerate() {
        check.segment(&format!("wall[{i}]"), wall.from_m, wall.to_m)?;
        faces.push(Face { from_m: wall.from_m, to_m: wall.to_m, two_sided: true });
    }
    Ok(faces)
}

impl Cuboid {
    /// The four sides, clockwise, so that each is seen from outside.
    fn faces(&self) -> impl Iterator<Item = Face> {
        let centre_m = [0, 1].map(|axis| 0.5 * (self.min_m[axis] + self.max_m[axis]));
        let half_m = [0, 1].map(|axis| 0.5 * (self.max_m[axis] - self.min_m[axis]));
        let turned = TruePose::new(centre_m[0], centre_m[1], self.turn_deg.to_radians());
        let corners = [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]]
            .map(|[x, y]: [f64; 2]| turned.transform([x * half_m[0], y * half_m[1]]));
        (0..4).map(move |i| Face { from_m: corners[i], to_m: corners[(i + 1) % 4], two_sided: false })
    }
}

fn add_areas(check: &Check, file: &File, plan: &mut Plan) -> Result<(), PlanError> {
    for (i, round) in file.round.iter().enumerate() {
        check.point(&format!("round[{i}].centre_m"), round.centre_m)?;
        check.positive(&format!("round[{i}].radius_m"), round.radius_m)?;
        plan.rounds.push(Round { centre_m: round.centre_m, radius_m: round.radius_m });
    }
    for (i, room) in file.room.iter().enumerate() {
        check.rectangle(&format!("room[{i}]"), room.min_m, room.max_m)?;
        plan.rooms.push(Room { name: room.name.clone(), min_m: room.min_m, max_m: room.max_m });
    }
    for (i, hole) in file.cliff.iter().enumerate() {
        check.rectangle(&format!("cliff[{i}]"), hole.min_m, hole.max_m)?;
        plan.cliffs.push(Cliff { min_m: hole.min_m, max_m: hole.max_m });
    }
    Ok(())
}

fn add_moving(check: &Check, file: &File, plan: &mut Plan) -> Result<(), PlanError> {
    for (i, door) in file.door.iter().enumerate() {
        check.segment(&format!("door[{i}]"), door.from_m, door.to_m)?;
        let opens_at_s = door.opens_at_s.unwrap_or(f64::INFINITY);
        if door.closes_at_s.is_nan() || opens_at_s.is_nan() || opens_at_s <= door.closes_at_s {
            return check.fail(format!("door[{i}].opens_at_s"), "must be later than closes_at_s");
        }
        let door = Door { from_m: door.from_m, to_m: door.to_m, closes_at_s: door.closes_at_s, opens_at_s };
        plan.doors.push(door);
    }
    for (i, person) in file.person.iter().enumerate() {
        check.positive(&format!("person[{i}].radius_m"), person.radius_m)?;
        check.positive(&format!("person[{i}].speed_mps"), person.speed_mps)?;
        if person.path_m.is_empty() {
            return check.fail(format!("person[{i}].path_m"), "at least one point is needed");
        }
        for point_m in &person.path_m {
            check.point(&format!("person[{i}].path_m"), *point_m)?;
        }
        let path_m = person.path_m.clone();
        plan.people.push(Person { radius_m: person.radius_m, speed_mps: person.speed_mps, path_m });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(text: &str) -> String {
        parse("home.toml", "home", text).unwrap_err().to_string()
    }

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
    fn errors_name_file_key_and_what_is_allowed() {
        let cases = [
            (
                format!("{START}[[box]]\nmin_m = [1.0, 1.0]\nmax_m = [0.5, 2.0]"),
                "home.toml: box[0].max_m: both coordinates",
            ),
            (
                format!("{START}[[round]]\ncentre_m = [0.0, 0.0]\nradius_m = -1.0"),
                "round[0].radius_m: a number above 0",
            ),
            (format!("{START}[[outline]]\npoints_m = [[0.0, 0.0], [1.0, 0.0]]"), "outline[0].points_m: at least three"),
            (format!("{START}[[wall]]\nfrom_m = [0.0, 0.0]\nto_m = [0.0, 0.0]"), "wall[0].to_m"),
            (format!("{START}[[wall]]\nfrom_m = [nan, 0.0]\nto_m = [1.0, 0.0]"), "wall[0].from_m: metres between"),
            (format!("{START}[[wal]]\n"), "home.toml: line 4, column 3: unknown field `wal`, expected one of"),
            ("[start]\nx_m = 1.0\n".into(), "missing field `y_m`"),
            ("[start]\nx_m = \"left\"\ny_m = 0.0\n".into(), "line 2, column 7: invalid type: string"),
            (START.into(), "a plan needs at least one"),
            ("[start\n".into(), "line 1"),
        ];
        for (text, expected) in cases {
            let message = error(&text);
            assert!(message.contains(expected) && message.starts_with("home.toml: "), "{message}");
            assert!(!message.contains('\n'), "{message}");
        }
        let unknown = load("no-such-plan").unwrap_err().to_string();
        assert!(unknown.contains("no-such-plan") && unknown.contains("corridor-loop"), "{unknown}");
    }
}
