//! Promise: host and target agree, bit for bit. The firmware flies in emulation what the host flies.
//!
//! The emulation executes the target's instructions exactly; its timing means nothing, and nothing here ran on silicon.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::Duration;

use firmware_stub::deadline::Slot;
use firmware_stub::record::{
    self, Arrival, CHUNK, EIGEN_WORDS, GUARDED_WORDS, Header, Kind, MATRIX_WORDS, SLOT_WORDS, VERDICT_WORDS,
};
use firmware_stub::request::Request;
use firmware_stub::sampling::{Notes, Reading};
use firmware_stub::settings::{guard_config, motor_constants};
use firmware_stub::{Background, Guarded, Mode, Paper, Sampling, Shared};
use monitor_core::Sample;
use monitor_core::guard::{self, Cause, Loss};
use monitor_core::paper::{Config, Monitor};
use monitor_core::sample::{Absence, Bank, Channel, PerPair};
use monitor_core::units::{Amperes, RadPerSec, Volts};
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
    slots[70_100].request = Some(Request::ByChannel);
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
struct Host<'q, M: Mode>(Sampling<'q, M>);

impl<'q, M: Mode> Shared<'q, M> for Host<'q, M> {
    fn with<R>(&mut self, f: impl FnOnce(&mut Sampling<'q, M>) -> R) -> R {
        f(&mut self.0)
    }
}

/// The same slots on the host: `answer` is what it would tell of each.
fn on_host<M: Mode, const N: usize>(mode: M, slots: &[Arrival], answer: impl Fn(&M) -> [u32; N]) -> Vec<[u32; N]> {
    let mut queue = Notes::<M>::new();
    let (notes, heard) = queue.split();
    let (mut host, mut background) = (Host(Sampling::new(mode, notes)), Background::new(heard));
    let step = |slot: &Arrival| {
        host.0.on_interrupt(Slot::default(), slot.set_point, || slot.reading, |_| {});
        let answer = answer(host.0.mode());
        background.learn(&mut host);
        while background.next_note().is_some() {}
        if let Some(request) = slot.request {
            background.answer(request, &mut host);
        }
        answer
    };
    slots.iter().map(step).collect()
}

fn host_verdicts(slots: &[Arrival]) -> Vec<[u32; VERDICT_WORDS]> {
    let paper = Paper::new(Monitor::new(&config()).unwrap());
    let verdicts = on_host(paper, slots, |paper| record::verdict_to_words(paper.verdict()));
    // The mission is worth comparing only if it holds what it should.
    assert_eq!(slots.len(), 140_000);
    for (fault, at) in (1..).zip([35_000, 75_000, 115_000]) {
        assert_eq!(verdicts[at][1] >> 4 & 0xf, fault, "{at}");
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

/// Flies slots in `guard` mode on the host and on both cores, and compares all answers; returns them with the log of the first.
fn fly_guarded(slots: &[Arrival], sample_rate_hz: f32) -> (Vec<[u32; GUARDED_WORDS]>, Vec<String>) {
    let monitor = guard::Monitor::new(&guard_config(sample_rate_hz)).unwrap();
    let host = on_host(Guarded::new(monitor, motor_constants()), slots, record::guarded_to_words);
    let firmware = toolchain::build("qemu-guard").unwrap_or_else(|error| panic!("{error}"));
    let config = Config { sample_rate_hz, ..config() };
    let mut stream = Stream::new(&Header { kind: Kind::Mission, records: slots.len() as u32, config });
    slots.iter().for_each(|slot| stream.push(&slot.to_words()));
    let stream = stream.finish();
    let [on_m4, on_m7] = [Board::CortexM4, Board::CortexM7]
        .map(|board| fly_with(board, &firmware, &stream).unwrap_or_else(|e| panic!("{e}")));
    assert_equal(&on_m4.answers, &host, "answer");
    assert_equal(&on_m7.answers, &host, "answer");
    (host, on_m4.log)
}

/// The word of a fault that is named, the runner-up left out.
const fn named(cause: Cause) -> u32 {
    2 | (cause as u32) << 4
}

#[test]
fn guard_mode_knows_and_says_the_same_on_host_and_target_to_the_last_bit_and_its_log_names_the_faults() {
    let (host, log) = fly_guarded(&mission(), 1000.0);
    // The mission is worth comparing only if it holds what it should.
    let causes = [Cause::LoadTorque, Cause::SpeedSensor, Cause::CurrentSensor];
    for (cause, at) in causes.into_iter().zip([35_008, 75_008, 115_008]) {
        assert_eq!(host[at][9] & 0xff, named(cause), "{at}");
    }
    let at = |line: &str| line.split(" s: ").next().and_then(|at| at.parse::<f64>().ok());
    let units = ["N m", "rad/s", "A"];
    for ((cause, unit), from) in causes.into_iter().zip(units).zip([20.0, 60.0, 100.0]) {
        let within = |line: &&String| at(line).is_some_and(|at| (from..from + 1.0).contains(&at));
        let has = |what: &str| log.iter().filter(within).find(|line| line.contains(what)).cloned();
        let line = has(&format!("fault {cause:?}, alarm since {from:.0}."));
        let line = line.unwrap_or_else(|| panic!("{cause:?} is not named within a second: {log:#?}"));
        assert!(line.contains(&format!(" {unit}, sigma ")), "{line}");
        assert!(has("distance ").is_some(), "{log:#?}");
    }
    let has = |line: &str| assert!(log.iter().any(|logged| logged.contains(line)), "{line} is not in {log:#?}");
    has("learned from 15000 samples, ");
    has("alarm withdrawn that stood since 20.0");
    // What was asked for while the speed sensor drifts.
    has("deviation from healthy: speed ");
    has(" slots turned away, 6 of them late or missing, 0 overruns, 0 notes dropped");
    has("70.300000 s: sample 70300: Monitoring, ");
}

/// Slots in a second of the rough ride.
const ROUGH_HZ: f32 = 200.0;

/// Whatever a monitor in `guard` mode can meet: windows that are refused, sensors that stick or are silent, a gap, a set point
/// that moves while a fault stands, one that is recalled, and one between two that are known.
fn rough_ride() -> Vec<Arrival> {
    let mut state = 1_u64;
    let mut noise = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1 << 23) as f32 - 1.0
    };
    (0..26_000_u32)
        .map(|k| {
            let set_point = match k {
                15_500..20_000 => 200.0,
                23_000.. => 250.0,
                _ => 300.0,
            };
            let mut load = 0.002 * (set_point - 100.0);
            // Slots 4,200 and 7,600 end a window of 3,000: one with spikes, and one in which the load has risen.
            load += if (6_100..7_600).contains(&k) { 0.02 } else { 0.0 };
            load += if (14_500..16_000).contains(&k) { 0.3 } else { 0.0 };
            let mut sample = Sample {
                speed: RadPerSec(set_point + 0.1 * noise()),
                armature_current: Amperes(load + 0.01 * noise()),
                armature_voltage: Volts(0.299 * load + 0.0302 * set_point + 0.01 * noise()),
            };
            match k {
                600..800 => sample.armature_voltage.0 = 9.0,
                1_300..4_000 if k.is_multiple_of(5) => sample.speed.0 += 30.0,
                11_500..12_000 => sample.speed.0 = 300.0,
                12_500..13_000 => sample.armature_current.0 = f32::NAN,
                _ => {}
            }
            let gap = (13_500..13_530).contains(&k);
            let reading = if gap { Reading::Absent(Absence::Missing) } else { Reading::Taken(sample) };
            let request = match k {
                15_800 => Some(Request::Acknowledge),
                15_900 | 21_000 => Some(Request::Statistics),
                _ => None,
            };
            Arrival { set_point: RadPerSec(set_point), reading, request }
        })
        .collect()
}

