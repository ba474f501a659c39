//! What befalls the robot, from a floor plan's keys.

use input_file::{FileError, Number, TomlFile};

use super::keys::{Failure, File, Grip};
use super::{metres, rectangle};
use crate::fault::{Fault, Part};
use crate::mishap::{HANGS_S, Hold, Kick, Kidnap, Mishaps, Rug, Sill};
use crate::pose::Pose2;

/// How long a kidnapped robot is off the floor where the file does not say, seconds.
const CARRIED_S: f64 = 5.0;

/// A kick where the file does not say: metres and degrees.
const KICK: (f64, f64) = (0.10, 15.0);

/// How far a rug turns the robot where the file does not say, degrees.
const RUG_DEG: f64 = 9.0;

pub(super) fn mishaps(toml: &TomlFile<'_>, file: &File) -> Result<Mishaps, FileError> {
    let mut mishaps = Mishaps::default();
    for (i, carry) in file.kidnap.iter().enumerate() {
        let to = carry.to_m.as_ref().map(|to| {
            let [x_m, y_m] = metres(to);
            Pose2::new(x_m, y_m, carry.heading_deg.as_ref().map_or(0.0, Number::get).to_radians())
        });
        if to.is_none() && carry.heading_deg.is_some() {
            return Err(toml.error(&format!("kidnap[{i}].heading_deg"), "has a meaning with to_m only; name that, too"));
        }
        if to.is_none() && file.room.is_empty() {
            let what = "is missing; only where the plan has a [[room]] can the place be drawn";
            return Err(toml.error(&format!("kidnap[{i}].to_m"), what));
        }
        let carried_s = carry.carried_s.as_ref().map_or(CARRIED_S, Number::get);
        mishaps.kidnaps.push(Kidnap { at_s: carry.at_s.get(), carried_s, to });
    }
    mishaps.kicks = file
        .kick
        .iter()
        .map(|push| Kick {
            at_s: push.at_s.get(),
            slide_m: push.slide_m.as_ref().map_or(KICK.0, Number::get),
            turn_rad: push.turn_deg.as_ref().map_or(KICK.1, Number::get).to_radians(),
        })
        .collect();
    for (i, carpet) in file.rug.iter().enumerate() {
        let [min_m, max_m] = rectangle(toml, &format!("rug[{i}]"), &carpet.min_m, &carpet.max_m)?;
        let turn_rad = carpet.turn_deg.as_ref().map_or(RUG_DEG, Number::get).to_radians();
        mishaps.rugs.push(Rug { min_m, max_m, turn_rad });
    }
    let hold = |grip: &Grip| Hold { is_jammed: grip.jammed, at_s: grip.at_s.get(), held_s: grip.held_s.get() };
    mishaps.holds = file.hold.iter().map(hold).collect();
    for (i, edge) in file.sill.iter().enumerate() {
        let [min_m, max_m] = rectangle(toml, &format!("sill[{i}]"), &edge.min_m, &edge.max_m)?;
        mishaps.sills.push(Sill { min_m, max_m, hangs_s: edge.hangs_s.as_ref().map_or(HANGS_S, Number::get) });
    }
    mishaps.faults =
        file.fault.iter().enumerate().map(|(i, failure)| fault(toml, i, failure)).collect::<Result<_, _>>()?;
    Ok(mishaps)
}

fn fault(toml: &TomlFile<'_>, i: usize, failure: &Failure) -> Result<Fault, FileError> {
    let Failure { part, at_s, lasts_s, sensor, shows_m } = failure;
    let error = |key: &str, what: &str| Err(toml.error(&format!("fault[{i}].{key}"), what));
    let part = match (part.as_str(), sensor) {
        ("sensor", None) => return error("sensor", "is missing; it must be the sensor's place in the rig, from 0"),
        ("sensor", Some(index)) => Part::Sensor { index: (*index).into(), shows_m: shows_m.as_ref().map(Number::get) },
        (_, Some(_)) => return error("sensor", "has a meaning with part = \"sensor\" only"),
        _ if shows_m.is_some() => return error("shows_m", "has a meaning with part = \"sensor\" only"),
        ("bump-left", _) => Part::BumpLeft,
        ("bump-right", _) => Part::BumpRight,
        ("cliff", _) => Part::Cliff,
        _ => return error("part", "must be \"bump-left\", \"bump-right\", \"cliff\" or \"sensor\""),
    };
    let lasts_s = lasts_s.as_ref().map_or(f64::INFINITY, Number::get);
    Ok(Fault { part, at_s: at_s.as_ref().map_or(0.0, Number::get), lasts_s })
}
