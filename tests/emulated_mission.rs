//! Promise: host and target agree, bit for bit. The firmware flies in emulation what the host flies.
//!
//! The emulation executes the target's instructions exactly; its timing means nothing, and nothing here ran on silicon.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::Duration;

use firmware_stub::deadline::Slot;
use firmware_stub::guarded::{GUARDED_WORDS, Guarded};
use firmware_stub::record::{self, Arrival, CHUNK, EIGEN_WORDS, Header, Kind, MATRIX_WORDS, SLOT_WORDS, VERDICT_WORDS};
use firmware_stub::request::Request;
use firmware_stub::sampling::{Notes, Reading};
use firmware_stub::settings::{guard_config, motor_constants};
use firmware_stub::{Background, Sampling, Shared};
use monitor_core::guard::Cause;
use monitor_core::paper::{Config, Diagnosis, Fault, Monitor};
use monitor_core::sample::Absence;
use monitor_core::sample::{Bank, PerPair};
use monitor_core::units::RadPerSec;
use monitor_sim::mission;
use monitor_sim::plant::Plant;
use monitor_sim::scenario::Scenario;
use monitor_sim::settings::PaperSettings;
use tests::stream::{self, Stream};
use tests::toolchain::{self, Board, Run};

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
    fly_with(board, &firmware(), stream)
}

fn fly_with(board: Board, firmware: &Path, stream: &[u32]) -> Result<Flown, String> {
    let desk = tempfile::tempdir().unwrap();
    fs::write(desk.path().join("mission.in"), stream::bytes(stream)).unwrap();
    let log = Run::new(board, firmware, desk.path()).log()?;
    let answer = fs::read(desk.path().join("mission.out")).unwrap();
    let answers = answer.chunks_exact(4).map(|word| u32::from_le_bytes(word.try_into().unwrap())).collect();
    Ok(Flown { answers, log })
}

/// Compares record by record, and shows the first that differs.
fn assert_equal<const N: usize>(target: &[u32], host: &[[u32; N]], what: &str) {
    for (index, (target, host)) in target.chunks_exact(N).zip(host).enumerate() {
        assert!(
            target == host,
            "the first {what} that differs is number {index}:\nhost   {host:08x?}\ntarget {target:08x?}"
        );
    }
    assert_eq!(target.len(), N * host.len(), "the target answered another number of {what}");
}

fn config() -> Config {
    PaperSettings::default_motor().unwrap().config(1000.0, 5.0, 15.0, 0.0)
}

/// The mission of figure 1, with readings among them that no sensor should give, slots without a sample, and requests.
fn mission() -> Vec<Arrival> {
    let mut slots: Vec<_> = Plant::new(&Scenario::figure_1(), 1)
        .map(|measured| Arrival::sample(RadPerSec(measured.set_point as f32), mission::sample(&measured)))
        .collect();
    let readings = [(7_000, f32::NAN), (50_000, f32::INFINITY), (50_001, 1e38), (51_000, 1e-40), (90_000, -0.0)];
    for (index, bad) in readings {
        let Reading::Taken(sample) = &mut slots[index].reading else { unreachable!() };
        sample.armature_current.0 = bad;
    }
    slots[52_000].set_point.0 = f32::NAN;
    // While the monitor settles, learns, judges, and while a fault stands.
    for (index, absence) in [
        (10, Absence::Missing),
        (8_000, Absence::Late),
        (9_000, Absence::Missing),
        (53_000, Absence::Late),
        (53_001, Absence::Missing),
        (70_000, Absence::Missing),
    ] {
        slots[index].reading = Reading::Absent(absence);
    }
    slots[70_100].request = Some(Request::Contributions);
    slots[70_200].request = Some(Request::Statistics);
    slots[70_300].request = Some(Request::Verdict);
    slots
}

fn mission_stream(slots: &[Arrival]) -> Vec<u32> {
    let mut stream = Stream::new(&Header { kind: Kind::Mission, records: slots.len() as u32, config: config() });
    slots.iter().for_each(|slot| stream.push(&slot.to_words()));
    stream.finish()
}

/// The interrupt's state on the host, where nothing interrupts.
struct Host<'q>(Sampling<'q>);

impl<'q> Shared<'q> for Host<'q> {
    fn with<R>(&mut self, f: impl FnOnce(&mut Sampling<'q>) -> R) -> R {
        f(&mut self.0)
    }
}

