//! The functions of `monitor-core` that are audited.
//!
//! State comes first and data second, by pointer: the proof that a trace does not depend on data takes what the second
//! argument points at as the data.

#![allow(unsafe_code)] // Unmangled names, which the host looks for; nothing else has them.

use core::mem::MaybeUninit;

use firmware_stub::kernels::{self, Kernel, Request};
use monitor_core::eigen::{ClosedFormEigen, Decomposition};
use monitor_core::hotelling::Model;
use monitor_core::moments::{LearnError, Moments};
use monitor_core::paper::{Baseline, Monitor};
use monitor_core::pca::{ExplainedShare, Pca};
use nalgebra::{Matrix2, Matrix3};

use crate::filters::Filters;
use crate::guard::Guarding;
use crate::start_up;

type Learned = Result<Baseline, LearnError>;

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_finish_learning(monitor: &mut Monitor) -> bool {
    monitor.finish_learning().is_ok()
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_push(window: &mut Moments<3>, x: &[f32; 3]) {
    window.push(*x);
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_window_end(learned: &mut MaybeUninit<Learned>, window: &Moments<3>) {
    learned.write(Baseline::learn(window, ExplainedShare::PAPER));
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_eigen2(found: &mut MaybeUninit<Decomposition<2>>, matrix: &Matrix2<f32>) {
    found.write(matrix.decompose());
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_eigen3(found: &mut MaybeUninit<Decomposition<3>>, matrix: &Matrix3<f32>) {
    found.write(matrix.decompose());
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_correlation2(found: &mut MaybeUninit<Decomposition<2>>, matrix: &Matrix2<f32>) {
    found.write(matrix.decompose_correlation());
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_correlation3(found: &mut MaybeUninit<Decomposition<3>>, matrix: &Matrix3<f32>) {
    found.write(matrix.decompose_correlation());
}

/// A model with the mean of its window.
struct Distance {
    mean: [f32; 3],
    model: Model<3>,
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_t2(distance: &Distance, x: &[f32; 3]) -> f32 {
    let ([a, b, c], [x0, x1, x2]) = (distance.mean, *x);
    distance.model.t2([x0 - a, x1 - b, x2 - c])
}

/// Everything of ours that a kernel works on.
pub(crate) struct Own {
    monitor: Monitor,
    guard: Guarding,
    window: Moments<3>,
    filters: Filters,
    distance: Distance,
}

impl Own {
    pub(crate) fn new() -> Option<Self> {
        let config = kernels::config();
        let window: Moments<3> = kernels::healthy(1).take(200).collect();
        let learned = window.statistics().ok()?;
        let pca = Pca::of_correlation(&learned.correlation(), ExplainedShare::PAPER).ok()?;
        Some(Own {
            monitor: Monitor::new(&config).ok()?,
            guard: Guarding::new()?,
            window: Moments::around(kernels::HEALTHY_MEAN),
            filters: Filters::new(config.cutoff_hz, config.sample_rate_hz)?,
            distance: Distance { mean: learned.mean.into(), model: Model::new(pca, learned.sigma(), learned.samples) },
        })
    }

    /// Calls a kernel; returns the digest of its result.
    pub(crate) fn call(&mut self, request: &Request) -> u32 {
        let [a, b, c, d, e, f, _] = request.numbers();
        match request.kernel {
            Kernel::Step => kernels::digest_of_verdict(self.monitor.step_channels(a, [b, c, d])),
            Kernel::FinishLearning => u32::from(audit_finish_learning(&mut self.monitor)),
            kernel if (Kernel::GuardStep..=Kernel::GuardInstall).contains(&kernel) => self.guard.call(request),
            Kernel::Push => {
                audit_push(&mut self.window, &[a, b, c]);
                0
            }
            Kernel::ClearWindow => {
                self.window = Moments::around(kernels::HEALTHY_MEAN);
                0
            }
            Kernel::WindowEnd => {
                let mut learned = MaybeUninit::uninit();
                audit_window_end(&mut learned, &self.window);
                // SAFETY: the function above has written it.
                digest_of_learned(unsafe { learned.assume_init_ref() })
            }
            Kernel::Eigen2 | Kernel::Correlation2 => {
                let (mut found, matrix) = (MaybeUninit::uninit(), Matrix2::new(a, b, b, c));
                match request.kernel {
                    Kernel::Eigen2 => audit_eigen2(&mut found, &matrix),
                    _ => audit_correlation2(&mut found, &matrix),
                }
                // SAFETY: the function above has written it.
                digest_of_eigen(unsafe { found.assume_init_ref() })
            }
            Kernel::Eigen3 | Kernel::Correlation3 => {
                let (mut found, matrix) = (MaybeUninit::uninit(), Matrix3::new(a, b, d, b, c, e, d, e, f));
                match request.kernel {
                    Kernel::Eigen3 => audit_eigen3(&mut found, &matrix),
                    _ => audit_correlation3(&mut found, &matrix),
                }
                // SAFETY: the function above has written it.
                digest_of_eigen(unsafe { found.assume_init_ref() })
            }
            Kernel::T2 => kernels::digest_of_numbers([audit_t2(&self.distance, &[a, b, c])]),
            kernel if kernel >= Kernel::UpperNormal => start_up::call(request),
            kernel => self.filters.call(kernel, [a, b, c]),
        }
    }
}

fn digest_of_learned(learned: &Learned) -> u32 {
    learned.as_ref().map_or(0, |baseline| {
        let stored = baseline.stored();
        kernels::digest_of_numbers(stored.mean.into_iter().chain(stored.eigenvalues))
    })
}

fn digest_of_eigen<const N: usize>(found: &Decomposition<N>) -> u32 {
    found
        .checked()
        .map_or(0, |eigen| kernels::digest_of_numbers(eigen.values.iter().chain(eigen.vectors.iter()).copied()))
}
