//! What the audited functions of `guard` mode are given, and digests of what they answer.

use monitor_core::guard::{Config, Directions, Explanation, Finding, MotorConstants, Verdict};

use super::{HEALTHY_MEAN, digest, digest_of_numbers};

/// Settings with times so short and scales so fast that phases and alarms change often.
#[must_use]
pub fn config() -> Config {
    Config {
        false_alarms_per_hour: 1.0,
        settle_s: 0.008,
        seed_s: 0.032,
        learn_s: 0.4,
        time_constants_s: [0.002, 0.008, 0.032, 0.128],
        memory_s: 10.0,
        clear_hold_s: 0.004,
        ..Config::at_rate(1000.0)
    }
}

/// Directions of the default motor's faults; none if its constants were no constants.
#[must_use]
pub fn directions() -> Directions {
    let motor = MotorConstants { resistance_ohm: 0.5, torque_constant_nm_per_a: 0.03, load_slope_nm_s: 1e-4 };
    Directions::of_motor(&motor, HEALTHY_MEAN).unwrap_or(Directions::none())
}

/// The digest of a verdict.
#[must_use]
pub fn digest_of_verdict(verdict: &Verdict) -> u32 {
    let flags = [
        verdict.alarm(),
        verdict.deviates(),
        verdict.recovering(),
        verdict.settled(),
        verdict.rejected(),
        verdict.gap(),
    ];
    let flags = flags.iter().fold(0, |word, flag| word << 1 | u32::from(*flag));
    let losses =
        verdict.losses().fold(0, |word, (channel, loss)| word << 8 | (channel as u32) << 4 | (loss as u32 + 1));
    let severity = verdict.severity().unwrap_or([-1.0; 4]);
    let since = verdict.since().map_or(u32::MAX, |since| since as u32);
    digest([verdict.sample() as u32, verdict.phase() as u32, since, flags, losses, digest_of_numbers(severity)])
}

/// The digest of a finding.
#[must_use]
pub fn digest_of_finding(finding: &Finding) -> u32 {
    let of_explanation = |explanation: &Explanation| {
        let Explanation { cause, size, size_sigma, misfit, runner_up } = *explanation;
        let (next, apart) = runner_up.map_or((0, 0.0), |(next, apart)| (next as u32 + 1, apart));
        digest([cause as u32, next, digest_of_numbers([size, size_sigma, misfit, apart])])
    };
    match finding {
        Finding::Healthy => 0,
        Finding::Locating => 1,
        Finding::Fault(explanation) => digest([2, of_explanation(explanation)]),
        Finding::Ambiguous(explanation, other) => digest([3, of_explanation(explanation), *other as u32]),
        Finding::Unknown => 4,
    }
}
