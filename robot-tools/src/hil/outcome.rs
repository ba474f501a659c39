//! What a drive in the loop showed.

use std::fmt;

use robot::FloorState;
use serde_json::json;
use wire::{Faults, LookBack, Place};

use super::{Hil, Swept};
use lab::recording::{MapScore, PathScore};

/// Something that was not the same on host and target.
#[derive(Clone, Debug)]
pub struct Difference {
    /// When, microseconds.
    pub time_us: u64,
    /// What.
    pub what: String,
}

/// How late the estimator's steps began after their samples were due, microseconds.
#[derive(Clone, Debug, Default)]
pub struct Latenesses {
    /// In ascending order.
    sorted: Vec<u32>,
}

impl Latenesses {
    /// Of these steps.
    pub fn of(mut late_us: Vec<u32>) -> Self {
        late_us.sort_unstable();
        Self { sorted: late_us }
    }

    /// What this share of the steps was at most, 0 to 1.
    pub fn at(&self, share: f64) -> u32 {
        let last = self.sorted.len().saturating_sub(1);
        self.sorted.get((share * last as f64).round() as usize).copied().unwrap_or(0)
    }
}

/// What a drive in the loop showed.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Estimates with the same bits on host and target.
    pub identical: u64,
    /// Everything that was not the same.
    pub differences: Vec<Difference>,
    /// The target's estimate against the truth.
    pub estimate: Option<PathScore>,
    /// The target's dead reckoning against the truth.
    pub odometry: Option<PathScore>,
    /// The map against the true plan.
    pub map: Option<MapScore>,
    /// Walls in the map.
    pub walls: usize,
    /// The firmware's last word on its faults.
    pub faults: Option<Faults>,
    /// The firmware's last word on its back end; none where it has none.
    pub look_back: Option<LookBack>,
    /// The firmware's last word on its place.
    pub place: Option<Place>,
    /// How late its steps began.
    pub late_us: Latenesses,
    /// Frames from the firmware that arrived damaged.
    pub damaged: u32,
    /// What became of the floor; none where it was not to be swept.
    pub swept: Option<Swept>,
}

impl Outcome {
    /// Whether every estimate was the same and nothing was lost.
    ///
    /// # Errors
    /// What was not right.
    pub fn verdict(&self) -> Result<(), String> {
        if let Some(first) = self.differences.first() {
            let t_s = first.time_us as f64 * 1e-6;
            let count = self.differences.len();
            return Err(format!("{count} differences between host and target, the first at {t_s} s: {}", first.what));
        }
        let board = self.faults.map(|faults| faults.board).ok_or("the firmware sent no faults frame: drive longer")?;
        let lost = [
            ("ranges_failed", board.ranges_failed),
            ("encoders_failed", board.encoders_failed),
            ("motors_failed", board.motors_failed),
            ("samples_dropped", board.samples_dropped),
            ("frames_dropped", board.frames_dropped),
            ("commands_dropped", board.commands_dropped),
            ("bytes_lost", board.bytes_lost),
            ("dead_man_stops", board.dead_man_stops),
            ("late_tasks", board.late_tasks),
            ("damaged frames", self.damaged),
        ];
        match lost.iter().find(|(_, count)| *count > 0) {
            Some((name, count)) => Err(format!("the firmware counts {name}: {count}; it must be 0 in the loop")),
            None if self.identical == 0 => Err("the firmware sent no estimate".into()),
            None => Ok(()),
        }
    }

