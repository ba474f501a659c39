//! Published filters, each set up as its documentation shows, in f32.

use super::{NOISE, reading};
use std::hint::black_box;

/// The general interface of all: a call that does one update. A macro, since adskalman's bounds are on sizes of a kind that
/// const generics do not satisfy.
macro_rules! others {
    ($module:ident, $n:literal) => {
        pub mod $module {
            use super::*;
            const N: usize = $n;

            pub fn kfilter() -> impl FnMut() {
                use kfilter::Kalman1M;
                use nalgebra_34::{SMatrix, SVector};
                let mut h = SMatrix::<f32, 1, N>::zeros();
                reading(N).iter().for_each(|&(i, d)| h[i] = d);
                let noise = SMatrix::<f32, 1, 1>::new(NOISE);
                let (f, q) = (SMatrix::<f32, N, N>::identity(), SMatrix::<f32, N, N>::zeros());
                let mut filter = Box::new(Kalman1M::new(f, q, h, noise, SVector::<f32, N>::zeros()));
                move || {
                    assert!(filter.update(SVector::<f32, 1>::new(black_box(0.01))).is_ok());
                }
            }

            struct Model {
                h: nalgebra::SMatrix<f32, 1, N>,
                ht: nalgebra::SMatrix<f32, N, 1>,
                r: nalgebra::SMatrix<f32, 1, 1>,
            }

            impl adskalman::ObservationModel<f32, nalgebra::Const<N>, nalgebra::Const<1>> for Model {
                fn H(&self) -> &nalgebra::SMatrix<f32, 1, N> {
                    &self.h
                }
                fn HT(&self) -> &nalgebra::SMatrix<f32, N, 1> {
                    &self.ht
                }
                fn R(&self) -> &nalgebra::SMatrix<f32, 1, 1> {
                    &self.r
                }
            }

            pub fn adskalman() -> impl FnMut() {
                use adskalman::{CovarianceUpdateMethod, ObservationModel, StateAndCovariance};
                use nalgebra::{SMatrix, SVector};
                let mut h = SMatrix::<f32, 1, N>::zeros();
                reading(N).iter().for_each(|&(i, d)| h[i] = d);
                let model = Box::new(Model { h, ht: h.transpose(), r: SMatrix::<f32, 1, 1>::new(NOISE) });
                let mut state = StateAndCovariance::new(SVector::<f32, N>::zeros(), SMatrix::<f32, N, N>::identity());
                move || {
                    let z = SVector::<f32, 1>::new(black_box(0.01));
                    state = model.update(&state, &z, CovarianceUpdateMethod::OptimalKalman).expect("a regular update");
                }
            }

            pub fn minikalman() -> impl FnMut() {
                use minikalman::prelude::*;
                let builder = minikalman::regular::builder::KalmanFilterBuilder::<N, f32>::default();
                let mut filter = builder.build();
                let mut measurement = builder.observations().build::<1>();
                filter.estimate_covariance_mut().apply(|p| (0..N).for_each(|i| p.set_at(i, i, 1.0)));
                measurement.observation_matrix_mut().apply(|h| {
                    reading(N).iter().for_each(|&(i, d)| h.set_at(0, i, d));
                });
                measurement.measurement_noise_covariance_mut().apply(|r| r.set_at(0, 0, NOISE));
                move || {
                    measurement.measurement_vector_mut().apply(|z| z[0] = black_box(0.01));
                    filter.correct(&mut measurement);
                }
            }
        }
    };
}

others!(n20, 20);
others!(n36, 36);
others!(n68, 68);
others!(n132, 132);
