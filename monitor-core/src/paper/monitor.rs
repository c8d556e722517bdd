//! The monitor: set-point gate, phase I (learning), phase II (judging), one call per sample.

use super::baseline::Baseline;
use super::detector::{Chain, Detector};
use super::verdict::{Phase, Settling, Slot, Verdict};
use crate::low_pass::{LowPass, LowPassError};
use crate::moments::{LearnError, Moments};
use crate::pca::{ExplainedShare, PcaError};
use crate::relay::{Relay, RelayError};
use crate::sample::Absence;
use crate::sample::{Bank, ModelId, PerPair, Sample};
use crate::set_point::{Gate, GateError, GateState, SetPointGate};
use crate::smoother::Smoother;
use crate::units::RadPerSec;

/// Settings of a monitor. All of them are fixed before the first sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// Samples per second, Hz.
    pub sample_rate_hz: f32,
    /// How long after a change of the set point nothing is learned or judged, s.
    pub settle_s: f32,
    /// Length of the learning window, s. The paper learns from 5 s to 20 s (III.B).
    pub learn_s: f32,
    /// Largest movement of the set point that is not a change, in the set point's unit.
    pub set_point_tolerance: f32,
    /// Share of the variance that the retained components must explain (1.3), in (0, 1].
    pub explained_share: f32,
    /// Cutoff of the residual's low-pass (fig. 3), Hz.
    pub cutoff_hz: f32,
    /// Threshold of each residual's relay, in the units of the scaled T2 (1.6): one is the mean in control.
    pub thresholds: Bank<f32>,
    /// How far below its threshold a residual must fall to bring its relay down, as a share of it, in [0, 1).
    pub hysteresis: f32,
}

impl Config {
    /// The paper's settings for a sampling rate: 5 s to settle, 15 s to learn, 80 % explained variance, residuals
    /// smoothed at 1 Hz. The thresholds are found for each motor by borderline runs (III.B).
    #[must_use]
    pub const fn paper(sample_rate_hz: f32, thresholds: Bank<f32>) -> Self {
        Config {
            sample_rate_hz,
            settle_s: 5.0,
            learn_s: 15.0,
            set_point_tolerance: 0.0,
            explained_share: ExplainedShare::PAPER.get(),
            cutoff_hz: 1.0,
            thresholds,
            hysteresis: 0.1,
        }
    }
}

/// Why a configuration was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ConfigError {
    /// The sampling rate must be finite and above zero.
    SampleRate,
    /// The settling time must be finite and not negative, and fit into 2^32 samples.
    SettleTime,
    /// The learning window must hold at least [`Moments::MIN_SAMPLES`] samples and fewer than 2^32.
    LearnTime,
    /// The set-point tolerance must be finite and not negative.
    SetPointTolerance,
    /// The share of variance to explain must lie in (0, 1].
    ExplainedShare,
    /// The cutoff must lie above zero and below half the sampling rate.
    Cutoff,
    /// The threshold of this residual must be finite and above zero.
    Threshold(ModelId),
    /// The hysteresis must lie in [0, 1).
    Hysteresis,
}

impl From<PcaError> for ConfigError {
    fn from(_: PcaError) -> Self {
        ConfigError::ExplainedShare
    }
}

impl From<LowPassError> for ConfigError {
    fn from(_: LowPassError) -> Self {
        ConfigError::Cutoff
    }
}

impl From<GateError> for ConfigError {
    fn from(_: GateError) -> Self {
        ConfigError::SetPointTolerance
    }
}

/// Where the monitor stands; each phase owns what it moves, so a monitor is as large as its largest phase.
#[derive(Clone, Copy, Debug)]
enum Stage<S: Smoother> {
    /// With the running mean of what was read while the loop settled, from which learning takes its deviations.
    Settling(Option<[f32; 3]>),
    Learning(Moments<3>),
    ModelDue(Moments<3>),
    Monitoring(Detector<S>),
}

