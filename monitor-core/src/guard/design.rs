//! Settings of `guard` mode, and what is worked out of them once.

use super::level::PERIOD;
use super::{SCALES, TREND};
use crate::ewma::{Ewma, EwmaError};
use crate::limit::{LimitError, smoothed_t2_limit};
use crate::moments::{Moments, Statistics};
use crate::root::square_root;
use crate::sample::Channel;
use crate::set_point::{GateError, SetPointGate};

/// Share of the false alarms that each time scale may make. The quicker ones get most: a limit that is lower by a given factor
/// saves them the larger part of their delay, as a sweep over Lorden's ratio shows (`GUARD.md`).
const SHARES: [f32; SCALES] = [0.35, 0.35, 0.2, 0.1];

/// Where limits lie, in standard deviations of a direction.
const FAR_SIGMAS: f32 = 7.0;

/// Settings of a monitor in `guard` mode. All of them are fixed before the first sample; [`Config::at_rate`] is what most
/// boards need.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Config {
    /// Samples per second, Hz.
    pub sample_rate_hz: f32,
    /// False alarms that are tolerable per hour, all tests together. The limits follow from it.
    pub false_alarms_per_hour: f32,
    /// How long after a change of the set point nothing is learned, s.
    pub settle_s: f32,
    /// Length of each of two seeding windows, s: from the first comes the clip of the second, from that the clip of the
    /// learning window.
    pub seed_s: f32,
    /// Length of the learning window, s; limits take into account how short it is. It holds at least 120 samples and 24 middle
    /// time constants.
    pub learn_s: f32,
    /// Largest movement of the set point that is not a change, in the set point's unit.
    pub set_point_tolerance: f32,
    /// Time constants of the four time scales, ascending, s: abrupt faults, the loop, drifts, and trends. The last one takes a
    /// sample in 64.
    pub time_constants_s: [f32; SCALES],
    /// Step of the converter of each channel, in its unit; zero where it is not known. No channel is taken to be more exact.
    pub converter_steps: [f32; 3],
    /// How long the mean remembers, s: benign drift that is slower (temperature) is followed.
    pub memory_s: f32,
    /// How far the mean may follow in all, in sigmas of each channel: a fault that grows as slowly is found when it is beyond.
    /// With 0 the mean is the learned one.
    pub drift_sigmas: f32,
    /// How long a distance must be beyond its limit before an alarm is raised, s. Every alarm is as late: what it buys is silence
    /// about disturbances that are over sooner, and that the slower scales have no memory of.
    pub raise_hold_s: f32,
    /// How long the motor must look healthy before an alarm is withdrawn, s.
    pub clear_hold_s: f32,
    /// Whether an alarm stands until [`acknowledge`](crate::guard::Monitor::acknowledge).
    pub latch: bool,
}

