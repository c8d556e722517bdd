//! What the core's positions, models, faults and refusals are called for people and machines.

use monitor_core::guard;
use monitor_core::moments::{LearnError, Moments};
use monitor_core::paper::baseline::BaselineError;
use monitor_core::paper::event::EventKind;
use monitor_core::paper::localize::{Diagnosis, Fault};
use monitor_core::paper::monitor::ConfigError;
use monitor_core::paper::verdict::Settling;
use monitor_core::paper::{Baseline, Phase};
use monitor_core::sample::{Bank, Channel, ModelId, Pair};

pub mod name;

/// The identifier of a fault in tables and JSON: the paper's number.
#[must_use]
pub const fn fault_id(fault: Fault) -> &'static str {
    match fault {
        Fault::LoadTorque => "F1",
        Fault::SpeedSensor => "F2",
        Fault::CurrentSensor => "F3",
    }
}

/// What a fault is, in words.
#[must_use]
pub const fn fault_name(fault: Fault) -> &'static str {
    match fault {
        Fault::LoadTorque => "load torque",
        Fault::SpeedSensor => "speed sensor",
        Fault::CurrentSensor => "current sensor",
    }
}

/// An event in words.
#[must_use]
pub fn event(kind: EventKind) -> String {
    let names = ChannelNames::motor();
    let wrong = |diagnosis| diagnosis_id(diagnosis).map_or_else(String::new, located);
    match kind {
        EventKind::Phase(Phase::Settling(Settling::Start)) => "settling after the start".to_owned(),
        EventKind::Phase(Phase::Settling(Settling::SetPointChanged)) => "settling: the set point changed".to_owned(),
        EventKind::Phase(Phase::Learning) => "learning".to_owned(),
        EventKind::Phase(Phase::ModelDue) => "learning window complete".to_owned(),
        EventKind::Phase(Phase::Monitoring) => "monitoring".to_owned(),
        EventKind::LearningRefused(error) => format!("learning refused: {}", names.explain_learning(error)),
        EventKind::RelayUp(model) => format!("relay up: {}", names.model(model)),
        EventKind::RelayDown(model) => format!("relay down: {}", names.model(model)),
        EventKind::Located(diagnosis) => format!("located: {}", wrong(diagnosis)),
        EventKind::Cleared(diagnosis) => format!("cleared: {}", wrong(diagnosis)),
        _ => format!("{kind:?}"),
    }
}

/// The identifier of a diagnosis, if it is one of something wrong.
#[must_use]
pub const fn diagnosis_id(diagnosis: Diagnosis) -> Option<&'static str> {
    match diagnosis {
        Diagnosis::Healthy => None,
        Diagnosis::Fault(fault) => Some(fault_id(fault)),
        Diagnosis::Unknown => Some("unknown"),
    }
}

/// A located fault in words: `F1 load torque`, or `unknown`.
#[must_use]
pub fn located(id: &str) -> String {
    let named = Fault::ALL.into_iter().find(|fault| fault_id(*fault) == id);
    named.map_or_else(|| id.to_owned(), |fault| format!("{id} {}", fault_name(fault)))
}

/// The key of a model in JSON, TOML and CSV.
#[must_use]
pub const fn model_key(model: ModelId) -> &'static str {
    match model {
        ModelId::Full => "full",
        ModelId::Pair(Pair::SpeedCurrent) => "speed_current",
        ModelId::Pair(Pair::CurrentVoltage) => "current_voltage",
        ModelId::Pair(Pair::SpeedVoltage) => "speed_voltage",
    }
}

/// A value of each model as a JSON-friendly record with named keys.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ByModel<T> {
    /// Of the PCA over all three channels.
    pub full: T,
    /// Of the pair r1: speed and current.
    pub speed_current: T,
    /// Of the pair r2: current and voltage.
    pub current_voltage: T,
    /// Of the pair r3: speed and voltage.
    pub speed_voltage: T,
}