    /// What the firmware said last that it does with the floor.
    fn floor_state(&self) -> Option<&'static str> {
        self.swept.as_ref()?.told?.state().map(FloorState::name)
    }

    /// The figures as JSON.
    pub fn to_json(&self, hil: &Hil) -> String {
        let figures = json!({
            "version": env!("CARGO_PKG_VERSION"),
            "plan": hil.plan,
            "job": hil.job.name(),
            "minutes": hil.minutes,
            "seed": hil.seed,
            "robot": hil.robot.name(),
            "identical": self.identical,
            "differences": self.differences.len(),
            "ate_m": self.estimate.map(|score| score.ate_m),
            "start_m": self.estimate.and_then(|score| score.start_m),
            "heading_deg": self.estimate.map(|score| score.heading_deg),
            "odometry_ate_m": self.odometry.map(|score| score.ate_m),
            "walls": self.walls,
            "walls_missed": self.map.map(|map| map.missed),
            "walls_invented": self.map.map(|map| map.invented),
            "stack_used_bytes": self.faults.map(|faults| faults.board.stack_used_bytes),
            "hand_overs_taken": self.look_back.map(|look_back| look_back.taken_over),
            "hand_overs_refused": self.look_back.map(|look_back| look_back.not_taken.iter().sum::<u32>()),
            "back_end_late": self.look_back.map(|look_back| look_back.late),
            "found": self.place.map(|place| place.found),
            "lost": self.place.map(|place| place.lost),
            "late_us_median": self.late_us.at(0.5),
            "late_us_99": self.late_us.at(0.99),
            "late_us_most": self.late_us.at(1.0),
            "contact_stops": self.faults.map(|faults| faults.board.contact_stops),
            "floor_state": self.floor_state(),
            "floor_told_s": self.swept.as_ref().and_then(|swept| swept.told).map(|told| told.seconds),
            "floor_swept": self.swept.as_ref().map(|swept| swept.score.swept),
            "floor_overlap": self.swept.as_ref().map(|swept| swept.score.overlap),
            "floor_hole_m2": self.swept.as_ref().map(|swept| swept.score.largest_hole_m2),
            "floor_home_m": self.swept.as_ref().map(|swept| swept.score.home_m),
        });
        format!("{figures:#}\n")
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all = self.identical as usize + self.differences.len();
        writeln!(f, "  {:<34}{:>12}   of {all}", "estimates with the host's bits", self.identical)?;
        if let (Some(estimate), Some(odometry)) = (&self.estimate, &self.odometry) {
            let row = |name: &str, value: f64, other: f64, unit: &str| {
                format!("  {name:<34}{:>12}   dead reckoning {other:.3} {unit}", format!("{value:.3} {unit}"))
            };
            writeln!(f, "{}", row("position, best alignment (RMSE)", estimate.ate_m, odometry.ate_m, "m"))?;
            writeln!(f, "{}", row("heading (RMSE)", estimate.heading_deg, odometry.heading_deg, "deg"))?;
        }
        if let Some(map) = &self.map {
            let walls = format!("{} missed, {} invented", map.missed, map.invented);
            writeln!(f, "  {:<34}{:>12}   {walls}", "walls in the map", self.walls)?;
        }
        if let Some(LookBack { taken_over, not_taken, late, .. }) = &self.look_back {
            let refused = not_taken.iter().sum::<u32>();
            writeln!(f, "  {:<34}{taken_over:>12}   {refused} refused, {late} waited for", "hand-overs taken")?;
        }
        if let Some(Swept { score, told }) = &self.swept {
            let minutes = told.map_or(0.0, |told| f64::from(told.seconds) / 60.0);
            let state = self.floor_state().unwrap_or("nothing told");
            let swept = format!("{:.1} %", 100.0 * score.swept);
            let after = format!("{state} after {minutes:.1} min, {:.2} m from the start", score.home_m);
            writeln!(f, "  {:<34}{swept:>12}   {after}", "floor swept")?;
            let largest = format!("{:.3} m2", score.largest_hole_m2);
            writeln!(f, "  {:<34}{largest:>12}   path over floor {:.2}", "largest piece missed", score.overlap)?;
        }
        let [median, p99, most] = [0.5, 0.99, 1.0].map(|share| self.late_us.at(share));
        writeln!(f, "  {:<34}{median:>12}   99 % {p99}, most {most}", "steps began late, median, us")?;
        if let Some(faults) = &self.faults {
            writeln!(f, "  {:<34}{:>12}", "stack used, bytes", faults.board.stack_used_bytes)?;
            writeln!(f, "  {:<34}{:>12}", "stops by bumper or cliff", faults.board.contact_stops)?;
        }
        Ok(())
    }
}
