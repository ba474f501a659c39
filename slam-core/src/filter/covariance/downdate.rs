//! The downdate's inner loops, rows -= factor * g.
//!
//! On a Cortex-M4F most of the time goes into loads and stores. It has 32 registers for floats: sixteen hold g over all
//! rows, fourteen a row. The compiler merges loads and stores into one VLDM or VSTM where neighbouring entries are in
//! neighbouring registers, which its order of work decides, see [`pair`]. Another compiler that did it otherwise would
//! compute the same, slower.

use super::{Block, LANES, Pair};

/// rows -= factors g^T for rows of sixteen entries, eight rows a turn.
#[inline(never)]
pub fn pairs(mut rows: &mut [Pair], factors: &[Block], g: &Block, h: &Block) {
    let g = [*g, *h];
    for [a, b, c, d, e, f, i, j] in factors {
        // Taking the rows here, not zipping them, keeps one address for all entries of a turn.
        let Some(([p, q, r, s, t, u, v, w], rest)) = rows.split_first_chunk_mut() else { break };
        pair(p, a, &g);
        pair(q, b, &g);
        pair(r, c, &g);
        pair(s, d, &g);
        pair(t, e, &g);
        pair(u, f, &g);
        pair(v, i, &g);
        pair(w, j, &g);
        rows = rest;
    }
}

#[cfg(not(target_arch = "arm"))]
#[inline(always)]
fn pair(row: &mut Pair, factor: &f32, g: &Pair) {
    for (p, g) in row.as_flattened_mut().iter_mut().zip(g.as_flattened()) {
        *p -= factor * g;
    }
}

/// One row. Registers are handed out in the order of the loads, first the even ones, then the odd ones: so the even
/// entries are loaded first. Left alone, the compiler would sort the loads by address: the four lowest of those between
/// two fences, which are no instructions, and any eight neighbours that are all on one side of a fence. The first half's
/// even entries are the four; the second half's eighth entry is on the other side; so the second half's first seven
/// loads become one VLDM, and the stores of seven and seven two VSTM.
#[cfg(target_arch = "arm")]
#[inline(always)]
fn pair(row: &mut Pair, factor: &f32, [g, h]: &Pair) {
    use core::sync::atomic::{Ordering::SeqCst, compiler_fence};
    let [_, [b0, _, b2, _, b4, _, b6, _]] = *row;
    let [[a0, _, a2, _, a4, _, a6, _], _] = *row;
    let [_, [_, b1, _, b3, _, b5, _, _]] = *row;
    compiler_fence(SeqCst);
    let f = *factor;
    let [[_, a1, _, a3, _, a5, _, _], _] = *row;
    compiler_fence(SeqCst);
    let b = [b0 - f * h[0], b1 - f * h[1], b2 - f * h[2], b3 - f * h[3], b4 - f * h[4], b5 - f * h[5], b6 - f * h[6]];
    let a = [a0 - f * g[0], a1 - f * g[1], a2 - f * g[2], a3 - f * g[3], a4 - f * g[4], a5 - f * g[5], a6 - f * g[6]];
    compiler_fence(SeqCst);
    let [first, second] = row;
    [second[0], second[1], second[2], second[3], second[4], second[5], second[6]] = b;
    [first[0], first[1], first[2], first[3], first[4], first[5], first[6]] = a;
    compiler_fence(SeqCst);
    // No register was left for these.
    first[7] -= f * g[7];
    second[7] -= f * h[7];
    compiler_fence(SeqCst);
}

/// The same for the first `WIDTH` entries of each row.
#[inline(never)]
pub fn lanes<const WIDTH: usize>(mut rows: &mut [Pair], factors: &[Block], g: &Block) {
    let g = *g;
    for [a, b, c, d, e, f, i, j] in factors {
        let Some(([p, q, r, s, t, u, v, w], rest)) = rows.split_first_chunk_mut() else { break };
        part::<0, 0, WIDTH>(p, a, &g);
        part::<0, 0, WIDTH>(q, b, &g);
        part::<0, 0, WIDTH>(r, c, &g);
        part::<0, 0, WIDTH>(s, d, &g);
        part::<0, 0, WIDTH>(t, e, &g);
        part::<0, 0, WIDTH>(u, f, &g);
        part::<0, 0, WIDTH>(v, i, &g);
        part::<0, 0, WIDTH>(w, j, &g);
        rows = rest;
    }
}

/// The same for the upper triangle of the first `WIDTH` rows and columns, four or eight, of a block on the diagonal,
/// which is the tile's first or second.
#[inline(never)]
pub fn triangle<const SIDE: usize, const WIDTH: usize>(rows: &mut [Pair], factors: &Block, g: &Block) {
    let Some([p, q, r, s, t, u, v, w]) = rows.first_chunk_mut() else { return };
    let ([a, b, c, d, e, f, i, j], g) = (factors, *g);
    part::<SIDE, 0, WIDTH>(p, a, &g);
    part::<SIDE, 1, WIDTH>(q, b, &g);
    part::<SIDE, 2, WIDTH>(r, c, &g);
    part::<SIDE, 3, WIDTH>(s, d, &g);
    if WIDTH > LANES / 2 {
        part::<SIDE, 4, WIDTH>(t, e, &g);
        part::<SIDE, 5, WIDTH>(u, f, &g);
        part::<SIDE, 6, WIDTH>(v, i, &g);
        part::<SIDE, 7, WIDTH>(w, j, &g);
    }
}

/// The entries `FROM..TO` of one half of a row.
#[inline(always)]
fn part<const SIDE: usize, const FROM: usize, const TO: usize>(row: &mut Pair, factor: &f32, g: &Block) {
    // What is left of the diagonal may be computed, too: with vector registers that is faster.
    let from = if cfg!(target_arch = "arm") { FROM } else { 0 };
    for (k, (p, g)) in row[SIDE].iter_mut().zip(g).enumerate() {
        if (from..TO).contains(&k) {
            *p -= factor * g;
        }
    }
}

/// gain = factor * column and mean += innovation * gain.
#[inline(never)]
pub fn correct(mean: &mut [Block], gain: &mut [Block], column: &[Block], factor: f32, innovation: f32) {
    for ((x, gain), g) in mean.iter_mut().zip(gain).zip(column) {
        let k = g.map(|g| factor * g);
        *gain = k;
        for (x, k) in x.iter_mut().zip(k) {
            *x += innovation * k;
        }
    }
}
