//! Promise: host and target agree, bit for bit. The firmware flies in emulation what the host flies.
//!
//! The emulation executes the target's instructions exactly; its timing means nothing, and nothing here ran on silicon.

use std::fs;
use std::path::PathBuf;
use std::sync::OnceLock;

use firmware_stub::on_sample;
use firmware_stub::record::{self, EIGEN_WORDS, Header, Kind, MATRIX_WORDS, SAMPLE_WORDS, VERDICT_WORDS};
use monitor_core::sample::{Bank, PerPair, Sample};
use monitor_core::units::RadPerSec;
use monitor_core::{Config, Monitor, Phase};
use monitor_sim::mission;
use monitor_sim::plant::Plant;
use monitor_sim::scenario::Scenario;
use monitor_sim::settings::PaperSettings;
use tests::toolchain::{self, Board};

/// The firmware, built once.
fn firmware() -> PathBuf {
    static ELF: OnceLock<Result<PathBuf, String>> = OnceLock::new();
    ELF.get_or_init(|| toolchain::build("qemu-mission")).clone().unwrap_or_else(|error| panic!("{error}"))
}

/// What an emulated board made of a stream.
struct Flown {
    answers: Vec<u32>,
    log: Vec<String>,
}

/// Sends a stream to an emulated board.
fn fly(board: Board, stream: &[u32]) -> Result<Flown, String> {
    let desk = tempfile::tempdir().unwrap();
    let bytes: Vec<u8> = stream.iter().flat_map(|word| word.to_le_bytes()).collect();
    fs::write(desk.path().join("mission.in"), bytes).unwrap();
    let frames = toolchain::emulate(board, &firmware(), desk.path())?;
    let answer = fs::read(desk.path().join("mission.out")).unwrap();
    let answers = answer.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect();
    Ok(Flown { answers, log: toolchain::decoded(&firmware(), &frames)? })
}

/// Compares record by record, and shows the first that differs.
fn assert_equal<const N: usize>(target: &[u32], host: &[[u32; N]], what: &str) {
    assert_eq!(target.len(), N * host.len(), "the target answered another number of {what}");
    for (index, (target, host)) in target.chunks_exact(N).zip(host).enumerate() {
        assert!(
            target == host,
            "the first {what} that differs is number {index}:\nhost   {host:08x?}\ntarget {target:08x?}"
        );
    }
}

fn config() -> Config {
    PaperSettings::default_motor().unwrap().config(1000.0, 5.0, 15.0, 0.0)
}

/// The mission of figure 1, with readings among them that no sensor should give.
fn mission() -> Vec<(RadPerSec, Sample)> {
    let set_point = |measured: &monitor_sim::plant::PlantSample| RadPerSec(measured.set_point as f32);
    let mut samples: Vec<_> = Plant::new(&Scenario::figure_1(), 1)
        .map(|measured| (set_point(&measured), mission::sample(&measured)))
        .collect();
    for (index, bad) in [(7_000, f32::NAN), (50_000, f32::INFINITY), (50_001, 1e38), (51_000, 1e-40), (90_000, -0.0)] {
        samples[index].1.armature_current.0 = bad;
    }
    samples[52_000].0.0 = f32::NAN;
    samples
}

fn mission_stream(samples: &[(RadPerSec, Sample)]) -> Vec<u32> {
    let header = Header { kind: Kind::Mission, records: samples.len() as u32, config: config() };
    let words = samples.iter().flat_map(|(set_point, sample)| record::sample_to_words(*set_point, *sample));
    header.to_words().into_iter().chain(words).collect()
}

/// The same mission on the host.
fn host_verdicts(samples: &[(RadPerSec, Sample)]) -> Vec<[u32; VERDICT_WORDS]> {
    let mut monitor = Monitor::new(&config()).unwrap();
    let mut named = Vec::new();
    let step = |(set_point, sample): &(RadPerSec, Sample)| {
        let verdict = on_sample(&mut monitor, *set_point, *sample, |_| {});
        if verdict.phase() == Phase::ModelDue {
            monitor.finish_learning().unwrap();
        }
        named.push(verdict.diagnosis());
        record::verdict_to_words(&verdict)
    };
    let verdicts = samples.iter().map(step).collect();
    // The mission is worth comparing only if it holds what it should.
    assert_eq!(samples.len(), 140_000);
    for (fault, at) in monitor_core::Fault::ALL.into_iter().zip([35_000, 75_000, 115_000]) {
        assert_eq!(named[at], monitor_core::Diagnosis::Fault(fault));
    }
    verdicts
}

#[test]
fn every_verdict_of_the_mission_is_equal_on_host_and_target_to_the_last_bit() {
    let samples = mission();
    let host = host_verdicts(&samples);
    for board in [Board::CortexM4, Board::CortexM7] {
        assert_equal(&fly(board, &mission_stream(&samples)).unwrap().answers, &host, "verdict");
    }
}

