//! Extending the map: from the outlier buffer to new walls (Rousse & Qiu 3.3).

use crate::births::BirthSettings;
use crate::births::birth;
use crate::births::candidates::{Candidates, SHORTEST_WALL_M};
use crate::births::cluster::{Members, newest_line};
use crate::births::line_fit::FittedLine;
use crate::births::local_line::{LocalLine, Origin};
use crate::births::verdict::{self, SHORT_M, Verdict};
use crate::filter::ekf::EkfView;
use crate::filter::layout;
use crate::geometry::angle::normal;
use crate::measurement::first_estimates::FirstEstimates;
use crate::measurement::sensor::SensorState;
use crate::motion::drive::Drive;
use crate::report::Changes;
use crate::sensing::latency::Latency;
use crate::walls::WallSettings;
use crate::walls::anchor::Anchor;
use crate::walls::decision::deviation;
use crate::walls::manhattan::ManhattanFrame;
use crate::walls::map::MapView;
use crate::walls::wall::Wall;

/// Gap between points from which a short line counts as a row of things, metres: chairs' legs stand 0.4 m apart.
const ROW_GAP_M: f32 = 0.15;

/// Where new walls come from, and where they go.
pub struct Extension<'a, const B: usize> {
    /// Settings of this stage.
    pub settings: &'a BirthSettings,
    /// What walls are like.
    pub walls: &'a WallSettings,
    /// The state.
    pub ekf: &'a mut EkfView,
    /// The walls.
    pub map: &'a mut MapView,
    /// Readings that fit no wall.
    pub candidates: &'a mut Candidates<B>,
    /// The robot's motion so far.
    pub drive: &'a Drive,
    /// Every sensor that there is room for.
    pub sensors: &'a [SensorState],
    /// Number of sensors in the rig.
    pub in_rig: usize,
    /// How late readings in metres are.
    pub latency: &'a Latency,
    /// What the models are differentiated at.
    pub first: &'a mut FirstEstimates,
    /// Variance of (x, y, theta) where a robot of this drive starts.
    pub start_variance: [f32; 3],
}