/// The fault monitor of one motor.
///
/// `S` smooths the residuals: the Butterworth [`LowPass`] by default, or a
/// [`MovingAverage`](crate::moving_average::MovingAverage).
#[derive(Clone, Debug)]
#[repr(C)] // In this order: what every sample touches comes first, where short instructions reach it.
pub struct Monitor<S: Smoother = LowPass> {
    /// On the last sample; each step brings it up to date in place.
    verdict: Verdict,
    gate_state: GateState,
    gate: SetPointGate,
    chain: Chain<S>,
    stage: Stage<S>,
    settling: Settling,
    learn_slots: u32,
    share: ExplainedShare,
    refused: Option<LearnError>,
}

impl Monitor {
    /// A monitor that settles, learns and then judges, its residuals smoothed by the Butterworth low-pass.
    ///
    /// # Errors
    /// [`ConfigError`] names the setting that is out of range.
    pub fn new(config: &Config) -> Result<Self, ConfigError> {
        Self::with_smoother(config, LowPass::butterworth(config.cutoff_hz, config.sample_rate_hz)?)
    }
}

impl<S: Smoother> Monitor<S> {
    /// A monitor with a smoother of its own; the configured cutoff is not used.
    ///
    /// # Errors
    /// [`ConfigError`] names the setting that is out of range.
    pub fn with_smoother(config: &Config, smoother: S) -> Result<Self, ConfigError> {
        if !(config.sample_rate_hz > 0.0 && config.sample_rate_hz.is_finite()) {
            return Err(ConfigError::SampleRate);
        }
        let samples = |seconds: f32| {
            let samples = libm::roundf(seconds * config.sample_rate_hz);
            // 2^32 as f32; written so that NaN is refused.
            (0.0..4_294_967_296.0).contains(&samples).then_some(samples as u32)
        };
        let settle_samples = samples(config.settle_s).ok_or(ConfigError::SettleTime)?;
        let learn_slots =
            samples(config.learn_s).filter(|n| *n >= Moments::<3>::MIN_SAMPLES).ok_or(ConfigError::LearnTime)?;
        let gate = SetPointGate::new(config.set_point_tolerance, settle_samples)?;
        let relay = |model| {
            Relay::new(*config.thresholds.get(model), config.hysteresis).map_err(|error| match error {
                RelayError::Threshold => ConfigError::Threshold(model),
                RelayError::Hysteresis => ConfigError::Hysteresis,
            })
        };
        let [full, speed_current, current_voltage, speed_voltage] = ModelId::ALL.map(relay);
        let pairs =
            PerPair { speed_current: speed_current?, current_voltage: current_voltage?, speed_voltage: speed_voltage? };
        Ok(Monitor {
            // The first sample has index zero.
            verdict: Verdict { sample: u64::MAX, ..Verdict::default() },
            gate_state: gate.unknown(),
            gate,
            chain: Chain { smoother, relays: Bank { full: full?, pairs } },
            stage: Stage::Settling(None),
            settling: Settling::Start,
            learn_slots,
            share: ExplainedShare::new(config.explained_share)?,
            refused: None,
        })
    }

    /// Starts judging at once, at a set point whose baseline is known (offline baselines, the paper II.C).
    #[must_use]
    pub fn starting_from(mut self, baseline: Baseline, set_point: f32) -> Self {
        self.gate_state = self.gate.open_at(set_point);
        self.judge_by(baseline);
        self
    }

    /// Judges from the next sample on.
    fn judge_by(&mut self, baseline: Baseline) {
        self.stage = Stage::Monitoring(Detector::new(baseline, &self.chain.smoother));
        self.verdict.phase = Phase::Monitoring;
        self.refused = None;
    }

    /// Takes one sample of the motor and says what is wrong, if anything is. The verdict is the monitor's own: copy what
    /// outlives the next step.
    #[inline]
    pub fn step(&mut self, set_point: RadPerSec, sample: Sample) -> &Verdict {
        self.step_channels(set_point.0, sample.into())
    }

