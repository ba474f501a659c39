//! What is found from samples: pure functions.

use slam_core::{DriveModel, RangeModel};
use wire::{Contacts, Range, Sample};

use lab::input::rig_file::Robot;

/// What is fine about a part, or what is wrong and what would put it right.
pub type Finding = Result<String, String>;

/// Counts by which an output must rise when something is held in front of the sensor.
const RISE_COUNTS: f32 = 300.0;
/// Metres by which a reported range must fall then.
const FALL_M: f32 = 0.4;
/// Largest share by which a held board's range may be off.
const RANGE_SHARE: f32 = 0.25;
/// Largest share by which a pushed distance may be off.
const SCALE_SHARE: f32 = 0.1;
/// Fewest ticks that count as a turn of a wheel.
const TURN_TICKS: i32 = 50;

/// One contact input.
#[derive(Clone, Copy)]
pub struct Contact {
    /// Its name.
    pub name: &'static str,
    /// What the person does.
    pub what: &'static str,
    pressed: Contacts,
}

impl Contact {
    fn is_on(&self, contacts: Contacts) -> bool {
        let is = |input: fn(&Contacts) -> bool| input(&self.pressed) && input(&contacts);
        is(|c| c.bump_left) || is(|c| c.bump_right) || is(|c| c.cliff) || is(|c| c.lifted) || is(|c| c.docked)
    }
}

const NONE: Contacts = Contacts { bump_left: false, bump_right: false, cliff: false, lifted: false, docked: false };

/// Every contact input.
pub const CONTACTS: [Contact; 5] = [
    Contact {
        name: "left bumper",
        what: "Press the left half of the bumper",
        pressed: Contacts { bump_left: true, ..NONE },
    },
    Contact {
        name: "right bumper",
        what: "Press the right half of the bumper",
        pressed: Contacts { bump_right: true, ..NONE },
    },
    Contact {
        name: "cliff sensor",
        what: "Take the white card from under the cliff sensor",
        pressed: Contacts { cliff: true, ..NONE },
    },
    Contact { name: "wheel drop", what: "Let go of a wheel-drop switch", pressed: Contacts { lifted: true, ..NONE } },
    Contact {
        name: "charging contact",
        what: "Bridge the charging contact, PC3 to ground,",
        pressed: Contacts { docked: true, ..NONE },
    },
];

/// A board at `held_m` in front of sensor `index`: does this one answer, and with about that range?
pub fn sensor(index: usize, robot: &Robot, held_m: f32, free: &[Sample], held: &[Sample]) -> Finding {
    let answers: Vec<f32> = (0..robot.names.len()).map(|i| answer(i, robot, free, held)).collect();
    let (most, answer) = answers.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).ok_or("no sensors")?;
    if answer < 1.0 {
        return Err("no output changed: check its supply, its output's wire and the board's distance".into());
    }
    if most != index {
        return Err(format!("sensor {most}, {}, answered instead: swap their wires", robot.names[most]));
    }
    let (range_m, shown) = match (robot.rig.sensors[index].model, robot.rig.adc) {
        (RangeModel::Sharp { scale_m, exponent, .. }, Some(adc)) => {
            let volts = median(index, held, counts).unwrap_or(0.0) / adc.full_scale() as f32 * adc.vref_v;
            (scale_m * volts.powf(exponent), format!("{volts:.2} V"))
        }
        _ => (median(index, held, metres).unwrap_or(f32::NAN), "as it reports".to_owned()),
    };
    if (range_m / held_m - 1.0).abs() > RANGE_SHARE {
        return Err(format!(
            "{range_m:.2} m, {shown}, instead of {held_m} m: check its kind, its place and the reference voltage"
        ));
    }
    Ok(format!("{range_m:.2} m, {shown}"))
}

/// How clearly a sensor answers to what is held in front of it: 1 is clear enough.
fn answer(sensor: usize, robot: &Robot, free: &[Sample], held: &[Sample]) -> f32 {
    let Some(part) = robot.rig.sensors.get(sensor) else { return 0.0 };
    match part.model {
        RangeModel::Sharp { .. } => {
            let [free, held] = [free, held].map(|samples| median(sensor, samples, counts).unwrap_or(0.0));
            (held - free) / RISE_COUNTS
        }
        // Where nothing is in range there is no reading.
        RangeModel::Metric { .. } => {
            let [free, held] = [free, held].map(|samples| median(sensor, samples, metres).unwrap_or(part.max_m));
            (free - held) / FALL_M
        }
    }
}

