//! An extended Kalman filter over the robot's pose and features, in the form that Joseph gave the update.
//!
//! The pose is states 0 to 2; a feature is the states from its place on. Nothing here knows what a feature is:
//! [`crate::features`] makes the observations.

use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, SVector};

use crate::geometry::{Pose, wrap};

/// What was observed against what was expected.
#[derive(Clone, Debug)]
pub struct Observation<const M: usize> {
    /// Observed less expected.
    pub innovation: SVector<f64, M>,
    /// Derivative of what was expected by the states from each place on, column by column.
    pub by: Vec<(usize, SVector<f64, M>)>,
    /// Noise of the observation.
    pub noise: SMatrix<f64, M, M>,
}

/// The filter.
#[derive(Clone, Debug)]
pub struct Ekf {
    mean: DVector<f64>,
    covariance: DMatrix<f64>,
}

impl Default for Ekf {
    fn default() -> Self {
        Self { mean: DVector::zeros(3), covariance: DMatrix::zeros(3, 3) }
    }
}

impl Ekf {
    /// The pose.
    pub fn pose(&self) -> Pose {
        Pose::new(self.mean[0], self.mean[1], self.mean[2])
    }

    /// Covariance of the pose.
    pub fn pose_covariance(&self) -> Matrix3<f64> {
        self.covariance.fixed_view::<3, 3>(0, 0).into_owned()
    }

    /// The states from this place on.
    pub fn states<const M: usize>(&self, at: usize) -> SVector<f64, M> {
        self.mean.fixed_rows::<M>(at).into_owned()
    }

    /// Variance of one state.
    pub fn variance(&self, at: usize) -> f64 {
        self.covariance[(at, at)]
    }

    /// Moves the robot on.
    pub fn predict(&mut self, motion: &Pose, noise: &Matrix3<f64>) {
        let pose = self.pose();
        let (by_pose, by_motion) = pose.compose_jacobians(motion);
        let moved = pose.compose(motion);
        self.set_pose(&moved);
        let rows = by_pose * self.covariance.rows(0, 3);
        self.covariance.rows_mut(0, 3).copy_from(&rows);
        let columns = self.covariance.columns(0, 3) * by_pose.transpose();
        self.covariance.columns_mut(0, 3).copy_from(&columns);
        let mut corner = self.covariance.fixed_view_mut::<3, 3>(0, 0);
        corner += by_motion * noise * by_motion.transpose();
    }

    fn set_pose(&mut self, pose: &Pose) {
        self.mean[0] = pose.at.x;
        self.mean[1] = pose.at.y;
        self.mean[2] = pose.theta;
    }

    /// P H'.
    fn gain_rows<const M: usize>(&self, by: &[(usize, SVector<f64, M>)]) -> DMatrix<f64> {
        let mut product = DMatrix::zeros(self.mean.len(), M);
        for (state, column) in by {
            product += self.covariance.column(*state) * column.transpose();
        }
        product
    }

    /// H A for a matrix with as many rows as there are states.
    fn project<const M: usize>(by: &[(usize, SVector<f64, M>)], a: &DMatrix<f64>) -> DMatrix<f64> {
        let mut product = DMatrix::zeros(M, a.ncols());
        for (state, column) in by {
            product += column * a.row(*state);
        }
        product
    }

    /// Covariance of the innovation.
    pub fn innovation_covariance<const M: usize>(&self, seen: &Observation<M>) -> SMatrix<f64, M, M> {
        let product = self.gain_rows(&seen.by);
        let projected = Self::project(&seen.by, &product);
        SMatrix::from_fn(|i, j| projected[(i, j)]) + seen.noise
    }

    /// Squared Mahalanobis distance of the innovation; infinite where its covariance has no inverse.
    pub fn distance<const M: usize>(&self, seen: &Observation<M>) -> f64 {
        let inverse = self.innovation_covariance(seen).try_inverse();
        inverse.map_or(f64::INFINITY, |inverse| (seen.innovation.transpose() * inverse * seen.innovation)[(0, 0)])
    }