#[test]
fn the_boards_log_names_the_three_faults_in_order_with_their_size_and_since_when() {
    let log = fly(Board::CortexM4, &mission_stream(&mission())).unwrap().log;
    let at = |line: &String| line.strip_prefix("sample ")?.split(':').next()?.parse::<u64>().ok();
    for (fault, start, end) in
        [("LoadTorque", 20_000, 40_000), ("SpeedSensor", 60_000, 80_000), ("CurrentSensor", 100_000, 120_000)]
    {
        let inside = |line: &&String| at(line).is_some_and(|sample| (start..end).contains(&sample));
        let named: Vec<&String> = log.iter().filter(inside).filter(|line| line.contains(": fault ")).collect();
        let last = named.last().unwrap_or_else(|| panic!("no fault named while {fault} stands:\n{log:#?}"));
        assert!(last.contains(&format!("fault {fault}, alarm since sample {}", start / 1000)), "{last}");
        assert!(last.contains("T2 ") && last.ends_with("limit 1.753"), "{last}");
    }
    assert!(log.first().is_some_and(|line| line == "sample 0: settling, Start"), "{:?}", log.first());
    // One sample later than without the reading at 7 s that was not a number.
    assert!(log.iter().any(|line| line == "sample 20001: Monitoring"), "{log:#?}");
}

#[test]
fn every_decomposition_is_equal_on_host_and_target_to_the_last_bit() {
    // Lower triangles: small integers in every arrangement, ties of correlations, extremes, and bits at random.
    let mut matrices: Vec<[u32; MATRIX_WORDS]> = Vec::new();
    let digit = |k: u32, place: u32| (k / 3_u32.pow(place) % 3) as f32 - 1.0;
    matrices.extend((0..729).map(|k| [0, 1, 2, 3, 4, 5].map(|place| digit(k, place).to_bits())));
    let rho = [-1.0, -0.999_999_9, -0.5, 0.0, 1e-7, 0.3, 0.999_9, 1.0_f32];
    for a in rho {
        for b in rho {
            matrices.extend(rho.map(|c| [1.0, a, 1.0, b, c, 1.0].map(f32::to_bits)));
        }
    }
    for extreme in [f32::MAX, f32::MIN_POSITIVE, 1e-45, 1e30, 1e-30, f32::NAN, f32::INFINITY] {
        matrices.extend((0..6).map(|place| {
            let mut entries = [1.0, 0.5, 2.0, -0.25, 0.125, 1.5_f32];
            entries[place] = extreme;
            entries.map(f32::to_bits)
        }));
        matrices.push([1.0, 0.5, 2.0, -0.25, 0.125, 1.5_f32].map(|a| (a * extreme).to_bits()));
    }
    let mut state = 1_u64;
    matrices.extend((0..5000).map(|_| {
        std::array::from_fn(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 32) as u32
        })
    }));
    let header = Header { kind: Kind::Matrices, records: matrices.len() as u32, config: config() };
    let stream: Vec<u32> = header.to_words().into_iter().chain(matrices.iter().flatten().copied()).collect();
    let host: Vec<[u32; EIGEN_WORDS]> = matrices.iter().map(|matrix| record::eigen_to_words(*matrix)).collect();
    assert!(host.iter().filter(|words| words[0] == 1).count() > 6000, "most of them have a decomposition");
    assert_equal(&fly(Board::CortexM4, &stream).unwrap().answers, &host, "decomposition");
}

#[test]
fn a_stream_that_is_not_one_or_ends_early_makes_the_board_say_so_and_fail() {
    let samples = mission();
    let header = Header { kind: Kind::Mission, records: 100, config: config() }.to_words();
    let words = samples.iter().flat_map(|(set_point, sample)| record::sample_to_words(*set_point, *sample));
    let cut: Vec<u32> = header.into_iter().chain(words.take(99 * SAMPLE_WORDS)).collect();
    let refused_as = |stream: &[u32]| fly(Board::CortexM4, stream).err().unwrap_or_default();
    assert!(refused_as(&cut).contains("the stream ends early"));
    assert!(refused_as(&header[..5]).contains("ends inside its header"));
    assert!(refused_as(&[0; 200]).contains("not one of samples or matrices"));
    let pairs = PerPair { speed_current: 1.0, current_voltage: 1.0, speed_voltage: f32::NAN };
    let refused = Config { thresholds: Bank { full: 1.0, pairs }, ..config() };
    let header = Header { kind: Kind::Mission, records: 0, config: refused }.to_words();
    assert!(refused_as(&header).contains("refuses its settings"));
}
