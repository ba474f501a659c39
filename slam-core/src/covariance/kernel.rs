//! The downdate's inner loops: rows -= factor * g, with g held in registers over all rows.
//!
//! On a Cortex-M4F most of the time goes into loads and stores. It has 32 registers for floats: sixteen hold g, fourteen
//! a row. The compiler merges the row's stores into one VSTM where neighbouring entries are in neighbouring registers.
//! It hands out the even registers first, in the order of the loads, and then the odd ones: so the even entries are
//! loaded before the odd ones, and fences, which are no instructions, keep that order. Another compiler that did it
//! otherwise would compute the same, slower.

use super::Block;

/// Two neighbouring blocks of a row.
pub type Pair = [Block; 2];

/// Rows that are worked on in one turn of a loop.
pub const TURN: usize = 4;

/// rows -= factors g^T for rows of sixteen entries.
#[inline(never)]
pub fn pairs(rows: &mut [[Pair; TURN]], factors: &[[f32; TURN]], g: &Block, h: &Block) {
    let g = [*g, *h];
    let mut factors = factors.iter();
    for [p, q, r, s] in rows {
        // Asking for the factor here keeps the compiler from unrolling further, which costs it the merged stores.
        let Some([f, e, d, c]) = factors.next() else { break };
        pair(p, f, &g);
        pair(q, e, &g);
        pair(r, d, &g);
        pair(s, c, &g);
    }
}

#[cfg(not(target_arch = "arm"))]
#[inline(always)]
fn pair(row: &mut Pair, factor: &f32, g: &Pair) {
    for (p, g) in row.as_flattened_mut().iter_mut().zip(g.as_flattened()) {
        *p -= factor * g;
    }
}

#[cfg(target_arch = "arm")]
#[inline(always)]
fn pair(row: &mut Pair, factor: &f32, [g, h]: &Pair) {
    use core::sync::atomic::{Ordering::SeqCst, compiler_fence};
    let [[a0, _, a2, _, a4, _, a6, _], [b0, _, b2, _, b4, _, b6, _]] = *row;
    compiler_fence(SeqCst);
    let [[_, a1, _, a3, _, a5, _, a7], [_, b1, _, b3, ..]] = *row;
    compiler_fence(SeqCst);
    let f = *factor;
    let a = [
        a0 - f * g[0],
        a1 - f * g[1],
        a2 - f * g[2],
        a3 - f * g[3],
        a4 - f * g[4],
        a5 - f * g[5],
        a6 - f * g[6],
        a7 - f * g[7],
    ];
    let b = [b0 - f * h[0], b1 - f * h[1], b2 - f * h[2], b3 - f * h[3], b4 - f * h[4], b6 - f * h[6]];
    compiler_fence(SeqCst);
    let [first, second] = row;
    *first = a;
    [second[0], second[1], second[2], second[3], second[4], second[6]] = b;
    compiler_fence(SeqCst);
    // No register was left for these.
    second[5] -= f * h[5];
    second[7] -= f * h[7];
}

/// The same for the entries `FROM..TO` of blocks that are `STRIDE` blocks apart.
#[inline(never)]
pub fn blocks<const STRIDE: usize, const FROM: usize, const TO: usize>(
    rows: &mut [[[Block; STRIDE]; TURN]],
    factors: &[[f32; TURN]],
    g: &Block,
) {
    let g = *g;
    for (rows, factors) in rows.iter_mut().zip(factors) {
        for (row, factor) in rows.iter_mut().filter_map(|row| row.first_mut()).zip(factors) {
            for (lane, (p, g)) in row.iter_mut().zip(g).enumerate() {
                if (FROM..TO).contains(&lane) {
                    *p -= factor * g;
                }
            }
        }
    }
}
