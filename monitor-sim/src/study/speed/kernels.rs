//! The monitor's kernels by the number of channels.
//!
//! The monitor itself has three, a truth table of three pairs, and no other number: so the kernels that it is made of are
//! measured, for as many channels as they are used with or could be.

use std::hint::black_box;

use monitor_core::eigen::ClosedFormEigen;
use monitor_core::ewma::Ewma;
use monitor_core::hotelling::Model;
use monitor_core::moments::Moments;
use monitor_core::pca::{ExplainedShare, Pca};
use nalgebra::SMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::{REPETITIONS, fastest};
use crate::tables::TextTable;

/// Different inputs, which fit into the nearest cache, and how often a measurement goes through them.
const INPUTS: usize = 256;
const ROUNDS: usize = 400;

/// A kernel with so many channels.
#[derive(Clone, Debug, Serialize)]
pub struct KernelRow {
    /// Which kernel.
    pub kernel: &'static str,
    /// Channels.
    pub channels: usize,
    /// Seed of its inputs.
    pub seed: u64,
    /// Measurements, of which this is the fastest.
    pub repetitions: usize,
    /// Calls of each.
    pub calls: usize,
    /// Time of a call, ns.
    pub ns_each: f64,
}

/// What the kernels are called, in the order of the table.
const SMOOTH: &str = "exponential smoother, a sample";
const LEARN: &str = "moments, a sample";
const DISTANCE: &str = "T\u{b2} by triangle, a sample";
const DECOMPOSE: &str = "eigenvalues and vectors, a correlation matrix";
const KERNELS: [&str; 4] = [SMOOTH, LEARN, DISTANCE, DECOMPOSE];

/// Measures all of them.
pub(super) fn measure(seed: u64) -> Vec<KernelRow> {
    let mut rows = [of_any::<1>(seed), of_any::<2>(seed), of_any::<3>(seed)].concat();
    rows.extend(of_closed_form::<2>(seed).into_iter().chain(of_closed_form::<3>(seed)));
    rows.sort_by_key(|row| KERNELS.iter().position(|kernel| *kernel == row.kernel)); // stable: channels stay in order
    rows
}

/// Kernels of any number of channels.
fn of_any<const N: usize>(seed: u64) -> Vec<KernelRow> {
    let samples = samples::<N>(seed);
    let smoother = Ewma::with_time_constant(0.075, 1000.0);
    let smooth = smoother
        .map(|smoother| timed::<N, _, _>(SMOOTH, seed, &samples, [0.0; N], |state, x| smoother.step(false, state, *x)));
    let learn = timed::<N, _, _>(LEARN, seed, &samples, Moments::around([0.0; N]), |moments, x| moments.push(*x));
    smooth.into_iter().chain([learn]).collect()
}

/// Kernels of matrices that have a closed form.
fn of_closed_form<const N: usize>(seed: u64) -> Vec<KernelRow>
where
    SMatrix<f32, N, N>: ClosedFormEigen<N>,
{
    let samples = samples::<N>(seed);
    let learned = samples.windows(INPUTS / 8).filter_map(|window| {
        let moments: Moments<N> = window.iter().copied().collect();
        moments.statistics().ok()
    });
    let matrices: Vec<_> = learned.map(|statistics| statistics.correlation()).collect();
    let pca = matrices.first().and_then(|matrix| Pca::of_correlation(matrix, ExplainedShare::PAPER).ok());
    let distance = pca.map(|pca| {
        let model = Model::new(pca, [1.0; N].into(), 15_000);
        timed::<N, _, _>(DISTANCE, seed, &samples, 0.0, |sum, x| *sum += model.t2(*x))
    });
    let decompose = timed::<N, _, _>(DECOMPOSE, seed, &matrices, (), |(), matrix| {
        black_box(matrix.decompose_correlation());
    });
    distance.into_iter().chain([decompose]).collect()
}

fn samples<const N: usize>(seed: u64) -> Vec<[f32; N]> {
    let mut draw = ChaCha8Rng::seed_from_u64(seed);
    (0..INPUTS).map(|_| [0.0; N].map(|_: f32| draw.random::<f32>() - 0.5)).collect()
}

/// The fastest of some measurements, in which a state takes every input in turn.
fn timed<const N: usize, S: Clone, I>(
    kernel: &'static str,
    seed: u64,
    inputs: &[I],
    begin: S,
    call: impl Fn(&mut S, &I),
) -> KernelRow {
    let (calls, wall_s) = fastest(|| {
        let mut state = begin.clone();
        for _ in 0..ROUNDS {
            black_box(inputs).iter().for_each(|input| call(&mut state, input));
        }
        black_box(state);
        ROUNDS * inputs.len()
    });
    KernelRow { kernel, channels: N, seed, repetitions: REPETITIONS, calls, ns_each: 1e9 * wall_s / calls as f64 }
}

/// Kernels down, channels across.
pub(super) fn table(rows: &[KernelRow]) -> TextTable {
    let caption = "The monitor's kernels by channels, ns each. guard mode has three channels and nothing else; paper mode one model \
                   of three and one of each pair. The eigen-solver takes two and three, so there is no monitor of four";
    let of = |kernel: &str, channels: usize| {
        let row = rows.iter().find(|row| row.kernel == kernel && row.channels == channels);
        row.map_or_else(|| "-".to_owned(), |row| format!("{:.2}", row.ns_each))
    };
    let row = |kernel: &str| [kernel.to_owned(), of(kernel, 1), of(kernel, 2), of(kernel, 3)];
    TextTable::new(caption, ["kernel", "1 channel", "2", "3"]).with_rows(KERNELS.map(row))
}
