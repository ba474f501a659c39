//! How far readings in use end from their walls, as they were seen at the time and as they look from the end.

use lab::evaluate::score::path;
use lab::evaluate::statistics::median;
use lab::recording::{Pose2, Recording};
use slam_core::{Outcome, WallView};

/// A wall may go on so far beyond what was seen of it, metres.
const BEYOND_M: f64 = 0.125;

/// Medians over the second half of a log, metres.
pub struct Distances {
    /// Of the filter's readings from its own walls, both as they were at the time.
    pub own_m: f64,
    /// Of the same from the walls of the look back, after the rigid motion that fits the poses best.
    pub live_m: f64,
    /// Of the same from those, seen from where the look back has the robot.
    pub back_m: f64,
}

/// Of the readings that the filter of `live` used; `back` is a look back on the same log.
pub fn distances(live: &Recording, back: &Recording) -> Distances {
    let half = live.steps.len() / 2;
    let pairs: Vec<(Pose2, Pose2)> =
        live.steps[half..].iter().zip(&back.steps[half..]).map(|(live, back)| (live.pose, back.pose)).collect();
    let to_back = path::align(&pairs);
    let [mut own_m, mut live_m, mut back_m] = [const { Vec::new() }; 3];
    for (i, (step, there)) in live.steps.iter().zip(&back.steps).enumerate().skip(half) {
        let map = live.maps.iter().rev().find(|map| map.step <= i);
        for reading in live.readings(i) {
            let (Outcome::Updated { wall, .. }, Some(hit)) = (reading.outcome, reading.hit_m) else { continue };
            let hit = hit.map(f64::from);
            let local = step.pose.relative(&Pose2::new(hit[0], hit[1], 0.0));
            let seen = there.pose.transform([local.x_m, local.y_m]);
            let own = map.and_then(|map| map.walls.iter().find(|own| own.id == wall));
            own_m.extend(own.map(|own| off_m(own, hit).abs()));
            let place = [there.pose.x_m, there.pose.y_m];
            let meets = |wall: &&WallView| along(wall, seen) && off_m(wall, place) < 0.0;
            let walls = back.walls().iter().filter(meets);
            let Some(met) = walls.min_by(|a, b| off_m(a, seen).abs().total_cmp(&off_m(b, seen).abs())) else {
                continue;
            };
            back_m.push(off_m(met, seen).abs());
            live_m.push(off_m(met, to_back.transform(hit)).abs());
        }
    }
    let [own_m, live_m, back_m] = [own_m, live_m, back_m].map(|all| median(&all).unwrap_or(f64::NAN));
    Distances { own_m, live_m, back_m }
}

/// How far a point is behind a wall's line, metres.
fn off_m(wall: &WallView, [x, y]: [f64; 2]) -> f64 {
    let (s, c) = f64::from(wall.beta_rad).sin_cos();
    c * x + s * y - f64::from(wall.rho_m)
}

/// Whether a point is beside what was seen of a wall.
fn along(wall: &WallView, [x, y]: [f64; 2]) -> bool {
    let (s, c) = f64::from(wall.beta_rad).sin_cos();
    (f64::from(wall.lo_m) - BEYOND_M..=f64::from(wall.hi_m) + BEYOND_M).contains(&(c * y - s * x))
}
