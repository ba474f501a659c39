//! What the hits seen from a keyframe still say once it is made one with the keyframe before.
//!
//! A pose takes three numbers of what is seen from it: where walls tell where it is, they do not tell where they are. Its groups in the
//! other keyframe's frame, as if no pose had been between, would say these three numbers once more, each time that keyframes are made one.

use slam_core::Pose;

use crate::frame::{Frame, dot, relative};
use crate::group::Group;
use crate::wall::Wall;

/// A group that the pose takes whole keeps so much of its weight, so that it still is one.
const LEAST: f32 = 1e-3;

/// One pose in the frame of another: x, y, theta.
type Row = [f32; 3];

/// Lessens the weights of the groups seen from `there`, which are to be seen from `here`, both in the map, by what their pose takes: where
/// that is in the frame of the other is known by the odometry, with this variance on each axis, and by walls that both see. A group on
/// such a wall keeps its redundancy number of its weight (Baarda 1968), one less its leverage. One on another wall is as well known as
/// where it is seen from.
pub fn lessen(own: &[Group], others: &mut [Group], (here, there): (&Pose, &Pose), walls: &[Option<Wall>], noise: Row) {
    let (frame, apart) = (Frame::of(here), Frame::of(&relative(here, there)));
    let row = |group: &Group| {
        let wall = walls.get(group.wall()?)?.as_ref().filter(|wall| wall.is_placed)?;
        let [nx, ny] = frame.turn_back(wall.line().normal);
        // Turned about where it is seen from, the mean moves across its beam.
        Some([nx, ny, dot([ny, -nx], apart.turn(group.mean_m))])
    };
    let is_shared = |group: &Group| own.iter().any(|other| other.wall() == group.wall());
    let [x, y, theta] = noise;
    let mut covariance = [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, theta]];
    for group in others.iter().filter(|group| is_shared(group)) {
        let Some(row) = row(group) else { continue };
        let (column, known) = product(&covariance, &row);
        let inverse = group.weight / (1.0 + group.weight * known);
        for (line, a) in covariance.iter_mut().zip(column) {
            for (entry, b) in line.iter_mut().zip(column) {
                *entry -= inverse * a * b;
            }
        }
    }
    for group in others {
        let Some(row) = row(group) else { continue };
        let leverage = group.weight * product(&covariance, &row).1;
        let share = if is_shared(group) { (1.0 - leverage).max(LEAST) } else { 1.0 / (1.0 + leverage) };
        group.weight *= share;
        group.scatter = group.scatter.map(|value| share * value);
    }
}

/// A covariance times a row, and the variance of what that measures.
fn product(covariance: &[Row; 3], row: &Row) -> (Row, f32) {
    let times = |line: &Row| line.iter().zip(row).map(|(a, b)| a * b).sum::<f32>();
    let [x, y, theta] = covariance;
    let column = [times(x), times(y), times(theta)];
    (column, times(&column))
}
