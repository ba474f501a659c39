//! From the outlier buffer to at most one new line: clustering, splitting at corners, noise or line (Rousse & Qiu 3.3, fig. 2).
//!
//! Both clusterings are asked for the cluster of one sensor's newest point, every time one is added: other clusters had
//! their turn when their own newest point came. The points of the cluster are taken from that one backwards for as long
//! as they stay straight, which splits a cluster that runs around a corner at the corner.

use crate::births::buffer::OutlierBuffer;
use crate::births::dbscan::{NOISE, dbscan};
use crate::births::line_fit::{FittedLine, Moments, fit};
use crate::walls::wall::GAP_M;

/// How outliers are grouped into candidate walls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Clustering {
    /// Readings of one sensor that follow each other.
    #[default]
    BySensor,
    /// Density-based over all sensors (Ester et al. 1996).
    Dbscan,
}

/// Fewest points of a line: two make any line, and each further one is a test of it.
const MIN_POINTS: u32 = 5;

/// Points from around a corner that a run may have taken in before it is seen to bend: the first is within a spacing of
/// the corner, and it takes about two more to stand out of the noise.
const CORNER_POINTS: usize = 3;

/// Fewest points, one's own included, in a core point's neighbourhood: twice the dimension (Sander et al. 1998).
const DBSCAN_MIN_POINTS: usize = 4;

/// Which points of the buffer belong together, by their position in it.
pub type Members<const B: usize> = [bool; B];

/// The straight part of the cluster of `sensor`'s newest point, and the line through it; none where it is noise.
pub fn newest_line<const B: usize>(
    buffer: &OutlierBuffer<B>,
    sensor: u8,
    clustering: Clustering,
    spacing_m: f32,
    relief_m: f32,
) -> Option<(Members<B>, FittedLine)> {
    let (anchor, newest) = buffer.newest_of(sensor)?;
    let mut cluster = [false; B];
    match clustering {
        Clustering::BySensor => {
            for (member, point) in cluster.iter_mut().zip(buffer.iter()) {
                *member = point.sensor == newest.sensor;
            }
        }
        Clustering::Dbscan => {
            let mut hits: heapless::Vec<[f32; 2], B> = heapless::Vec::new();
            for point in buffer.iter() {
                let _ = hits.push(point.hit_m);
            }
            // Neighbours on one wall are `spacing_m` apart along it, and scatter by the noise of both.
            let epsilon_m = 3.0 * (spacing_m + newest.sigma_m);
            let labels = dbscan::<B>(&hits, epsilon_m, DBSCAN_MIN_POINTS);
            let label = labels.get(anchor).copied().filter(|&l| l != NOISE)?;
            for (member, l) in cluster.iter_mut().zip(labels) {
                *member = l == label;
            }
        }
    }
    let mut members = straight_part(buffer, &cluster, anchor, relief_m)?;
    let line = fit_members(buffer, &members, relief_m)?;
    grow(buffer, &mut members, &line, relief_m);
    let line = fit_members(buffer, &members, relief_m)?;
    Some((members, line))
}

/// The longest run of the cluster's points, from the anchor backwards, that is straight and has no gap as wide as a
/// door that nothing was read in. Where it ends because it bends, the last few points are left out: they may be from around the corner already,
/// hidden in the noise, and at its end they would turn the line most.
fn straight_part<const B: usize>(
    buffer: &OutlierBuffer<B>,
    cluster: &Members<B>,
    anchor: usize,
    relief_m: f32,
) -> Option<Members<B>> {
    let newest = buffer.get(anchor)?;
    let mut members = [false; B];
    let mut moments = Moments::about(newest.hit_m, relief_m);
    let mut last = newest;
    let mut count = 0;
    let mut bends = false;
    for (i, (member, &in_cluster)) in members.iter_mut().zip(cluster).enumerate().take(anchor + 1).rev() {
        let Some(point) = buffer.get(i).filter(|_| in_cluster) else { continue };
        let gap = [point.hit_m[0] - last.hit_m[0], point.hit_m[1] - last.hit_m[1]];
        // Readings of one sensor in steps that follow each other have seen all there is to see between them.
        let follows = point.sensor == last.sensor && last.step.wrapping_sub(point.step) <= 1;
        if !follows && gap[0] * gap[0] + gap[1] * gap[1] > GAP_M * GAP_M {
            break;
        }
        let mut longer = moments;
        longer.add(point);
        if !longer.scatter().is_straight() {
            bends = true;
            break;
        }
        moments = longer;
        last = point;
        *member = true;
        count += 1;
    }
    if bends {
        let oldest = members.iter_mut().filter(|member| **member).take(CORNER_POINTS);
        for member in oldest {
            *member = false;
            count -= 1;
        }
    }
    (count >= MIN_POINTS).then_some(members)
}

fn fit_members<const B: usize>(buffer: &OutlierBuffer<B>, members: &Members<B>, relief_m: f32) -> Option<FittedLine> {
    let points = buffer.iter().zip(members).filter(|(_, m)| **m).map(|(p, _)| p);
    let mut moments = Moments::about(points.clone().next()?.hit_m, relief_m);
    for point in points.clone() {
        moments.add(point);
    }
    Some(fit::<B>(points, &moments.scatter(), relief_m))
}

/// Adds every point, of whichever sensor, that lies on the line within its noise and the line's, close enough to what
/// the line has already.
fn grow<const B: usize>(buffer: &OutlierBuffer<B>, members: &mut Members<B>, line: &FittedLine, relief_m: f32) {
    for (member, point) in members.iter_mut().zip(buffer.iter()) {
        let along = line.along(point.hit_m);
        let (residual, sigma) = line.residual(point.hit_m);
        let cos = point.direction[0] * line.normal[0] + point.direction[1] * line.normal[1];
        let sensor_m = point.sigma_m * cos;
        let noise_m2 = sensor_m * sensor_m + relief_m * relief_m;
        let near = along > line.lo_m - GAP_M && along < line.hi_m + GAP_M;
        // A line that does not know where it is going cannot tell its own points from those of a corner's other wall.
        let known = sigma * sigma < noise_m2;
        // 95 % of a chi-square distribution with one degree of freedom.
        if near && cos > 0.0 && known && residual * residual < 3.84 * (noise_m2 + sigma * sigma) {
            *member = true;
        }
    }
}
