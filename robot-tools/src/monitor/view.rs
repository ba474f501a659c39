//! The picture of a robot in a terminal.

use std::collections::BTreeMap;
use std::fmt;

use robot::FloorState;
use wire::{BoardFaults, Calibration, Estimate, Faults, Floor, Frame, Frozen, LookBack, Place, Range, Sample, Wall};

/// Most walls that are listed.
const LISTED: usize = 24;

/// What the robot said last.
#[derive(Clone, Debug, Default)]
pub struct View {
    sample: Option<Sample>,
    estimate: Option<Estimate>,
    walls: BTreeMap<u8, Wall>,
    calibration: Option<Calibration>,
    faults: Option<Faults>,
    frozen: Option<Frozen>,
    look_back: Option<LookBack>,
    place: Option<Place>,
    floor: Option<Floor>,
    /// The latest that a step began, microseconds.
    latest_us: u32,
    samples: u64,
    /// Whether any frame arrived.
    heard: bool,
    /// Frames that arrived damaged, and their bytes.
    pub damaged: (u32, u64),
}

impl View {
    /// Takes a frame into the picture.
    pub fn take(&mut self, frame: Frame) {
        self.heard = true;
        match frame {
            Frame::Sample(sample) => {
                self.samples += 1;
                self.sample = Some(sample);
            }
            Frame::Estimate(estimate) => {
                self.walls.retain(|index, _| *index < estimate.walls);
                self.latest_us = self.latest_us.max(estimate.late_us);
                self.estimate = Some(estimate);
            }
            Frame::Wall(wall) => {
                self.walls.insert(wall.index, wall);
            }
            Frame::Calibration(calibration) => self.calibration = Some(calibration),
            Frame::Faults(faults) => self.faults = Some(faults),
            Frame::Frozen(frozen) => self.frozen = Some(frozen),
            Frame::LookBack(look_back) => self.look_back = Some(look_back),
            Frame::Place(place) => self.place = Some(place),
            Frame::Floor(floor) => self.floor = Some(floor),
            Frame::Motors(_) | Frame::Command(_) | Frame::MapRequest(_) | Frame::MapAnswer(_) => {}
        }
    }

    /// Whether no frame arrived.
    pub fn is_empty(&self) -> bool {
        !self.heard
    }

    /// The robot's time, microseconds.
    pub fn time_us(&self) -> u64 {
        self.estimate.map_or(0, |estimate| estimate.time_us)
    }
}

impl fmt::Display for View {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(estimate) = self.estimate else { return writeln!(f, "nothing heard yet") };
        let [x, y, theta] = estimate.pose;
        let [xx, _, _, yy, _, tt] = estimate.covariance;
        let (position_cm, heading_deg) = (100.0 * xx.max(yy).max(0.0).sqrt(), tt.max(0.0).sqrt().to_degrees());
        writeln!(
            f,
            "{:8.1} s   {} samples, {} damaged frames of {} bytes",
            self.time_us() as f64 * 1e-6,
            self.samples,
            self.damaged.0,
            self.damaged.1
        )?;
        writeln!(f, "pose      x {x:.3} m   y {y:.3} m   heading {:.1} deg", theta.to_degrees())?;
        writeln!(f, "sigma     {position_cm:.1} cm   {heading_deg:.2} deg")?;
        match estimate.alpha {
            Some([alpha, sigma]) => {
                writeln!(f, "grid      {:.2} deg, sigma {:.2} deg", alpha.to_degrees(), sigma.to_degrees())?;
            }
            None => writeln!(f, "grid      none yet")?,
        }
        let restarts = self.faults.map_or(0, |faults| faults.slam.restarts);
        writeln!(f, "health    {}, {restarts} maps begun anew", format!("{:?}", estimate.health).to_lowercase())?;
        self.write_frozen(f)?;
        self.write_floor(f)?;
        self.write_look_back(f, &estimate)?;
        self.write_sample(f)?;
        self.write_faults(f)?;
        self.write_calibration(f)?;
        self.write_walls(f, estimate.walls)
    }
}

impl View {
    fn write_sample(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(sample) = &self.sample else { return Ok(()) };
        write!(f, "ranges   ")?;
        for range in &sample.ranges {
            match range {
                Range::Counts(counts) => write!(f, " {counts:>5}")?,
                Range::Metres(metres) => write!(f, " {metres:.2} m")?,
                Range::Missing => write!(f, "     -")?,
            }
        }
        let touched = sample.contacts;
        let names = [
            (touched.bump_left, "left"),
            (touched.bump_right, "right"),
            (touched.cliff, "cliff"),
            (touched.lifted, "lifted"),
            (touched.docked, "dock"),
        ];
        let touched: Vec<&str> = names.iter().filter(|(on, _)| *on).map(|(_, name)| *name).collect();
        writeln!(f, "\nticks     {} {}   touched: {}", sample.left_ticks, sample.right_ticks, touched.join(" "))
    }

