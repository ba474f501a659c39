//! A made-up but plausible recording, the same on every machine: a robot drives round a room with a partition and a
//! slanted wall. No estimator is involved; errors and outcomes are drawn from simple formulas.

use hal_sim::floor::{FloorRaster, Moment};
use hal_sim::plan_file;
use lab::evaluate::score::consistency;
use lab::recording::{
    CalibrationSnapshot, Figures, Job, MapScore, MapSnapshot, ParameterInfo, PathScore, Pose2, Recording, Segment,
    SensorInfo, Step,
};
use slam_core::{Outcome, ReadingReport, Refusal, WallKind, WallView};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Corners of the drive, metres: a rectangle with round ends.
const DRIVE: [[f64; 2]; 2] = [[0.0, 0.0], [3.8, 2.3]];
const SPEED_M_S: f64 = 0.25;
const RANGE_MAX_M: f64 = 1.5;

/// The walls: ends, and whether it lies on the grid.
const PLAN: [([f64; 2], [f64; 2], bool); 7] = [
    ([-0.6, -0.6], [4.4, -0.6], true),
    ([4.4, -0.6], [4.4, 2.0], true),
    ([4.4, 2.0], [3.5, 2.9], false),
    ([3.5, 2.9], [-0.6, 2.9], true),
    ([-0.6, 2.9], [-0.6, -0.6], true),
    ([1.0, 0.9], [2.8, 0.9], true),
    ([1.0, 1.0], [2.8, 1.0], true),
];

/// Numbers that look random, the same everywhere (Numerical Recipes' congruential generator).
struct Noise(u32);

impl Noise {
    /// Uniform in [0, 1).
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(self.0 >> 8) / f64::from(1u32 << 24)
    }

    /// About normal with unit variance: the sum of twelve uniforms.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

/// A drive of `seconds` at `rate_hz` with eight sensors.
pub fn sample_recording(seconds: f64, rate_hz: f64) -> Recording {
    let mut noise = Noise(7);
    let mut recording = Recording {
        title: "Sample room".into(),
        seed: Some(7),
        sensors: (0..8).map(sensor).collect(),
        parameters: parameters(),
        true_walls: PLAN.iter().map(|(from, to, _)| Segment { from_m: *from, to_m: *to }).collect(),
        ..Recording::default()
    };
    let mut seen: [Option<[f64; 2]>; PLAN.len()] = [None; PLAN.len()];
    let count = (seconds * rate_hz) as usize + 1;
    for i in 0..count {
        let t_s = i as f64 / rate_hz;
        let before = walls(&seen).count();
        let step = step(t_s, &mut noise);
        readings(&mut recording, &step, &mut seen, &mut noise);
        let now = walls(&seen).count();
        recording.steps.push(Step { walls: now, births: (now - before) as u8, ..step });
        if now != before || i % rate_hz as usize == 0 || i + 1 == count {
            recording.maps.push(MapSnapshot { step: i, walls: walls(&seen).collect() });
            recording.calibration.push(calibration(i, t_s));
        }
    }
    recording.figures = figures(seconds, recording.walls().len());
    recording.figures.consistency = consistency::score(&recording);
    recording
}

/// The recording of a robot whose job was to sweep the floor: a lane, and half of it once more.
pub fn cleaned() -> Recording {
    const ROOM: &str = "[start]\nx_m = 1.0\ny_m = 1.0\nheading_deg = 90.0\n\
        [[outline]]\npoints_m = [[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [0.0, 2.0]]\n";
    let plan = plan_file::parse("home.toml", "home", ROOM).unwrap();
    let mut floor = FloorRaster::new(&plan, 0.17, plan.start);
    let moments = (0..=100).map(|i| (0.4 * f64::from(i), 0.3 + 0.02 * f64::from(if i <= 60 { i } else { 120 - i })));
    for (i, (t_s, x_m)) in moments.enumerate() {
        let doing = if i <= 60 { "lanes" } else { "docking" };
        let pose = Pose2::new(x_m, 1.0, 0.0);
        floor.record(&Moment { t_s, pose, doing, is_pressed: i == 60, is_on_floor: true });
    }
    let mut recording = sample_recording(40.0, 10.0);
    recording.job = Some(Job::Clean);
    recording.figures.floor = Some(floor.score());
    recording
}

fn sensor(index: usize) -> SensorInfo {
    let bearing_rad = index as f64 * PI / 4.0;
    SensorInfo {
        name: ["front", "front left", "left", "back left", "back", "back right", "right", "front right"][index].into(),
        x_m: 0.15 * bearing_rad.cos(),
        y_m: 0.15 * bearing_rad.sin(),
        bearing_rad,
        span_m: [0.1, RANGE_MAX_M],
    }
}