#[test]
fn refused_windows_lost_sensors_and_moving_set_points_are_the_same_on_host_and_target_and_are_logged() {
    let (host, log) = fly_guarded(&rough_ride(), ROUGH_HZ);
    let has = |line: &str| assert!(log.iter().any(|logged| logged.contains(line)), "{line} is not in {log:#?}");
    has("learning refused, ConstantChannel(ArmatureVoltage)");
    has("learning refused, Clipped");
    has("learning refused, Drifting(ArmatureCurrent)");
    has("learned from 3000 samples, ");
    has("sensor lost, Speed Stuck");
    has("sensor back, Speed");
    has("sensor lost, ArmatureCurrent Silent");
    has("samples are turned away, Unfit");
    has("gap, no samples come");
    has("samples come again");
    has("fault LoadTorque, alarm since 72.5");
    has("Withheld");
    has("acknowledged: the motor is taken for healthy");
    // What the log says is in the answers, which are compared.
    let (flags, refused): (BTreeSet<u32>, BTreeSet<u32>) = host.iter().map(|answer| (answer[1], answer[8])).unzip();
    assert_eq!(refused.len(), 4, "none, and three reasons: {refused:?}");
    for (channel, loss) in [(Channel::Speed, Loss::Stuck), (Channel::ArmatureCurrent, Loss::Silent)] {
        let bit = 16 + 2 * channel.position() as u32 + loss as u32;
        assert!(flags.iter().any(|flags| flags >> bit & 1 == 1), "{channel:?} {loss:?}");
    }
    assert!(host.iter().any(|answer| answer[9] & 0xff == named(Cause::LoadTorque)));
    let numbers: BTreeSet<u32> = host.iter().map(|answer| answer[14]).collect();
    assert!(numbers.len() > 100, "models and limits move: {}", numbers.len());
    // Two set points were learned, and the first is judged by at once when it is reached again.
    let learned: BTreeSet<u32> = host.iter().map(|answer| answer[7]).collect();
    assert_eq!(learned.len(), 3, "none, and two: {learned:?}");
    let judged = |at: usize| host[at][3] != u32::MAX;
    assert!(!judged(17_000) && judged(20_600), "{log:#?}");
    // One between them is judged when it has been seeded, for 5 s, and not for a window of 15.
    assert!(!judged(23_900) && judged(24_200) && judged(25_999), "{log:#?}");
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
