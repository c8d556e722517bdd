//! What others' code takes for the same work.

#![allow(unsafe_code)] // Unmangled names, which the host looks for; and functions in C.

use core::mem::MaybeUninit;

use biquad::{Biquad, Coefficients, DirectForm2Transposed, Q_BUTTERWORTH_F32, ToHertz, Type};
use firmware_stub::kernels::{self, Kernel, Request};
use monitor_core::moments::Moments;
use nalgebra::{Const, Matrix2, Matrix3, SMatrix, SVector, SymmetricEigen, Vector3};

use crate::textbook::TextbookMonitor;

type Iterated<const N: usize> = (SVector<f32, N>, SMatrix<f32, N, N>);

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_nalgebra_eigen2(found: &mut MaybeUninit<SymmetricEigen<f32, Const<2>>>, matrix: &Matrix2<f32>) {
    found.write(SymmetricEigen::new(*matrix));
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_nalgebra_eigen3(found: &mut MaybeUninit<SymmetricEigen<f32, Const<3>>>, matrix: &Matrix3<f32>) {
    found.write(SymmetricEigen::new(*matrix));
}

/// A mean, and the inverse of the covariance. Its layout is that of the peer in C.
#[repr(C)]
struct Mahalanobis {
    mean: Vector3<f32>,
    inverse: Matrix3<f32>,
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_nalgebra_t2(model: &Mahalanobis, x: &Vector3<f32>) -> f32 {
    let d = x - model.mean;
    d.dot(&(model.inverse * d))
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_biquad(filter: &mut DirectForm2Transposed<f32>, input: &f32) -> f32 {
    filter.run(*input)
}

#[inline(never)]
#[unsafe(no_mangle)]
extern "C" fn audit_textbook(monitor: &mut TextbookMonitor, x: &[f32; 3], residuals: &mut [f32; 4]) -> u8 {
    let (found, fault) = monitor.step(*x);
    *residuals = found;
    fault
}

/// Everything that a peer works on.
pub(crate) struct Peers {
    mahalanobis: Mahalanobis,
    filter: DirectForm2Transposed<f32>,
    monitor: TextbookMonitor,
    #[cfg(feature = "c-peers")]
    c: in_c::State,
}

impl Peers {
    pub(crate) fn new() -> Option<Self> {
        let config = kernels::config();
        let window: Moments<3> = kernels::healthy(1).take(200).collect();
        let learned = window.statistics().ok()?;
        let mahalanobis = Mahalanobis { mean: learned.mean, inverse: learned.covariance.try_inverse()? };
        let low_pass = Coefficients::from_params(
            Type::LowPass,
            config.sample_rate_hz.hz(),
            config.cutoff_hz.hz(),
            Q_BUTTERWORTH_F32,
        );
        let low_pass = low_pass.ok()?;
        Some(Peers {
            #[cfg(feature = "c-peers")]
            c: in_c::State::new(&mahalanobis, &low_pass)?,
            mahalanobis,
            filter: DirectForm2Transposed::new(low_pass),
            monitor: TextbookMonitor::learn(
                kernels::healthy(1).take(100),
                config.cutoff_hz,
                config.sample_rate_hz,
                config.thresholds.full,
            )
            .ok()?,
        })
    }

    /// Calls a kernel; none when this firmware was built without it.
    pub(crate) fn call(&mut self, request: &Request) -> Option<u32> {
        let [a, b, c, d, e, f, _] = request.numbers();
        let x = request.channels();
        let digest = match request.kernel {
            Kernel::NalgebraEigen2 => {
                let mut found = MaybeUninit::uninit();
                audit_nalgebra_eigen2(&mut found, &Matrix2::new(a, b, b, c));
                // SAFETY: the function above has written it.
                let found = unsafe { found.assume_init_ref() };
                digest_of_eigen(&(found.eigenvalues, found.eigenvectors))
            }
            Kernel::NalgebraEigen3 => {
                let mut found = MaybeUninit::uninit();
                audit_nalgebra_eigen3(&mut found, &Matrix3::new(a, b, d, b, c, e, d, e, f));
                // SAFETY: the function above has written it.
                let found = unsafe { found.assume_init_ref() };
                digest_of_eigen(&(found.eigenvalues, found.eigenvectors))
            }
            Kernel::NalgebraT2 => kernels::digest_of_numbers([audit_nalgebra_t2(&self.mahalanobis, &x.into())]),
            Kernel::Biquad => kernels::digest_of_numbers([audit_biquad(&mut self.filter, &a)]),
            Kernel::Textbook => {
                let mut residuals = [0.0; 4];
                let fault = audit_textbook(&mut self.monitor, &x, &mut residuals);
                kernels::digest_of_numbers(residuals) ^ u32::from(fault)
            }
            #[cfg(feature = "c-peers")]
            _ => self.c.call(&self.mahalanobis, request.kernel, &x),
            #[cfg(not(feature = "c-peers"))]
            _ => return None,
        };
        Some(digest)
    }
}

fn digest_of_eigen<const N: usize>((values, vectors): &Iterated<N>) -> u32 {
    kernels::digest_of_numbers(values.iter().chain(vectors.iter()).copied())
}

/// The functions of `tests/audit/peers/peers.c`, which the host compiles and hands to the linker.
#[cfg(feature = "c-peers")]
mod in_c {
    use biquad::Coefficients;
    use firmware_stub::kernels::{self, Kernel};

    use super::Mahalanobis;

    /// A mean and an upper triangle U, T2 = |U (x - mean)|^2.
    #[repr(C)]
    struct Triangle {
        mean: [f32; 3],
        rows: [f32; 6],
    }

    /// Coefficients in CMSIS-DSP's order and sign (b0, b1, b2, -a1, -a2), and the state.
    #[repr(C)]
    struct Filter {
        coefficients: [f32; 5],
        state: [f32; 2],
    }

    unsafe extern "C" {
        fn audit_c_t2_matrix(model: &Mahalanobis, x: &[f32; 3]) -> f32;
        fn audit_c_t2_triangle(model: &Triangle, x: &[f32; 3]) -> f32;
        fn audit_c_biquad(filter: &mut Filter, input: &f32) -> f32;
    }

    pub(super) struct State {
        triangle: Triangle,
        filter: Filter,
    }

    impl State {
        pub(super) fn new(model: &Mahalanobis, low_pass: &Coefficients<f32>) -> Option<Self> {
            let u = model.inverse.cholesky()?.l().transpose();
            let rows = [u.m11, u.m12, u.m13, u.m22, u.m23, u.m33];
            let Coefficients { a1, a2, b0, b1, b2 } = *low_pass;
            Some(State {
                triangle: Triangle { mean: model.mean.into(), rows },
                filter: Filter { coefficients: [b0, b1, b2, -a1, -a2], state: [0.0; 2] },
            })
        }

        pub(super) fn call(&mut self, model: &Mahalanobis, kernel: Kernel, x: &[f32; 3]) -> u32 {
            // SAFETY: the layouts are those that `peers.c` declares, and it touches nothing else.
            let result = unsafe {
                match kernel {
                    Kernel::CMatrixT2 => audit_c_t2_matrix(model, x),
                    Kernel::CTriangleT2 => audit_c_t2_triangle(&self.triangle, x),
                    _ => audit_c_biquad(&mut self.filter, &x[0]),
                }
            };
            kernels::digest_of_numbers([result])
        }
    }
}
