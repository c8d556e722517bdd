//! `guard` mode on a board: the name of what is wrong is asked for at leisure, of a copy of the monitor.

use monitor_core::guard::{
    Cause, Design, Directions, Finding, Loss, Model, Monitor, MotorConstants, Phase, Quality, Verdict, Window,
};
use monitor_core::moments::LearnError;
use monitor_core::sample::{Absence, Channel};
use monitor_core::units::RadPerSec;

use super::Mode;
use crate::sampling::Reading;

/// Slots from one question for a name to the next, while the motor deviates: a name takes sixteen times what a slot does, and
/// copying the monitor holds the sampling interrupt off.
const NAMED_EVERY: u64 = 100;

/// The monitor, and what is remembered beside it.
#[derive(Clone, Debug)]
pub struct Guarded {
    monitor: Monitor,
    motor: MotorConstants,
    stood: Stood,
    /// The slot in which the alarm was last raised.
    raised: u64,
}

/// Something that changed with a slot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct News {
    /// The slot.
    pub sample: u64,
    /// What has changed.
    pub what: What,
}

/// What can change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum What {
    /// The monitor entered a phase.
    Phase(Phase),
    /// An alarm: the motor behaves otherwise than it was learned to.
    Raised {
        /// Since this sample; earlier than now if the alarm before was of the same fault.
        since: u64,
        /// The largest distance in units of its limit; zero while nothing is judged.
        severity: f32,
    },
    /// That alarm is withdrawn.
    Withdrawn {
        /// It stood since this sample.
        since: u64,
    },
    /// A sensor says nothing any more.
    Lost(Channel, Loss),
    /// It does again.
    Back(Channel),
    /// Samples have been missing for so long that the motor is not watched.
    Gap,
    /// They come again.
    GapOver,
    /// A window was refused; learning has begun again, or waits until the alarm is acknowledged. Of seeding windows that are refused
    /// for one reason in a row only the first is told.
    Refused(LearnError),
    /// A learning window was accepted.
    Learned(Quality),
}

/// Why a slot is turned away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Rejected {
    /// It has no sample of its own.
    Absent(Absence),
    /// A channel that is not lost has no reading, or a wild one where the readings before were not, two channels are lost, or the
    /// set point is no number.
    Unfit,
}

/// When a name was last asked for, and what was said.
#[derive(Clone, Copy, Debug, Default)]
pub struct Named {
    asked: Option<u64>,
    said: Option<(Option<u64>, Name)>,
}

/// A name without its size: what can be told apart, and what it cannot be told from.
type Name = [Option<Cause>; 2];

/// What stands, and is told of when it changes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Stood {
    phase: Option<Phase>,
    since: Option<u64>,
    gap: bool,
    lost: [Option<Loss>; 3],
    refused: Option<LearnError>,
}

impl Stood {
    fn of(monitor: &Monitor) -> Self {
        let verdict = monitor.verdict();
        let mut lost = [None; 3];
        for (channel, loss) in verdict.losses() {
            if let Some(place) = lost.get_mut(channel.position()) {
                *place = Some(loss);
            }
        }
        let (phase, since) = (Some(verdict.phase()), verdict.since());
        Stood { phase, since, gap: verdict.gap(), lost, refused: monitor.refused() }
    }

    /// What has changed since `before`.
    #[inline(never)]
    fn news(&self, before: &Self, verdict: &Verdict) -> [Option<What>; 8] {
        let phase = self.phase.filter(|_| self.phase != before.phase).map(What::Phase);
        let severity = || verdict.severity().unwrap_or_default().into_iter().fold(0.0, f32::max);
        let (withdrawn, raised) = match (before.since, self.since) {
            (before, now) if before == now => (None, None),
            (before, now) => (
                before.map(|since| What::Withdrawn { since }),
                now.map(|since| What::Raised { since, severity: severity() }),
            ),
        };
        let gap = (self.gap != before.gap).then_some(if self.gap { What::Gap } else { What::GapOver });
        let refused = self.refused.filter(|_| self.refused != before.refused).map(What::Refused);
        let [a, b, c] = [Channel::Speed, Channel::ArmatureCurrent, Channel::ArmatureVoltage].map(|channel| {
            let lost = |stood: &Self| stood.lost.get(channel.position()).copied().flatten();
            match (lost(before), lost(self)) {
                (before, now) if before == now => None,
                (_, Some(loss)) => Some(What::Lost(channel, loss)),
                (_, None) => Some(What::Back(channel)),
            }
        });
        [withdrawn, refused, phase, raised, gap, a, b, c]
    }
}

