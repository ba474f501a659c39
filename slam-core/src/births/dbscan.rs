//! Density-based clustering (Ester, Kriegel, Sander and Xu 1996) of at most `B` points, in bounded time and memory.

use heapless::Vec;

/// Label of a point that belongs to no cluster.
pub const NOISE: u8 = u8::MAX;

/// Clusters of `points`: a label per point, counted from 0, [`NOISE`] for noise and for entries past the points.
///
/// A point with at least `min_points` points within `epsilon_m` (itself included) is a core point; clusters are the
/// points that can be reached from a core point over core points. A border point in reach of two clusters goes to the
/// one found first. The points are sorted along the longer side of their extent, so that only those within `epsilon_m`
/// along it are looked at; at worst O(B^2) distances, no recursion. What it sorts and queues is on the stack only while it runs.
#[inline(never)]
pub fn dbscan<const B: usize>(points: &[[f32; 2]], epsilon_m: f32, min_points: usize) -> [u8; B] {
    let mut labels = [NOISE; B];
    let points = points.get(..B).unwrap_or(points);
    let sorted = Sorted::<B>::new(points, epsilon_m);
    let mut core = [false; B];
    let mut place = [0u8; B];
    for (k, (point, core)) in sorted.points.iter().zip(&mut core).enumerate() {
        // One more than the neighbours: the point itself.
        *core = sorted.neighbours(k).take(min_points.saturating_sub(1)).count() + 1 >= min_points;
        if let Some(place) = place.get_mut(usize::from(point.index)) {
            *place = k as u8;
        }
    }
    let mut queued = [false; B];
    let mut left = points.len();
    let mut next = 0u8;
    for &seed in place.iter().take(points.len()) {
        let seed = usize::from(seed);
        let is_new = core.get(seed) == Some(&true) && queued.get(seed) == Some(&false);
        if !is_new || next == NOISE {
            continue;
        }
        let mut queue: Vec<u8, B> = Vec::new();
        let mut enqueue = |k: usize, left: &mut usize, queue: &mut Vec<u8, B>| {
            if let Some(q) = queued.get_mut(k).filter(|q| !**q) {
                *q = true;
                *left -= 1;
                let _ = queue.push(k as u8);
            }
        };
        enqueue(seed, &mut left, &mut queue);
        while let Some(k) = queue.pop() {
            let k = usize::from(k);
            let label = sorted.points.get(k).and_then(|point| labels.get_mut(usize::from(point.index)));
            if let Some(label) = label {
                *label = next;
            }
            if left > 0 && core.get(k) == Some(&true) {
                for neighbour in sorted.neighbours(k) {
                    enqueue(neighbour, &mut left, &mut queue);
                }
            }
        }
        next += 1;
    }
    labels
}

/// A point in the order along the longer side.
#[derive(Clone, Copy)]
struct Point {
    along_m: f32,
    across_m: f32,
    /// Its place in the caller's order.
    index: u8,
}

struct Sorted<const B: usize> {
    points: Vec<Point, B>,
    /// Square of the neighbourhood's radius, m^2.
    limit_m2: f32,
}

impl<const B: usize> Sorted<B> {
    fn new(points: &[[f32; 2]], epsilon_m: f32) -> Self {
        let extent = |axis: usize| {
            let (mut low, mut high) = (f32::MAX, f32::MIN);
            for value in points.iter().filter_map(|p| p.get(axis)) {
                low = if *value < low { *value } else { low };
                high = if *value > high { *value } else { high };
            }
            high - low
        };
        let swap = extent(1) > extent(0);
        let mut sorted = Vec::new();
        for (index, &[x, y]) in points.iter().enumerate() {
            let (along_m, across_m) = if swap { (y, x) } else { (x, y) };
            let _ = sorted.push(Point { along_m, across_m, index: index as u8 });
        }
        sort(&mut sorted);
        Self { points: sorted, limit_m2: epsilon_m * epsilon_m }
    }

    /// Places of the points within the radius of the one at place `k`, itself not included.
    fn neighbours(&self, k: usize) -> impl Iterator<Item = usize> {
        let (before, rest) = self.points.split_at_checked(k).unwrap_or((&[], &[]));
        let (center, after) = rest.split_first().unzip();
        let (along_m, across_m) = center.map_or((f32::NAN, f32::NAN), |p| (p.along_m, p.across_m));
        let limit_m2 = self.limit_m2;
        let within = move |p: &Point| {
            let d = p.along_m - along_m;
            d * d <= limit_m2
        };
        let near = move |p: &Point| {
            let (dx, dy) = (p.along_m - along_m, p.across_m - across_m);
            dx * dx + dy * dy <= limit_m2
        };
        let before = before.iter().enumerate().rev().take_while(move |(_, p)| within(p));
        let after = after.unwrap_or(&[]).iter().enumerate().take_while(move |(_, p)| within(p));
        let after = after.map(move |(i, p)| (k + 1 + i, p));
        before.chain(after).filter(move |(_, p)| near(p)).map(|(i, _)| i)
    }
}

/// Shell's sort with Ciura's gaps: short, and without a panic for orders that are none.
fn sort(points: &mut [Point]) {
    for gap in [57, 23, 10, 4, 1] {
        for i in gap..points.len() {
            let Some(&point) = points.get(i) else { continue };
            let mut j = i;
            while let Some(&other) = j.checked_sub(gap).and_then(|before| points.get(before)) {
                if other.along_m <= point.along_m {
                    break;
                }
                if let Some(slot) = points.get_mut(j) {
                    *slot = other;
                }
                j -= gap;
            }
            if let Some(slot) = points.get_mut(j) {
                *slot = point;
            }
        }
    }
}
