//! P J^T of a sparse row J.

use super::{HEAD, LANES, Pair, TILE, rows};

/// The first `N` entries of the first `W` blocks of tile `m` of P J^T: the first states' rows times the factors of `head`,
/// and the others' as they are stored: a row where the state is left of the tile, a column where it is right of it.
#[inline(never)]
pub fn tile<const N: usize, const W: usize>(
    pairs: &[Pair],
    m: usize,
    [e, f, g, h]: &[f32; HEAD],
    others: &[(usize, f32)],
    out: &mut [[f32; N]; W],
) {
    let first = TILE * m;
    let Some((above, diagonal)) = pairs.get(rows(m)..).and_then(|rows| rows.split_at_checked(first)) else {
        return;
    };
    let Some(diagonal) = diagonal.first_chunk() else { return };
    // In registers. Loops of more than eight turns would put it in memory.
    let mut sums = [[0.0; N]; W];
    if let Some([p, q, r, s]) = above.first_chunk() {
        for (w, sums) in sums.iter_mut().enumerate() {
            for (k, sum) in sums.iter_mut().enumerate() {
                *sum = e * p[w][k] + f * q[w][k] + g * r[w][k] + h * s[w][k];
            }
        }
    } else {
        for (w, sums) in sums.iter_mut().enumerate() {
            for (k, sum) in sums.iter_mut().enumerate() {
                let p = |c| crossed(diagonal, c, LANES * w + k);
                *sum = e * p(0) + f * p(1) + g * p(2) + h * p(3);
            }
        }
    }
    for &(state, factor) in others {
        if let Some(row) = above.get(state) {
            for (w, sums) in sums.iter_mut().enumerate() {
                for (k, sum) in sums.iter_mut().enumerate() {
                    *sum += factor * row[w][k];
                }
            }
        } else if state >= first + TILE {
            let rows = pairs.get(rows(state / TILE) + first..).and_then(|rows| rows.first_chunk::<TILE>());
            let Some(rows) = rows else { continue };
            for (w, sums) in sums.iter_mut().enumerate() {
                for (k, sum) in sums.iter_mut().enumerate() {
                    *sum += factor * rows[(LANES * w + k) % TILE][state / LANES % 2][state % LANES];
                }
            }
        } else {
            add_beside(&mut sums, diagonal, factor, state % TILE);
        }
    }
    *out = sums;
}

/// Adds row and column `c` of the tile on the diagonal, times a factor.
#[inline(always)]
fn add_beside<const N: usize, const W: usize>(
    sums: &mut [[f32; N]; W],
    diagonal: &[Pair; TILE],
    factor: f32,
    c: usize,
) {
    // Each with constant addresses. No state of the tile is past what is asked for.
    match c % (N * W) {
        0 => add_crossed::<N, W, 0>(sums, diagonal, factor),
        1 => add_crossed::<N, W, 1>(sums, diagonal, factor),
        2 => add_crossed::<N, W, 2>(sums, diagonal, factor),
        3 => add_crossed::<N, W, 3>(sums, diagonal, factor),
        4 => add_crossed::<N, W, 4>(sums, diagonal, factor),
        5 => add_crossed::<N, W, 5>(sums, diagonal, factor),
        6 => add_crossed::<N, W, 6>(sums, diagonal, factor),
        7 => add_crossed::<N, W, 7>(sums, diagonal, factor),
        8 => add_crossed::<N, W, 8>(sums, diagonal, factor),
        9 => add_crossed::<N, W, 9>(sums, diagonal, factor),
        10 => add_crossed::<N, W, 10>(sums, diagonal, factor),
        11 => add_crossed::<N, W, 11>(sums, diagonal, factor),
        12 => add_crossed::<N, W, 12>(sums, diagonal, factor),
        13 => add_crossed::<N, W, 13>(sums, diagonal, factor),
        14 => add_crossed::<N, W, 14>(sums, diagonal, factor),
        _ => add_crossed::<N, W, 15>(sums, diagonal, factor),
    }
}

#[inline(always)]
fn add_crossed<const N: usize, const W: usize, const C: usize>(
    sums: &mut [[f32; N]; W],
    diagonal: &[Pair; TILE],
    factor: f32,
) {
    for (w, sums) in sums.iter_mut().enumerate() {
        for (k, sum) in sums.iter_mut().enumerate() {
            *sum += factor * crossed(diagonal, C, LANES * w + k);
        }
    }
}

/// Entry `k` of a tile's row and column `c`, of which only what is right of the diagonal is stored.
#[inline(always)]
fn crossed(diagonal: &[Pair; TILE], c: usize, k: usize) -> f32 {
    let (i, j) = if k < c { (k, c) } else { (c, k) };
    diagonal[i % TILE][j / LANES % 2][j % LANES]
}