    fn write_floor(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(floor) = &self.floor else { return Ok(()) };
        let doing = floor.state().map_or("something that this program does not know", FloorState::name);
        let (minutes, seconds) = (floor.seconds / 60, floor.seconds % 60);
        writeln!(
            f,
            "floor     {doing}; {:.1} m2 swept, {:.0} % of what was seen, after {minutes} min {seconds} s",
            floor.swept_m2,
            100.0 * floor.share()
        )
    }

    fn write_look_back(&self, f: &mut fmt::Formatter<'_>, estimate: &Estimate) -> fmt::Result {
        let late_ms = f64::from(self.latest_us) * 1e-3;
        writeln!(f, "steps     {late_ms:.1} ms late at most   map epoch {}", estimate.epoch)?;
        if let Some(place) = &self.place {
            let state = format!("{:?}", place.state).to_lowercase();
            let odds = place.log_odds.map_or(String::new(), |odds| format!("; log odds of the best place {odds:.1}"));
            let Place { sequence, saves, failed, found, lost, .. } = place;
            writeln!(
                f,
                "kept map  {state}, save {sequence}; {saves} saved, {failed} failed, {found} found, {lost} lost{odds}"
            )?;
        }
        let Some(back) = &self.look_back else { return Ok(()) };
        let refused: Vec<String> = slam_core::NotTaken::ALL
            .iter()
            .zip(back.not_taken)
            .filter(|(_, count)| *count > 0)
            .map(|(reason, count)| format!("{reason:?} {count}").to_lowercase())
            .collect();
        let refused = if refused.is_empty() { "none".to_owned() } else { refused.join(", ") };
        let now = if back.is_working { "under way" } else { "waiting" };
        writeln!(
            f,
            "look back {now}, {} keyframes, {} groups; {} done, {} taken over, refused: {refused}; {} fruitless, {} outdated, {} late",
            back.keyframes, back.groups, back.done, back.taken_over, back.fruitless, back.outdated, back.late
        )
    }

    fn write_faults(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(Faults { slam, board }) = self.faults else { return Ok(()) };
        writeln!(
            f,
            "estimator {} steps, {} updates, {} births, {} merges, {} removed, {} refused, {} map full",
            slam.steps,
            slam.updates,
            slam.births,
            slam.merges,
            slam.prunes,
            slam.refused.iter().sum::<u32>(),
            slam.map_full
        )?;
        let counts = named(&board);
        let counted: Vec<String> =
            counts.iter().filter(|(_, count)| *count > 0).map(|(name, count)| format!("{name} {count}")).collect();
        let counted = if counted.is_empty() { "none".to_owned() } else { counted.join(", ") };
        writeln!(f, "faults    {counted}   (stack {} bytes)", board.stack_used_bytes)
    }

    fn write_frozen(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(frozen) = self.frozen else { return Ok(()) };
        let now: Vec<String> =
            (0..16).filter(|sensor| frozen.sensors >> sensor & 1 != 0).map(|sensor| sensor.to_string()).collect();
        let now = if now.is_empty() { "none now".to_owned() } else { format!("range sensor {}", now.join(", ")) };
        writeln!(f, "frozen    {now}")
    }

    fn write_calibration(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Some(calibration) = &self.calibration else { return Ok(()) };
        write!(f, "factors  ")?;
        for factor in &calibration.factors {
            write!(f, " {:?} {:.4}", factor.parameter, factor.estimate)?;
        }
        writeln!(f)
    }

    fn write_walls(&self, f: &mut fmt::Formatter<'_>, count: u8) -> fmt::Result {
        writeln!(f, "walls     {count}")?;
        for wall in self.walls.values().take(LISTED) {
            writeln!(
                f,
                "  {:>4} {:<8} rho {:>7.3} m +- {:>4.1} cm   beta {:>7.1} deg   from {:>6.2} to {:>6.2} m",
                wall.id,
                format!("{:?}", wall.kind).to_lowercase(),
                wall.rho_m,
                100.0 * wall.sigma_rho_m,
                wall.beta_rad.to_degrees(),
                wall.lo_m,
                wall.hi_m
            )?;
        }
        Ok(())
    }
}

fn named(board: &BoardFaults) -> [(&'static str, u32); 11] {
    [
        ("ranges failed", board.ranges_failed),
        ("encoders failed", board.encoders_failed),
        ("motors failed", board.motors_failed),
        ("samples dropped", board.samples_dropped),
        ("frames dropped", board.frames_dropped),
        ("commands dropped", board.commands_dropped),
        ("bytes lost", board.bytes_lost),
        ("contact stops", board.contact_stops),
        ("dead-man stops", board.dead_man_stops),
        ("watchdog resets", board.watchdog_resets),
        ("late tasks", board.late_tasks),
    ]
}
