//! How wrong the covariance of a long window is: the core's moments beside the textbook's, in `f32`.
//!
//! `cargo run --release -p tests --bin moments` prints the table; `-- 1e8` sets the longest window (default 1e7).
//! Errors are the largest over the entries of the covariance of three correlated normal channels, relative to the
//! product of their sigmas, against the same sums in `f64`.

use std::process::ExitCode;

use comfy_table::Table;
use monitor_core::moments::Moments;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// One sample to the next: three methods and a reference.
struct Race {
    core: Moments<3>,
    welford: Welford<f32>,
    squares: Squares,
    /// Of the samples as `f32` reads them, less the first.
    reference: Welford<f64>,
    first: [f32; 3],
}

/// Welford's update of mean and co-moments (1962), as textbooks print it.
#[derive(Default)]
struct Welford<F> {
    n: F,
    mean: [F; 3],
    products: [[F; 3]; 3],
}

macro_rules! welford {
    ($float:ty) => {
        impl Welford<$float> {
            fn push(&mut self, x: [$float; 3]) {
                self.n += 1.0;
                let before: [$float; 3] = std::array::from_fn(|i| x[i] - self.mean[i]);
                for (mean, deviation) in self.mean.iter_mut().zip(before) {
                    *mean += deviation / self.n;
                }
                let after: [$float; 3] = std::array::from_fn(|i| x[i] - self.mean[i]);
                for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
                    self.products[i][j] += before[i] * after[j];
                }
            }

            fn covariance(&self) -> [[f64; 3]; 3] {
                self.products.map(|row| row.map(|product| f64::from(product / (self.n - 1.0))))
            }
        }
    };
}
welford!(f32);
welford!(f64);

/// Sums and sums of squares.
#[derive(Default)]
struct Squares {
    n: f32,
    first: [f32; 3],
    second: [[f32; 3]; 3],
}

impl Squares {
    fn push(&mut self, x: [f32; 3]) {
        self.n += 1.0;
        for i in 0..3 {
            self.first[i] += x[i];
            for j in 0..3 {
                self.second[i][j] += x[i] * x[j];
            }
        }
    }

    fn covariance(&self) -> [[f64; 3]; 3] {
        let mean = |i: usize| self.first[i] / self.n;
        std::array::from_fn(|i| {
            std::array::from_fn(|j| f64::from((self.second[i][j] - self.n * mean(i) * mean(j)) / (self.n - 1.0)))
        })
    }
}

impl Race {
    /// Before its first sample.
    fn starting_with(first: [f32; 3]) -> Self {
        Race {
            core: Moments::around(first),
            welford: Welford::default(),
            squares: Squares::default(),
            reference: Welford::default(),
            first,
        }
    }

    fn push(&mut self, x: [f32; 3]) {
        let first = self.first;
        self.core.push(x);
        self.welford.push(x);
        self.squares.push(x);
        self.reference.push(std::array::from_fn(|i| f64::from(x[i]) - f64::from(first[i])));
    }

    /// Errors of the core, of Welford's update and of the sums of squares.
    fn errors(&self) -> Result<[f64; 3], String> {
        let exact = self.reference.covariance();
        let core = self.core.statistics().map_err(|error| format!("the window is refused: {error:?}"))?;
        let core = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(core.covariance[(i, j)])));
        let worst = |found: [[f64; 3]; 3]| {
            let entries = (0..3).flat_map(|i| (0..3).map(move |j| (i, j)));
            let error = |(i, j): (usize, usize)| (found[i][j] - exact[i][j]).abs() / (exact[i][i] * exact[j][j]).sqrt();
            entries.map(error).fold(0.0, f64::max)
        };
        Ok([core, self.welford.covariance(), self.squares.covariance()].map(worst))
    }
}

fn study(longest: u64) -> Result<Table, String> {
    let mut table = Table::new();
    table.set_header(["mean/sigma", "samples", "core", "Welford", "sum of squares"]);
    for ratio in [1.0, 1e3, 1e4, 1e5] {
        let (mut race, mut rng) = (None::<Race>, ChaCha8Rng::seed_from_u64(1));
        let mut report_at = 1_000;
        for n in 1..=longest {
            let [a, b, c]: [f64; 3] = std::array::from_fn(|_| StandardNormal.sample(&mut rng));
            // Sigmas of 0.01, means of `ratio` sigmas, correlations of 0.8 and -0.6.
            let x = [a, 0.8 * a + 0.6 * b, 0.8 * c - 0.6 * a].map(|z| (0.01 * (ratio + z)) as f32);
            let race = race.get_or_insert_with(|| Race::starting_with(x));
            race.push(x);
            if n == report_at {
                let errors = race.errors()?.map(|error| format!("{error:.1e}"));
                table.add_row([format!("{ratio:e}"), format!("{n:e}")].into_iter().chain(errors));
                report_at *= 10;
            }
        }
        eprintln!("mean/sigma {ratio:e}: done");
    }
    Ok(table)
}

fn main() -> ExitCode {
    let longest = match std::env::args().nth(1).map(|text| text.parse::<f64>()) {
        None => 1e7,
        Some(Ok(longest)) if (1e3..=1e9).contains(&longest) => longest,
        Some(_) => {
            eprintln!("error: the longest window is a number of samples from 1e3 to 1e9, such as 1e8");
            return ExitCode::from(2);
        }
    };
    match study(longest as u64) {
        Ok(table) => {
            println!("Largest error of a covariance entry, relative to the sigmas\n{table}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
