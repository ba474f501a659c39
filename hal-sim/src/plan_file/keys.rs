//! The keys of a floor plan file.

use input_file::{Allowed, Finite, Limits, Number};
use serde::Deserialize;

use crate::plan::Battery;

/// A point of the plan.
pub(super) type Point = [Number<Coordinate>; 2];

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
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
    #[serde(default)]
    pub kidnap: Vec<Carry>,
    #[serde(default)]
    pub kick: Vec<Push>,
    #[serde(default)]
    pub rug: Vec<Carpet>,
    #[serde(default)]
    pub sill: Vec<Edge>,
    #[serde(default)]
    pub hold: Vec<Grip>,
    #[serde(default)]
    pub fault: Vec<Failure>,
    #[serde(default)]
    pub keep_out: Vec<Outline>,
    #[serde(default)]
    pub clean: Vec<Outline>,
    pub battery: Option<Cells>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct Start {
    pub x_m: Number<Coordinate>,
    pub y_m: Number<Coordinate>,
    pub heading_deg: Option<Number<Finite>>,
    pub dock: Option<bool>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct Cells {
    pub charge: Option<Number<Share>>,
    pub lasts_min: Number<Minutes>,
    pub charges_min: Number<Minutes>,
}

impl Cells {
    /// The battery; full where the file does not say how full.
    pub(super) fn battery(&self) -> Battery {
        let charge = self.charge.as_ref().map_or(1.0, Number::get);
        Battery { charge, lasts_min: self.lasts_min.get(), charges_min: self.charges_min.get() }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct Outline {
    pub points_m: Vec<Point>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct Cuboid {
    pub min_m: Point,
    pub max_m: Point,
    pub turn_deg: Option<Number<Finite>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct Wall {
    pub from_m: Point,
    pub to_m: Point,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct RoundThing {
    pub centre_m: Point,
    pub radius_m: Number<Size>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct RoomArea {
    pub name: String,
    pub min_m: Point,
    pub max_m: Point,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct DoorLeaf {
    pub from_m: Point,
    pub to_m: Point,
    pub closes_at_s: Option<Number<Finite>>,
    /// May be infinite: never.
    pub opens_at_s: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct Walker {
    pub radius_m: Option<Number<Size>>,
    pub speed_mps: Option<Number<Size>>,
    pub path_m: Vec<Point>,
    #[serde(default)]
    pub gives_way: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct Hole {
    pub min_m: Point,
    pub max_m: Point,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct Carry {
    pub at_s: Number<Time>,
    pub carried_s: Option<Number<Size>>,
    pub to_m: Option<Point>,
    pub heading_deg: Option<Number<Finite>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct Push {
    pub at_s: Number<Time>,
    pub slide_m: Option<Number<Slide>>,
    pub turn_deg: Option<Number<Finite>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct Carpet {
    pub min_m: Point,
    pub max_m: Point,
    pub turn_deg: Option<Number<Finite>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct Grip {
    pub at_s: Number<Time>,
    pub held_s: Number<Size>,
    #[serde(default)]
    pub jammed: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct Edge {
    pub min_m: Point,
    pub max_m: Point,
    pub hangs_s: Option<Number<Size>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub(super) struct Failure {
    pub part: String,
    pub at_s: Option<Number<Time>>,
    pub lasts_s: Option<Number<Size>>,
    pub sensor: Option<u8>,
    pub shows_m: Option<Number<Size>>,
}

/// A moment, seconds since the start.
pub(super) struct Time;

impl Limits for Time {
    const ALLOWED: Allowed = Allowed::within(0.0, 1e6, "seconds from 0 to 1000000");
}

/// How long a battery lasts, or takes to be full, minutes.
pub(super) struct Minutes;

impl Limits for Minutes {
    const ALLOWED: Allowed =
        Allowed { above_min: true, ..Allowed::within(0.0, 1e5, "minutes above 0 and up to 100000") };
}

/// How full a battery is.
pub(super) struct Share;

impl Limits for Share {
    const ALLOWED: Allowed = Allowed::within(0.0, 1.0, "a share from 0 to 1");
}

/// How far a kick moves the robot, metres.
pub(super) struct Slide;

impl Limits for Slide {
    const ALLOWED: Allowed = Allowed::within(0.0, 10.0, "metres from 0 to 10");
}

/// A coordinate in the plan's frame, metres.
pub(super) struct Coordinate;

impl Limits for Coordinate {
    const ALLOWED: Allowed = Allowed::within(-1000.0, 1000.0, "metres from -1000 to 1000");
}

/// A radius in metres, or a speed in m/s.
pub(super) struct Size;

impl Limits for Size {
    const ALLOWED: Allowed =
        Allowed { above_min: true, ..Allowed::within(0.0, 1000.0, "a number above 0 and up to 1000") };
}