    /// Takes in an observation.
    pub fn update<const M: usize>(&mut self, seen: &Observation<M>) {
        let Some(inverse) = self.innovation_covariance(seen).try_inverse() else { return };
        let gain = self.gain_rows(&seen.by) * inverse;
        self.mean += &gain * seen.innovation;
        self.mean[2] = wrap(self.mean[2]);
        // (I - K H) P (I - K H)' + K R K', multiplied out so that H is never written in full.
        let left = &self.covariance - &gain * Self::project(&seen.by, &self.covariance);
        let right = Self::project(&seen.by, &left.transpose()).transpose();
        let updated = left - right * gain.transpose() + &gain * seen.noise * gain.transpose();
        self.covariance = 0.5 * (&updated + updated.transpose());
    }

    /// Adds a feature; returns its place.
    pub fn add<const M: usize>(
        &mut self,
        value: SVector<f64, M>,
        by_pose: SMatrix<f64, M, 3>,
        noise: SMatrix<f64, M, M>,
    ) -> usize {
        let n = self.mean.len();
        let cross = by_pose * self.covariance.rows(0, 3);
        let own = by_pose * self.pose_covariance() * by_pose.transpose() + noise;
        self.mean = self.mean.clone().resize_vertically(n + M, 0.0);
        self.mean.fixed_rows_mut::<M>(n).copy_from(&value);
        let mut covariance = self.covariance.clone().resize(n + M, n + M, 0.0);
        covariance.view_mut((n, 0), (M, n)).copy_from(&cross);
        covariance.view_mut((0, n), (n, M)).copy_from(&cross.transpose());
        covariance.view_mut((n, n), (M, M)).copy_from(&own);
        self.covariance = covariance;
        n
    }

    /// Memory that the state takes, bytes.
    pub fn bytes(&self) -> usize {
        8 * (self.mean.len() + self.covariance.len())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Vector2};

    fn filter() -> Ekf {
        let mut ekf = Ekf::default();
        ekf.predict(&Pose::new(0.5, 0.1, 0.3), &Matrix3::new(4e-3, 1e-3, 0.0, 1e-3, 5e-3, 2e-4, 0.0, 2e-4, 3e-3));
        ekf.add(
            Vector2::new(1.0, 0.2),
            SMatrix::from_fn(|i, j| 0.3 + i as f64 - 0.4 * j as f64),
            Matrix2::identity() * 1e-3,
        );
        ekf
    }

    /// The update against the one in information form: the inverse covariance grows by H' R^-1 H.
    #[test]
    fn an_update_adds_information() {
        let mut ekf = filter();
        let columns = [Vector2::new(1.0, 0.2), Vector2::new(0.0, -0.7), Vector2::new(0.5, 0.1), Vector2::new(0.3, 1.0)];
        let places = [0, 2, 3, 4];
        let seen = Observation {
            innovation: Vector2::new(0.02, -0.01),
            by: places.into_iter().zip(columns).collect(),
            noise: Matrix2::new(2e-3, 3e-4, 3e-4, 1e-3),
        };
        let mut h = DMatrix::zeros(2, 5);
        for (place, column) in &seen.by {
            h.set_column(*place, column);
        }
        let r = seen.noise.try_inverse().expect("positive");
        let before = ekf.covariance.clone().try_inverse().expect("positive");
        let expected = (before + h.transpose() * r * &h).try_inverse().expect("positive");
        let moved = &expected * h.transpose() * r * seen.innovation + &ekf.mean;
        ekf.update(&seen);
        assert!((&ekf.covariance - &expected).norm() < 1e-9 * expected.norm());
        assert!((&ekf.mean - moved).norm() < 1e-9);
    }

    #[test]
    fn motion_leaves_features_alone_and_carries_their_correlation() {
        let mut ekf = filter();
        let (feature, own) = (ekf.states::<2>(3), ekf.variance(3));
        let before = ekf.covariance.clone();
        let motion = Pose::new(0.4, 0.0, -0.2);
        let (by_pose, _) = ekf.pose().compose_jacobians(&motion);
        ekf.predict(&motion, &Matrix3::zeros());
        assert_eq!((ekf.states::<2>(3), ekf.variance(3)), (feature, own));
        let expected = by_pose * before.view((0, 3), (3, 2));
        assert!((ekf.covariance.view((0, 3), (3, 2)) - expected).norm() < 1e-12);
    }
}
