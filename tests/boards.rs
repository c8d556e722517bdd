//! Promises of the boards: every firmware builds for the board it names, samples by interrupt against a real deadline,
//! and ends in a defined state. In emulation; nothing here ran on silicon.

use std::fs;
use std::io::Write;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::Duration;

use tests::stream;
use tests::toolchain::{Board, Firmware, Run, Unit};

/// Builds a firmware, or fails with what is missing.
fn built(firmware: Firmware<'_>) -> std::path::PathBuf {
    firmware.build().unwrap_or_else(|error| panic!("{error}"))
}

const BARE: Firmware<'_> = Firmware::example("bare_interrupt", "board-qemu");
const EMBASSY: Firmware<'_> = Firmware::example("embassy", "board-qemu,embassy");
const DRILL: Firmware<'_> = Firmware::emulated("fault-drill");
const THRUSTER: Firmware<'_> = Firmware::thruster("board-stm32f405,emulated");
const PAPER_THRUSTER: Firmware<'_> = Firmware::thruster("board-stm32f405,emulated,paper");

#[test]
fn hard_fault_stack_overflow_watchdog_and_panic_leave_the_output_safe_with_a_reason_and_an_exit_code() {
    let drill = built(DRILL);
    let desk = tempfile::tempdir().unwrap();
    let reasons = ["hard fault", "stack overflow", "watchdog", "panic"];
    for (number, reason) in (1_u32..).zip(reasons) {
        fs::write(desk.path().join("drill.in"), number.to_le_bytes()).unwrap();
        let ended = Run::new(Board::CortexM4, &drill, desk.path()).counting_instructions().frames().unwrap_err();
        assert!(ended.contains("exit status: 1") && ended.contains(&format!("error: {reason}")), "{ended}");
        assert!(ended.contains("fault output safe"), "{ended}");
    }
    // A drill that does not exist is told from a fault that went unnoticed.
    fs::write(desk.path().join("drill.in"), 9_u32.to_le_bytes()).unwrap();
    let ended = Run::new(Board::CortexM4, &drill, desk.path()).frames().unwrap_err();
    assert!(ended.contains("no such drill"), "{ended}");
}

#[test]
fn the_examples_for_a_bare_interrupt_and_for_embassy_learn_judge_and_name_the_fault() {
    let desk = tempfile::tempdir().unwrap();
    let bare = Run::new(Board::CortexM4, &built(BARE), desk.path()).counting_instructions().log().unwrap();
    // embassy's executor sleeps, and QEMU's clock then jumps over slots: the same ones in every run.
    let asleep = ["-icount", "shift=6,sleep=off"];
    let embassy = Run::new(Board::CortexM4, &built(EMBASSY), desk.path()).with(&asleep).log().unwrap();
    for log in [&bare, &embassy] {
        assert!(log.iter().any(|line| line.contains("fault SpeedSensor, alarm since 3.5")), "{log:#?}");
    }
    // No slot is lost or late; the first one of the drift may be turned away, being wild by itself.
    assert!(bare.iter().any(|line| line.contains(" 0 of them late or missing, 0 overruns")), "{bare:#?}");
}

#[test]
fn an_interrupt_that_is_held_up_overruns_and_the_slots_it_cost_are_late_or_missing() {
    let desk = tempfile::tempdir().unwrap();
    // Slot 2000 takes 1.2 ms: the next one begins while it lasts, but in time. Slot 2100 takes 3.6 ms: two slots are
    // missing, and the third is late.
    fs::write(desk.path().join("stall.in"), stream::bytes(&[2000, 1200, 2100, 3600])).unwrap();
    let log = Run::new(Board::CortexM4, &built(BARE), desk.path()).counting_instructions().log().unwrap();
    let has = |line: &str| assert!(log.iter().any(|logged| logged.contains(line)), "{line} is not in {log:#?}");
    has("2.000000 s: sampling overran");
    has("2.100000 s: sampling overran");
    has("2.101000 s: samples are turned away, Absent(Missing)");
    has("2.103000 s: samples are turned away, Absent(Late)");
    has("2.104000 s: samples are judged again after 3");
    has(" slots turned away, 3 of them late or missing, ");
}