fn parameters() -> Vec<ParameterInfo> {
    let names = ["gain_front", "gain_left", "scale_left", "scale_right"];
    names
        .iter()
        .enumerate()
        .map(|(k, name)| ParameterInfo { name: (*name).into(), truth: Some(true_factor(k)) })
        .collect()
}

fn true_factor(k: usize) -> f64 {
    [1.012, 0.991, 1.004, 0.997][k]
}

fn calibration(step: usize, t_s: f64) -> CalibrationSnapshot {
    let sigma = 0.01 / (1.0 + t_s / 5.0).sqrt() + 0.0005;
    let values = (0..4).map(|k| {
        let learnt = 1.0 - (-t_s / 20.0).exp();
        ((1.0 + (true_factor(k) - 1.0) * learnt) as f32, sigma as f32)
    });
    CalibrationSnapshot { step, values: values.collect() }
}

/// Position and heading after `travel_m` along the drive, at constant speed, turning on the spot being instant.
fn along_drive(travel_m: f64) -> Pose2 {
    let [[x0, y0], [x1, y1]] = DRIVE;
    let (w, h) = (x1 - x0, y1 - y0);
    let s = travel_m.rem_euclid(2.0 * (w + h));
    let (x_m, y_m, theta_rad) = if s < w {
        (x0 + s, y0, 0.0)
    } else if s < w + h {
        (x1, y0 + s - w, FRAC_PI_2)
    } else if s < 2.0 * w + h {
        (x1 - (s - w - h), y1, PI)
    } else {
        (x0, y1 - (s - 2.0 * w - h), -FRAC_PI_2)
    };
    Pose2 { x_m, y_m, theta_rad }
}

fn step(t_s: f64, noise: &mut Noise) -> Step {
    let truth = along_drive(SPEED_M_S * t_s);
    let drift = 0.004 * t_s;
    let sigma = 0.004 + 0.004 * (1.0 - (-t_s / 30.0).exp());
    let pose = Pose2 {
        x_m: truth.x_m + 0.008 * (t_s / 11.0).sin() + 0.0005 * noise.normal(),
        y_m: truth.y_m + 0.007 * (t_s / 17.0).sin() + 0.0005 * noise.normal(),
        theta_rad: truth.theta_rad + 0.006 * (t_s / 9.0).sin(),
    };
    let dead_reckoning = Pose2 {
        x_m: truth.x_m + drift * (t_s / 40.0).cos(),
        y_m: truth.y_m + drift * (t_s / 40.0).sin(),
        theta_rad: truth.theta_rad + 0.002 * t_s,
    };
    let v = (sigma * sigma) as f32;
    let covariance = [[v, 0.3 * v, 0.0], [0.3 * v, 0.7 * v, 0.0], [0.0, 0.0, 2.5e-5]];
    Step {
        t_text: format!("{t_s:.3}"),
        t_s,
        pose,
        covariance,
        alpha: (t_s > 2.0).then(|| (0.01 / (1.0 + t_s as f32), 0.02 / (1.0 + t_s as f32))),
        dead_reckoning,
        sensed: dead_reckoning,
        truth: Some(truth),
        ..Step::default()
    }
}

/// Where a beam meets a wall: range and position along the wall, metres.
fn meet(origin: [f64; 2], bearing_rad: f64, (from, to, _): &([f64; 2], [f64; 2], bool)) -> Option<(f64, f64)> {
    let (s, c) = bearing_rad.sin_cos();
    let edge = [to[0] - from[0], to[1] - from[1]];
    let size = edge[0].hypot(edge[1]);
    let cross = c * edge[1] - s * edge[0];
    if cross.abs() < 1e-9 {
        return None;
    }
    let gap = [from[0] - origin[0], from[1] - origin[1]];
    let range = (gap[0] * edge[1] - gap[1] * edge[0]) / cross;
    let share = (gap[0] * s - gap[1] * c) / cross;
    (range > 0.0 && (0.0..=1.0).contains(&share)).then_some((range, share * size))
}