/// The same mission on the host.
fn host_verdicts(slots: &[Arrival]) -> Vec<[u32; VERDICT_WORDS]> {
    let mut queue = Notes::new();
    let (notes, heard) = queue.split();
    let mut host = Host(Sampling::new(Monitor::new(&config()).unwrap(), notes));
    let mut background = Background::new(heard, config().explained_share);
    let mut named = Vec::new();
    let step = |slot: &Arrival| {
        let verdict = *host.0.on_interrupt(Slot::default(), slot.set_point, || slot.reading, |_| {});
        background.learn(&mut host);
        while background.next_note().is_some() {}
        named.push(verdict.diagnosis());
        record::verdict_to_words(&verdict)
    };
    let verdicts = slots.iter().map(step).collect();
    // The mission is worth comparing only if it holds what it should.
    assert_eq!(slots.len(), 140_000);
    for (fault, at) in Fault::ALL.into_iter().zip([35_000, 75_000, 115_000]) {
        assert_eq!(named[at], Diagnosis::Fault(fault));
    }
    verdicts
}

#[test]
fn every_verdict_of_the_mission_is_equal_on_host_and_target_to_the_last_bit() {
    let slots = mission();
    let host = host_verdicts(&slots);
    for board in [Board::CortexM4, Board::CortexM7] {
        assert_equal(&fly(board, &mission_stream(&slots)).unwrap().answers, &host, "verdict");
    }
}

#[test]
fn the_boards_log_names_the_three_faults_in_order_with_their_size_and_since_when() {
    let log = fly(Board::CortexM4, &mission_stream(&mission())).unwrap().log;
    let at = |line: &String| line.split(" s: ").next()?.parse::<f64>().ok();
    for (fault, start, end) in
        [("LoadTorque", 20.0, 40.0), ("SpeedSensor", 60.0, 80.0), ("CurrentSensor", 100.0, 120.0)]
    {
        let inside = |line: &&String| at(line).is_some_and(|seconds| (start..end).contains(&seconds));
        let named: Vec<&String> = log.iter().filter(inside).filter(|line| line.contains(" s: fault ")).collect();
        let last = named.last().unwrap_or_else(|| panic!("no fault named while {fault} stands:\n{log:#?}"));
        assert!(last.contains(&format!("fault {fault}, alarm since {start}")), "{last}");
        assert!(last.contains("T2 ") && last.ends_with("of limit 1.753"), "{last}");
    }
    assert!(log.first().is_some_and(|line| line == "0.000000 s: settling, Start"), "{:?}", log.first());
    // A late sample is turned away with its reason, and the next one is judged again.
    let has = |line: &str| assert!(log.iter().any(|logged| logged.contains(line)), "{line} is not in {log:#?}");
    has("53.000000 s: samples are turned away, Absent(Late)");
    has("53.001000 s: samples are turned away, Absent(Missing)");
    has("53.002000 s: samples are judged again after 2");
    has("samples are turned away, NonFinite(ArmatureCurrent)");
    has("samples are turned away, NonFiniteSetPoint");
    // What was asked for while the speed sensor drifts.
    has("contributions to T2: speed ");
    has("70.200000 s: 10 slots turned away, 6 of them late or missing, 0 overruns, 0 notes dropped");
    has("70.300000 s: Monitoring, Fault(SpeedSensor), T2 ");
    // The painted stack: more than a frame, far less than the memory.
    let painted = log.iter().find_map(|line| line.strip_prefix("STACK_HIGH_WATER_BYTES=")?.parse::<u32>().ok());
    assert!(painted.is_some_and(|bytes| (500..20_000).contains(&bytes)), "{painted:?}");
    println!("STACK_HIGH_WATER_BYTES={}", painted.unwrap());
}

#[test]
fn guard_mode_says_the_same_on_host_and_target_to_the_last_bit_and_its_log_names_the_faults() {
    let slots = mission();
    let mut guarded = Guarded::new(&guard_config(1000.0), motor_constants()).unwrap();
    let host: Vec<[u32; GUARDED_WORDS]> = slots.iter().map(|slot| guarded.turn(slot)).collect();
    // The mission is worth comparing only if it holds what it should.
    const FAULT: u32 = 2;
    let causes = [Cause::LoadTorque, Cause::SpeedSensor, Cause::CurrentSensor];
    for (cause, at) in causes.into_iter().zip([35_000, 75_000, 115_000]) {
        assert_eq!(host[at][7..9], [FAULT, cause as u32], "{at}");
    }
    let firmware = toolchain::build("qemu-guard").unwrap_or_else(|error| panic!("{error}"));
    let on_m4 = fly_with(Board::CortexM4, &firmware, &mission_stream(&slots)).unwrap();
    assert_equal(&on_m4.answers, &host, "verdict");
    let on_m7 = fly_with(Board::CortexM7, &firmware, &mission_stream(&slots)).unwrap();
    assert_equal(&on_m7.answers, &host, "verdict");
    for (cause, from) in causes.into_iter().zip([20.0, 60.0, 100.0]) {
        let named = on_m4.log.iter().any(|line| {
            let at = line.split(" s: ").next().and_then(|at| at.parse::<f64>().ok());
            at.is_some_and(|at| (from..from + 1.0).contains(&at)) && line.contains(&format!("cause: {cause:?}"))
        });
        assert!(named, "{cause:?} is not named within a second: {:#?}", on_m4.log);
    }
}

