//! Floor plans as TOML: the built-in ones and the user's own. The format is described in `docs/reference/plans.md`.

mod bounds;
mod keys;
mod mishaps;

use std::path::Path;

use input_file::{FileError, Number, TomlFile};

use crate::inside::{crossing_edges, edges, encloses};
use crate::plan::{Cliff, Door, Face, Person, Plan, Room, Round};
use crate::pose::Pose2;
use crate::random_home::{large_home, random_home};
use keys::{Cells, Cuboid, File, Outline, Point};

/// The built-in plans: name and text.
pub const BUILT_IN: [(&str, &str); 6] = [
    ("room", include_str!("../plans/room.toml")),
    ("l-shape", include_str!("../plans/l-shape.toml")),
    ("flat", include_str!("../plans/flat.toml")),
    ("corridor-loop", include_str!("../plans/corridor-loop.toml")),
    ("clutter", include_str!("../plans/clutter.toml")),
    ("diagonal", include_str!("../plans/diagonal.toml")),
];

/// Shortest straight piece, metres.
const SHORTEST_M: f64 = 1e-3;

/// Radius of a person's legs where the file names none, metres.
const LEG_RADIUS_M: f64 = 0.15;

/// Speed of a person where the file names none, m/s.
const WALKING_MPS: f64 = 0.5;

/// Whether a plan of this name is one of the program's own, so that there is no file to read.
pub fn is_built_in(name: &str) -> bool {
    BUILT_IN.iter().any(|(own, _)| *own == name) || drawn(name).is_some()
}

/// The home that is drawn at random where it has such a name.
fn drawn(name: &str) -> Option<Plan> {
    let (kind, seed) = name.split_once('-')?;
    let draw = match kind {
        "random" => random_home,
        "large" => large_home,
        _ => return None,
    };
    Some(draw(seed.parse().ok()?))
}

/// The plan with this built-in name, the home drawn at random `random-SEED` or `large-SEED`, or else the plan in the file of this name.
///
/// # Errors
/// Neither exists, or the file is not a plan.
pub fn load(name_or_file: &str) -> Result<Plan, FileError> {
    if let Some((name, text)) = BUILT_IN.iter().find(|(name, _)| *name == name_or_file) {
        return parse(&format!("built-in plan {name}"), name, text);
    }
    if let Some(plan) = drawn(name_or_file) {
        return Ok(plan);
    }
    let path = Path::new(name_or_file);
    if !path.exists() {
        let names = BUILT_IN.map(|(name, _)| name).join(", ");
        return Err(FileError::new(
            path,
            format!("is neither a file nor a built-in plan; built in are {names}, random-SEED and large-SEED"),
        ));
    }
    let text = input_file::read(path)?;
    let stem = path.file_stem().map_or_else(|| name_or_file.into(), |stem| stem.to_string_lossy().into_owned());
    parse(name_or_file, &stem, &text)
}

/// The plan in a TOML text. `file` is what errors call it, `name` the plan's name where the text gives none.
///
/// # Errors
/// The text is no TOML, or a key is unknown, missing, mistyped or impossible.
pub fn parse(file: &str, name: &str, text: &str) -> Result<Plan, FileError> {
    let toml = TomlFile::new(Path::new(file), text);
    let keys: File = toml.read()?;
    let heading_deg = keys.start.heading_deg.as_ref().map_or(0.0, Number::get);
    let mut plan = Plan {
        name: keys.name.clone().unwrap_or_else(|| name.into()),
        start: Pose2::new(keys.start.x_m.get(), keys.start.y_m.get(), heading_deg.to_radians()),
        has_dock: keys.start.dock.unwrap_or(false),
        battery: keys.battery.as_ref().map(Cells::battery),
        faces: faces(&toml, &keys)?,
        rounds: Vec::new(),
        rooms: Vec::new(),
        doors: Vec::new(),
        people: Vec::new(),
        cliffs: Vec::new(),
        mishaps: mishaps::mishaps(&toml, &keys)?,
        bounds: bounds::bounds(&toml, &keys)?,
    };
    add_areas(&toml, &keys, &mut plan)?;
    add_moving(&toml, &keys, &mut plan)?;
    check_places(&toml, &plan)?;
    bounds::check(&toml, &plan)?;
    if plan.faces.is_empty() && plan.rounds.is_empty() {
        return Err(toml.error("outline", "is missing; a plan needs at least one outline, box, wall or round"));
    }
    check_size(&plan).map_err(|what| toml.error("outline", &what))?;
    Ok(plan)
}

/// A home is no larger than this, square metres: its floor is counted in squares of 2.5 cm.
const LARGEST_M2: f64 = 40_000.0;

