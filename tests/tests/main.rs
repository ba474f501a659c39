//! Tests across the crates, in one program: it is linked once, and no core waits for the last test of a file.

mod accuracy;
mod capacities;
mod clean_areas;
mod contradictions;
mod covariance;
mod docks;
mod documents;
mod drawn_robots;
mod experiments;
mod faults;
mod first_look_backs;
mod floor_job;
mod floor_page;
mod floor_plans;
mod frozen_sensors;
mod holds;
mod hostile_input;
mod jolts;
mod last_poses;
mod long_drive;
mod odd_inputs;
mod output_noise;
mod place_page;
mod positivity;
mod protocol;
mod pushes;
mod range_counts;
mod real_logs;
mod relocation;
mod report_page;
mod run_page;
mod same_bits;
mod second_copies;
mod settings;
mod short_sensors;
mod slips;
mod slow_logs;
mod structure;
mod studio;
mod wings;

/// The file's modules, beside the folder of this name.
fn files_of(folder: &str) -> Vec<String> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(folder);
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let name =
        |path: std::path::PathBuf| path.file_stem().and_then(|stem| stem.to_str()).expect("a plain name").to_owned();
    entries.map(name).filter(|name| name != "main").collect()
}

#[test]
fn no_file_of_tests_is_left_out() {
    for (folder, main) in
        [("tests/tests", include_str!("main.rs")), ("lab-cli/tests", include_str!("../../lab-cli/tests/main.rs"))]
    {
        let files = files_of(folder);
        assert!(files.len() > 10, "{folder}: {files:?}");
        for file in files {
            assert!(main.lines().any(|line| line == format!("mod {file};")), "{folder}/main.rs lacks {file}");
        }
    }
}