#[test]
fn every_decomposition_is_equal_on_host_and_target_to_the_last_bit() {
    let matrices = matrices();
    let mut stream = Stream::new(&Header { kind: Kind::Matrices, records: matrices.len() as u32, config: config() });
    matrices.iter().for_each(|matrix| stream.push(matrix));
    let host: Vec<[u32; EIGEN_WORDS]> = matrices.iter().map(|matrix| record::eigen_to_words(*matrix)).collect();
    assert!(host.iter().filter(|words| words[0] == 1).count() > 6000, "most of them have a decomposition");
    assert_equal(&fly(Board::CortexM4, &stream.finish()).unwrap().answers, &host, "decomposition");
}

/// Lower triangles: small integers in every arrangement, ties of correlations, extremes, and bits at random.
fn matrices() -> Vec<[u32; MATRIX_WORDS]> {
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
    matrices
}

#[test]
fn a_stream_that_is_not_one_is_corrupt_or_ends_early_makes_the_board_say_so_and_fail() {
    let refused_as = |stream: &[u32]| fly(Board::CortexM4, stream).err().unwrap_or_default();
    let slots = &mission()[..3 * CHUNK];
    let whole = mission_stream(slots);
    assert_eq!(fly(Board::CortexM4, &whole).unwrap().answers.len(), slots.len() * VERDICT_WORDS);
    let header = record::HEADER_WORDS + 1;
    let second = header + CHUNK * SLOT_WORDS + 1;
    assert!(refused_as(&whole[..second + 7]).contains("the stream ends early"));
    assert!(refused_as(&whole[..second - 1]).contains("ends before a check word"));
    assert!(refused_as(&whole[..5]).contains("ends inside its header"));
    for (word, bit) in [(4, 0), (header + 3, 31), (second + 20, 7), (second - 1, 3)] {
        let mut corrupt = whole.clone();
        corrupt[word] ^= 1 << bit;
        assert!(refused_as(&corrupt).contains("the stream is corrupt"), "word {word}, bit {bit}");
    }
    let resealed = |change: fn(&mut Vec<u32>)| {
        let mut words = Header { kind: Kind::Mission, records: 1, config: config() }.to_words().to_vec();
        change(&mut words);
        let check = record::check_word(&words);
        words.into_iter().chain([check]).collect::<Vec<_>>()
    };
    assert!(refused_as(&resealed(|words| words[1] = 9)).contains("not one of slots or matrices"));
    assert!(refused_as(&resealed(|words| words[12] = f32::NAN.to_bits())).contains("refuses its settings"));
    let mut stream = Stream::new(&Header { kind: Kind::Mission, records: 1, config: config() });
    stream.push(&[3, 0, 0, 0, 0]);
    assert!(refused_as(&stream.finish()).contains("a record of the stream is not a slot"));
}

#[test]
fn no_stream_no_firmware_another_firmware_and_a_run_that_hangs_each_end_in_a_sentence() {
    let desk = tempfile::tempdir().unwrap();
    let ends_as = |run: Run| run.log().err().unwrap_or_default();
    let no_stream = ends_as(Run::new(Board::CortexM4, &firmware(), desk.path()));
    assert!(no_stream.contains("mission.in cannot be opened"), "{no_stream}");
    let no_firmware = ends_as(Run::new(Board::CortexM4, &desk.path().join("none.elf"), desk.path()));
    assert!(no_firmware.contains("none.elf cannot be read"), "{no_firmware}");
    let other = std::env::current_exe().unwrap();
    let wrong = ends_as(Run::new(Board::CortexM4, &other, desk.path()));
    assert!(wrong.contains("is not a firmware"), "{wrong}");
    // Stopped before its first instruction, the board waits for ever.
    let hung = Run::new(Board::CortexM4, &firmware(), desk.path()).with(&["-S"]).within(Duration::from_secs(1));
    let hung = ends_as(hung);
    assert!(hung.contains("did not end within 1 s"), "{hung}");
}

#[test]
fn thresholds_that_are_no_numbers_are_refused_on_the_board_as_on_the_host() {
    let pairs = PerPair { speed_current: 1.0, current_voltage: 1.0, speed_voltage: f32::NAN };
    let refused = Config { thresholds: Bank { full: 1.0, pairs }, ..config() };
    assert!(Monitor::new(&refused).is_err());
    let stream = Stream::new(&Header { kind: Kind::Mission, records: 0, config: refused }).finish();
    let said = fly(Board::CortexM4, &stream).err().unwrap_or_default();
    assert!(said.contains("refuses its settings"), "{said}");
}
