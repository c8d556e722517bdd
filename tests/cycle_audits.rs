//! Promise: the audit of time finds a path that depends on data, by what it sees and by proof, and lets a choice pass.

use std::sync::OnceLock;
use std::time::Duration;

use firmware_stub::kernels::{Kernel, Request};
use tests::audit::cycle_audit::{self, Kernels, Observed};
use tests::audit::inputs::{self, NASTY, Question};
use tests::audit::taint::Proof;
use tests::audit::trace::{self, Detail, Limits};

/// The firmware, built once.
fn kernels() -> &'static Kernels {
    static KERNELS: OnceLock<Result<Kernels, String>> = OnceLock::new();
    KERNELS.get_or_init(Kernels::build).as_ref().unwrap_or_else(|error| panic!("{error}"))
}

/// A specimen on every nasty number and some others: what was seen, and the proof.
fn specimen(kernel: Kernel) -> (Observed, Proof) {
    let numbers = NASTY.into_iter().chain([0.5, 1.5, 3.0, 7.0, 9.0, 100.0]);
    let ask = |x| Question { request: Request::new(kernel, &[x]), label: "specimen", expected: None };
    let questions: Vec<_> = numbers.map(ask).collect();
    let seen = cycle_audit::observe(kernels(), &questions).unwrap().remove("specimen").unwrap();
    // For the proof, one input that takes the ordinary path is enough.
    let proof = cycle_audit::prove(kernels(), &[ask(0.5)]).unwrap().remove("specimen").unwrap();
    (seen, proof)
}

#[test]
fn a_branch_on_data_is_seen_as_several_paths_and_refused_by_the_proof() {
    let (seen, proof) = specimen(Kernel::Branching);
    assert!(seen.paths.len() > 3, "{} paths", seen.paths.len());
    assert!(!proof.holds());
    let said = proof.faults().join("\n");
    assert!(said.contains("audit_branching") && said.contains("depends on data"), "{said}");
}

#[test]
fn a_choice_without_a_branch_is_one_path_and_proven() {
    let (seen, proof) = specimen(Kernel::Selecting);
    assert_eq!((seen.calls, seen.paths.len()), (20, 1));
    assert!(proof.holds(), "{:?}", proof.faults());
    assert_eq!(proof.selects.len(), 1, "the choice was followed, and not overlooked");
}

#[test]
fn an_address_from_data_is_one_path_and_still_refused() {
    let (seen, proof) = specimen(Kernel::Indexing);
    assert_eq!(seen.paths.len(), 1, "the paths alone do not tell");
    assert!(proof.faults().join("\n").contains("its address depends on data"), "{:?}", proof.faults());
}

#[test]
fn a_branch_on_what_an_earlier_sample_left_behind_is_refused() {
    let ask = |label| Question { request: Request::new(Kernel::Remembering, &[0.5]), label, expected: None };
    let proofs = cycle_audit::prove(kernels(), &[ask("first"), ask("second")]).unwrap();
    assert!(proofs["first"].holds(), "nothing has been remembered yet: {:?}", proofs["first"].faults());
    assert_eq!(proofs["first"].control.len(), 4, "the number that decides is state");
    assert!(proofs["second"].faults().join("\n").contains("audit_remembering"), "{:?}", proofs["second"].faults());
}

#[test]
fn judging_and_learning_take_one_path_each_whatever_the_samples_are() {
    let proofs = cycle_audit::prove(kernels(), &inputs::steps(1, 60)).unwrap();
    for label in [inputs::MONITORING, inputs::SWITCHING, inputs::LEARNING, inputs::LEARNING_JOIN] {
        assert_eq!(proofs[label].faults(), Vec::<String>::new(), "{label}");
        assert!(proofs[label].selects.len() > 3, "{label}: data was followed, and not lost");
    }
}

#[test]
fn judging_and_learning_in_guard_mode_take_paths_that_only_the_count_decides() {
    let proofs = cycle_audit::prove(kernels(), &inputs::guard(1, 200)).unwrap();
    for label in [inputs::GUARD_MONITORING, inputs::GUARD_TURN, inputs::GUARD_SEEDING, inputs::GUARD_LEARNING] {
        assert_eq!(proofs[label].faults(), Vec::<String>::new(), "{label}");
        assert!(proofs[label].selects.len() > 3, "{label}: data was followed, and not lost");
    }
}

#[test]
fn an_answer_that_is_not_the_hosts_stops_the_audit() {
    let wrong = Question { request: Request::new(Kernel::Filter, &[1.0]), label: "filter", expected: Some(1) };
    let error = cycle_audit::observe(kernels(), &[wrong]).unwrap_err();
    assert!(error.contains("the firmware's result is not the host's"), "{error}");
}

#[test]
fn a_firmware_that_runs_too_long_is_stopped_with_a_sentence() {
    let (elf, requests) = (&kernels().elf, [Request::new(Kernel::Filter, &[1.0])]);
    let run = |limits| trace::run(elf, &requests, Detail::Path, limits, |_| Ok(())).unwrap_err();
    let short = Limits { instructions: 1000, ..Limits::DEFAULT };
    assert!(run(short).contains("stopped after 1000 instructions"), "{}", run(short));
    let quick = Limits { time: Duration::from_millis(1), ..Limits::DEFAULT };
    assert!(run(quick).contains("it hangs"), "{}", run(quick));
}
