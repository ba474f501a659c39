//! The packed covariance against the textbook, for every length of state.

use std::vec;
use std::vec::Vec;

use super::random::Random;
use crate::filter::covariance::{Covariance, HEAD, LANES, Pair, TILE, entry, rows};

const TILES: usize = 3;
const CAPACITY: usize = TILE * TILES;
type Packed = Covariance<[Pair; rows(TILES)]>;
type Vector = [Pair; TILES];

const ZERO: Packed = Covariance([[[0.0; LANES]; 2]; rows(TILES)]);

fn random_symmetric(random: &mut Random, n: usize) -> (Packed, Vec<Vec<f64>>) {
    let (mut packed, mut dense) = (ZERO, vec![vec![0.0; n]; n]);
    for i in 0..n {
        for j in 0..=i {
            let value = random.uniform(-1.0, 1.0) as f32;
            packed.set(i, j, value);
            (dense[i][j], dense[j][i]) = (value.into(), value.into());
        }
    }
    (packed, dense)
}

fn random_vector(random: &mut Random, n: usize) -> (Vector, Vec<f64>) {
    let mut vector = [[[0.0; LANES]; 2]; TILES];
    let values: Vec<f64> = (0..n).map(|_| f64::from(random.uniform(-1.0, 1.0) as f32)).collect();
    for (i, value) in values.iter().enumerate() {
        vector.as_flattened_mut().as_flattened_mut()[i] = *value as f32;
    }
    (vector, values)
}

fn scaled(vector: &Vector, factor: f32) -> Vector {
    vector.map(|pair| pair.map(|block| block.map(|value| factor * value)))
}

/// Every entry, from both sides, within a few roundings of numbers around 1; nothing outside the n x n part.
fn assert_equal(packed: &Packed, dense: &[Vec<f64>], what: &str) {
    for i in 0..CAPACITY {
        for j in 0..CAPACITY {
            let expected = dense.get(i).and_then(|row| row.get(j)).copied().unwrap_or(0.0);
            let difference = (f64::from(packed.get(i, j)) - expected).abs();
            assert!(difference < 1e-6, "{what}: n = {}, entry {i}, {j}", dense.len());
            assert_eq!(packed.get(i, j).to_bits(), packed.get(j, i).to_bits());
        }
    }
}

#[test]
fn every_entry_has_a_place_of_its_own() {
    let mut packed = ZERO;
    let value = |i: usize, j: usize| (i.min(j) * CAPACITY + i.max(j) + 1) as f32;
    for i in 0..CAPACITY {
        for j in i..CAPACITY {
            // From either side.
            if (i + j) % 2 == 0 { packed.set(i, j, value(i, j)) } else { packed.set(j, i, value(i, j)) }
        }
    }
    for i in 0..CAPACITY {
        for j in 0..CAPACITY {
            assert_eq!(packed.get(i, j), value(i, j), "{i}, {j}");
        }
    }
}

#[test]
fn outside_there_is_nothing() {
    let mut packed = ZERO;
    packed.set(0, CAPACITY, 1.0);
    packed.set(CAPACITY, 0, 1.0);
    packed.set(CAPACITY + 9, CAPACITY + 9, 1.0);
    assert_equal(&packed, &[], "set outside");
    assert_eq!(packed.get(3, CAPACITY), 0.0);
    assert_eq!(packed.get(usize::MAX, 1), 0.0);
    assert_eq!(entry(&[[[1.0; LANES]; 2]; TILES], CAPACITY), 0.0);
}

#[test]
fn downdate_is_the_naive_one_for_every_length() {
    let mut random = Random::new(1);
    for n in 1..=CAPACITY {
        let (mut packed, mut dense) = random_symmetric(&mut random, n);
        let (g, values) = random_vector(&mut random, n);
        let k = 0.7f32;
        packed.downdate(&g, &scaled(&g, k), n);
        for i in 0..n {
            for j in 0..n {
                dense[i][j] -= f64::from(k) * values[i] * values[j];
            }
        }
        assert_equal(&packed, &dense, "downdate");
    }
}

