//! What a monitor in `guard` mode knows behind a slot, as words.

use monitor_core::guard::{Explanation, Finding, Monitor, Phase, Quality, SCALES, Stored};
use monitor_core::moments::LearnError;
use monitor_core::sample::Channel;

use super::check_word;
use crate::mode::{Guarded, Mode};

/// Words of an answer.
pub const GUARDED_WORDS: usize = 15;

/// Slots from one answer with a name to the next, while the motor deviates: a name takes sixteen times what a slot does.
const NAMED_EVERY: u64 = 16;

/// Slots from one answer with all numbers to the next: as many as a model takes for one round of sharpening.
const NUMBERS_EVERY: u64 = 64;

/// Channels, and set points that a monitor knows at most.
const CHANNELS: usize = 3;
const SET_POINTS: usize = 4;

/// What stands, since when, the bits of the distances, what was learned and refused, the name with its size, and check words
/// of all numbers that samples are judged by.
#[must_use]
pub fn guarded_to_words(guarded: &Guarded) -> [u32; GUARDED_WORDS] {
    let monitor = guarded.monitor();
    let verdict = monitor.verdict();
    let said = [
        verdict.alarm(),
        verdict.deviates(),
        verdict.recovering(),
        verdict.settled(),
        verdict.rejected(),
        verdict.gap(),
        verdict.absent().is_some(),
    ];
    let phase = match verdict.phase() {
        Phase::Settling => 0,
        Phase::Seeding => 1,
        Phase::Learning => 2,
        Phase::ModelDue => 3,
        Phase::Monitoring => 4,
        Phase::Withheld => 5,
    };
    let flags = said.into_iter().fold(phase, |word, said| word << 1 | u32::from(said));
    let flags = verdict
        .losses()
        .fold(flags, |word, (channel, loss)| word | 1 << (16 + 2 * channel.position() as u32 + loss as u32));
    let [fast, middle, slow, trend] = verdict.severity().map_or([u32::MAX; 4], |severity| severity.map(f32::to_bits));
    let since = verdict.since().map_or(u32::MAX, |since| since as u32);
    let due = |every| verdict.sample().is_multiple_of(every);
    let [name, size, sigma, misfit, apart] = if due(NAMED_EVERY) { found(&guarded.finding()) } else { [0; 5] };
    let numbers = if due(NUMBERS_EVERY) { numbers(monitor) } else { 0 };
    let (learned, refused) = (learned(monitor.quality()), monitor.refused().map_or(0, refused));
    let sample = verdict.sample() as u32;
    [sample, flags, since, fast, middle, slow, trend, learned, refused, name, size, sigma, misfit, apart, numbers]
}

fn found(finding: &Finding) -> [u32; 5] {
    let of = |kind: u32, found: &Explanation| {
        let (next, apart) = found.runner_up.map_or((0, 0), |(next, apart)| (next as u32 + 1, apart.to_bits()));
        let name = kind | (found.cause as u32) << 4 | next << 8;
        [name, found.size.to_bits(), found.size_sigma.to_bits(), found.misfit.to_bits(), apart]
    };
    match finding {
        Finding::Healthy => [0; 5],
        Finding::Locating => [1, 0, 0, 0, 0],
        Finding::Fault(found) => of(2, found),
        Finding::Ambiguous(found, other) => of(3 | (*other as u32) << 12, found),
        Finding::Unknown => [4, 0, 0, 0, 0],
    }
}

fn learned(quality: &Quality) -> u32 {
    let Quality { samples, clipped_share, condition, drift_sigmas, slow_variance_ratio } = *quality;
    let [a, b, c, d] = [clipped_share, condition, drift_sigmas, slow_variance_ratio].map(f32::to_bits);
    check_word(&[samples, a, b, c, d])
}

fn refused(error: LearnError) -> u32 {
    let of = |kind: u32, channel: Channel| kind | (channel.position() as u32) << 4;
    match error {
        LearnError::TooShort { samples } => 1 | samples << 4,
        LearnError::ConstantChannel(channel) => of(2, channel),
        LearnError::NonFinite(channel) => of(3, channel),
        LearnError::Clipped => 4,
        LearnError::Drifting(channel) => of(5, channel),
        LearnError::Unexpected(channel) => of(6, channel),
        _ => 7, // no PCA
    }
}

/// The check word of limits, deviation, and of the models of all set points, which bring check words of their own.
fn numbers(monitor: &Monitor) -> u32 {
    let mut words = [0; SCALES + CHANNELS + SET_POINTS];
    let (limits, deviation) = (monitor.limits().unwrap_or_default(), monitor.deviation().unwrap_or_default());
    let numbers = limits.into_iter().chain(deviation).map(f32::to_bits);
    let models = monitor.stored().map(|stored| check_of(&stored));
    for (word, bits) in words.iter_mut().zip(numbers.chain(models)) {
        *word = bits;
    }
    check_word(&words)
}

/// The check word at the end of a stored model.
fn check_of(stored: &Stored) -> u32 {
    stored.bytes().last_chunk().map_or(0, |check| u32::from_le_bytes(*check))
}
