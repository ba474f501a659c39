//! What `docs/formats.md` says is what the program does.

use std::path::Path;

use crate::common::Place;
use lab::input::rig_file::Robot;

const FORMATS: &str = include_str!("../../docs/formats.md");

fn examples() -> Vec<&'static str> {
    FORMATS.split("```toml\n").skip(1).map(|rest| rest.split("```").next().expect("an end")).collect()
}

#[test]
fn the_rig_examples_are_good() {
    let examples = examples();
    assert_eq!(examples.len(), 2);
    for example in examples {
        let robot = Robot::parse(Path::new("docs/formats.md"), example).unwrap_or_else(|error| panic!("{error}"));
        let spelt_out = robot.rig.sensors[0].max_incidence_rad;
        let without: String = example
            .lines()
            .filter(|line| !line.starts_with("max_incidence"))
            .fold(String::new(), |text, line| text + line + "\n");
        let default = Robot::parse(Path::new("docs/formats.md"), &without).expect("it is optional");
        assert_eq!(default.rig.sensors[0].max_incidence_rad, spelt_out, "the default is the documented one");
    }
}

#[test]
fn every_file_written_is_documented_with_its_header() {
    let place = Place::new();
    place.lab().args(["--plan", "room", "--minutes", "0.2", "--out", "out", "--trace"]).assert().success();
    let mut names: Vec<String> = std::fs::read_dir(place.path("out"))
        .expect("the folder")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    names.sort();
    assert_eq!(names.len(), 14, "{names:?}");
    for name in &names {
        assert!(FORMATS.contains(&format!("`{name}`")), "{name} is not documented");
    }
    for name in ["estimate.csv", "walls.csv", "calibration.csv", "readings.csv"] {
        let text = place.get(&format!("out/{name}"));
        let header = text.lines().next().expect("a header");
        assert!(FORMATS.contains(&format!("`{header}`")), "{name}: {header}");
    }
}

#[test]
fn every_figure_is_documented() {
    let place = Place::new();
    place.lab().args(["--plan", "room", "--minutes", "3", "--out", "out"]).assert().success();
    let own = ["program", "version", "title", "estimator_s", "poses_compared", "seed", "configuration", "files"];
    let summary = place.summary("out");
    let keys = |value: &serde_json::Value| value.as_object().expect("an object").keys().cloned().collect::<Vec<_>>();
    let wall = &summary["consistency"]["walls"][0];
    let consistency = &summary["consistency"];
    let [surfels, visit] = [&consistency["surfels"], &wall["visits"][0]].map(keys);
    let inner = [keys(consistency), keys(wall), visit, surfels, keys(&summary["map"])].concat();
    for key in keys(&summary).iter().chain(&inner) {
        assert!(own.contains(&key.as_str()) || FORMATS.contains(&format!("`{key}`")), "{key} is not documented");
    }
}

#[test]
fn the_experiment_example_is_good() {
    use monte_carlo::file::Experiment;
    use monte_carlo::key::Key;
    use monte_carlo::row::Metric;
    use monte_carlo::variant::NAMED;
    let text = include_str!("../../docs/reference/experiments.md");
    let example = text.split("```toml\n").nth(1).and_then(|rest| rest.split("```").next()).expect("an example");
    let example = example.replace(", \"my-home.toml\"", "");
    Experiment::parse(Path::new("docs/reference/experiments.md"), &example).unwrap_or_else(|error| panic!("{error}"));
    let names = Key::ALL.map(Key::name).into_iter().chain(Metric::ALL.map(Metric::name)).chain(NAMED);
    for name in names {
        assert!(text.contains(&format!("`{name}`")), "{name} is not documented");
    }
}