fn check_size(plan: &Plan) -> Result<(), String> {
    let [width_m, depth_m] = [0, 1].map(|axis| {
        let ends_m = plan.faces.iter().flat_map(|face| [face.from_m[axis], face.to_m[axis]]);
        let [low_m, high_m] =
            ends_m.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], end| [low.min(end), high.max(end)]);
        high_m - low_m
    });
    if width_m * depth_m > LARGEST_M2 {
        let what = format!(
            "makes a home of {width_m} by {depth_m} m; it must be {LARGEST_M2} m2 at most, and numbers are metres"
        );
        return Err(what);
    }
    Ok(())
}

/// The robot starts within an outline, where there is one, and not in a box; so does one that is put down somewhere.
fn check_places(toml: &TomlFile<'_>, plan: &Plan) -> Result<(), FileError> {
    let put_down = plan.mishaps.kidnaps.iter().enumerate();
    let put_down = put_down.filter_map(|(i, kidnap)| Some((format!("kidnap[{i}].to_m"), kidnap.to?)));
    for (place, pose) in std::iter::once(("start".to_owned(), plan.start)).chain(put_down) {
        if !plan.is_inside([pose.x_m, pose.y_m]) {
            return Err(toml.error(&place, OUTSIDE));
        }
    }
    Ok(())
}

/// Why a robot cannot be at a place.
const OUTSIDE: &str = "is outside the outline or in a box; the robot must be inside, where it can drive";

impl Plan {
    /// Checks that a robot can start at a place, as the plan's own start is checked.
    ///
    /// # Errors
    /// Why not, to be put after the place's name.
    pub fn check_start(&self, start: &Pose2) -> Result<(), String> {
        if !self.is_inside([start.x_m, start.y_m]) {
            return Err(OUTSIDE.to_owned());
        }
        bounds::check_start(self, start)
    }
}

/// Twice the area within a closed line, m^2: positive where it runs counter-clockwise.
fn twice_area_m2(points_m: &[[f64; 2]]) -> f64 {
    edges(points_m).map(|([ax, ay], [bx, by])| ax * by - bx * ay).sum()
}

fn metres(point: &Point) -> [f64; 2] {
    [point[0].get(), point[1].get()]
}

/// Both corners of a rectangle, metres.
fn rectangle(toml: &TomlFile<'_>, place: &str, min: &Point, max: &Point) -> Result<[[f64; 2]; 2], FileError> {
    let (min_m, max_m) = (metres(min), metres(max));
    if min_m[0] < max_m[0] && min_m[1] < max_m[1] {
        Ok([min_m, max_m])
    } else {
        Err(toml.error(&format!("{place}.max_m"), "both coordinates must be larger than min_m's"))
    }
}

/// Both ends of a straight piece, metres.
fn segment(toml: &TomlFile<'_>, place: &str, from: &Point, to: &Point) -> Result<[[f64; 2]; 2], FileError> {
    let (from_m, to_m) = (metres(from), metres(to));
    if libm::hypot(to_m[0] - from_m[0], to_m[1] - from_m[1]) > SHORTEST_M {
        Ok([from_m, to_m])
    } else {
        Err(toml.error(&format!("{place}.to_m"), "must be at least 1 mm from from_m"))
    }
}

/// The points of a closed line, metres.
fn closed_line(toml: &TomlFile<'_>, place: &str, line: &Outline) -> Result<Vec<[f64; 2]>, FileError> {
    let points_m: Vec<[f64; 2]> = line.points_m.iter().map(metres).collect();
    if points_m.len() < 3 {
        return Err(toml.error(place, "at least three points are needed"));
    }
    let length_m = |(from_m, to_m): ([f64; 2], [f64; 2])| libm::hypot(to_m[0] - from_m[0], to_m[1] - from_m[1]);
    if let Some(j) = edges(&points_m).position(|edge| length_m(edge) <= SHORTEST_M) {
        return Err(toml.error(&format!("{place}[{j}]"), "must be at least 1 mm from the next point"));
    }
    if let Some((i, j)) = crossing_edges(&points_m) {
        let what = format!(
            "crosses itself: the line from point {} and that from point {}; the corners must be in order, each side apart from the others",
            i + 1,
            j + 1
        );
        return Err(toml.error(place, &what));
    }
    Ok(points_m)
}

