//! Extending the map: the outlier buffer, births, and the map's upkeep (report 3.3).

use crate::births::birth::{self, LocalLine};
use crate::births::buffer::Outlier;
use crate::births::cluster::{Members, newest_line};
use crate::births::line_fit::{FittedLine, Influence};
use crate::births::verdict::{self, SHORT_M, Verdict};
use crate::config::WallPolicy;
use crate::filter::ekf::Ekf;
use crate::geometry::angle::sin_cos;
use crate::report::StepReport;
use crate::sensing::range::Reading;
use crate::slam::Slam;
use crate::walls::founding::{self};
use crate::walls::manhattan::GridDirection;
use crate::walls::wall::Wall;

/// A length that a wall must have to be told from a chair leg, metres; what the buffer's room per sensor is spread over
/// twice.
const SHORTEST_WALL_M: f32 = 0.25;

/// A short line that was seen with such a gap is a row of things, metres: chairs' legs stand 0.4 m apart.
const ROW_GAP_M: f32 = 0.15;

/// Clusterings per second, at most: one in each step of 25 Hz.
const CLUSTERINGS_PER_S: f32 = 25.0;

impl<const S: usize, const W: usize, const B: usize, const NB: usize, const BLOCKS: usize> Slam<S, W, B, NB, BLOCKS> {
    /// Puts a reading that fits no wall into the ring buffer, unless the sensor's last one ended at the same place.
    pub(crate) fn keep_outlier(&mut self, sensor: usize, reading: &Reading) {
        let pose = self.odometry.pose;
        let beam = self.mount_then(sensor).beam([pose.x_m, pose.y_m], sin_cos(pose.theta_rad));
        let hit_m = beam.at(reading.range_m / self.gain(sensor));
        let spacing_m = self.spacing_m();
        if let Some((_, last)) = self.buffer.newest_of(sensor as u8) {
            // Across the beam: along it, noise alone moves the hit.
            let d = [hit_m[0] - last.hit_m[0], hit_m[1] - last.hit_m[1]];
            let across_m = d[1] * beam.direction[0] - d[0] * beam.direction[1];
            if across_m.abs() < spacing_m {
                return;
            }
        }
        let outlier = Outlier {
            sensor: sensor as u8,
            hit_m,
            direction: beam.direction,
            by_factor: self.odometry.by_factor(hit_m),
            by_latency: self.by_latency(sensor, hit_m),
            range_m: reading.range_m,
            sigma_m: reading.sigma_m(),
            step: self.counters.steps as u16,
            sweep_m: self.sweep_m(sensor, reading.range_m),
            position_variance: self.odometry.position_variance,
            heading_variance: self.odometry.heading_variance,
        };
        self.counters.buffered = self.counters.buffered.saturating_add(1);
        if self.buffer.push(outlier) {
            self.counters.overwritten = self.counters.overwritten.saturating_add(1);
        }
        if let Some(pending) = self.pending.get_mut(sensor) {
            *pending = true;
        }
    }

    /// Standard deviation of a hit across its beam from not knowing when an analogue reading was made, metres.
    fn sweep_m(&self, sensor: usize, range_m: f32) -> f32 {
        let i = self.last_step.increment;
        let moved_m = libm::sqrtf(i.forward_m * i.forward_m + i.left_m * i.left_m) + (i.turn_rad * range_m).abs();
        moved_m * self.timing_share(sensor)
    }

    /// Distance between buffered hits of one sensor at which the buffer holds a stretch twice as long as the shortest
    /// wall for every sensor at once.
    fn spacing_m(&self) -> f32 {
        2.0 * SHORTEST_WALL_M * self.rig.sensors.len() as f32 / B as f32
    }

