//! What was seen from each keyframe: every reading that ended on something, and on which wall of the end the filter had it.

use std::collections::{BTreeMap, BTreeSet};

use slam_core::{BUILT_RELIEF_M, Outcome, RangeModel, RangeSensor, ReadingReport, Rig, SURFACE_M, WallView};

use super::keyframes::Keyframes;
use super::parts::Parts;
use crate::input::rig_file::MAX_SENSORS;
use crate::recording::{MapSnapshot, Pose2, Recording, wrap};

/// Of so many readings of a sensor that reports metres, which say the same, one is one: as the estimator finds on real logs,
/// three to five. An analogue sensor's noise is new each time.
const ALIKE: f64 = 4.0;

/// Two readings of a sensor in a row that differ by less than this share are of one surface.
const SAME_SURFACE: f64 = 0.25;

/// One reading, in its keyframe's frame, and on which wall it is.
#[derive(Clone, Copy, Debug)]
pub struct Sighting {
    /// The keyframe.
    pub key: usize,
    /// The wall; none where it is on something else.
    pub wall: Option<usize>,
    /// Where its beam began, metres.
    pub from_m: [f64; 2],
    /// Where it ended, metres.
    pub end_m: [f64; 2],
    /// Least cosine of the incidence at which its sensor sees a wall.
    pub min_cos: f64,
    /// How sure its end is.
    pub noise: Noise,
}

/// A reading's standard deviation, metres, and of how many it is one.
#[derive(Clone, Copy, Debug)]
pub struct Noise {
    /// 1-sigma, metres.
    pub sigma_m: f64,
    /// Of so many that say the same it is one.
    pub alike: f64,
}

impl Noise {
    /// Of a reading where this range was to be read.
    pub fn of(sensor: &RangeSensor, range_m: f64) -> Self {
        match sensor.model {
            RangeModel::Metric { noise_m, noise_rel } => {
                let own_m = f64::from(noise_m).hypot(f64::from(noise_rel) * range_m);
                Self { sigma_m: own_m.hypot(BUILT_RELIEF_M.into()), alike: ALIKE }
            }
            RangeModel::Sharp { scale_m, exponent, noise_v } => {
                let volts = (range_m / f64::from(scale_m)).powf(1.0 / f64::from(exponent));
                let own_m = f64::from(exponent) * range_m / volts * f64::from(noise_v);
                Self { sigma_m: own_m.hypot(SURFACE_M.into()), alike: 1.0 }
            }
        }
    }
}

/// Where noise is told: what each sensor read so far.
#[derive(Clone, Debug, Default)]
pub struct Expected {
    last_m: [Option<f64>; MAX_SENSORS],
}

impl Expected {
    /// Takes in the next reading of a sensor: the range at which its noise is told, metres; none where it has no range.
    ///
    /// That of an analogue one must not depend on the reading itself: those that came out short would count for more than those that
    /// came out long, and every wall would be pulled towards the robot. So it is what the filter expected; where that expected nothing,
    /// what the sensor read last on what seems to be the same surface.
    pub fn range_m(&mut self, number: usize, sensor: &RangeSensor, reading: &ReadingReport) -> Option<f64> {
        let range_m = f64::from(reading.range_m?);
        let last_m = self.last_m.get_mut(number)?.replace(range_m);
        let RangeModel::Sharp { .. } = sensor.model else { return Some(range_m) };
        Some(match (reading.outcome, last_m) {
            (Outcome::Updated { innovation_m, .. }, _) if range_m > f64::from(innovation_m) => {
                range_m - f64::from(innovation_m)
            }
            (_, Some(last_m)) if (last_m - range_m).abs() < SAME_SURFACE * last_m => last_m,
            _ => range_m,
        })
    }
}

/// Whether of a surface at this range only the readings of an analogue sensor that come out short are any: they would draw it near.
fn is_cut_off(sensor: &RangeSensor, range_m: f64) -> bool {
    let is_analogue = matches!(sensor.model, RangeModel::Sharp { .. });
    is_analogue && range_m + 2.0 * Noise::of(sensor, range_m).sigma_m > f64::from(sensor.max_m)
}

