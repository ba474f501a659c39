//! The filter alone: one scalar update and one prediction, with a capacity fitted to the state.

use core::hint::black_box;
use instruction_count::Bench;
use slam_core::ekf::{Ekf, EkfView, Jacobian, LEADING, MotionJacobian, storage};
use static_cell::ConstStaticCell;

/// The longest state whose covariance fits the chip's RAM beside the rest of this program.
static LONGEST: ConstStaticCell<Ekf<{ storage(208) }>> = ConstStaticCell::new(Ekf::IDLE);

/// Every state length that is measured.
pub fn run(bench: &Bench) {
    one_length::<{ storage(24) }>(bench, ["update_n20", "predict_n20"], 20);
    one_length::<{ storage(32) }>(bench, ["update_n31", "predict_n31"], 31);
    one_length::<{ storage(40) }>(bench, ["update_n36", "predict_n36"], 36);
    one_length::<{ storage(48) }>(bench, ["update_n47", "predict_n47"], 47);
    one_length::<{ storage(72) }>(bench, ["update_n68", "predict_n68"], 68);
    one_length::<{ storage(80) }>(bench, ["update_n79", "predict_n79"], 79);
    one_length::<{ storage(136) }>(bench, ["update_n132", "predict_n132"], 132);
    one_length::<{ storage(144) }>(bench, ["update_n143", "predict_n143"], 143);
    let longest = LONGEST.take();
    longest.clear();
    measure(bench, ["update_n207", "predict_n207"], 207, longest);
}

#[inline(never)]
fn one_length<const ROWS: usize>(bench: &Bench, names: [&str; 2], n: usize) {
    let mut ekf: Ekf<ROWS> = Ekf::IDLE;
    ekf.clear();
    measure(bench, names, n, &mut ekf);
}

fn measure(bench: &Bench, names: [&str; 2], n: usize, ekf: &mut EkfView) {
    for i in 0..n {
        // Every state depends a little on the first, so that no covariance is zero.
        let jacobian: Jacobian = (i > 0).then_some((0, 0.1)).into_iter().collect();
        ekf.augment(0.0, &jacobian, 1.0);
    }
    let jacobian = reading(n);
    bench.case(names[0], || ekf.update(black_box(0.01), black_box(&jacobian), black_box(1e-4)));
    let motion = motion();
    let noise = [[1e-6, 0.0, 0.0], [0.0, 1e-6, 0.0], [0.0, 0.0, 1e-6]];
    bench.case(names[1], || ekf.predict(black_box([0.01, 0.0, 0.0]), black_box(&motion), black_box(&noise)));
}

/// A reading of a grid wall: pose, grid direction, the sensor's gain, the wall's distance.
fn reading(n: usize) -> Jacobian {
    [(0, -1.0), (1, 0.1), (2, 0.3), (3, 0.2), (9, 1.0), (n - 1, 1.0)].into_iter().collect()
}

/// Two wheels with a scale each, and the track.
fn motion() -> MotionJacobian {
    let mut jacobian = [[0.0; LEADING]; 3];
    for (i, row) in jacobian.iter_mut().enumerate() {
        row[i] = 1.0;
        row[4] = 0.01;
        row[5] = -0.01;
        row[6] = 0.02;
    }
    jacobian[0][2] = -0.01;
    jacobian[1][2] = 0.01;
    jacobian
}
