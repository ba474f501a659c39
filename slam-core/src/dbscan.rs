//! Density-based clustering (Ester, Kriegel, Sander and Xu 1996) of at most `B` points, in bounded time and memory.

/// Label of a point that belongs to no cluster.
pub const NOISE: u8 = u8::MAX;

/// Clusters of `points`: a label per point, counted from 0, [`NOISE`] for noise and for entries past the points.
///
/// A point with at least `min_points` points within `epsilon_m` (itself included) is a core point; clusters are the
/// points that can be reached from a core point over core points. A border point in reach of two clusters goes to the
/// one found first. O(B^2) distances, no recursion.
pub fn dbscan<const B: usize>(points: &[[f32; 2]], epsilon_m: f32, min_points: usize) -> [u8; B] {
    let mut labels = [NOISE; B];
    let mut queued = [false; B];
    let limit = epsilon_m * epsilon_m;
    let near = |a: &[f32; 2], b: &[f32; 2]| {
        let (dx, dy) = (a[0] - b[0], a[1] - b[1]);
        dx * dx + dy * dy <= limit
    };
    let mut neighbours = [0u8; B];
    for (i, a) in points.iter().enumerate().take(B) {
        for (j, b) in points.iter().enumerate().take(B).skip(i + 1) {
            if near(a, b) {
                for k in [i, j] {
                    if let Some(n) = neighbours.get_mut(k) {
                        *n = n.saturating_add(1);
                    }
                }
            }
        }
    }
    let is_core = |i: usize| neighbours.get(i).is_some_and(|&n| usize::from(n) + 1 >= min_points);
    let mut next = 0u8;
    for seed in 0..points.len().min(B) {
        if !is_core(seed) || labels.get(seed).is_none_or(|&l| l != NOISE) || next == NOISE {
            continue;
        }
        let mut queue: heapless::Vec<u8, B> = heapless::Vec::new();
        let mut enqueue = |i: usize, queue: &mut heapless::Vec<u8, B>| {
            if let Some(q) = queued.get_mut(i).filter(|q| !**q) {
                *q = true;
                let _ = queue.push(i as u8);
            }
        };
        enqueue(seed, &mut queue);
        while let Some(i) = queue.pop() {
            let i = usize::from(i);
            if let Some(label) = labels.get_mut(i) {
                *label = next;
            }
            let Some(a) = points.get(i).filter(|_| is_core(i)) else { continue };
            for (j, b) in points.iter().enumerate().take(B) {
                if near(a, b) {
                    enqueue(j, &mut queue);
                }
            }
        }
        next += 1;
    }
    labels
}