    /// Finds new walls among the outliers (report 3.3), and keeps the map tidy.
    pub(crate) fn extend_map(&mut self, report: &mut StepReport<S>) {
        let prunes_before = self.counters.prunes;
        // Clustering is the longest work of a step: one sensor's a step at 25 Hz, more where there is more time.
        let turns = (libm::ceilf(self.dt_s * CLUSTERINGS_PER_S) as usize).clamp(1, S.max(1));
        for _ in 0..turns {
            let Some(sensor) = self.next_pending() else { break };
            let (clustering, relief_m) = (self.config.clustering, self.config.relief_m);
            let found = newest_line(&self.buffer, sensor as u8, clustering, self.spacing_m(), relief_m);
            if let Some((members, line)) = found
                && self.is_wall(sensor, &line)
                && !self.is_row(&members, &line)
                && self.give_birth(&members, &line)
            {
                report.births = report.births.saturating_add(1);
                self.counters.births = self.counters.births.saturating_add(1);
                self.merge(self.map.walls().len().saturating_sub(1), true, report);
            }
        }
        founding::upkeep(
            &mut self.map,
            &mut self.ekf,
            &mut self.has_grid,
            self.config.walls,
            self.counters.steps as usize,
        );
        // One wall a step is held against all others.
        let turn = self.counters.steps as usize % self.map.walls().len().max(1);
        self.merge(turn, false, report);
        if self.map.prune(&mut self.ekf, self.odometry.path_m) {
            self.counters.prunes = self.counters.prunes.saturating_add(1);
        }
        // Those that made room for a birth are among them.
        report.prunes = (self.counters.prunes - prunes_before) as u8;
    }

    fn merge(&mut self, wall: usize, newborn: bool, report: &mut StepReport<S>) {
        if self.map.merge(&mut self.ekf, wall, newborn) {
            report.merges = report.merges.saturating_add(1);
            self.counters.merges = self.counters.merges.saturating_add(1);
        }
    }

    /// The next sensor in turn with a buffered point that has not been clustered yet.
    fn next_pending(&mut self) -> Option<usize> {
        let sensors = self.pending.len();
        for offset in 1..=sensors {
            let sensor = (self.last_clustered + offset) % sensors.max(1);
            if let Some(pending) = self.pending.get_mut(sensor).filter(|pending| **pending) {
                *pending = false;
                self.last_clustered = sensor;
                return Some(sensor);
            }
        }
        None
    }

    /// Long enough, seen under angles that the sensor supports, and straight.
    fn is_wall(&self, sensor: usize, line: &FittedLine) -> bool {
        line.length_m() >= SHORTEST_WALL_M
            && self.min_cos.get(sensor).is_some_and(|min_cos| line.cos_incidence >= *min_cos)
            && line.is_straight()
    }

    /// A short row of things with room between them, as chair legs are. Where there is an exact grid it would turn the
    /// heading; a wall near the grid turns nothing.
    fn is_row(&self, members: &Members<B>, line: &FittedLine) -> bool {
        let length_m = line.length_m();
        if length_m > SHORT_M || !self.has_grid || self.config.walls == WallPolicy::NearGrid {
            return false;
        }
        const BINS: u32 = 32;
        let mut seen = 0u32;
        for (point, _) in self.buffer.iter().zip(members).filter(|(_, member)| **member) {
            let share = (line.along(point.hit_m) - line.lo_m) / length_m.max(1e-3);
            seen |= 1 << ((share * BINS as f32) as u32).min(BINS - 1);
        }
        let (mut run, mut longest) = (0u32, 0u32);
        for bin in 0..BINS {
            run = if seen >> bin & 1 == 0 { run + 1 } else { 0 };
            longest = longest.max(run);
        }
        // Two steps apart, one reading may have been refused between two that were not.
        longest as f32 * length_m / BINS as f32 > ROW_GAP_M.max(2.0 * self.last_step.path_m)
    }