impl<T> ByModel<T> {
    /// Makes the value of each model.
    pub fn from_fn(mut make: impl FnMut(ModelId) -> T) -> Self {
        ByModel {
            full: make(ModelId::Full),
            speed_current: make(ModelId::Pair(Pair::SpeedCurrent)),
            current_voltage: make(ModelId::Pair(Pair::CurrentVoltage)),
            speed_voltage: make(ModelId::Pair(Pair::SpeedVoltage)),
        }
    }

    /// The value of one model.
    #[must_use]
    pub const fn get(&self, model: ModelId) -> &T {
        match model {
            ModelId::Full => &self.full,
            ModelId::Pair(Pair::SpeedCurrent) => &self.speed_current,
            ModelId::Pair(Pair::CurrentVoltage) => &self.current_voltage,
            ModelId::Pair(Pair::SpeedVoltage) => &self.speed_voltage,
        }
    }
}

impl<T> ByModel<T> {
    /// The value of one model, to be changed.
    pub const fn get_mut(&mut self, model: ModelId) -> &mut T {
        match model {
            ModelId::Full => &mut self.full,
            ModelId::Pair(Pair::SpeedCurrent) => &mut self.speed_current,
            ModelId::Pair(Pair::CurrentVoltage) => &mut self.current_voltage,
            ModelId::Pair(Pair::SpeedVoltage) => &mut self.speed_voltage,
        }
    }
}

impl<T: Copy> ByModel<T> {
    /// As the core keeps it.
    #[must_use]
    pub fn bank(&self) -> Bank<T> {
        Bank::from_fn(|model| *self.get(model))
    }
}

/// Share of the variance that each component explains (1.3), by model: figures 5 and 8.
#[must_use]
pub fn explained(baseline: &Baseline) -> ByModel<Vec<f64>> {
    ByModel::from_fn(|model| match model {
        ModelId::Full => baseline.full().pca().explained().map(f64::from).to_vec(),
        ModelId::Pair(pair) => baseline.pairs().get(pair).pca().explained().map(f64::from).to_vec(),
    })
}

/// How many components each model retains.
#[must_use]
pub fn retained(baseline: &Baseline) -> ByModel<usize> {
    let retained = baseline.retained();
    ByModel::from_fn(|model| *retained.get(model))
}

/// The three names a user gives to the channels, in the order of their positions.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ChannelNames(pub [String; 3]);

impl ChannelNames {
    /// The names of the motor's channels.
    #[must_use]
    pub fn motor() -> Self {
        ChannelNames(["speed", "current", "voltage"].map(str::to_owned))
    }

    /// The name of one channel.
    #[must_use]
    pub fn of(&self, channel: Channel) -> &str {
        let [speed, current, voltage] = &self.0;
        match channel {
            Channel::Speed => speed,
            Channel::ArmatureCurrent => current,
            Channel::ArmatureVoltage => voltage,
        }
    }

    /// A model, by the channels it looks at.
    #[must_use]
    pub fn model(&self, model: ModelId) -> String {
        match model {
            ModelId::Full => "all channels".to_owned(),
            ModelId::Pair(pair) => pair.channels().map(|channel| self.of(channel)).join(", "),
        }
    }

    /// A located fault in words. The table (1.8) was made for a motor under a speed loop, so only there has a pattern
    /// the name of a cause.
    #[must_use]
    pub fn located(&self, id: &str) -> String {
        if *self == ChannelNames::motor() || id == "unknown" { located(id) } else { format!("{id} pattern") }
    }

