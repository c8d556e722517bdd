//! Butterworth low-passes: the smoothing filter at the end of the residual generator (the paper, fig. 3).
//!
//! Both orders are in delta-operator form. In the usual direct forms the feedback of the second order is
//! 2 y[n-1] - y[n-2] plus something of the size of (fc/fs)^2; in `f32` that something drowns in the rounding of the two
//! large terms, and at a cutoff of 5e-5 of the sampling rate the DC gain is wrong by more than half. The delta form keeps
//! the small coefficients themselves and adds differences to its states (Kauraniemi, Laakso, Hartimo, Ovaska, IEEE
//! TCAS-II 45(1), 1998).
//!
//! What is left is the state's own rounding: an increment below half a unit in the last place of the state is lost, so
//! an output comes to rest up to 1.4e-8 fs/fc short of its input (1e-4 at fc/fs = 1.3e-4), relative to it. [`Compensated`]
//! carries what is lost, and has no such limit; `NUMERICS.md` ([`crate::numerics`]) has the figures of each form, which
//! reach up to fc/fs = 0.45: towards 0.5 the poles approach z = -1, and rounding rings there for as long as they do.
//!
//! # At start-up, or in flash
//! The designs are `const fn`s of a dozen multiplications and two divisions, in single precision, without trigonometry. A
//! board that knows its cutoff beforehand evaluates them in a `const` and carries neither design code nor a way to
//! fail; the compiler rounds as the target does, so both ways give the same bits.
//!
//! ```
//! use monitor_core::low_pass::{Compensated, LowPass};
//! use monitor_core::smoother::Smoother;
//!
//! static RESIDUAL: LowPass = match LowPass::butterworth(1.0, 1000.0) {
//!     Ok(design) => design,
//!     Err(_) => panic!("the cutoff must lie below half the sampling rate"), // while compiling, never on the board
//! };
//! let mut state = RESIDUAL.at_rest(1.0);
//! assert_eq!(RESIDUAL.step(&mut state, 1.0), 1.0);
//!
//! // The same design with compensated states.
//! let slow = Compensated(RESIDUAL);
//! let mut state = slow.at_rest(1.0);
//! assert_eq!(slow.step(&mut state, 1.0), 1.0);
//! ```

mod compensated;
mod first_order;
mod second_order;

pub use compensated::{Compensated, CompensatedState};
pub use first_order::{FirstOrder, FirstOrderState};
pub use second_order::{LowPass, LowPassState};

/// Why a filter was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum LowPassError {
    /// The cutoff must lie above zero and below half the sampling rate.
    Cutoff,
}

/// g = tan(pi fc/fs), the cutoff of the analogue prototype of which the bilinear transform is taken.
const fn prewarped(cutoff_hz: f32, sample_rate_hz: f32) -> Result<f32, LowPassError> {
    let cutoff = cutoff_hz / sample_rate_hz;
    if !(cutoff > 0.0 && cutoff < 0.5 && sample_rate_hz > 0.0) {
        return Err(LowPassError::Cutoff);
    }
    Ok(tangent_of_pi_times(cutoff))
}

/// tan(pi x) for x in (0, 1/2), to within two units in the last place, by `tests/references/fit_tangent.py`.
///
/// `libm::tanf` computes in double precision, which is software on a target without it: kilobytes of flash for one number.
const fn tangent_of_pi_times(x: f32) -> f32 {
    // The difference is exact.
    if x <= 0.25 { tangent_to_quarter(x) } else { 1.0 / tangent_to_quarter(0.5 - x) }
}

/// tan(pi x) for x in [0, 1/4].
const fn tangent_to_quarter(x: f32) -> f32 {
    let w = x * x;
    let high = 161.149_1 + w * (732.735_8 + w * (860.452_2 + w * 27_534.316));
    x * (core::f32::consts::PI + w * (10.335_347 + w * (40.822_414 + w * high)))
}

#[cfg(test)]
mod accuracy;
#[cfg(test)]
mod tests;
