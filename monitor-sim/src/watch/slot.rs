//! One slot of a run as it is shown, whichever monitor judged it.

use monitor_core::guard;
use monitor_core::guard::Loss;
use monitor_core::moments::LearnError;
use monitor_core::paper::localize::{Diagnosis, Fault};
use monitor_core::paper::{Monitor, Verdict};
use monitor_core::sample::ModelId;

use crate::guardian::{Guardian, Said, Size};
use crate::names::name::Name;

/// Most distances that are shown side by side: the time scales of `guard` mode, the models of `paper` mode.
pub const DISTANCES: usize = 4;

/// One slot of a run.
#[derive(Clone, Copy, Debug)]
pub struct Slot {
    /// Seconds since the beginning of the run.
    pub t_s: f64,
    /// Set point; not a number where there is none.
    pub set_point: f64,
    /// The three channels; not a number where there is no reading.
    pub x: [f64; 3],
    /// What the monitor says.
    pub says: Says,
}

/// What the monitor is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// In front of the learning window of a log.
    Waiting,
    /// Waiting for the loop to settle.
    Settling,
    /// Gathering what healthy means.
    Learning,
    /// Judging.
    Monitoring,
    /// At a set point that nothing is known of and that was reached while a fault was suspected.
    Withheld,
}

/// What the monitor says of a slot.
#[derive(Clone, Copy, Debug)]
pub struct Says {
    /// What it is doing.
    pub phase: Phase,
    /// Whether the slot was judged.
    pub judged: bool,
    /// Whether something is wrong.
    pub alarm: bool,
    /// Whether the loop recovers.
    pub recovering: bool,
    /// How each channel is lost, if it is.
    pub lost: [Option<Loss>; 3],
    /// What is wrong, once it has a name.
    pub name: Option<Name>,
    /// How large it is, where the name has a size.
    pub size: Option<Size>,
    /// Each distance over its limit; not a number where there is none.
    pub ratios: [f32; DISTANCES],
    /// Mean and sigma that the slot is judged by; not numbers where there are none.
    pub mean: [f32; 3],
    /// See `mean`.
    pub sigma: [f32; 3],
    /// With the last slot of a learning window: why it was refused, if it was.
    pub refused: Option<LearnError>,
}

impl Says {
    /// Nothing is said yet.
    pub const NOTHING: Self = Says {
        phase: Phase::Waiting,
        judged: false,
        alarm: false,
        recovering: false,
        lost: [None; 3],
        name: None,
        size: None,
        ratios: [f32::NAN; DISTANCES],
        mean: [f32::NAN; 3],
        sigma: [f32::NAN; 3],
        refused: None,
    };

    /// What the monitor in `guard` mode says.
    #[must_use]
    pub fn by_guard(said: &Said, guardian: &Guardian) -> Self {
        let verdict = &said.verdict;
        let mut ratios = [f32::NAN; DISTANCES];
        for (ratio, severity) in ratios.iter_mut().zip(verdict.severity().into_iter().flatten()) {
            *ratio = severity;
        }
        let mut lost = [None; 3];
        for (channel, loss) in verdict.losses() {
            if let Some(lost) = lost.get_mut(channel as usize) {
                *lost = Some(loss);
            }
        }
        let model = guardian.guard().model();
        Says {
            phase: match verdict.phase() {
                guard::Phase::Settling => Phase::Settling,
                guard::Phase::Seeding | guard::Phase::Learning | guard::Phase::ModelDue => Phase::Learning,
                guard::Phase::Monitoring => Phase::Monitoring,
                guard::Phase::Withheld => Phase::Withheld,
            },
            judged: verdict.severity().is_some(),
            alarm: verdict.alarm(),
            recovering: verdict.recovering(),
            lost,
            name: said.found.map(|found| found.name),
            size: said.found.and_then(|found| found.size),
            ratios,
            mean: model.map_or([f32::NAN; 3], guard::Model::mean),
            sigma: model.map_or([f32::NAN; 3], guard::Model::sigma),
            refused: said.learned.and_then(Result::err),
        }
    }

    /// What the monitor in `paper` mode says; `refused` if this was the last slot of a window that was.
    #[must_use]
    pub fn by_paper(verdict: &Verdict, monitor: &Monitor, refused: Option<LearnError>) -> Self {
        let thresholds = monitor.thresholds();
        let ratio = |model: ModelId| {
            verdict.residuals().map_or(f32::NAN, |residuals| residuals.get(model) / thresholds.get(model))
        };
        let baseline = monitor.baseline();
        Says {
            phase: match verdict.phase() {
                monitor_core::paper::Phase::Settling(_) => Phase::Settling,
                monitor_core::paper::Phase::Learning | monitor_core::paper::Phase::ModelDue => Phase::Learning,
                monitor_core::paper::Phase::Monitoring => Phase::Monitoring,
            },
            judged: verdict.residuals().is_some(),
            alarm: verdict.alarm(),
            name: match verdict.diagnosis() {
                Diagnosis::Healthy => None,
                Diagnosis::Fault(Fault::LoadTorque) => Some(Name::LoadTorque),
                Diagnosis::Fault(Fault::SpeedSensor) => Some(Name::SpeedSensor),
                Diagnosis::Fault(Fault::CurrentSensor) => Some(Name::CurrentSensor),
                Diagnosis::Unknown => Some(Name::Unknown),
            },
            ratios: ModelId::ALL.map(ratio),
            mean: baseline.map_or([f32::NAN; 3], monitor_core::paper::Baseline::mean),
            sigma: baseline.map_or([f32::NAN; 3], monitor_core::paper::Baseline::sigma),
            refused,
            ..Says::NOTHING
        }
    }
}
