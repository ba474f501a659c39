//! Small rigs and logs, and the program as a user calls it.

use std::fs;
use std::path::PathBuf;

use assert_cmd::Command;
use tempfile::TempDir;

/// Two wheels, two sensors that report metres.
pub const WHEELED_RIG: &str = r#"[wheels]
track_m = 0.2
metres_per_tick = 0.001
scale_sigma = 0.005
noise_m2_per_m = 1e-5

[[range_sensor]]
name = "left"
x_m = 0.0
y_m = 0.1
bearing_deg = 90.0
min_m = 0.05
max_m = 2.0
gain_sigma = 0.01
noise_m = 0.01
noise_rel = 0.01

[[range_sensor]]
name = "front"
x_m = 0.1
y_m = 0.0
bearing_deg = 0
min_m = 0.05
max_m = 2.0
gain_sigma = 0.0
noise_m = 0.01
noise_rel = 0.0
"#;

/// A dead-reckoned pose, one sensor to the left.
pub const ODOMETRY_RIG: &str = r#"[odometry]
scale_sigma = 0.05
noise_m2_per_m = 4e-4
noise_rad2_per_m = 2e-4
noise_rad2_per_rad = 1e-3

[[range_sensor]]
name = "left"
x_m = 0.0
y_m = 0.0
bearing_deg = 90.0
min_m = 0.05
max_m = 2.0
gain_sigma = 0.01
noise_m = 0.01
noise_rel = 0.01
"#;

/// Two wheels, one Sharp sensor.
pub const SHARP_RIG: &str = r#"[wheels]
track_m = 0.2
metres_per_tick = 0.001
scale_sigma = 0.005
noise_m2_per_m = 1e-5

[adc]
bits = 12
vref_v = 3.3

[[range_sensor]]
name = "left"
x_m = 0.0
y_m = 0.1
bearing_deg = 90.0
min_m = 0.2
max_m = 1.5
gain_sigma = 0.01
scale_m = 0.60374
exponent = -1.16
noise_v = 0.012
"#;

/// A folder of its own for each test, and ways to fill and read it.
pub struct Place {
    folder: TempDir,
}

impl Place {
    /// An empty folder.
    pub fn new() -> Self {
        Self { folder: TempDir::new().expect("a temporary folder") }
    }

    /// A file in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file.
    pub fn put(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).expect("a folder");
        }
        fs::write(&path, content).expect("a file");
        path
    }

    /// Reads a text file.
    pub fn get(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap_or_else(|cause| panic!("{name}: {cause}"))
    }

    /// Reads `summary.json` of an output folder.
    pub fn summary(&self, out: &str) -> serde_json::Value {
        serde_json::from_str(&self.get(&format!("{out}/summary.json"))).expect("JSON")
    }

    /// The program, working in the folder.
    pub fn lab(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lab"));
        command.current_dir(self.folder.path());
        command
    }

    /// `lab replay log --rig rig.toml --out out`.
    pub fn replay(&self, log: &str) -> Command {
        let mut command = self.lab();
        command.args(["replay", log, "--rig", "rig.toml", "--out", "out"]);
        command
    }
}

/// A log for [`WHEELED_RIG`]: straight ahead at 0.25 m/s along a wall 0.8 m to the left, at 10 Hz.
pub fn wheeled_log(rows: usize) -> String {
    let mut text = String::from("t_s,left_ticks,right_ticks,range_0_m,range_1_m\n");
    for i in 0..rows {
        let range_m = 0.7 + 0.004 * ((i * 7 % 5) as f64 - 2.0);
        text += &format!("{:.1},{},{},{range_m:.3},\n", i as f64 * 0.1, 100 + 25 * i, 40 + 25 * i);
    }
    text
}
