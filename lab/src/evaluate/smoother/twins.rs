//! Walls that turn out to be one.

use std::collections::BTreeSet;

use super::graph::Graph;
use super::seen::{Beam, STRETCH_M, Seen};

/// Two stretches of one wall are flush to within this, metres.
const FLUSH_M: f64 = 0.005;

/// 99 % of a chi-square distribution with one degree of freedom.
const GATE: f64 = 6.63;

/// Walls with the same face are about so far apart, metres: the depth of a room. Where what is known of two leaves them anywhere within
/// it, one lies by chance where the other may be, and says nothing.
const ROOM_M: f64 = 3.5;

/// Gate for walls that were both seen at one place, over half a metre, and not both can be: five sigma. A door's leaf may have been moved
/// there.
const SHARED_GATE: f64 = 25.0;
const SHARED_M: f64 = 0.5;

/// Farther apart, the robot fits between two walls, and can have seen both, metres.
const ROBOT_M: f64 = 0.35;

/// Over a metre it is no door's leaf: where beams to one went through the other there cannot be two. Thirty sigma, for an
/// odometry worse than its rig file says had them 24 apart; what is farther away is a cupboard before a wall.
const HIDDEN_GATE: f64 = 900.0;
const HIDDEN_M: f64 = 1.0;

/// Farther apart, one may be another room's, metres: no corridor is narrower (escape routes: DIN 18040-1).
const REACH_M: f64 = 1.5;

/// Cosine of eight degrees.
const PARALLEL_COS: f64 = 0.99;

/// Stretches of one wall with no more than this between them are one: no door fits in, metres.
const GAP_M: f64 = 0.4;

/// Walls that beams to another one, the second, went through where readings ended on them.
type Crossed = BTreeSet<(usize, usize)>;

/// A pair that may be one wall.
struct Pair {
    kept: usize,
    gone: usize,
    /// Squared distance over its variance.
    off: f64,
    /// They do not lie on each other.
    apart: bool,
}

/// Unites walls that may be one: all pairs that lie on each other for what is known of them; where there are none, the
/// likeliest pair that was seen at one place. False where there is none either.
pub fn merge(graph: &mut Graph) -> bool {
    let mut seen = graph.seen();
    // The one with more readings stays.
    seen.sort_by_key(|wall| std::cmp::Reverse(wall.count));
    let crossed = crossed(&seen, &graph.beams());
    let mut pairs = Vec::new();
    for (i, a) in seen.iter().enumerate() {
        pairs.extend(seen[i + 1..].iter().filter_map(|b| pair(graph, a, b, &crossed)));
    }
    pairs.sort_by(|a, b| (a.apart, a.off).partial_cmp(&(b.apart, b.off)).unwrap_or(std::cmp::Ordering::Equal));
    let mut touched = Vec::new();
    for pair in &pairs {
        if (pair.apart && !touched.is_empty()) || touched.contains(&pair.kept) || touched.contains(&pair.gone) {
            continue;
        }
        graph.unite(pair.kept, pair.gone);
        touched.extend([pair.kept, pair.gone]);
    }
    !touched.is_empty()
}

fn pair(graph: &Graph, a: &Seen, b: &Seen, crossed: &Crossed) -> Option<Pair> {
    if (a.beta_rad - b.beta_rad).cos() < PARALLEL_COS {
        return None;
    }
    let (lo, hi) = (a.span_m[0].max(b.span_m[0]), a.span_m[1].min(b.span_m[1]));
    if lo - hi > GAP_M {
        return None;
    }
    let along_m = 0.5 * (lo + hi);
    let (s, c) = a.beta_rad.sin_cos();
    let on_a = [a.rho_m * c - along_m * s, a.rho_m * s + along_m * c];
    let apart_m = b.rho_m - on_a[0] * b.beta_rad.cos() - on_a[1] * b.beta_rad.sin();
    let variance = graph.variance_apart(a.wall, b.wall, along_m)?.max(0.0) + FLUSH_M * FLUSH_M;
    let square = apart_m * apart_m / variance;
    let shared_m = STRETCH_M * a.stretches.intersection(&b.stretches).count() as f64;
    let hides = crossed.contains(&(a.wall, b.wall)) || crossed.contains(&(b.wall, a.wall));
    let gate = match shared_m {
        HIDDEN_M.. if hides => HIDDEN_GATE,
        _ if apart_m.abs() > REACH_M => return None,
        SHARED_M.. if hides || apart_m.abs() < ROBOT_M => SHARED_GATE,
        _ => GATE.min(likelier_one(variance)),
    };
    (square <= gate).then_some(Pair { kept: a.wall, gone: b.wall, off: square, apart: square > GATE })
}

/// Squared distance over its variance up to which walls that are so well known, m^2, are likelier one than two: the density of the
/// distance is above that of other walls.
fn likelier_one(variance: f64) -> f64 {
    (ROOM_M * ROOM_M / (std::f64::consts::TAU * variance)).ln()
}

fn crossed(seen: &[Seen], beams: &[Beam]) -> Crossed {
    let mut crossed = Crossed::new();
    for (beam, own) in beams.iter().filter_map(|beam| Some((beam, beam.wall?))) {
        for wall in seen.iter().filter(|wall| wall.wall != own) {
            let stretch = wall.meet(beam).and_then(|meeting| meeting.through_m).map(Seen::stretch);
            if stretch.is_some_and(|stretch| wall.stretches.contains(&stretch)) {
                crossed.insert((wall.wall, own));
            }
        }
    }
    crossed
}
