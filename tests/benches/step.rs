//! What a sample and a learning window cost on a host, beside the same chain written with libraries.
//!
//! `cargo bench -p tests`. Times depend on the machine: quote the ratios.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use monitor_core::eigen::ClosedFormEigen;
use monitor_core::moments::Moments;
use monitor_core::paper::{Baseline, Config, Monitor, Phase};
use monitor_core::sample::{Bank, PerPair};
use monitor_sim::plant::Plant;
use monitor_sim::scenario::Scenario;
use nalgebra::{Matrix3, SymmetricEigen};
use tests::textbook::TextbookMonitor;

const RATE_HZ: f32 = 1000.0;
const THRESHOLD: f32 = 1.8;

/// The default mission's samples: 20 s of settling and learning, then 120 s that hold the three faults.
fn samples() -> Vec<[f32; 3]> {
    let measured = Plant::new(&Scenario::figure_1(), 1);
    measured.map(|m| [m.speed, m.armature_current, m.armature_voltage].map(|v| v as f32)).collect()
}

fn monitor(samples: &[[f32; 3]]) -> Monitor {
    let pairs = PerPair { speed_current: THRESHOLD, current_voltage: THRESHOLD, speed_voltage: THRESHOLD };
    let mut monitor =
        Monitor::new(&Config::paper(RATE_HZ, Bank { full: THRESHOLD, pairs })).expect("a good configuration");
    for x in samples {
        if monitor.step_channels(300.0, *x).phase() == Phase::ModelDue {
            monitor.finish_learning().expect("a window that can be learned");
        }
    }
    monitor
}

fn step(c: &mut Criterion) {
    let samples = samples();
    let (window, judged) = (&samples[5_000..20_000], &samples[20_000..]);
    let learned = monitor(&samples[..20_000]);
    let mut group = c.benchmark_group("step");
    group.throughput(Throughput::Elements(judged.len() as u64));
    group.bench_function("monitor-core", |b| {
        b.iter(|| {
            let mut monitor = learned.clone();
            judged.iter().for_each(|x| {
                black_box(monitor.step_channels(300.0, *x));
            });
        });
    });
    group.bench_function("nalgebra and biquad", |b| {
        b.iter(|| {
            let mut monitor =
                TextbookMonitor::learn(window[..100].iter().copied(), 1.0, RATE_HZ, THRESHOLD).expect("a good cutoff");
            judged.iter().for_each(|x| {
                black_box(monitor.step(*x));
            });
        });
    });
    group.finish();
}

fn window(c: &mut Criterion) {
    let samples = samples();
    let window = &samples[5_000..20_000];
    let mut group = c.benchmark_group("learning window of 15,000");
    group.throughput(Throughput::Elements(window.len() as u64));
    group.bench_function("monitor-core", |b| {
        b.iter(|| {
            let moments: Moments<3> = window.iter().copied().collect();
            black_box(Baseline::learn(&moments, monitor_core::pca::ExplainedShare::PAPER))
        });
    });
    group.bench_function("nalgebra, two passes", |b| {
        b.iter(|| black_box(TextbookMonitor::learn(window.iter().copied(), 1.0, RATE_HZ, THRESHOLD)));
    });
    group.finish();

    let correlation = Matrix3::new(1.0, 0.4, -0.3, 0.4, 1.0, 0.2, -0.3, 0.2, 1.0_f32);
    let mut group = c.benchmark_group("eigen 3x3");
    group.bench_function("closed form", |b| b.iter(|| black_box(&correlation).closed_form_eigen()));
    group.bench_function("nalgebra SymmetricEigen", |b| b.iter(|| SymmetricEigen::new(*black_box(&correlation))));
    group.finish();
}

criterion_group!(benches, step, window);
criterion_main!(benches);
