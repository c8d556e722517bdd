//! A motor watched in `guard` mode slot by slot, as host and emulated board do it: the same lines on both, so that what they
//! answer can be compared in every bit.

use monitor_core::guard::{
    Config, ConfigError, Directions, Explanation, Finding, Model, Monitor, MotorConstants, Phase,
};

use crate::record::Arrival;
use crate::sampling::Reading;

/// Words of an answer.
pub const GUARDED_WORDS: usize = 12;

/// Slots from one question for a name to the next, while something is wrong. A name costs twenty times what a slot does.
const NAMED_EVERY: u64 = 16;

/// The monitor, and the directions by which it names faults once it has learned.
#[derive(Clone, Debug)]
pub struct Guarded {
    guard: Monitor,
    motor: MotorConstants,
    directions: Directions,
    found: Finding,
}

impl Guarded {
    /// A monitor before its first slot.
    ///
    /// # Errors
    /// [`ConfigError`] names the setting that is out of range.
    pub fn new(config: &Config, motor: MotorConstants) -> Result<Self, ConfigError> {
        Ok(Guarded { guard: Monitor::new(config)?, motor, directions: Directions::none(), found: Finding::Healthy })
    }

    /// The monitor.
    #[must_use]
    pub const fn guard(&self) -> &Monitor {
        &self.guard
    }

    /// What is wrong, as last asked.
    #[must_use]
    pub const fn found(&self) -> &Finding {
        &self.found
    }

    /// Takes a slot. A board does the first part in its sampling interrupt, and the rest in the main loop.
    pub fn turn(&mut self, arrival: &Arrival) -> [u32; GUARDED_WORDS] {
        match arrival.reading {
            Reading::Taken(sample) => self.guard.step(arrival.set_point, sample),
            Reading::Absent(why) => self.guard.skip(why),
        };
        if let Some(window) = self.guard.learned() {
            let model = Model::learn(window, self.guard.design());
            if self.guard.install(model)
                && let Some(model) = self.guard.model()
            {
                self.directions = Directions::of_motor(&self.motor, model.mean()).unwrap_or_default();
            }
        }
        let verdict = self.guard.verdict();
        if !verdict.deviates() {
            self.found = Finding::Healthy;
        } else if verdict.sample().is_multiple_of(NAMED_EVERY) {
            self.found = self.guard.finding(&self.directions);
        }
        self.to_words()
    }

    /// What stands, since when, the bits of the distances, and the name with its size.
    fn to_words(&self) -> [u32; GUARDED_WORDS] {
        let verdict = self.guard.verdict();
        let phase = match verdict.phase() {
            Phase::Settling => 0,
            Phase::Seeding => 1,
            Phase::Learning => 2,
            Phase::ModelDue => 3,
            Phase::Monitoring => 4,
            Phase::Withheld => 5,
        };
        let said = [
            verdict.alarm(),
            verdict.deviates(),
            verdict.recovering(),
            verdict.settled(),
            verdict.rejected(),
            verdict.gap(),
            verdict.absent().is_some(),
        ];
        let flags = said.into_iter().fold(phase, |word, said| word << 1 | u32::from(said));
        let flags = verdict
            .losses()
            .fold(flags, |word, (channel, loss)| word | 1 << (16 + 2 * channel.position() as u32 + loss as u32));
        let [fast, middle, slow, trend] =
            verdict.severity().map_or([u32::MAX; 4], |severity| severity.map(f32::to_bits));
        let since = verdict.since().map_or(u32::MAX, |since| since as u32);
        let none = [0; 4];
        let (kind, [name, next, size, sigma]) = match &self.found {
            Finding::Healthy => (0, none),
            Finding::Locating => (1, none),
            Finding::Fault(found) => (2, of(found)),
            Finding::Ambiguous(found, _) => (3, of(found)),
            Finding::Unknown => (4, none),
        };
        [verdict.sample() as u32, flags, since, fast, middle, slow, trend, kind, name, next, size, sigma]
    }
}

fn of(found: &Explanation) -> [u32; 4] {
    let next = found.runner_up.map_or(u32::MAX, |(cause, apart)| apart.to_bits() ^ cause as u32);
    [found.cause as u32, next, found.size.to_bits(), found.size_sigma.to_bits()]
}