impl Config {
    /// Settings for a sampling rate: one false alarm in a hundred hours; 2 s to settle, twice 1 s to seed, 15 s to learn;
    /// time scales of 7.5 ms, 75 ms, 2 s and 15 s.
    #[must_use]
    pub const fn at_rate(sample_rate_hz: f32) -> Self {
        Config {
            sample_rate_hz,
            false_alarms_per_hour: 0.01,
            settle_s: 2.0,
            seed_s: 1.0,
            learn_s: 15.0,
            set_point_tolerance: 0.0,
            time_constants_s: [0.0075, 0.075, 2.0, 15.0],
            converter_steps: [0.0; 3],
            memory_s: 600.0,
            drift_sigmas: 0.5,
            raise_hold_s: 0.0,
            clear_hold_s: 0.02,
            latch: false,
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
    /// The rate of false alarms must be above zero, and neither below one in some 10^7 samples times the tests nor so high
    /// that alarms are no rarity: see [`smoothed_t2_limit`].
    FalseAlarmRate,
    /// The settling time must be finite and not negative, and fit into 2^31 samples.
    SettleTime,
    /// A seeding window must hold at least [`Moments::MIN_SAMPLES`] samples and fewer than 2^31.
    SeedTime,
    /// The learning window must last at least 24 times the middle time constant, hold at least four times
    /// [`Moments::MIN_SAMPLES`], and fewer than 2^31 samples.
    LearnTime,
    /// The set-point tolerance must be finite and not negative.
    SetPointTolerance,
    /// Time constants must be finite, ascend, and not be negative.
    TimeConstants,
    /// The converter step of this channel must be finite and not negative.
    ConverterStep(Channel),
    /// The memory must be finite, and at least the learning window.
    Memory,
    /// The reach of the drift must be finite and not negative.
    Drift,
    /// The hold of the raising must be finite and not negative, and fit into 2^31 samples.
    RaiseHold,
    /// The hold of the clearing must be finite and not negative, and fit into 2^31 samples.
    ClearHold,
}

impl From<EwmaError> for ConfigError {
    fn from(error: EwmaError) -> Self {
        match error {
            EwmaError::TimeConstant => ConfigError::TimeConstants,
            EwmaError::SampleRate => ConfigError::SampleRate,
        }
    }
}

impl From<GateError> for ConfigError {
    fn from(_: GateError) -> Self {
        ConfigError::SetPointTolerance
    }
}

/// The frozen part of a monitor, apart from what it learns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Design {
    pub(super) gate: SetPointGate,
    /// The first three take every sample, the last one in `PERIOD`.
    pub(super) scales: [Ewma; SCALES],
    /// Variance of a converter's rounding, of each channel.
    pub(super) floors: [f32; 3],
    /// What the largest distance of the middle and the slow scale in as many samples as are learned from reaches once in twenty
    /// times, in limits.
    pub(super) expected_peaks: [f32; 2],
    /// Samples between two false alarms.
    pub(super) interval_samples: f32,
    pub(super) sample_rate_hz: f32,
    pub(super) seed_slots: u32,
    pub(super) learn_slots: u32,
    pub(super) memory_slots: f32,
    pub(super) drift_sigmas: f32,
    /// Whether the mean may follow at all.
    pub(super) follows: bool,
    pub(super) latch: bool,
}

impl Design {
    /// Works out the settings.
    ///
    /// # Errors
    /// [`ConfigError`] names the setting that is out of range.
    pub fn new(config: &Config) -> Result<Self, ConfigError> {
        let rate = config.sample_rate_hz;
        if !(rate > 0.0 && rate.is_finite()) {
            return Err(ConfigError::SampleRate);
        }
        let slots = |seconds: f32| whole_slots(seconds * rate);
        let gate =
            SetPointGate::new(config.set_point_tolerance, slots(config.settle_s).ok_or(ConfigError::SettleTime)?)?;
        let [fast, middle, slow, trend] = config.time_constants_s;
        if !(fast <= middle && middle <= slow && slow <= trend) {
            return Err(ConfigError::TimeConstants);
        }
        let scale = |time_constant_s| Ewma::with_time_constant(time_constant_s, rate);
        let mut floors = config.converter_steps;
        for (position, floor) in floors.iter_mut().enumerate() {
            if !(*floor >= 0.0 && floor.is_finite()) {
                return Err(ConfigError::ConverterStep(Channel::at(position)));
            }
            *floor = *floor * *floor / 12.0; // of a rounding error, which is uniform
        }
        let seed_slots =
            slots(config.seed_s).filter(|n| *n >= Moments::<3>::MIN_SAMPLES).ok_or(ConfigError::SeedTime)?;
        let learn_slots = slots(config.learn_s)
            .filter(|n| *n >= 4 * Moments::<3>::MIN_SAMPLES && config.learn_s >= 24.0 * middle)
            .ok_or(ConfigError::LearnTime)?;
        if !(config.memory_s >= config.learn_s && config.memory_s.is_finite()) {
            return Err(ConfigError::Memory);
        }
        if !(config.drift_sigmas >= 0.0 && config.drift_sigmas.is_finite()) {
            return Err(ConfigError::Drift);
        }
        let mut design = Design {
            gate,
            scales: [
                scale(fast)?,
                scale(middle)?,
                scale(slow)?,
                Ewma::with_time_constant(trend, rate / PERIOD as f32)?,
            ],
            floors,
            expected_peaks: [1.0; 2],
            interval_samples: 3600.0 * rate / config.false_alarms_per_hour,
            sample_rate_hz: rate,
            seed_slots,
            learn_slots,
            memory_slots: (config.memory_s * rate).max(learn_slots as f32),
            drift_sigmas: config.drift_sigmas,
            follows: config.drift_sigmas > 0.0,
            latch: config.latch,
        };
        let (proof, mut expected_peaks) = (20.0 * learn_slots as f32, design.expected_peaks);
        let refused = |_| ConfigError::FalseAlarmRate;
        for (place, expected) in [1, 2].into_iter().zip(&mut expected_peaks) {
            let scale = design.scales.get(place).ok_or(ConfigError::TimeConstants)?;
            let reached = smoothed_t2_limit(scale, 3, 1e6, proof).map_err(refused)?;
            *expected = reached / design.limit(place, 1e6).map_err(refused)?;
        }
        design.expected_peaks = expected_peaks;
        design.limit(0, 1e6).map_err(refused)?;
        design.limit(TREND, 1e6).map_err(|_| ConfigError::FalseAlarmRate)?;
        Ok(design)
    }