/// A reading that ended somewhere.
#[derive(Clone, Copy, Debug)]
pub struct End {
    /// Its step.
    pub step: usize,
    /// Its sensor.
    pub sensor: usize,
    /// The wall that the filter used it for, by the identifier that this has in the end.
    pub wall: Option<u16>,
    /// Where, in the map frame of the moment, metres.
    pub at_m: [f64; 2],
    /// The range at which its noise is told, metres.
    pub about_m: f64,
}

impl Sighting {
    /// None where the rig has no such sensor.
    pub fn of(
        recording: &Recording,
        rig: &Rig<MAX_SENSORS>,
        keyframes: &Keyframes,
        end: &End,
        wall: Option<usize>,
    ) -> Option<Self> {
        let sensor = rig.sensors.get(end.sensor)?;
        let from_robot = recording.steps[end.step].pose.relative(&Pose2::new(end.at_m[0], end.at_m[1], 0.0));
        let robot = keyframes.local(recording, end.step);
        Some(Self {
            key: keyframes.before(end.step),
            wall,
            from_m: robot.transform([sensor.mount.x_m.into(), sensor.mount.y_m.into()]),
            end_m: robot.transform([from_robot.x_m, from_robot.y_m]),
            min_cos: f64::from(sensor.max_incidence_rad).cos(),
            noise: Noise::of(sensor, end.about_m),
        })
    }
}

/// Every reading that ended somewhere.
pub fn ended_on(recording: &Recording, rig: &Rig<MAX_SENSORS>, parts: &Parts) -> Vec<End> {
    let became = mergers(&recording.maps, parts);
    // Identifiers come again after 65,536 births: then a chain of mergers may have no end.
    let chain = |id: u16| std::iter::successors(Some(id), |id| became.get(id).copied()).take(became.len() + 1);
    let root = |id: u16| chain(id).last().unwrap_or(id);
    let (mut ends, mut expected) = (Vec::new(), Expected::default());
    for step in 0..recording.steps.len() {
        for (number, (sensor, reading)) in rig.sensors.iter().zip(recording.readings(step)).enumerate() {
            let about_m = expected.range_m(number, sensor, reading);
            let wall = match reading.outcome {
                Outcome::Updated { wall, .. } => Some(root(wall)),
                Outcome::Gated { .. } | Outcome::Unexplained => None,
                Outcome::Missing | Outcome::Refused(_) => continue,
            };
            let hit_m = reading.hit_m.filter(|hit_m| hit_m.iter().all(|metres| metres.is_finite()));
            let Some((hit_m, about_m)) = hit_m.zip(about_m) else { continue };
            if wall.is_some() || !is_cut_off(sensor, about_m) {
                ends.push(End { step, sensor: number, wall, at_m: hit_m.map(f64::from), about_m });
            }
        }
    }
    ends
}

/// Which wall each merged one became part of: one beside it that has its readings from then on.
fn mergers(maps: &[MapSnapshot], parts: &Parts) -> BTreeMap<u16, u16> {
    let mut became = BTreeMap::new();
    for pair in maps.windows(2) {
        let [before, after] = pair else { continue };
        if parts.at(before.step) != parts.at(after.step) {
            continue;
        }
        let ids: BTreeSet<u16> = after.walls.iter().map(|wall| wall.id).collect();
        for gone in before.walls.iter().filter(|wall| !ids.contains(&wall.id)) {
            let grown = |wall: &&WallView| {
                let had = before.walls.iter().find(|old| old.id == wall.id).map_or(0, |old| old.updates);
                let covers = wall.lo_m - 0.1 < gone.lo_m && wall.hi_m + 0.1 > gone.hi_m;
                let turned = wrap(f64::from(wall.beta_rad - gone.beta_rad));
                turned.abs() < 0.15 && covers && wall.updates >= had + gone.updates
            };
            let nearest = |a: &&WallView, b: &&WallView| {
                let off = |wall: &WallView| (wall.rho_m - gone.rho_m).abs();
                off(a).total_cmp(&off(b))
            };
            if let Some(kept) = after.walls.iter().filter(grown).min_by(nearest) {
                became.insert(gone.id, kept.id);
            }
        }
    }
    became
}