impl<const B: usize> Extension<'_, B> {
    /// Finds new walls among the outliers, in a step that has time for so many turns, and adds them to the map.
    pub fn extend(&mut self, turns: usize) -> Changes {
        let mut changes = Changes::default();
        // Clustering is the longest work of a step: a turn is one sensor's.
        for _ in 0..turns.min(self.sensors.len().max(1)) {
            let Some(sensor) = self.candidates.next_pending(self.sensors.len()) else { break };
            let spacing_m = Candidates::<B>::spacing_m(self.in_rig);
            let (clustering, relief_m) = (self.settings.clustering, self.walls.relief_m);
            let found = newest_line(&self.candidates.buffer, sensor as u8, clustering, spacing_m, relief_m);
            if let Some((members, line)) = found
                && self.is_wall(sensor, &line)
                && !self.is_row(&members, &line)
                && self.give_birth(&members, &line, &mut changes)
            {
                changes.births = changes.births.saturating_add(1);
                let newborn = self.map.walls().len().saturating_sub(1);
                changes.merges += u8::from(self.map.merge(self.ekf, self.walls.policy, newborn, true));
            }
        }
        changes
    }

    /// Long enough, seen under angles that the sensor supports, and straight.
    fn is_wall(&self, sensor: usize, line: &FittedLine) -> bool {
        line.length_m() >= SHORTEST_WALL_M
            && self.sensors.get(sensor).is_some_and(|sensor| line.cos_incidence >= sensor.min_cos)
            && line.is_straight()
    }

    /// A short row of things with room between them, as chair legs are. Where there is an exact grid it would turn the
    /// heading; a wall near the grid turns nothing.
    fn is_row(&self, members: &Members<B>, line: &FittedLine) -> bool {
        let length_m = line.length_m();
        if length_m > SHORT_M || !self.map.has_grid || deviation(self.walls.policy) > 0.0 {
            return false;
        }
        const BINS: u32 = 32;
        let mut seen = 0u32;
        for (point, _) in self.candidates.buffer.iter().zip(members).filter(|(_, member)| **member) {
            let share = (line.along(point.hit_m) - line.lo_m) / length_m.max(1e-3);
            seen |= 1 << ((share * BINS as f32) as u32).min(BINS - 1);
        }
        let (mut run, mut longest) = (0u32, 0u32);
        for bin in 0..BINS {
            run = if seen >> bin & 1 == 0 { run + 1 } else { 0 };
            longest = longest.max(run);
        }
        // Two steps apart, one reading may have been refused between two that were not.
        longest as f32 * length_m / BINS as f32 > ROW_GAP_M.max(2.0 * self.drive.step.path_m)
    }

    /// Begins anew where the robot is, if there is no wall yet and the start is known badly.
    fn drop_anchor(&mut self) {
        if self.map.walls().is_empty() && Anchor::is_due(self.ekf) {
            self.map.drop_anchor(self.ekf, self.start_variance, &self.drive.states);
            *self.first = FirstEstimates::START;
        }
    }

    /// Adds the wall that a line is, where it is clear which, and takes its points out of the buffer. Its variables are on the stack only
    /// while it runs, not beside those of the clustering.
    #[inline(never)]
    fn give_birth(&mut self, members: &Members<B>, line: &FittedLine, changes: &mut Changes) -> bool {
        self.drop_anchor();
        let points = self.candidates.buffer.iter().zip(members).filter(|(_, member)| **member).map(|(point, _)| point);
        let origin = Origin { ekf: self.ekf, drive: self.drive, sensors: self.sensors, latency: self.latency };
        let mut local = LocalLine::new(&origin, line, points);
        let grid = self.map.grid(self.ekf);
        let policy = self.walls.policy;
        let doubts = &mut self.candidates.doubts;
        let verdict = match verdict::judge(self.ekf, policy, grid.as_ref(), &local, self.map.walls(), doubts) {
            // Where there is no room for a direction of its own, it has the grid's.
            Verdict::NearGrid(quarter, _) if self.ekf.len() + 2 > self.ekf.capacity() => Verdict::OnGrid(quarter),
            verdict => verdict,
        };
        if verdict == Verdict::Wait {
            return false;
        }
        local.add_relief(self.walls.relief_m);
        let path_m = self.drive.dead_reckoning.path_m;
        let states = if matches!(verdict, Verdict::OnGrid(_)) { 1 } else { 2 };
        let lacking = (self.ekf.len() + states).saturating_sub(self.ekf.capacity());
        let is_full = self.map.is_full() || lacking > 0;
        if is_full && self.map.evict(self.ekf, line.count, lacking, path_m) {
            changes.prunes = changes.prunes.saturating_add(1);
        }
        let first_normal = match verdict {
            Verdict::OnGrid(quarter) => ManhattanFrame::of(self.ekf).normal(quarter),
            _ => normal(self.ekf.mean(layout::THETA) + local.normal_rad),
        };
        let states = if self.map.is_full() { None } else { birth::add_states(self.ekf, verdict, &local) };
        let Some((rho, direction)) = states else {
            changes.refused = changes.refused.saturating_add(1);
            return false;
        };
        let mut wall = Wall { first_normal, ..Wall::at(rho, direction, (0.0, 0.0)) };
        let centroid = layout::pose(self.ekf).transform(local.centroid_m);
        let along_m = wall.line(self.ekf, &ManhattanFrame::of(self.ekf)).along(centroid);
        (wall.lo_m, wall.hi_m) = (along_m + line.lo_m, along_m + line.hi_m);
        self.map.add(wall, line.count, path_m);
        self.candidates.buffer.retain(|i, _| !members.get(i).copied().unwrap_or(false));
        true
    }
}