fn faces(toml: &TomlFile<'_>, file: &File) -> Result<Vec<Face>, FileError> {
    let mut faces = Vec::new();
    for points_m in outlines(toml, file)? {
        faces.extend(edges(&points_m).map(|(from_m, to_m)| Face { from_m, to_m, two_sided: false }));
    }
    for (i, cuboid) in file.boxes.iter().enumerate() {
        let corners_m = rectangle(toml, &format!("box[{i}]"), &cuboid.min_m, &cuboid.max_m)?;
        faces.extend(cuboid.faces(corners_m));
    }
    for (i, wall) in file.wall.iter().enumerate() {
        let [from_m, to_m] = segment(toml, &format!("wall[{i}]"), &wall.from_m, &wall.to_m)?;
        faces.push(Face { from_m, to_m, two_sided: true });
    }
    Ok(faces)
}

/// The outlines. One that runs clockwise is seen from outside: a pillar. Where the robot starts in it, and in no other, it is the home.
fn outlines(toml: &TomlFile<'_>, file: &File) -> Result<Vec<Vec<[f64; 2]>>, FileError> {
    let line = |(i, outline): (usize, &Outline)| closed_line(toml, &format!("outline[{i}].points_m"), outline);
    let mut outlines: Vec<Vec<[f64; 2]>> = file.outline.iter().enumerate().map(line).collect::<Result<_, _>>()?;
    let start_m = [file.start.x_m.get(), file.start.y_m.get()];
    let is_home = |points_m: &Vec<[f64; 2]>| twice_area_m2(points_m) > 0.0 && encloses(points_m, start_m);
    if !outlines.iter().any(is_home) {
        outlines.iter_mut().filter(|points_m| encloses(points_m, start_m)).for_each(|points_m| points_m.reverse());
    }
    Ok(outlines)
}

impl Cuboid {
    /// The four sides, clockwise, so that each is seen from outside.
    fn faces(&self, [min_m, max_m]: [[f64; 2]; 2]) -> impl Iterator<Item = Face> {
        let centre_m = [0, 1].map(|axis| 0.5 * (min_m[axis] + max_m[axis]));
        let half_m = [0, 1].map(|axis| 0.5 * (max_m[axis] - min_m[axis]));
        let turn_deg = self.turn_deg.as_ref().map_or(0.0, Number::get);
        let turned = Pose2::new(centre_m[0], centre_m[1], turn_deg.to_radians());
        let corners = [[-1.0, -1.0], [-1.0, 1.0], [1.0, 1.0], [1.0, -1.0]]
            .map(|[x, y]: [f64; 2]| turned.transform([x * half_m[0], y * half_m[1]]));
        (0..4).map(move |i| Face { from_m: corners[i], to_m: corners[(i + 1) % 4], two_sided: false })
    }
}

fn add_areas(toml: &TomlFile<'_>, file: &File, plan: &mut Plan) -> Result<(), FileError> {
    for round in &file.round {
        plan.rounds.push(Round { centre_m: metres(&round.centre_m), radius_m: round.radius_m.get() });
    }
    for (i, room) in file.room.iter().enumerate() {
        let [min_m, max_m] = rectangle(toml, &format!("room[{i}]"), &room.min_m, &room.max_m)?;
        plan.rooms.push(Room { name: room.name.clone(), min_m, max_m });
    }
    for (i, hole) in file.cliff.iter().enumerate() {
        let [min_m, max_m] = rectangle(toml, &format!("cliff[{i}]"), &hole.min_m, &hole.max_m)?;
        plan.cliffs.push(Cliff { min_m, max_m });
    }
    Ok(())
}

fn add_moving(toml: &TomlFile<'_>, file: &File, plan: &mut Plan) -> Result<(), FileError> {
    for (i, door) in file.door.iter().enumerate() {
        let [from_m, to_m] = segment(toml, &format!("door[{i}]"), &door.from_m, &door.to_m)?;
        let closes_at_s = door.closes_at_s.as_ref().map_or(0.0, Number::get);
        let opens_at_s = door.opens_at_s.unwrap_or(f64::INFINITY);
        if opens_at_s.is_nan() || opens_at_s <= closes_at_s {
            return Err(toml.error(&format!("door[{i}].opens_at_s"), "must be later than closes_at_s"));
        }
        plan.doors.push(Door { from_m, to_m, closes_at_s, opens_at_s });
    }
    for (i, person) in file.person.iter().enumerate() {
        let path_m: Vec<[f64; 2]> = person.path_m.iter().map(metres).collect();
        if path_m.is_empty() {
            return Err(toml.error(&format!("person[{i}].path_m"), "at least one point is needed"));
        }
        plan.people.push(Person {
            radius_m: person.radius_m.as_ref().map_or(LEG_RADIUS_M, Number::get),
            speed_mps: person.speed_mps.as_ref().map_or(WALKING_MPS, Number::get),
            gives_way: person.gives_way,
            path_m,
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests;
