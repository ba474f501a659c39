//! What the page's scripts call. Objects go over as JSON, columns of numbers as `Float64Array`s, errors as texts that say what
//! is wrong, where, and what would be right.

use lab::run::Job;
use wasm_bindgen::prelude::wasm_bindgen;

use crate::watched::command;
use crate::{Files, Knobs, Replayed, Scene, Simulated, Watched, tuned};

/// What the page asks of every source of a run, whatever it comes from.
macro_rules! grows {
    ($source:ident) => {
        #[wasm_bindgen]
        impl $source {
            pub fn head(&self) -> String {
                self.0.head().to_string()
            }

            pub fn state(&mut self) -> String {
                self.0.state().to_string()
            }

            pub fn steps(&mut self) -> Vec<f64> {
                self.0.steps()
            }

            pub fn map(&mut self) -> Option<String> {
                self.0.map().map(|map| map.to_string())
            }

            pub fn figures(&self) -> String {
                self.0.figures().to_string()
            }

            pub fn report(&self) -> Option<String> {
                self.0.report()
            }

            pub fn look_back(&mut self, pieces: usize) -> Result<bool, String> {
                self.0.look_back(pieces).map_err(str::to_owned)
            }

            pub fn looked_back(&self) -> Option<String> {
                self.0.back().walls().map(|walls| walls.to_string())
            }

            pub fn looked_back_path(&self) -> Vec<f64> {
                self.0.back().path(self.0.recording())
            }

            pub fn look_back_page(&self) -> Option<String> {
                self.0.look_back_page()
            }
        }
    };
}

grows!(Simulation);
grows!(Replay);
grows!(Robot);

/// A simulated drive; each function is the one of this name of [`Simulated`].
#[wasm_bindgen]
pub struct Simulation(Simulated);

#[wasm_bindgen]
impl Simulation {
    #[wasm_bindgen(constructor)]
    pub fn new(plan: String, rig: String, job: &str, seed: u32) -> Result<Simulation, String> {
        let (_, job) = Job::ALL.into_iter().find(|(name, _)| *name == job).ok_or("the job must be explore or clean")?;
        Simulated::new(&Scene { plan, rig, job, seed: seed.into() }).map(Simulation)
    }

    pub fn advance(&mut self, until_s: f64, most: usize) {
        self.0.advance(until_s, most);
    }

    pub fn time(&self) -> Option<f64> {
        self.0.time_s()
    }

    pub fn home(&self) -> String {
        self.0.home().to_string()
    }

    pub fn floor(&self) -> Vec<f32> {
        self.0.floor()
    }

    pub fn carry(&mut self) -> Result<(), String> {
        self.0.carry(None)
    }

    pub fn carry_to(&mut self, x_m: f64, y_m: f64) -> Result<(), String> {
        self.0.carry(Some([x_m, y_m]))
    }

    pub fn kick(&mut self) {
        self.0.kick();
    }

    pub fn hold(&mut self) {
        self.0.hold();
    }

    pub fn cover(&mut self, sensor: usize, is_covered: bool) {
        self.0.cover(sensor, is_covered);
    }

    pub fn cut_power(&mut self) -> Result<(), String> {
        self.0.cut_power()
    }

    pub fn begin_in(&mut self, map: Vec<u8>) -> Result<(), String> {
        self.0.begin_in(map)
    }

    pub fn sought(&self) -> Option<String> {
        self.0.sought().map(|walls| walls.to_string())
    }

    pub fn rebuild(&mut self, plan: &str) -> Result<(), String> {
        self.0.rebuild(plan)
    }

    pub fn log(&self) -> String {
        self.0.log().to_owned()
    }

    pub fn rig(&self) -> String {
        self.0.rig_toml().to_owned()
    }

    pub fn kept_map(&self) -> Vec<u8> {
        self.0.kept_map()
    }
}

