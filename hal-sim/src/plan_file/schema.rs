//! The keys of a floor plan file.

use serde::Deserialize;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct File {
    pub name: Option<String>,
    pub start: Start,
    #[serde(default)]
    pub outline: Vec<Outline>,
    #[serde(default, rename = "box")]
    pub boxes: Vec<Cuboid>,
    #[serde(default)]
    pub wall: Vec<Wall>,
    #[serde(default)]
    pub round: Vec<RoundThing>,
    #[serde(default)]
    pub room: Vec<RoomArea>,
    #[serde(default)]
    pub door: Vec<DoorLeaf>,
    #[serde(default)]
    pub person: Vec<Walker>,
    #[serde(default)]
    pub cliff: Vec<Hole>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Start {
    pub x_m: f64,
    pub y_m: f64,
    #[serde(default)]
    pub heading_deg: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Outline {
    pub points_m: Vec<[f64; 2]>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Cuboid {
    pub min_m: [f64; 2],
    pub max_m: [f64; 2],
    #[serde(default)]
    pub turn_deg: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Wall {
    pub from_m: [f64; 2],
    pub to_m: [f64; 2],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RoundThing {
    pub centre_m: [f64; 2],
    pub radius_m: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RoomArea {
    pub name: String,
    pub min_m: [f64; 2],
    pub max_m: [f64; 2],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DoorLeaf {
    pub from_m: [f64; 2],
    pub to_m: [f64; 2],
    #[serde(default)]
    pub closes_at_s: f64,
    pub opens_at_s: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Walker {
    #[serde(default = "leg_radius_m")]
    pub radius_m: f64,
    #[serde(default = "walking_speed_mps")]
    pub speed_mps: f64,
    pub path_m: Vec<[f64; 2]>,
}

fn leg_radius_m() -> f64 {
    0.15
}

fn walking_speed_mps() -> f64 {
    0.5
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Hole {
    pub min_m: [f64; 2],
    pub max_m: [f64; 2],
}