    fn give_birth(&mut self, members: &Members<B>, line: &FittedLine) -> bool {
        let mut local = self.in_robot_frame(members, line);
        let grid = self.has_grid.then(|| GridDirection::of(&self.ekf));
        let verdict = verdict::judge(&self.ekf, self.config.walls, grid.as_ref(), &local, &mut self.doubts);
        if verdict == Verdict::Wait {
            return false;
        }
        local.add_relief(self.config.relief_m);
        let full = self.map.is_full() || self.ekf.len() + 2 > Ekf::<NB, BLOCKS>::CAPACITY;
        if full && self.map.evict(&mut self.ekf, line.count, self.odometry.path_m) {
            self.counters.prunes = self.counters.prunes.saturating_add(1);
        }
        let states = if self.map.is_full() { None } else { birth::add_states(&mut self.ekf, verdict, &local) };
        let Some((rho, direction)) = states else {
            self.counters.map_full = self.counters.map_full.saturating_add(1);
            return false;
        };
        let grid = GridDirection::of(&self.ekf);
        let wall = Wall { rho, direction, ..Wall::NEW };
        let centroid = self.pose_from_start().transform(local.centroid_m);
        let along_m = wall.line(&self.ekf, &grid).along(centroid);
        let extent = (along_m + line.lo_m, along_m + line.hi_m);
        self.map.add(rho, direction, extent, line.count, self.odometry.path_m);
        self.buffer.retain(|i, _| !members.get(i).copied().unwrap_or(false));
        true
    }

    /// The fitted line from the odometry frame into the robot's, with the odometry's noise since its points were seen.
    fn in_robot_frame(&self, members: &Members<B>, line: &FittedLine) -> LocalLine {
        let to_robot = self.odometry.pose.inverse();
        let centroid_m = to_robot.transform(line.centroid_m);
        let normal_rad = line.normal_rad - self.odometry.pose.theta_rad;
        let heading = (self.odometry.heading_variance - line.heading_variance).max(0.0);
        let position = (self.odometry.position_variance - line.position_variance).max(0.0);
        let (s, c) = sin_cos(normal_rad);
        let lever_m = centroid_m[1] * c - centroid_m[0] * s;
        let (mut by_gain, mut by_drive) = ([Influence::default(); S], [Influence::default(); 3]);
        let mut by_latency = Influence::default();
        let gains: [f32; S] = core::array::from_fn(|sensor| self.gain(sensor));
        let points = self.buffer.iter().zip(members).filter(|(_, member)| **member).map(|(point, _)| point);
        for p in points {
            let weight = line.weight(p);
            let sensor = usize::from(p.sensor);
            if let (Some(influence), Some(gain)) = (by_gain.get_mut(sensor), gains.get(sensor)) {
                // hit = origin + range / gain * direction
                line.add_shift(influence, weight, p.direction.map(|d| -p.range_m / (gain * gain) * d));
            }
            // What moves the point moves the robot too: what counts is the difference.
            for ((influence, then), now) in by_drive.iter_mut().zip(p.by_factor).zip(self.odometry.by_factor(p.hit_m)) {
                line.add_shift(influence, weight, [then[0] - now[0], then[1] - now[1]]);
            }
            line.add_shift(&mut by_latency, weight, p.by_latency);
        }
        let drive = [self.layout.first_scale, self.layout.second_scale, self.layout.track];
        let latency = [(&self.layout.latency, &by_latency)];
        let states = self.layout.gains.iter().zip(&by_gain).chain(drive.iter().zip(&by_drive)).chain(latency);
        let mut by_calibration = heapless::Vec::new();
        for (state, influence) in states {
            let (offset, direction) = line.by_parameter(influence);
            if let Some(state) = *state
                && (offset != 0.0 || direction != 0.0)
            {
                let _ = by_calibration.push((state, offset, direction));
            }
        }
        LocalLine {
            centroid_m,
            normal_rad,
            // A heading that walks randomly over a stretch moves its end by a third of the lever squared.
            variance_m2: line.variance_m2 + position + heading * lever_m * lever_m * (1.0 / 3.0),
            direction_variance: line.direction_variance + heading,
            length_m: line.length_m(),
            count: line.count,
            seen_m: line.centroid_m,
            path_m: self.odometry.path_m,
            by_calibration,
        }
    }
}
