//! Walls that turn out to be one.

use heapless::Vec;

use crate::chance::likelier_same;
use crate::diary::Diary;
use crate::frame::{Frame, dot};
use crate::solve::Solver;
use crate::survey::{SIGMAS, is_on, through_m};
use crate::wall::Wall;

/// Two stretches of one wall are flush to within this, metres.
const FLUSH_M: f32 = 0.005;

/// 99 % of a chi-square distribution with one degree of freedom.
const GATE: f32 = 6.63;

/// Gate for walls that were both seen at one place, over half a metre, and not both can be: five sigma. A door's leaf may have been moved
/// there.
const SHARED_GATE: f32 = 25.0;
const SHARED_M: f32 = 0.5;

/// Farther apart, the robot fits between two walls, and can have seen both, metres.
const ROBOT_M: f32 = 0.35;

/// Over a metre it is no door's leaf: where beams to one went through the other there cannot be two, within thirty sigma; what is
/// farther away is a cupboard before a wall.
const HIDDEN_GATE: f32 = 900.0;
const HIDDEN_M: f32 = 1.0;

/// Farther apart, one may be another room's, metres: no corridor is narrower (escape routes: DIN 18040-1).
const REACH_M: f32 = 1.5;

/// Cosine of eight degrees.
const PARALLEL_COS: f32 = 0.99;

/// Stretches of one wall with no more than this between them are one: no door fits in, metres.
const GAP_M: f32 = 0.4;

/// Where two walls were seen is told in pieces of this length, metres, at most [`PIECES`] of them.
const PIECE_M: f32 = 0.25;
const PIECES: f32 = 128.0;

/// Pairs that are looked at in one go.
const PAIRS: usize = 32;

/// Multiply-adds of a look at two walls, and of a look at one group.
const PAIR_COST: u32 = 30;
const GROUP_COST: u32 = 10;

/// A pair that may be one wall.
#[derive(Clone, Copy, Debug)]
struct Pair {
    walls: [u8; 2],
    /// Squared distance over its variance.
    off: f32,
    /// They do not lie on each other.
    apart: bool,
}

/// Looks for pairs, one by one.
#[derive(Clone, Debug)]
pub struct Twins {
    walls: [usize; 2],
    pairs: Vec<Pair, PAIRS>,
}

impl Twins {
    /// Before the first pair.
    pub const NEW: Self = Self { walls: [0, 0], pairs: Vec::new() };

    /// Looks at the next pair. The cost in multiply-adds; none past the last.
    pub fn take<const K: usize, const G: usize, const W: usize, const B: usize, const P: usize>(
        &mut self,
        diary: &Diary<K, G, W>,
        solver: &Solver<K, W, B, P>,
    ) -> Option<u32> {
        let [a, mut b] = self.walls;
        b += 1;
        self.walls = if b < W { [a, b] } else { [a + 1, a + 1] };
        if b >= W {
            return (a + 1 < W).then_some(1);
        }
        let seen = |wall: usize| diary.walls.get(wall)?.as_ref().filter(|wall| wall.is_seen());
        let Some((first, second)) = seen(a).zip(seen(b)) else { return Some(1) };
        let look = Look { diary, solver, walls: [(a, first), (b, second)] };
        let (cost, found) = look.judge();
        if let Some((off, apart)) = found {
            let name = |wall: usize| u8::try_from(wall).unwrap_or(u8::MAX);
            // A full list has more than enough to do.
            let _ = self.pairs.push(Pair { walls: [name(a), name(b)], off, apart });
        }
        Some(cost)
    }

    /// Unites walls that may be one: all pairs that lie on each other for what is known of them; where there are none, the
    /// likeliest pair that was seen at one place. The wall with more hits stays. False where there is nothing to unite.
    pub fn unite<const K: usize, const G: usize, const W: usize>(&mut self, diary: &mut Diary<K, G, W>) -> bool {
        let mut touched = [false; W];
        let is_free = |touched: &[bool; W], pair: &Pair| {
            pair.walls.iter().all(|wall| touched.get(usize::from(*wall)).is_some_and(|touched| !touched))
        };
        let any = |touched: &[bool; W]| touched.iter().any(|touched| *touched);
        loop {
            let open = self.pairs.iter().filter(|pair| is_free(&touched, pair));
            let open = open.filter(|pair| !pair.apart || !any(&touched));
            let best = open.min_by(|a, b| a.apart.cmp(&b.apart).then(a.off.total_cmp(&b.off)));
            let Some([a, b]) = best.map(|pair| pair.walls.map(usize::from)) else { return any(&touched) };
            let hits = |wall: usize| diary.walls.get(wall).copied().flatten().map_or(0, |wall| wall.hits);
            let (kept, gone) = if hits(a) >= hits(b) { (a, b) } else { (b, a) };
            diary.unite(kept, gone);
            for wall in [a, b] {
                if let Some(touched) = touched.get_mut(wall) {
                    *touched = true;
                }
            }
        }
    }
}