/// The estimator over a log; each function is the one of this name of [`Replayed`].
#[wasm_bindgen]
pub struct Replay(Replayed);

#[wasm_bindgen]
impl Replay {
    /// Of files, each as its name and its content; what is not there has no name.
    #[wasm_bindgen(constructor)]
    #[expect(clippy::too_many_arguments, reason = "the page has the files one by one")]
    pub fn new(
        log_name: String,
        log: Vec<u8>,
        rig_name: String,
        rig: Vec<u8>,
        truth_name: String,
        truth: Vec<u8>,
        map_name: String,
        map: Vec<u8>,
    ) -> Result<Replay, String> {
        let named = |name: String, content| (!name.is_empty()).then_some((name, content));
        let (truth, map) = (named(truth_name, truth), named(map_name, map));
        let files = Files { log: (log_name, log), rig: (rig_name, rig), truth, map };
        Replayed::new(files).map(Replay).map_err(|error| error.to_string())
    }

    pub fn advance(&mut self, most: usize) {
        self.0.advance(most);
    }

    pub fn is_over(&self) -> bool {
        self.0.is_over()
    }

    pub fn tell_again(&mut self) {
        self.0.tell_again();
    }

    pub fn maps(&self) -> String {
        self.0.maps().to_string()
    }

    pub fn estimate(&self) -> String {
        self.0.estimate().to_owned()
    }

    pub fn kept_map(&self) -> Vec<u8> {
        self.0.kept_map()
    }
}

/// A robot at the other end of a line; each function is the one of this name of [`Watched`].
#[wasm_bindgen]
pub struct Robot(Watched);

#[wasm_bindgen]
impl Robot {
    #[wasm_bindgen(constructor)]
    pub fn new(rig: &str) -> Result<Robot, String> {
        Watched::new(rig).map(Robot)
    }

    pub fn tell_again(&mut self) {
        self.0.tell_again();
    }

    pub fn take(&mut self, bytes: &[u8]) {
        self.0.take(bytes);
    }

    /// What is to be sent to the robot now, by the page's clock, see [`crate::Errands::due`].
    pub fn due(&mut self, now_ms: f64) -> Vec<u8> {
        self.0.errands().due(now_ms)
    }

    pub fn begin_map(&mut self, name: &str, map: Vec<u8>) -> Result<(), String> {
        self.0.errands().begin_map(name, map)
    }

    pub fn fetched(&mut self) -> Vec<u8> {
        self.0.errands().fetched()
    }

    pub fn examine(&mut self) {
        self.0.examine();
    }

    pub fn answer(&mut self) {
        self.0.errands().answer();
    }

    pub fn end_examination(&mut self) {
        self.0.errands().end_examination();
    }

    pub fn log(&self) -> String {
        self.0.log().to_owned()
    }

    pub fn rig(&self) -> String {
        self.0.rig_toml().to_owned()
    }
}

/// The bytes that tell a robot what to do: `start`, `stop`, `reset`, or `spin` with a share of the supply for each wheel.
#[wasm_bindgen]
pub fn robot_command(name: &str, left: f32, right: f32) -> Vec<u8> {
    command(name, [left, right])
}

/// The built-in plans and their texts.
#[wasm_bindgen]
pub fn built_in_plans() -> String {
    let plans = hal_sim::plan_file::BUILT_IN.iter().map(|(name, text)| (*name, serde_json::json!(text)));
    serde_json::Value::Object(plans.map(|(name, text)| (name.to_owned(), text)).collect()).to_string()
}

/// The rig file of a built-in robot with some of its numbers changed, see [`Knobs`].
///
/// # Errors
/// What is impossible.
#[wasm_bindgen]
pub fn tuned_rig(rig: &str, knobs: &str) -> Result<String, String> {
    let knobs: Knobs = serde_json::from_str(knobs).map_err(|error| format!("the sliders: {error}"))?;
    tuned(rig, knobs)
}
