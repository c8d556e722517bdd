//! What is measured, or why it is not, and by which names: three channels, three pairs of them, four models.
//!
//! Inside the kernels a sample is `[f32; 3]`; the names are a thin layer over those positions, so another triple (a
//! pump's current, voltage and flow, say) takes the same positions under names of its own.

use crate::units::{Amperes, RadPerSec, Volts};

/// One sample of the thruster motor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sample {
    /// Measured shaft speed.
    pub speed: RadPerSec,
    /// Measured armature current.
    pub armature_current: Amperes,
    /// Armature voltage: the output of the current controller, which the paper takes as the third measured variable.
    pub armature_voltage: Volts,
}

impl From<Sample> for [f32; 3] {
    fn from(sample: Sample) -> [f32; 3] {
        [sample.speed.0, sample.armature_current.0, sample.armature_voltage.0]
    }
}

/// Why a slot of the sampling clock has no sample that can be judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Absence {
    /// The sample was taken after its slot: filters of a fixed rate have no place for it.
    Late,
    /// There is none.
    Missing,
}

/// A measured channel, by its position in the sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Channel {
    /// Position 0: shaft speed.
    Speed,
    /// Position 1: armature current.
    ArmatureCurrent,
    /// Position 2: armature voltage.
    ArmatureVoltage,
}

impl Channel {
    /// The channels in the order of their positions.
    pub const ALL: [Channel; 3] = [Channel::Speed, Channel::ArmatureCurrent, Channel::ArmatureVoltage];

    /// The channel at a position: 0, 1, and 2 or above.
    #[must_use]
    pub const fn at(position: usize) -> Channel {
        match position {
            0 => Channel::Speed,
            1 => Channel::ArmatureCurrent,
            _ => Channel::ArmatureVoltage,
        }
    }

    /// The position of this channel in a sample.
    #[must_use]
    pub const fn position(self) -> usize {
        match self {
            Channel::Speed => 0,
            Channel::ArmatureCurrent => 1,
            Channel::ArmatureVoltage => 2,
        }
    }
}

/// A pair of channels: the data set of one partial PCA model (the paper, III.C).
///
/// The paper numbers its residuals r1, r2, r3 and writes (1.8) with those numbers; the text lists the pairs in another
/// order than (1.8) needs. Fault 3, a drift of the current sensor inside the loop, moves only the measured current, so
/// the residual that stays down in `f3 = r1 r2 (not r3)` is the pair without the current. Hence the order here.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Pair {
    /// r1 of (1.8): speed and armature current.
    SpeedCurrent,
    /// r2 of (1.8): armature current and armature voltage.
    CurrentVoltage,
    /// r3 of (1.8): speed and armature voltage.
    SpeedVoltage,
}

impl Pair {
    /// The pairs in the order r1, r2, r3 of (1.8).
    pub const ALL: [Pair; 3] = [Pair::SpeedCurrent, Pair::CurrentVoltage, Pair::SpeedVoltage];

    /// The two channels of the pair.
    #[must_use]
    pub const fn channels(self) -> [Channel; 2] {
        match self {
            Pair::SpeedCurrent => [Channel::Speed, Channel::ArmatureCurrent],
            Pair::CurrentVoltage => [Channel::ArmatureCurrent, Channel::ArmatureVoltage],
            Pair::SpeedVoltage => [Channel::Speed, Channel::ArmatureVoltage],
        }
    }

    /// The two entries of `x` that belong to this pair.
    #[must_use]
    pub const fn of(self, x: [f32; 3]) -> [f32; 2] {
        let [speed, current, voltage] = x;
        match self {
            Pair::SpeedCurrent => [speed, current],
            Pair::CurrentVoltage => [current, voltage],
            Pair::SpeedVoltage => [speed, voltage],
        }
    }
}

/// One value for each pair.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PerPair<T> {
    /// r1 of (1.8).
    pub speed_current: T,
    /// r2 of (1.8).
    pub current_voltage: T,
    /// r3 of (1.8).
    pub speed_voltage: T,
}