#[test]
fn a_product_is_the_naive_one_for_every_length_and_column() {
    let mut random = Random::new(2);
    for n in 1..=CAPACITY {
        let (mut packed, mut dense) = random_symmetric(&mut random, n);
        // A downdate before it: what it leaves beside the upper triangle must not show.
        let (g, values) = random_vector(&mut random, n);
        packed.downdate(&g, &scaled(&g, 0.5), n);
        for i in 0..n {
            for j in 0..n {
                dense[i][j] -= 0.5 * values[i] * values[j];
            }
        }
        for c in 0..n {
            let (mut out, _) = random_vector(&mut random, CAPACITY);
            let mut head = [0.0; HEAD];
            head[c % n.min(HEAD)] = 0.7;
            packed.product(&head, &[(c, -0.3), (n - 1 - c, 0.2)], n, &mut out);
            for i in 0..n {
                let expected = f64::from(0.7f32) * dense[i][c % n.min(HEAD)] - f64::from(0.3f32) * dense[i][c]
                    + f64::from(0.2f32) * dense[i][n - 1 - c];
                assert!((f64::from(entry(&out, i)) - expected).abs() < 1e-6, "n = {n}, column {c}, entry {i}");
            }
            assert!((n..n.next_multiple_of(LANES)).all(|i| entry(&out, i) == 0.0));
        }
    }
}

#[test]
fn a_quadratic_form_is_the_naive_one_for_every_length() {
    let mut random = Random::new(5);
    for n in HEAD + 1..=CAPACITY {
        let (packed, dense) = random_symmetric(&mut random, n);
        for c in HEAD..n {
            let mut row = vec![0.0; n];
            row[..HEAD].copy_from_slice(&[0.7, -0.2, 0.5, 0.1]);
            row[c] += -0.3;
            row[n - 1] += 0.2;
            let head = [row[0], row[1], row[2], row[3]];
            let others = [(c, -0.3), (n - 1, 0.2)];
            let expected: f64 = (0..n)
                .flat_map(|i| (0..n).map(move |j| (i, j)))
                .map(|(i, j)| f64::from(row[i]) * f64::from(row[j]) * dense[i][j])
                .sum();
            let difference = (f64::from(packed.quadratic(&head, &others)) - expected).abs();
            assert!(difference < 1e-6, "n = {n}, column {c}");
        }
    }
}

#[test]
fn setting_a_row_sets_it_from_its_diagonal_on() {
    let mut random = Random::new(7);
    for n in 1..=CAPACITY {
        for i in 0..n.min(LANES) {
            let (mut packed, mut dense) = random_symmetric(&mut random, n);
            let (row, values) = random_vector(&mut random, n);
            packed.set_row(i, &row, n);
            for j in i..n {
                dense[i][j] = values[j];
                dense[j][i] = values[j];
            }
            assert_equal(&packed, &dense, "set row");
        }
    }
}

#[test]
fn setting_a_column_sets_the_row_too() {
    let mut random = Random::new(3);
    for n in 1..=CAPACITY {
        for i in 0..n {
            let (mut packed, mut dense) = random_symmetric(&mut random, n);
            let (column, values) = random_vector(&mut random, n);
            packed.set_column(i, &column, 2.5, n);
            for j in 0..n {
                (dense[i][j], dense[j][i]) = (values[j], values[j]);
            }
            dense[i][i] = 2.5;
            assert_equal(&packed, &dense, "set_column");
        }
    }
}

#[test]
fn a_state_moves_with_its_row_and_column() {
    let mut random = Random::new(4);
    for n in 1..=CAPACITY {
        for to in 0..n {
            let (mut packed, mut dense) = random_symmetric(&mut random, n);
            packed.move_state(n - 1, to, n);
            dense.swap_remove(to);
            for row in &mut dense {
                row.swap_remove(to);
            }
            assert_equal(&packed, &dense, "move_state");
        }
    }
}