#[test]
fn the_thruster_firmware_learns_monitors_and_answers_in_guard_mode_on_the_emulated_stm32f405() {
    let log = asked_in_flight(THRUSTER, &["slots turned away", "deviation from healthy", "deviates since", "limits"]);
    // The emulator's converters count instead of measuring, so that the window may be refused.
    assert_in_order(&log, &["sampling at 1000 Hz", "Settling", "Seeding", "Learning", "ModelDue", "learn"]);
}

#[test]
fn the_thruster_firmware_learns_monitors_and_answers_in_paper_mode_on_the_emulated_stm32f405() {
    let log = asked_in_flight(PAPER_THRUSTER, &["armature voltage", "slots turned away", "contributions to T2"]);
    assert_in_order(&log, &["sampling at 1000 Hz", "settling, Start", "Learning", "ModelDue", "Monitoring"]);
}

/// Runs a thruster's firmware, asks everything of it once it monitors, and waits for the answers; returns its log.
fn asked_in_flight(thruster: Firmware<'_>, answers: &[&str]) -> Vec<String> {
    let desk = tempfile::tempdir().unwrap();
    let line = desk.path().join("line");
    let serial = format!("unix:{},server=on,wait=off", line.display());
    // Requests go to the third serial line, USART3.
    let run = Run::new(Board::Stm32F405, &built(thruster), desk.path())
        .counting_instructions()
        .within(Duration::from_secs(30))
        .with(&["-serial", "null", "-serial", "null", "-serial", &serial]);
    let mut asked = None;
    let log = run.watch(|log| {
        let has = |what: &str| log.iter().any(|line| line.contains(what));
        if (has("s: Monitoring") || has("learning refused")) && asked.is_none() {
            asked = ask(&line, b"cvs");
        }
        answers.iter().all(|answer| has(answer))
    });
    log.unwrap_or_else(|error| panic!("{error}"))
}

/// Whether the first lines that hold these follow one another.
fn assert_in_order(log: &[String], what: &[&str]) {
    let places: Vec<_> = what.iter().map(|what| log.iter().position(|line| line.contains(what))).collect();
    assert!(places.is_sorted() && places[0].is_some(), "{places:?} of {what:?} in {log:#?}");
}

/// Sends bytes over the emulated serial line. Closed at once, it would lose them, so whoever asks holds it open.
fn ask(line: &Path, requests: &[u8]) -> Option<UnixStream> {
    let mut line = UnixStream::connect(line).ok()?;
    line.write_all(requests).ok().map(|()| line)
}

#[test]
fn the_production_firmware_of_the_stm32f405_builds_with_either_clock() {
    for features in ["board-stm32f405", "board-stm32f405,pll"] {
        built(Firmware::thruster(features));
    }
}

#[test]
fn two_boards_at_once_are_refused_with_a_sentence() {
    for (features, sentence) in [
        ("board-qemu,board-stm32f405", "a firmware is for one board"),
        ("board", "no board is chosen"),
        ("board-qemu,emulated", "the feature emulated belongs to the feature board-stm32f405"),
        ("board-stm32f405,emulated,pll", "choose either the feature pll or the feature emulated"),
    ] {
        let library = Firmware { binary: "firmware-stub", unit: Unit::Library, features, ..BARE };
        let refused = library.build().unwrap_err();
        assert!(refused.contains(sentence), "{refused}");
    }
}

#[test]
fn the_library_compiles_for_the_rp2040_and_the_rp2350() {
    for (target, cpu) in [("thumbv6m-none-eabi", "cortex-m0plus"), ("thumbv8m.main-none-eabihf", "cortex-m33")] {
        for binary in ["monitor-core", "firmware-stub"] {
            let unit = Unit::Library;
            built(Firmware { binary, unit, features: "defmt", target, cpu, guarded: false, ..BARE });
        }
    }
}

#[test]
fn every_firmware_is_free_of_lints() {
    let emulated = ["qemu-mission", "qemu-guard"].map(Firmware::emulated);
    let thrusters = ["board-stm32f405", "board-stm32f405,pll"].map(Firmware::thruster);
    for firmware in [DRILL, BARE, EMBASSY, THRUSTER, PAPER_THRUSTER].into_iter().chain(emulated).chain(thrusters) {
        firmware.lint().unwrap_or_else(|error| panic!("{error}"));
    }
}