impl<T> PerPair<T> {
    /// Makes the value of each pair.
    pub fn from_fn(mut make: impl FnMut(Pair) -> T) -> Self {
        PerPair {
            speed_current: make(Pair::SpeedCurrent),
            current_voltage: make(Pair::CurrentVoltage),
            speed_voltage: make(Pair::SpeedVoltage),
        }
    }

    /// The value of one pair.
    #[must_use]
    pub const fn get(&self, pair: Pair) -> &T {
        match pair {
            Pair::SpeedCurrent => &self.speed_current,
            Pair::CurrentVoltage => &self.current_voltage,
            Pair::SpeedVoltage => &self.speed_voltage,
        }
    }
}

/// A model of the bank, and the residual it makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ModelId {
    /// PCA over all three channels.
    Full,
    /// Partial PCA over a pair.
    Pair(Pair),
}

impl ModelId {
    /// The full model, then the pairs in the order of (1.8).
    pub const ALL: [ModelId; 4] = [
        ModelId::Full,
        ModelId::Pair(Pair::SpeedCurrent),
        ModelId::Pair(Pair::CurrentVoltage),
        ModelId::Pair(Pair::SpeedVoltage),
    ];
}

/// One value for each model of the bank: the full PCA and the three partial ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Bank<T> {
    /// Of the PCA over all three channels.
    pub full: T,
    /// Of the three partial PCA.
    pub pairs: PerPair<T>,
}

impl<T> Bank<T> {
    /// Makes the value of each model.
    pub fn from_fn(mut make: impl FnMut(ModelId) -> T) -> Self {
        Bank { full: make(ModelId::Full), pairs: PerPair::from_fn(|pair| make(ModelId::Pair(pair))) }
    }

    /// The value of one model.
    #[must_use]
    pub const fn get(&self, model: ModelId) -> &T {
        match model {
            ModelId::Full => &self.full,
            ModelId::Pair(pair) => self.pairs.get(pair),
        }
    }

    /// Applies `f` to the value of each model.
    #[inline(always)]
    pub(crate) fn map<U>(self, mut f: impl FnMut(T) -> U) -> Bank<U> {
        let PerPair { speed_current, current_voltage, speed_voltage } = self.pairs;
        Bank {
            full: f(self.full),
            pairs: PerPair {
                speed_current: f(speed_current),
                current_voltage: f(current_voltage),
                speed_voltage: f(speed_voltage),
            },
        }
    }

    /// Lets `f` change the value of each model by that of another bank.
    #[inline(always)]
    pub(crate) fn update<U>(&mut self, other: Bank<U>, mut f: impl FnMut(&mut T, U)) {
        f(&mut self.full, other.full);
        f(&mut self.pairs.speed_current, other.pairs.speed_current);
        f(&mut self.pairs.current_voltage, other.pairs.current_voltage);
        f(&mut self.pairs.speed_voltage, other.pairs.speed_voltage);
    }

    /// Applies `f` to the values that two banks have for each model.
    #[inline(always)]
    pub(crate) fn zip_with<U, V>(self, other: Bank<U>, mut f: impl FnMut(T, U) -> V) -> Bank<V> {
        let PerPair { speed_current, current_voltage, speed_voltage } = self.pairs;
        Bank {
            full: f(self.full, other.full),
            pairs: PerPair {
                speed_current: f(speed_current, other.pairs.speed_current),
                current_voltage: f(current_voltage, other.pairs.current_voltage),
                speed_voltage: f(speed_voltage, other.pairs.speed_voltage),
            },
        }
    }
}

/// Operations on the four values side by side. The processor can start one operation a cycle but needs another cycle
/// before the result of a floating-point operation can be used, so four chains in step are faster than one by one.
impl core::ops::Add for Bank<f32> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip_with(other, |a, b| a + b)
    }
}

impl core::ops::Sub for Bank<f32> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip_with(other, |a, b| a - b)
    }
}

impl core::ops::Mul<f32> for Bank<f32> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, factor: f32) -> Self {
        self.map(|a| a * factor)
    }
}

impl Bank<bool> {
    /// Whether any of the four is true.
    #[must_use]
    pub const fn any(&self) -> bool {
        self.full || self.pairs.speed_current || self.pairs.current_voltage || self.pairs.speed_voltage
    }
}