/// Does this input, and no other, change when it is pressed?
pub fn contact(contact: &Contact, before: &[Sample], pressed: &[Sample]) -> Finding {
    let (Some(before), Some(pressed)) = (before.last(), pressed.last()) else { return Err("no samples".into()) };
    let all_on = |contacts: Contacts| CONTACTS.map(|contact| contact.is_on(contacts));
    let (was, is) = (all_on(before.contacts), all_on(pressed.contacts));
    let changed: Vec<_> = CONTACTS.iter().zip(was.iter().zip(is)).filter(|(_, (was, is))| *was != is).collect();
    match changed[..] {
        [(one, (false, true))] if one.name == contact.name => Ok("it answers".into()),
        [] if contact.is_on(before.contacts) => Err("it is on all the time: its cable is cut, or it is stuck".into()),
        [] => Err("it does not answer: check its wire".into()),
        _ => {
            let names: Vec<&str> = changed.iter().map(|(contact, _)| contact.name).collect();
            Err(format!("what changed is {}: swap wires, or one is reversed", names.join(", ")))
        }
    }
}

/// The contacts that keep the robot from turning its wheels forward; none where it may.
pub fn blocking(samples: &[Sample]) -> Option<String> {
    let contacts = samples.last()?.contacts;
    let on = CONTACTS.iter().filter(|contact| !contact.pressed.docked && contact.is_on(contacts));
    let names: Vec<&str> = on.map(|contact| contact.name).collect();
    (!names.is_empty()).then(|| names.join(", "))
}

/// Did this wheel (0 left, 1 right), and no other, count forward?
pub fn turned(wheel: usize, before: &[Sample], after: &[Sample]) -> Finding {
    let ticks = travelled(before, after)?;
    let (this, other) = (ticks[wheel], ticks[1 - wheel]);
    if this.abs() < TURN_TICKS && other.abs() >= TURN_TICKS {
        return Err(format!("the other encoder counted {other}: left and right are swapped"));
    }
    if this.abs() < TURN_TICKS {
        return Err(format!("{this} ticks: it does not turn or its encoder does not count"));
    }
    if this < 0 {
        return Err(format!("{this} ticks: it counts backward; swap its channels A and B, or the motor's wires"));
    }
    Ok(format!("{this} ticks"))
}

/// Did both encoders count what the robot was pushed?
pub fn scale(robot: &Robot, pushed_m: f32, before: &[Sample], after: &[Sample]) -> Finding {
    let DriveModel::Wheels { metres_per_tick, .. } = robot.rig.drive else { return Ok("no encoders".into()) };
    let metres = travelled(before, after)?.map(|ticks| ticks as f32 * metres_per_tick);
    match metres.iter().find(|metres| (*metres / pushed_m - 1.0).abs() > SCALE_SHARE) {
        Some(_) => Err(format!(
            "left {:.3} m, right {:.3} m instead of {pushed_m} m: metres_per_tick of {metres_per_tick} does not fit",
            metres[0], metres[1]
        )),
        None => Ok(format!("left {:.3} m, right {:.3} m", metres[0], metres[1])),
    }
}

fn travelled(before: &[Sample], after: &[Sample]) -> Result<[i32; 2], String> {
    let (Some(first), Some(last)) = (before.last(), after.last()) else { return Err("no samples".into()) };
    Ok([last.left_ticks.wrapping_sub(first.left_ticks), last.right_ticks.wrapping_sub(first.right_ticks)])
}

fn counts(range: Range) -> Option<f32> {
    if let Range::Counts(counts) = range { Some(f32::from(counts)) } else { None }
}

fn metres(range: Range) -> Option<f32> {
    if let Range::Metres(metres) = range { Some(metres) } else { None }
}

/// The median of a sensor's readings of one kind.
fn median(sensor: usize, samples: &[Sample], kind: fn(Range) -> Option<f32>) -> Option<f32> {
    let mut values: Vec<f32> =
        samples.iter().filter_map(|sample| sample.ranges.get(sensor).copied().and_then(kind)).collect();
    values.sort_unstable_by(f32::total_cmp);
    values.get(values.len() / 2).copied()
}