    /// The same for any three channels: positions 0, 1 and 2 stand where speed, current and voltage do.
    ///
    /// Never fails, never allocates. A reading that is not a number or out of range is reported and leaves model, filters
    /// and relays as they were: only time passes. While the set point holds, the work does not depend on the readings.
    #[inline]
    pub fn step_channels(&mut self, set_point: f32, x: [f32; 3]) -> &Verdict {
        let [a, b, c] = x;
        self.slot(set_point, a, b, c)
    }

    /// One slot of the sampling clock. Once in flash, whoever calls it, so that what is audited is what flies; readings
    /// come one by one because an array would have to pass through memory.
    #[inline(never)]
    fn slot(&mut self, set_point: f32, a: f32, b: f32, c: f32) -> &Verdict {
        let x = [a, b, c];
        self.verdict.sample = self.verdict.sample.wrapping_add(1);
        self.verdict.readings = x;
        if let Stage::Monitoring(detector) = &mut self.stage
            && self.gate.holds(&self.gate_state, set_point)
        {
            detector.step(&self.chain, x, &mut self.verdict);
        } else {
            self.before_judging(set_point);
        }
        &self.verdict
    }

    /// Lets a slot of the sampling clock go by that has no sample of its own, and says so.
    pub fn skip(&mut self, why: Absence) -> &Verdict {
        // No reading is no number.
        self.step_channels(self.gate_state.reference(), [f32::NAN; 3]);
        self.verdict.standing = self.verdict.standing.with(match why {
            Absence::Late => Slot::Late,
            Absence::Missing => Slot::Missing,
        });
        &self.verdict
    }

    /// A sample that no model judges: the monitor learns, or settles, or waits for its model, or the set point has moved.
    #[cold]
    #[inline(never)]
    fn before_judging(&mut self, set_point: f32) {
        let x = self.verdict.readings;
        let held = !measurable(x);
        let slot = if held { Slot::Unfit } else { Slot::Taken };
        self.verdict.standing = self.verdict.standing.with(slot);
        if !set_point.is_finite() {
            self.verdict.standing = self.verdict.standing.with(Slot::SetPointNonFinite);
            return;
        }
        match self.gate.step(&mut self.gate_state, set_point) {
            Gate::Changed => self.settle(),
            Gate::Settling => {}
            Gate::Open => self.open(held, x),
        }
        match &mut self.stage {
            Stage::Settling(mean) if !held => *mean = Some(mean.map_or(x, |mean| follow(mean, x))),
            Stage::Learning(window) => {
                window.push_unless(held, x);
                if window.slots() >= self.learn_slots {
                    self.stage = Stage::ModelDue(*window);
                }
            }
            _ => {}
        }
        self.verdict.phase = self.phase();
    }

    /// The set point has moved: whatever was learned or stood is void.
    fn settle(&mut self) {
        // A set point that moves while the monitor still settles does not change why it settles.
        if !matches!(self.stage, Stage::Settling(_)) {
            self.settling = Settling::SetPointChanged;
        }
        self.stage = Stage::Settling(None);
        self.verdict.standing = self.verdict.standing.without_relays();
    }

    /// The set point has been constant for long enough. Where nothing has been read meanwhile, a window waits for the first
    /// sample that is fit.
    fn open(&mut self, held: bool, x: [f32; 3]) {
        if let Stage::Settling(mean) = self.stage
            && let Some(shift) = mean.or((!held).then_some(x))
        {
            self.stage = Stage::Learning(Moments::around(shift));
        }
    }

    /// The learning window, once it is complete and until a model is installed.
    ///
    /// A board copies it out of the sampling interrupt, calls [`Baseline::learn`] at leisure, and hands the result in
    /// with [`Monitor::install`].
    #[must_use]
    pub fn learned_window(&self) -> Option<&Moments<3>> {
        match &self.stage {
            Stage::ModelDue(window) => Some(window),
            _ => None,
        }
    }

