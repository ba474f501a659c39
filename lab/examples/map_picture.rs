//! Draws the README's picture: the finished map of a simulated drive.
//!
//! `cargo run --release -p lab --example map_picture -- docs/map.svg [PLAN] [MINUTES] [SEED]`

use lab::run::{Job, Run};
use lab::{input::settings::Settings, show::report};
use slam_core::Config;
use std::{env, error::Error, fs, path::PathBuf};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = env::args().skip(1);
    let file = PathBuf::from(arguments.next().ok_or("name the file to write, as docs/map.svg")?);
    let plan = arguments.next().unwrap_or_else(|| "flat".into());
    let minutes = arguments.next().map_or(Ok(10.0), |text| text.parse())?;
    let seed = arguments.next().map_or(Ok(1), |text| text.parse())?;
    let out = env::temp_dir().join(format!("map-picture-{}", std::process::id()));
    let run = Run {
        plan,
        job: Job::Explore,
        minutes,
        seed,
        rig: None,
        map: None,
        start: None,
        out: out.clone(),
        settings: Settings::Exactly(Config::default()),
        trace: false,
    };
    let drawn = run.run(|_| ()).map(|recording| report::map_svg(&recording));
    fs::remove_dir_all(&out)?;
    fs::write(&file, drawn?)?;
    println!("{} written", file.display());
    Ok(())
}
