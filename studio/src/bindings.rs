//! What the page's scripts call. Objects go over as JSON, columns of numbers as `Float64Array`s, errors as texts that say what
//! is wrong, where, and what would be right.

use wasm_bindgen::prelude::wasm_bindgen;

use crate::simulated;

/// A simulated drive.
#[wasm_bindgen]
pub struct Simulation(simulated::Simulated);

#[wasm_bindgen]
impl Simulation {
    /// A robot at its start, in the built-in plan of this name or in the plan of this text; `rig` likewise.
    ///
    /// # Errors
    /// What is wrong with plan or rig.
    #[wasm_bindgen(constructor)]
    pub fn new(plan: String, rig: String, seed: u32) -> Result<Simulation, String> {
        simulated::Simulated::new(&simulated::Scene { plan, rig, seed: seed.into() }).map(Simulation)
    }

    /// Drives on until this time, seconds since the start, but for at most so many samples.
    pub fn advance(&mut self, until_s: f64, most: usize) {
        self.0.advance(until_s, most);
    }

    /// The time of the last sample, seconds since the start; none before the first.
    pub fn time(&self) -> Option<f64> {
        self.0.time_s()
    }

    /// What stays as it is over the drive.
    pub fn head(&self) -> String {
        self.0.head().to_string()
    }

    /// What stands where in the home.
    pub fn home(&self) -> String {
        self.0.home().to_string()
    }

    /// The steps that the page has not got.
    pub fn steps(&mut self) -> Vec<f64> {
        self.0.steps()
    }

    /// Map and calibration, where the page has older ones.
    pub fn map(&mut self) -> Option<String> {
        self.0.map().map(|map| map.to_string())
    }

    /// The figures so far.
    pub fn figures(&self) -> String {
        self.0.figures().to_string()
    }

    /// What the robot sensed so far, as a `log.csv`.
    pub fn log(&self) -> String {
        self.0.log().to_owned()
    }

    /// The robot as a rig file.
    pub fn rig(&self) -> String {
        self.0.rig_toml().to_owned()
    }
}

/// The built-in plans and their texts.
#[wasm_bindgen]
pub fn built_in_plans() -> String {
    let plans = hal_sim::plan_file::BUILT_IN.iter().map(|(name, text)| (*name, serde_json::json!(text)));
    serde_json::Value::Object(plans.map(|(name, text)| (name.to_owned(), text)).collect()).to_string()
}
