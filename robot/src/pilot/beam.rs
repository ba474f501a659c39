//! What the pilot keeps of each range sensor, and how it goes into the picture.

use slam_core::{Pose, Rig};

use super::PilotConfig;
use super::memory::{Cell, Memory};

/// Steps without a reading after which a sensor is taken to see nothing, and how far it then surely sees, metres.
const EMPTY_STEPS: u8 = 5;
const EMPTY_M: f32 = 0.5;

/// What is near the body ends beams of about this length, metres.
const NEAR_M: f32 = 0.25;

/// One sensor as the pilot sees it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Beam {
    pub mount_m: [f32; 2],
    pub direction: [f32; 2],
    pub min_m: f32,
    pub max_m: f32,
    /// Last reading, metres, and the number of steps since.
    pub range_m: f32,
    pub age: u8,
    /// 1-sigma of a reading of what is near the body, tenths of a millimetre; two bytes, for which there was room.
    pub noise: u16,
}

impl Beam {
    /// Of no sensor.
    pub(crate) const NONE: Self =
        Self { mount_m: [0.0; 2], direction: [0.0; 2], min_m: 0.0, max_m: 0.0, range_m: 0.0, age: u8::MAX, noise: 0 };

    /// Of a pilot that is yet to be prepared.
    pub(crate) const ZEROS: Self = Self { age: 0, ..Self::NONE };

    /// The beams of a rig, none of them read yet.
    pub(crate) fn of_rig<const S: usize>(rig: &Rig<S>) -> [Beam; S] {
        let mut beams = [Self::NONE; S];
        for (beam, sensor) in beams.iter_mut().zip(&rig.sensors) {
            let (s, c) = slam_core::angle::sin_cos(sensor.mount.bearing_rad);
            beam.mount_m = [sensor.mount.x_m, sensor.mount.y_m];
            beam.direction = [c, s];
            beam.min_m = sensor.min_m;
            beam.max_m = sensor.max_m;
            beam.noise = (1e4 * sensor.model.noise_m(NEAR_M)) as u16;
        }
        beams
    }

    /// Takes this step's reading, if there is one that the sensor can make.
    pub(crate) fn take(&mut self, range_m: Option<f32>) {
        match range_m {
            Some(range_m) if range_m >= self.min_m && range_m <= self.max_m => {
                self.range_m = range_m;
                self.age = 0;
            }
            _ => self.age = self.age.saturating_add(1),
        }
    }

    /// 1-sigma of a reading of what is near the body, metres.
    pub(crate) fn noise_m(&self) -> f32 {
        1e-4 * f32::from(self.noise)
    }

    /// A point on the beam in the robot's frame, metres.
    pub(crate) fn point_m(&self, range_m: f32) -> [f32; 2] {
        [self.mount_m[0] + range_m * self.direction[0], self.mount_m[1] + range_m * self.direction[1]]
    }

    /// Where the beam ends in the robot's frame, if it was read in the last moments.
    pub(crate) fn hit_m(&self) -> Option<[f32; 2]> {
        (self.age <= 3).then(|| self.point_m(self.range_m))
    }
}

/// What becomes of obstacles that a beam seems to pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Passed {
    /// They vanish.
    Vanish,
    /// They stay, and what is behind them is free.
    Stay,
    /// They stay, and what is behind them is not seen.
    End,
}

/// Draws one beam into the picture: free up to its end, and a hit there where it is near enough to be placed. A beam without a
/// reading makes no obstacle vanish: a sensor that is blind sees nothing, too.
pub(crate) fn draw_beam<const N: usize>(
    memory: &mut Memory<N>,
    beam: &Beam,
    pose: &Pose,
    config: &PilotConfig,
    passed: Passed,
) {
    let trusted_m = config.trusted_m.min(0.8 * beam.max_m);
    let empty = beam.age >= EMPTY_STEPS;
    if beam.age != 0 && !empty {
        return;
    }
    let free_m = if empty { EMPTY_M.min(trusted_m) } else { (beam.range_m - memory.cell_m).min(trusted_m) };
    let from_m = pose.transform(beam.mount_m);
    let to_m = pose.transform(beam.point_m(1.0));
    let along = [to_m[0] - from_m[0], to_m[1] - from_m[1]];
    let cell_at = |memory: &Memory<N>, range_m: f32| {
        memory.cell_at(from_m[0] + range_m * along[0], from_m[1] + range_m * along[1])
    };
    let step_m = 0.5 * memory.cell_m;
    let mut last = Cell { col: i16::MIN, row: 0 };
    let mut range_m = 0.0;
    while range_m < free_m {
        let cell = cell_at(memory, range_m);
        let is_obstacle = cell != last && memory.is_obstacle(cell);
        if is_obstacle && passed == Passed::End {
            break;
        }
        if cell != last && (!is_obstacle || passed == Passed::Vanish && !empty) {
            memory.see_free(cell);
        }
        last = cell;
        range_m += step_m;
    }
    if !empty && beam.range_m <= trusted_m {
        let cell = cell_at(memory, beam.range_m);
        memory.see_hit(cell);
    }
}