/// Two walls that are looked at.
struct Look<'a, const K: usize, const G: usize, const W: usize, const B: usize, const P: usize> {
    diary: &'a Diary<K, G, W>,
    solver: &'a Solver<K, W, B, P>,
    walls: [(usize, &'a Wall); 2],
}

impl<const K: usize, const G: usize, const W: usize, const B: usize, const P: usize> Look<'_, K, G, W, B, P> {
    /// The cost, and the squared distance over its variance where they may be one, with whether they lie apart.
    fn judge(&self) -> (u32, Option<(f32, bool)>) {
        let [(_, a), (_, b)] = self.walls;
        let (line, other) = (a.line(), b.line());
        let overlap_m = [a.lo_m.max(b.lo_m), a.hi_m.min(b.hi_m)];
        if dot(line.normal, other.normal) < PARALLEL_COS || overlap_m[0] - overlap_m[1] > GAP_M {
            return (PAIR_COST, None);
        }
        let along_m = 0.5 * (overlap_m[0] + overlap_m[1]);
        let apart_m = other.rho_m - dot(other.normal, line.at(along_m));
        let Some(variance) = self.variance_apart(along_m) else { return (PAIR_COST, None) };
        let variance = variance + FLUSH_M * FLUSH_M;
        let square = apart_m * apart_m / variance;
        let len = self.solver.system.len() as u32;
        let cost = PAIR_COST + len * len / 2;
        let is_near = apart_m.abs() <= REACH_M;
        if square <= GATE.min(likelier_same(variance)) && is_near {
            return (cost, Some((square, false)));
        }
        if square > HIDDEN_GATE {
            return (cost, None);
        }
        let cost = cost + 4 * GROUP_COST * self.diary.groups.len() as u32;
        let [on_a, on_b] = [0, 1].map(|i| self.pieces(i, overlap_m));
        let shared_m = PIECE_M.max((overlap_m[1] - overlap_m[0]) / PIECES) * (on_a & on_b).count_ones() as f32;
        let hides = || self.is_crossed(0, on_a, overlap_m) || self.is_crossed(1, on_b, overlap_m);
        let is_shared = shared_m >= SHARED_M && is_near && square <= SHARED_GATE;
        let may_be_one = (is_shared && apart_m.abs() < ROBOT_M) || ((is_shared || shared_m >= HIDDEN_M) && hides());
        (cost, may_be_one.then_some((square, square > GATE)))
    }

    /// Variance of how far the second is behind the first where both are `along_m`, m^2; none where one is not placed.
    fn variance_apart(&self, along_m: f32) -> Option<f32> {
        let [(a, first), (b, second)] = self.walls;
        let (a, b) = (self.solver.place(a)?, self.solver.place(b)?);
        let (arm_a, arm_b) = (first.anchor_m - along_m, second.anchor_m - along_m);
        Some(self.solver.system.variance(&[(b, 1.0), (b + 1, arm_b), (a, -1.0), (a + 1, -arm_a)]))
    }

    /// In which pieces of an overlap hits are on one of the two. Those that may be on the other as well do not tell, nor do those on
    /// several stretches.
    fn pieces(&self, i: usize, overlap_m: [f32; 2]) -> u128 {
        let [Some(&(index, wall)), Some(&(_, other))] = [i, 1 - i].map(|i| self.walls.get(i)) else { return 0 };
        let (line, other) = (wall.line(), other.line());
        let mut pieces = 0;
        for (key, groups) in self.diary.sightings() {
            let frame = Frame::of(&key.pose);
            for group in groups.iter().filter(|group| group.wall() == Some(index) && group.is_stretch()) {
                let group = &self.diary.gains.correct(group);
                let offset = group.offset(&frame, &line);
                let may_be_other = group.offset(&frame, &other).square < SIGMAS * SIGMAS;
                if may_be_other || !is_on(group, &offset) {
                    continue;
                }
                let reach_m = group.reach_m(&offset);
                let [lo, hi] = [-reach_m, reach_m].map(|reach_m| piece(overlap_m, offset.along_m + reach_m));
                let is_in = |i: &i32| (0..PIECES as i32).contains(i);
                (lo..=hi).filter(is_in).for_each(|i| pieces |= 1 << i);
            }
        }
        pieces
    }

    /// Whether beams to the other went through one of the two where hits are on it and on both sides of that.
    fn is_crossed(&self, i: usize, pieces: u128, overlap_m: [f32; 2]) -> bool {
        let [Some(&(_, wall)), Some(&(other, _))] = [i, 1 - i].map(|i| self.walls.get(i)) else { return false };
        let (line, pieces) = (wall.line(), pieces & pieces << 1 & pieces >> 1);
        self.diary.sightings().any(|(key, groups)| {
            groups.iter().filter(|group| group.wall() == Some(other) && group.is_stretch()).any(|group| {
                let (frame, group) = (Frame::of(&key.pose), self.diary.gains.correct(group));
                let through = through_m(frame.point(group.from_m), frame.point(group.mean_m), &line);
                let at = through.map(|along_m| piece(overlap_m, along_m)).and_then(|at| u32::try_from(at).ok());
                at.and_then(|at| pieces.checked_shr(at)).is_some_and(|rest| rest & 1 == 1)
            })
        })
    }
}

/// The piece of an overlap that a place is in.
fn piece(overlap_m: [f32; 2], along_m: f32) -> i32 {
    let piece_m = PIECE_M.max((overlap_m[1] - overlap_m[0]) / PIECES);
    libm::floorf((along_m - overlap_m[0]) / piece_m) as i32
}