    /// Hands in what was made of the learning window. Returns whether the monitor was waiting for it: if the set point
    /// has changed meanwhile, the baseline is of no use and is ignored.
    pub fn install(&mut self, learned: Result<Baseline, LearnError>) -> bool {
        let Stage::ModelDue(window) = self.stage else { return false };
        match learned {
            Ok(baseline) => self.judge_by(baseline),
            Err(error) => {
                (self.stage, self.refused) = (Stage::Learning(Moments::around(window.shift())), Some(error));
                self.verdict.phase = Phase::Learning;
            }
        }
        true
    }

    /// Ends learning with a baseline that is already known, such as the one of this set point from an earlier visit
    /// or from a table (offline baselines, the paper II.C): judging begins with the next sample.
    ///
    /// Returns whether it did: only while a window is being learned, or has been, does the monitor want one. While the
    /// loop settles or samples are judged nothing changes.
    pub fn recall(&mut self, baseline: Baseline) -> bool {
        let wanted = matches!(self.stage, Stage::Learning(_) | Stage::ModelDue(_));
        if wanted {
            self.judge_by(baseline);
        }
        wanted
    }

    /// Makes a model of the learning window if it is complete, on the spot: [`Monitor::learned_window`],
    /// [`Baseline::learn`] and [`Monitor::install`] in one, for hosts and for boards with time to spare in the loop.
    ///
    /// Returns whether a model was installed.
    ///
    /// # Errors
    /// [`LearnError`] when the window was refused; a new one has begun.
    pub fn finish_learning(&mut self) -> Result<bool, LearnError> {
        let Some(window) = self.learned_window() else { return Ok(false) };
        let learned = Baseline::learn(window, self.share);
        self.install(learned);
        learned.map(|_| true)
    }

    /// The baseline that samples are judged by, while the monitor judges.
    #[must_use]
    pub fn baseline(&self) -> Option<&Baseline> {
        match &self.stage {
            Stage::Monitoring(detector) => Some(&detector.baseline),
            _ => None,
        }
    }

    /// What each channel contributes to the T2 of a sample by the full model; none while nothing is judged.
    /// See [`Model::contributions`](crate::hotelling::Model::contributions).
    #[must_use]
    pub fn contributions(&self, x: [f32; 3]) -> Option<[f32; 3]> {
        self.baseline().map(|baseline| baseline.contributions(x))
    }

    /// The verdict on the last slot; before the first, the index of its sample is the largest `u64`, one before zero.
    #[must_use]
    pub const fn verdict(&self) -> &Verdict {
        &self.verdict
    }

    /// Why the last complete learning window was refused, until one is accepted.
    #[must_use]
    pub const fn refused(&self) -> Option<LearnError> {
        self.refused
    }

    /// The share of variance that a model must explain; what [`Baseline::learn`] asks for.
    #[must_use]
    pub const fn explained_share(&self) -> ExplainedShare {
        self.share
    }

    /// The threshold of each residual's relay.
    #[must_use]
    pub fn thresholds(&self) -> Bank<f32> {
        Bank::from_fn(|model| self.chain.relays.get(model).threshold())
    }

    fn phase(&self) -> Phase {
        match &self.stage {
            Stage::Settling(_) => Phase::Settling(self.settling),
            Stage::Learning(_) => Phase::Learning,
            Stage::ModelDue(_) => Phase::ModelDue,
            Stage::Monitoring(_) => Phase::Monitoring,
        }
    }
}

/// A running mean over the last sixteen readings or so.
fn follow(mean: [f32; 3], x: [f32; 3]) -> [f32; 3] {
    let ([m1, m2, m3], [x1, x2, x3]) = (mean, x);
    [m1 + 0.0625 * (x1 - m1), m2 + 0.0625 * (x2 - m2), m3 + 0.0625 * (x3 - m3)]
}

/// Whether all three readings are finite and of a size that sensors measure, in any unit. No branch, as in the detector.
#[inline(always)]
fn measurable(x: [f32; 3]) -> bool {
    const LARGEST: f32 = 1e15;
    x.map(|x| x.abs() <= LARGEST).iter().fold(true, |all, one| all & one)
}

#[cfg(test)]
mod tests;