impl Guarded {
    /// A monitor before its first slot, of a motor with these constants. What was learned earlier has been restored in it.
    #[must_use]
    pub fn new(monitor: Monitor, motor: MotorConstants) -> Self {
        Guarded { monitor, motor, stood: Stood::default(), raised: 0 }
    }

    /// The monitor.
    #[must_use]
    pub const fn monitor(&self) -> &Monitor {
        &self.monitor
    }
}

impl Mode for Guarded {
    type Verdict = Verdict;
    type News = News;
    type Rejected = Rejected;
    type Window = (Window, Design);
    type Model = (Model, Quality);
    type Finding = Finding;
    type Named = Named;

    fn step(&mut self, set_point: RadPerSec, reading: Reading, mut tell: impl FnMut(News)) -> Option<Rejected> {
        let Guarded { monitor, stood, raised, .. } = self;
        match reading {
            Reading::Taken(sample) => monitor.step(set_point, sample),
            Reading::Absent(why) => monitor.skip(why),
        };
        let (verdict, now) = (monitor.verdict(), Stood::of(monitor));
        if now != *stood {
            for what in now.news(stood, verdict).into_iter().flatten() {
                if let What::Raised { .. } = what {
                    *raised = verdict.sample();
                }
                tell(News { sample: verdict.sample(), what });
            }
            *stood = now;
        }
        verdict.rejected().then(|| verdict.absent().map_or(Rejected::Unfit, Rejected::Absent))
    }

    fn verdict(&self) -> &Verdict {
        self.monitor.verdict()
    }

    fn slot(&self) -> u64 {
        self.monitor.verdict().sample()
    }

    fn alarm(&self) -> bool {
        self.monitor.verdict().alarm()
    }

    fn since(&self) -> Option<u64> {
        self.monitor.verdict().since()
    }

    fn learned_window(&self) -> Option<Self::Window> {
        self.monitor.learned().map(|window| (*window, *self.monitor.design()))
    }

    fn learn((window, design): &Self::Window) -> Result<Self::Model, LearnError> {
        Model::learn(window, design)
    }

    fn install(&mut self, learned: Result<Self::Model, LearnError>, mut tell: impl FnMut(News)) -> bool {
        let what = match &learned {
            Ok((_, quality)) => What::Learned(*quality),
            Err(error) => What::Refused(*error),
        };
        let wanted = self.monitor.install(learned);
        if wanted {
            tell(News { sample: self.slot(), what });
            self.stood.refused = self.monitor.refused();
        }
        wanted
    }

    fn acknowledge(&mut self) {
        self.monitor.acknowledge();
    }

    /// How far each reading is from healthy, in its unit.
    fn by_channel(&self) -> Option<[f32; 3]> {
        self.monitor.deviation()
    }

    fn finding(&self) -> Finding {
        // The directions are those of the set point that stands: its model may have been learned long ago.
        let mean = self.monitor.model().map(Model::mean);
        let directions = mean.and_then(|mean| Directions::of_motor(&self.motor, mean).ok());
        self.monitor.finding(&directions.unwrap_or_default())
    }

    fn is_to_be_named(&self, named: &Named) -> bool {
        // Not as soon as it is raised: what is known then is of the time before.
        let last = named.asked.map_or(self.raised, |asked| asked.max(self.raised));
        self.monitor.verdict().deviates() && self.slot().wrapping_sub(last) >= NAMED_EVERY
    }

    fn name(&self, named: &mut Named) -> Option<Finding> {
        named.asked = Some(self.slot());
        let finding = self.finding();
        let name = match &finding {
            // Nothing to say yet.
            Finding::Healthy | Finding::Locating => return None,
            Finding::Fault(found) => [Some(found.cause), None],
            Finding::Ambiguous(found, other) => [Some(found.cause), Some(*other)],
            Finding::Unknown => [None, None],
        };
        // The same name of another alarm is news again.
        let said = Some((self.since(), name));
        let news = named.said != said;
        named.said = said;
        news.then_some(finding)
    }
}
