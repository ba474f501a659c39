//! Whether what the sensors show changes while the pose does: where it does not, the wheels turn and the robot is held.
//!
//! Along a straight wall a robot that is held sees what one that drives sees. So where nothing changes for a while, it looks about: it turns
//! on the spot and back. What that shows does not change for one that is held.

use crate::pilot::beam::Beam;

/// With no change over so much path the robot is held, metres: beside a wall nothing changes until its ends are in sight, and
/// walls of homes are shorter than this and twice a sensor's range.
const HELD_M: f32 = 6.0;
/// The same where the pose went through something that stands there, metres.
const THROUGH_M: f32 = 0.5;
/// After so much path with no change it looks about, metres. So far a robot that is held runs on in its map until it finds out, and the place
/// where it was held is known to centimetres. After half of that it would look about four times as often.
const UNSEEN_M: f32 = 1.0;
/// So far it turns to look about, radians, and at this rate at most, rad/s: the estimator compares readings every quarter of a radian
/// (`slam_core`'s `holds::stillness`), from the third time on they tell, and each is the mean of some.
const LOOK_RAD: f32 = 1.0;
const LOOK_RADPS: f32 = 1.0;
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
    /// Path when it last looked about since, metres; whether it does, and when that began, milliseconds as they wrap.
    looked_m: f32,
    is_looking: bool,
    since_ms: u16,
}

impl<const S: usize> Traction<S> {
    pub(super) const fn new() -> Self {
        Self {
            mean_m: [f32::NAN; S],
            anchor_m: [f32::NAN; S],
            path_m: 0.0,
            is_through: false,
            looked_m: 0.0,
            is_looking: false,
            since_ms: 0,
        }
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
        self.path_m > most_m && self.is_witnessed()
    }

    fn is_witnessed(&self) -> bool {
        self.anchor_m.iter().filter(|anchor_m| !anchor_m.is_nan()).count() >= WITNESSES
    }

    /// How fast it turns to look about, rad/s, where that is due or going on: counter-clockwise first, and back. It turns at this rate at most.
    pub(super) fn look_about(&mut self, most_radps: f32, now_us: u64) -> Option<f32> {
        let now_ms = (now_us / 1000) as u16;
        if !self.is_looking && self.path_m - self.looked_m > UNSEEN_M && self.is_witnessed() {
            (self.looked_m, self.is_looking, self.since_ms) = (self.path_m, true, now_ms);
        }
        let rate_radps = most_radps.min(LOOK_RADPS);
        // A robot that hardly turns turns as far as it can before the time wraps.
        let turn_ms = ((1e3 * LOOK_RAD / rate_radps) as u16).min(u16::MAX / 4);
        let since_ms = now_ms.wrapping_sub(self.since_ms);
        self.is_looking &= since_ms <= 2 * turn_ms;
        self.is_looking.then_some(if since_ms > turn_ms { -rate_radps } else { rate_radps })
    }

    /// Begins anew from here.
    pub(super) fn begin(&mut self) {
        self.anchor_m = self.mean_m;
        self.path_m = 0.0;
        self.looked_m = 0.0;
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
    fn where_nothing_changes_it_turns_once_in_a_metre_and_back_as_far() {
        let beams = [Beam { range_m: 0.2, age: 0, ..Beam::default() }; 4];
        for most_radps in [0.5, 2.0] {
            let mut traction = Traction::<4>::new();
            let (mut turned_rad, mut most_rad, mut looks, mut was_looking) = (0.0_f32, 0.0_f32, 0, false);
            for step in 0..5000_u64 {
                let turn_radps = traction.look_about(most_radps, 10_000 * step);
                assert!(turn_radps.is_none_or(|turn_radps| turn_radps.abs() <= most_radps));
                turned_rad += 0.01 * turn_radps.unwrap_or(0.0);
                most_rad = most_rad.max(turned_rad);
                looks += usize::from(turn_radps.is_some() && !was_looking);
                was_looking = turn_radps.is_some();
                traction.step(&beams, if was_looking { 0.0 } else { 0.001 });
            }
            assert!((0.95..1.05).contains(&most_rad) && turned_rad.abs() < 0.05, "{most_rad} {turned_rad}");
            assert_eq!(looks, if most_radps < 1.0 { 3 } else { 4 }, "a metre of path, and the time of a look");
        }
    }

    #[test]
    fn a_robot_that_hardly_turns_stops_looking_about() {
        let mut traction = Traction::<4>::new();
        let beams = [Beam { range_m: 0.2, age: 0, ..Beam::default() }; 4];
        for _ in 0..200 {
            traction.step(&beams, 0.01);
        }
        let looks = (0..6000_u64).filter(|step| traction.look_about(0.01, 10_000 * step).is_some()).count();
        assert!((3000..4000).contains(&looks), "{looks}");
    }

    #[test]
    fn a_robot_whose_readings_change_does_not_look_about() {
        let mut traction = Traction::<4>::new();
        for step in 0..9000_u64 {
            let range_m = 0.5 + 0.001 * (step % 900) as f32;
            traction.step(&[Beam { range_m, age: 0, ..Beam::default() }; 4], 0.001);
            assert_eq!(traction.look_about(1.0, 10_000 * step), None);
        }
    }

    #[test]
    fn a_robot_that_sees_nothing_cannot_tell() {
        let mut traction = Traction::<4>::new();
        let blind = [Beam { age: u8::MAX, ..Beam::default() }; 4];
        (0..1000).for_each(|_| {
            traction.step(&blind, 0.01);
        });
        assert!(!traction.is_held() && traction.look_about(1.0, 0).is_none());
    }
}
