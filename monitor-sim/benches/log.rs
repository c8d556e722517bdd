//! How fast a recorded log is read. `cargo bench -p monitor-sim`

use std::fmt::Write as _;
use std::hint::black_box;
use std::io::Cursor;

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use monitor_sim::log::{ColumnRef, LogOptions, LogReader};

const ROWS: u32 = 100_000;

/// Twelve columns as a CNC spindle logs them, one of them text; three are chosen.
fn log() -> Vec<u8> {
    let mut text = String::from("t,p,speed,a,cp,cs,ca,current,bus,oc,voltage,process\n");
    for row in 0..ROWS {
        let x = f64::from(row);
        let (speed, current, voltage) = (53.3 + x.sin(), 20.0 + x.sin(), 118.0 + x.cos());
        let _ = writeln!(
            text,
            "{row},{x:.1},{speed:.2},{current:.3},283.0,53.3,0.0,{current:.3},0.946,319.0,{voltage:.2},Layer 1 Up"
        );
    }
    text.into_bytes()
}

fn channels() -> Vec<(String, ColumnRef)> {
    let column = |name: &str| (name.to_owned(), name.parse().expect("a column name"));
    ["speed", "current", "voltage"].map(column).to_vec()
}

fn read(c: &mut Criterion) {
    let (text, channels) = (log(), channels());
    let mut group = c.benchmark_group("log of 12 columns");
    group.throughput(Throughput::Elements(ROWS.into()));
    group.bench_function("three chosen", |b| {
        b.iter_batched(
            || Cursor::new(text.clone()),
            |input| {
                let mut log =
                    LogReader::from_reader("log", input, &channels, LogOptions::default()).expect("a good log");
                while let Some(row) = log.next_row().expect("a good row") {
                    black_box(row.values);
                }
            },
            BatchSize::LargeInput,
        );
    });
    group.finish();
}

criterion_group!(benches, read);
criterion_main!(benches);