    /// Statistics of smoothed channels in which no channel is more exact than its converter, whose rounding is averaged by so
    /// much, nor its tail lighter than that of a reading that seldom changes by a step can be, of which a sample counts for so
    /// much.
    ///
    /// Of deviations within a range q, a weighted sum stays within z deviations as seldom as a normal one of variance
    /// v + z w q sqrt(v)/3 does, w the largest weight (Bernstein 1946), and as one of q^2/4 of each sample (Hoeffding 1963).
    pub(super) fn floored(&self, statistics: &Statistics<3>, variance_ratio: f32, weight: f32) -> Statistics<3> {
        let mut floored = *statistics;
        for (i, floor) in self.floors.into_iter().enumerate() {
            if let Some(variance) = floored.covariance.get_mut((i, i)) {
                let rounding = floor * variance_ratio;
                let plain = variance.max(rounding);
                let step = square_root(12.0 * floor);
                let tail = plain + FAR_SIGMAS / 3.0 * weight * step * square_root(plain);
                *variance = plain.max(tail.min(3.0 * rounding));
            }
        }
        floored
    }

    /// The limit of the time scale at this place, whose covariance was learned with so many degrees of freedom.
    pub(super) fn limit(&self, place: usize, degrees_of_freedom: f32) -> Result<f32, LimitError> {
        let (scale, share) = self.scales.get(place).zip(SHARES.get(place)).ok_or(LimitError::Retained)?;
        let stride = if place == TREND { PERIOD as f32 } else { 1.0 };
        smoothed_t2_limit(scale, 3, degrees_of_freedom, self.interval_samples / (share * stride))
    }

    /// Variance of each time scale over that of its samples, if those are independent.
    pub(super) fn variance_ratios(&self) -> [f32; SCALES] {
        let [fast, middle, slow, trend] = &self.scales;
        // The trend smooths what the middle scale has smoothed, which after a period still is this like itself.
        let alike = (0..PERIOD.ilog2()).fold(1.0 - middle.weight(), |power, _| power * power);
        let kept = (1.0 - trend.weight()) * alike;
        let of_trend = trend.variance_ratio() * (1.0 + kept) / (1.0 - kept);
        let [fast, middle, slow] = [fast, middle, slow].map(|scale| scale.variance_ratio());
        [fast, middle, slow, middle * of_trend]
    }
}

/// Slots that a count with a fraction is, if that is neither negative nor beyond what is counted.
pub(super) fn whole_slots(slots: f32) -> Option<u32> {
    // 2^31 as f32; written so that NaN is refused.
    (0.0..2_147_483_648.0).contains(&slots).then_some(slots as u32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coarse_channel_has_the_tail_of_one_that_seldom_changes_by_a_step_and_a_dithered_one_its_own() {
        let config = Config { converter_steps: [1.0, 1.0, 0.0], ..Config::at_rate(1000.0) };
        let design = Design::new(&config).unwrap();
        // Variances that limits are made for, in squared steps, of readings with this one.
        let floored = |variance: f32, weight: f32| {
            let ratio = weight / (2.0 - weight);
            let (mean, covariance) = (nalgebra::Vector3::zeros(), nalgebra::Matrix3::identity() * variance * ratio);
            let floored = design.floored(&Statistics { samples: 1000, mean, covariance }, ratio, weight);
            floored.covariance.diagonal().map(|v| v / ratio)
        };
        // Rounding is 1/12, and 1/4 bounds any tail. Of the third channel no step is known.
        for (variance, expected) in [(0.0, 0.25), (0.0736, 0.25), (0.2, 0.25), (0.25, 0.25), (1.0, 1.0), (9.0, 9.0)] {
            let found = floored(variance, 0.125);
            assert!((found.x - expected).abs() < 1e-4 && (found.z - variance).abs() < 1e-4, "{variance}: {found}");
        }
        // Where a sample counts for little, sums are nearly normal.
        let slow = floored(0.0736, 0.0005);
        assert!((0.083..0.12).contains(&slow.x), "{slow}");
    }
}