fn readings(recording: &mut Recording, step: &Step, seen: &mut [Option<[f64; 2]>], noise: &mut Noise) {
    let sensors = recording.sensors.clone();
    for mount in &sensors {
        let pose = step.truth.unwrap_or_default();
        let (s, c) = pose.theta_rad.sin_cos();
        let origin = [pose.x_m + c * mount.x_m - s * mount.y_m, pose.y_m + s * mount.x_m + c * mount.y_m];
        let bearing = pose.theta_rad + mount.bearing_rad;
        let nearest = (0..PLAN.len())
            .filter_map(|k| meet(origin, bearing, &PLAN[k]).map(|(range, along)| (k, range, along)))
            .filter(|(_, range, _)| *range < RANGE_MAX_M)
            .min_by(|a, b| a.1.total_cmp(&b.1));
        recording.readings.push(match nearest {
            Some((wall, range, along)) => reading(step, mount, wall, range, along, seen, noise),
            None => ReadingReport { outcome: Outcome::Refused(Refusal::Floor), range_m: None, hit_m: None },
        });
    }
}

fn reading(
    step: &Step,
    mount: &SensorInfo,
    wall: usize,
    range: f64,
    along: f64,
    seen: &mut [Option<[f64; 2]>],
    noise: &mut Noise,
) -> ReadingReport {
    let sigma = 0.004 + 0.006 * range * range;
    let draw = noise.uniform();
    let innovation = sigma * noise.normal() * if draw < 0.03 { 4.0 } else { 1.0 };
    let known = seen[wall].is_some_and(|[lo, hi]| hi - lo > 0.2 && along > lo - 0.1 && along < hi + 0.1);
    let extent = seen[wall].get_or_insert([along, along]);
    *extent = [extent[0].min(along), extent[1].max(along)];
    let (innovation_m, variance_m2) = (innovation as f32, (sigma * sigma) as f32);
    let outcome = match (known, draw) {
        (_, d) if d > 0.97 => Outcome::Refused(Refusal::Held),
        (false, _) => Outcome::Unexplained,
        (true, _) if innovation.abs() > 3.29 * sigma => Outcome::Gated { wall: wall as u16, innovation_m, variance_m2 },
        (true, _) => Outcome::Updated { wall: wall as u16, innovation_m, variance_m2, noise_m2: variance_m2 },
    };
    let measured = range + innovation;
    let pose = step.pose;
    let (s, c) = pose.theta_rad.sin_cos();
    let (bs, bc) = (pose.theta_rad + mount.bearing_rad).sin_cos();
    let x = pose.x_m + c * mount.x_m - s * mount.y_m + measured * bc;
    let y = pose.y_m + s * mount.x_m + c * mount.y_m + measured * bs;
    ReadingReport { outcome, range_m: Some(measured as f32), hit_m: Some([x as f32, y as f32]) }
}

/// The walls seen long enough, as the estimator would describe them.
fn walls(seen: &[Option<[f64; 2]>]) -> impl Iterator<Item = WallView> {
    seen.iter().enumerate().filter_map(|(k, extent)| {
        let [lo, hi] = (*extent).filter(|[lo, hi]| hi - lo > 0.2)?;
        let (from, to, grid) = PLAN[k];
        let tangent = (to[1] - from[1]).atan2(to[0] - from[0]);
        let beta = (tangent - FRAC_PI_2).rem_euclid(TAU);
        let (s, c) = beta.sin_cos();
        let start = -from[0] * s + from[1] * c;
        Some(WallView {
            id: k as u16,
            kind: if grid { WallKind::Grid } else { WallKind::Free },
            rho_m: (from[0] * c + from[1] * s + 0.006) as f32,
            beta_rad: beta as f32,
            lo_m: (start + lo) as f32,
            hi_m: (start + hi) as f32,
            sigma_rho_m: 0.004,
            updates: 100,
        })
    })
}

fn figures(seconds: f64, walls: usize) -> Figures {
    let estimate = PathScore {
        poses: 100,
        ate_m: 0.0083,
        start_m: Some(0.0112),
        heading_deg: 0.31,
        nees: Some(3.4),
        alignment: Pose2 { x_m: 0.01, y_m: -0.005, theta_rad: 0.01 },
    };
    let odometry = PathScore { ate_m: 0.216, start_m: Some(0.309), heading_deg: 6.2, nees: None, ..estimate };
    Figures {
        lost: 0.0,
        floor: None,
        path_m: SPEED_M_S * seconds,
        duration_s: seconds,
        estimator_s: seconds / 500.0,
        walls,
        updates: 1234,
        outliers: 56,
        mean_nis: Some(1.04),
        nis_before_gate: Some(1.9),
        median_nis_before_gate: Some(0.47),
        nis_associated: Some(1.1),
        latency_s: None,
        looking_back: None,
        outside_gate: Some(0.03),
        estimate: Some(estimate),
        odometry: Some(odometry),
        map: Some(MapScore { offset_m: Some(0.0061), matched: walls, missed: 0, invented: 0 }),
        consistency: None,
    }
}
