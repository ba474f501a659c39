//! Whether what the sensors show changes while the pose does: where it does not, the wheels turn and the robot is held.

use crate::pilot::beam::Beam;

/// With no change over so much path the robot is held, metres: beside a wall nothing changes until its ends are in sight, and
/// walls of homes are shorter than this and twice a sensor's range.
const HELD_M: f32 = 6.0;
/// The same where the pose went through something that stands there, metres.
const THROUGH_M: f32 = 0.5;
/// At least so many sensors have to show something.
const WITNESSES: usize = 2;
/// A reading that moved by more than this and this share of itself has changed, metres: three sigma of the mean of ten readings of an
/// analogue sensor, whose noise grows with the range.
const CHANGE_M: f32 = 0.03;
const CHANGE_SHARE: f32 = 0.04;
/// Share of a new reading in the mean.
const NEW_SHARE: f32 = 0.1;

/// The mean reading of each sensor, now and where it last changed.
#[derive(Clone, Debug)]
pub(super) struct Traction<const S: usize> {
    mean_m: [f32; S],
    anchor_m: [f32; S],
    /// Path since something changed, metres.
    path_m: f32,
    /// The pose went through something since.
    is_through: bool,
}

impl<const S: usize> Traction<S> {
    pub(super) const fn new() -> Self {
        Self { mean_m: [f32::NAN; S], anchor_m: [f32::NAN; S], path_m: 0.0, is_through: false }
    }

    /// The readings after so much path (metres); whether something has changed.
    pub(super) fn step(&mut self, beams: &[Beam; S], moved_m: f32) -> bool {
        self.path_m += moved_m;
        let mut is_changed = false;
        let means = self.mean_m.iter_mut().zip(&mut self.anchor_m);
        for ((mean_m, anchor_m), beam) in means.zip(beams).filter(|(_, beam)| beam.age == 0) {
            if anchor_m.is_nan() {
                (*mean_m, *anchor_m) = (beam.range_m, beam.range_m);
            }
            *mean_m += NEW_SHARE * (beam.range_m - *mean_m);
            is_changed |= (*mean_m - *anchor_m).abs() > CHANGE_M + CHANGE_SHARE * *anchor_m;
        }
        if is_changed {
            self.begin();
        }
        is_changed
    }

    /// Whether the robot is held.
    pub(super) fn is_held(&self) -> bool {
        let most_m = if self.is_through { THROUGH_M } else { HELD_M };
        self.path_m > most_m && self.anchor_m.iter().filter(|anchor_m| !anchor_m.is_nan()).count() >= WITNESSES
    }

    /// Begins anew from here.
    pub(super) fn begin(&mut self) {
        self.anchor_m = self.mean_m;
        self.path_m = 0.0;
        self.is_through = false;
    }

    /// The pose is where something stands.
    pub(super) fn go_through(&mut self) {
        self.is_through = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_that_stay_while_the_pose_runs_on_say_that_it_is_held() {
        let beam = |range_m: f32| Beam { range_m, age: 0, ..Beam::default() };
        let run = |change_per_step_m: f32| {
            let mut traction = Traction::<4>::new();
            (0..610).any(|step| {
                let noise_m = if step % 2 == 0 { 0.01 } else { -0.01 };
                let range_m = 0.6 + noise_m + change_per_step_m * step as f32;
                traction.step(&[beam(range_m), beam(0.9), beam(0.4), beam(0.5)], 0.01);
                traction.is_held()
            })
        };
        assert!(run(0.0));
        assert!(!run(0.001), "it comes on at a slant");
    }

    #[test]
    fn a_robot_that_sees_nothing_cannot_tell() {
        let mut traction = Traction::<4>::new();
        let blind = [Beam { age: u8::MAX, ..Beam::default() }; 4];
        (0..1000).for_each(|_| {
            traction.step(&blind, 0.01);
        });
        assert!(!traction.is_held());
    }
}