    /// Why a learning window was refused, and what helps.
    #[must_use]
    pub fn explain_learning(&self, error: LearnError) -> String {
        match error {
            LearnError::TooShort { samples } => format!(
                "the learning window holds {samples} usable samples; at least {} are needed: choose a longer window",
                Moments::<3>::MIN_SAMPLES
            ),
            LearnError::ConstantChannel(channel) => format!(
                "channel '{}' is constant over the learning window, so nothing can be measured in units of its sigma: \
                 choose another window or another channel",
                self.of(channel)
            ),
            LearnError::NonFinite(channel) => {
                format!("channel '{}' holds values too large to learn from", self.of(channel))
            }
            LearnError::Clipped => {
                "more than a tenth of the learning window had to be clipped: something began in it, or \
                 spikes are no exception there: choose another window"
                    .to_owned()
            }
            LearnError::Drifting(channel) => format!(
                "the mean of '{}' moves from the first half of the learning window to the second: choose a window in which \
                 the motor has settled and runs undisturbed",
                self.of(channel)
            ),
            LearnError::Unexpected(channel) => format!(
                "the mean of '{}' is not what the neighbouring set points make expect: a fault may stand",
                self.of(channel)
            ),
            _ => format!("the learning window has no principal components ({error:?})"),
        }
    }

    /// Why a stored baseline was refused.
    #[must_use]
    pub fn explain_baseline(&self, error: BaselineError) -> String {
        match error {
            BaselineError::Mean(channel) => format!("the mean of '{}' is not a finite number", self.of(channel)),
            BaselineError::Sigma(channel) => format!("the sigma of '{}' is not above zero", self.of(channel)),
            BaselineError::Loadings => "the loadings are not orthonormal".to_owned(),
            BaselineError::Eigenvalues => "the eigenvalues do not descend or do not sum to three".to_owned(),
            BaselineError::Samples => format!("at least {} samples are needed", Moments::<3>::MIN_SAMPLES),
            _ => format!("it has no principal components ({error:?})"),
        }
    }
}

/// Why a monitor's configuration was refused, and what the setting must be.
#[must_use]
pub fn explain_config(error: ConfigError) -> String {
    match error {
        ConfigError::SampleRate => "the sampling rate must be above zero".to_owned(),
        ConfigError::SettleTime => "the settling time must not be negative and must fit into 2^32 samples".to_owned(),
        ConfigError::LearnTime => {
            format!("the learning window must hold at least {} samples", Moments::<3>::MIN_SAMPLES)
        }
        ConfigError::SetPointTolerance => "the set-point tolerance must be finite and not negative".to_owned(),
        ConfigError::ExplainedShare => "the share of variance to explain must lie above 0 and up to 1".to_owned(),
        ConfigError::Cutoff => "the cutoff must lie above zero and below half the sampling rate".to_owned(),
        ConfigError::Threshold(model) => format!("the threshold '{}' must be finite and above zero", model_key(model)),
        ConfigError::Hysteresis => "the hysteresis must lie in [0, 1)".to_owned(),
        _ => format!("{error:?}"),
    }
}

/// Why the monitor in `guard` mode refused its configuration, and what the setting must be.
#[must_use]
pub fn explain_guard_config(error: guard::ConfigError) -> String {
    use guard::ConfigError;
    match error {
        ConfigError::SampleRate => "the sampling rate must be above zero".to_owned(),
        ConfigError::FalseAlarmRate => {
            "so many false alarms per hour, or so few, cannot be set limits for: choose another --false-alarms-per-hour \
             (0.01 if none is given)"
                .to_owned()
        }
        ConfigError::SettleTime => "the settling time must not be negative and must fit into 2^31 samples".to_owned(),
        ConfigError::SeedTime => {
            format!("a seeding window must hold at least {} samples: learn for longer", Moments::<3>::MIN_SAMPLES)
        }
        ConfigError::LearnTime => format!(
            "the learning window must hold at least {} samples, and last 24 middle time constants, behind two seeding windows of \
             at least {} samples: learn for longer",
            4 * Moments::<3>::MIN_SAMPLES,
            Moments::<3>::MIN_SAMPLES
        ),
        ConfigError::SetPointTolerance => "the set-point tolerance must be finite and not negative".to_owned(),
        ConfigError::RaiseHold | ConfigError::ClearHold => {
            "the hold of an alarm must be finite and not negative and fit into 2^31 samples".to_owned()
        }
        ConfigError::ConverterStep(channel) => {
            format!("the converter step of the {} must be finite and not negative", ChannelNames::motor().of(channel))
        }
        _ => format!("{error:?}"),
    }
}
