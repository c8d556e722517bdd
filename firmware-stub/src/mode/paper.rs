//! `paper` mode on a board: names come with the verdicts.

use monitor_core::moments::{LearnError, Moments};
use monitor_core::paper::event::{Event, EventKind, Watch};
use monitor_core::paper::verdict::Rejected;
use monitor_core::paper::{Baseline, Diagnosis, Monitor, Verdict};
use monitor_core::pca::ExplainedShare;
use monitor_core::sample::ModelId;
use monitor_core::units::RadPerSec;

use super::Mode;
use crate::sampling::Reading;

/// The monitor, and what is remembered beside it.
#[derive(Clone, Debug)]
pub struct Paper {
    monitor: Monitor,
    watch: Watch,
    /// The last readings that were not turned away.
    channels: [f32; 3],
}

/// Something that changed between two verdicts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct News {
    /// What, and when.
    pub event: Event,
    /// The smoothed T2 it is about: of the relay's model, else of the full one; zero when nothing was judged.
    pub residual: f32,
    /// The limit of that.
    pub limit: f32,
    /// The sample from which on some relay has been up.
    pub alarm_since: Option<u64>,
}

impl Paper {
    /// A monitor before its first slot.
    #[must_use]
    pub fn new(monitor: Monitor) -> Self {
        Paper { monitor, watch: Watch::default(), channels: [0.0; 3] }
    }

    /// The monitor.
    #[must_use]
    pub const fn monitor(&self) -> &Monitor {
        &self.monitor
    }
}

impl Mode for Paper {
    type Verdict = Verdict;
    type News = News;
    type Rejected = Rejected;
    type Window = (Moments<3>, ExplainedShare);
    type Model = Baseline;
    type Finding = Diagnosis;
    type Named = ();

    fn step(&mut self, set_point: RadPerSec, reading: Reading, mut tell: impl FnMut(News)) -> Option<Rejected> {
        let Paper { monitor, watch, channels, .. } = self;
        match reading {
            Reading::Taken(sample) => monitor.step(set_point, sample),
            Reading::Absent(why) => monitor.skip(why),
        };
        let verdict = monitor.verdict();
        let rejected = verdict.rejected();
        if rejected.is_none() {
            *channels = verdict.readings();
        }
        watch.observe(verdict, |event| tell(news(event, monitor)));
        rejected
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
        self.monitor.verdict().alarm_since()
    }

    fn learned_window(&self) -> Option<Self::Window> {
        self.monitor.learned_window().map(|window| (*window, self.monitor.explained_share()))
    }

    fn learn((window, share): &Self::Window) -> Result<Baseline, LearnError> {
        Baseline::learn(window, *share)
    }

    fn install(&mut self, learned: Result<Baseline, LearnError>, mut tell: impl FnMut(News)) -> bool {
        let wanted = self.monitor.install(learned);
        if let (true, Err(error)) = (wanted, learned) {
            tell(news(Event { sample: self.slot(), kind: EventKind::LearningRefused(error) }, &self.monitor));
        }
        wanted
    }

    fn by_channel(&self) -> Option<[f32; 3]> {
        self.monitor.contributions(self.channels)
    }

    fn finding(&self) -> Diagnosis {
        self.monitor.verdict().diagnosis()
    }
}

/// What the main loop needs in order to tell of an event.
#[inline(never)]
fn news(event: Event, monitor: &Monitor) -> News {
    let model = match event.kind {
        EventKind::RelayUp(model) | EventKind::RelayDown(model) => model,
        _ => ModelId::Full,
    };
    let verdict = monitor.verdict();
    let residual = verdict.residuals().map_or(0.0, |residuals| *residuals.get(model));
    News { event, residual, limit: *monitor.thresholds().get(model), alarm_since: verdict.alarm_since() }
}
