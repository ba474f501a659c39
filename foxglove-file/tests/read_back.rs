//! The file read back: every message fits its schema and says what the run was.

use std::collections::BTreeMap;
use std::io::Cursor;

use foxglove_file::{Output, SCHEMAS, write};
use lab::input::built_in_robot;
use lab::recording::{Pose2, Recording};
use lab::run::{Drive, Session};
use serde_json::Value;
use slam_core::Config;

fn driven() -> Recording {
    let (robot, _) = built_in_robot().expect("it is built in");
    let plan = hal_sim::plan_file::load("room").expect("it is built in");
    let mut drive = Drive::new(&plan, &robot, hal_sim::SimOptions::default(), 1).expect("it can be simulated");
    let mut session = Session::new(&robot, Config::for_rig(&robot.rig), "room").expect("the built-in rig");
    while session.recording().steps.len() < 500 {
        drive.step(&mut session);
    }
    drive.finish(session)
}

/// What of a value does not fit a schema; the keywords that the schemas here use.
fn misfit(schema: &Value, value: &Value, place: &str) -> Option<String> {
    let fits = match schema["type"].as_str() {
        Some("object") => value.is_object(),
        Some("array") => value.is_array(),
        Some("string") => value.is_string(),
        Some("integer") => value.is_i64() || value.is_u64(),
        Some("number") => value.is_number(),
        Some("boolean") => value.is_boolean(),
        _ => false,
    };
    if !fits {
        return Some(format!("{place}: {value} is no {}", schema["type"]));
    }
    let required = schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str);
    if let Some(missing) = required.into_iter().find(|name| value.get(name).is_none()) {
        return Some(format!("{place}: {missing} is missing"));
    }
    let fields =
        value.as_object().into_iter().flatten().find_map(|(name, field)| match schema["properties"].get(name) {
            Some(schema) => misfit(schema, field, &format!("{place}.{name}")),
            None => Some(format!("{place}: {name} is in no schema")),
        });
    let items =
        schema.get("items").and_then(|schema| value.as_array()?.iter().find_map(|item| misfit(schema, item, place)));
    fields.or(items)
}

#[test]
fn every_message_fits_its_schema_and_says_what_the_run_was() {
    let mut recording = driven();
    // A robot that learns where it started moves the plan with the true path.
    recording.steps.iter_mut().for_each(|step| step.start = Pose2::new(0.5, -1.0, 0.25));
    let mut bytes = Vec::new();
    let mut output = Output::new(Cursor::new(&mut bytes)).unwrap();
    write(&mut output, &recording).unwrap();
    output.finish().unwrap();
    let mut counts: BTreeMap<String, usize> = BTreeMap::new();
    let mut last: BTreeMap<String, Value> = BTreeMap::new();
    for message in mcap::MessageStream::new(&bytes).expect("an MCAP file") {
        let message = message.expect("a whole message");
        let schema = message.channel.schema.as_ref().expect("a schema");
        assert!(SCHEMAS.iter().any(|(name, _)| *name == schema.name) && schema.encoding == "jsonschema");
        let (text, value) =
            (serde_json::from_slice(&schema.data).unwrap(), serde_json::from_slice(&message.data).unwrap());
        assert_eq!(misfit(&text, &value, &message.channel.topic), None);
        let stamp = &value["timestamp"];
        if let (Some(sec), Some(nsec)) = (stamp["sec"].as_u64(), stamp["nsec"].as_u64()) {
            assert_eq!(message.log_time, sec * 1_000_000_000 + nsec);
        }
        *counts.entry(message.channel.topic.clone()).or_default() += 1;
        last.insert(message.channel.topic.clone(), value);
    }
    assert_eq!([counts["/pose"], counts["/truth"], counts["/figures"], counts["/plan"]], [500, 500, 500, 1]);
    let end = recording.steps.last().unwrap();
    // Numbers are read to their last bit but one.
    let x_m = last["/pose"]["pose"]["position"]["x"].as_f64().expect("a number");
    assert!((x_m - end.pose.x_m).abs() < 1e-12, "{x_m} {}", end.pose.x_m);
    let corner = &last["/plan"]["entities"][0]["lines"][0]["points"][0];
    let expected_m = recording.start().transform(recording.true_walls[0].from_m);
    for (axis, expected_m) in ["x", "y"].into_iter().zip(expected_m) {
        let is_m = corner[axis].as_f64().expect("a number");
        assert!((is_m - expected_m).abs() < 1e-6, "{axis} {is_m} {expected_m}");
    }
    let lines = last["/walls"]["entities"][0]["lines"].as_array().unwrap();
    let points: usize = lines.iter().map(|line| line["points"].as_array().unwrap().len()).sum();
    assert_eq!(points, 2 * recording.walls().len());
    assert!(counts["/hits"] > 10 && last["/path"]["poses"].as_array().unwrap().len() == 500);
}
