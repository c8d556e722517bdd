//! What host and emulated board tell each other: words of 32 bits, little endian, of fixed size per record.
//!
//! Host to board: one [`Header`], then as many records as it announces: samples (4 words) or symmetric matrices
//! (6 words). Board to host: for each sample the verdict (7 words), for each matrix the decomposition (13 words).
//! Floating-point numbers travel as their bits, so equality means equality of every bit.

use monitor_core::eigen::ClosedFormEigen;
use monitor_core::localize::{Diagnosis, Fault};
use monitor_core::sample::{Bank, ModelId, PerPair};
use monitor_core::units::{Amperes, RadPerSec, Volts};
use monitor_core::verdict::{Absence, Rejected};
use monitor_core::{Config, Phase, Sample, Verdict};
use nalgebra::Matrix3;

/// Words of a header, of a sample with its set point, of a verdict, of a matrix and of a decomposition.
pub const HEADER_WORDS: usize = 14;
/// See [`HEADER_WORDS`].
pub const SAMPLE_WORDS: usize = 4;
/// See [`HEADER_WORDS`].
pub const VERDICT_WORDS: usize = 7;
/// See [`HEADER_WORDS`].
pub const MATRIX_WORDS: usize = 6;
/// See [`HEADER_WORDS`].
pub const EIGEN_WORDS: usize = 13;

/// "TFM" and the version of this format.
const MAGIC: u32 = u32::from_le_bytes(*b"TFM1");

/// What the records behind a header are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Samples of a mission.
    Mission,
    /// Matrices to decompose.
    Matrices,
}

/// The first record of a stream.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Header {
    /// What follows.
    pub kind: Kind,
    /// How many records follow.
    pub records: u32,
    /// Settings of the monitor (of no meaning to matrices).
    pub config: Config,
}

impl Header {
    /// The header as words.
    #[must_use]
    pub fn to_words(&self) -> [u32; HEADER_WORDS] {
        let c = &self.config;
        let [full, r1, r2, r3] = ModelId::ALL.map(|model| c.thresholds.get(model).to_bits());
        let kind = match self.kind {
            Kind::Mission => 1,
            Kind::Matrices => 2,
        };
        let [rate, settle, learn, tolerance, share, cutoff, hysteresis] = [
            c.sample_rate_hz,
            c.settle_s,
            c.learn_s,
            c.set_point_tolerance,
            c.explained_share,
            c.cutoff_hz,
            c.hysteresis,
        ]
        .map(f32::to_bits);
        [MAGIC, kind, self.records, rate, settle, learn, tolerance, share, cutoff, hysteresis, full, r1, r2, r3]
    }

    /// Reads a header; none when the words are not one.
    #[must_use]
    pub fn from_words(words: [u32; HEADER_WORDS]) -> Option<Self> {
        let [magic, kind, records, settings @ ..] = words;
        let [
            sample_rate_hz,
            settle_s,
            learn_s,
            set_point_tolerance,
            explained_share,
            cutoff_hz,
            hysteresis,
            full,
            r1,
            r2,
            r3,
        ] = settings.map(f32::from_bits);
        let kind = match (magic, kind) {
            (MAGIC, 1) => Kind::Mission,
            (MAGIC, 2) => Kind::Matrices,
            _ => return None,
        };
        let pairs = PerPair { speed_current: r1, current_voltage: r2, speed_voltage: r3 };
        let thresholds = Bank { full, pairs };
        let config = Config {
            sample_rate_hz,
            settle_s,
            learn_s,
            set_point_tolerance,
            explained_share,
            cutoff_hz,
            thresholds,
            hysteresis,
        };
        Some(Header { kind, records, config })
    }
}

/// A sample and its set point as words.
#[must_use]
pub fn sample_to_words(set_point: RadPerSec, sample: Sample) -> [u32; SAMPLE_WORDS] {
    [set_point.0, sample.speed.0, sample.armature_current.0, sample.armature_voltage.0].map(f32::to_bits)
}

/// Reads a sample and its set point.
#[must_use]
pub fn sample_from_words(words: [u32; SAMPLE_WORDS]) -> (RadPerSec, Sample) {
    let [set_point, speed, current, voltage] = words.map(f32::from_bits);
    let sample =
        Sample { speed: RadPerSec(speed), armature_current: Amperes(current), armature_voltage: Volts(voltage) };
    (RadPerSec(set_point), sample)
}

/// A verdict as words: what stands, since when, and the bits of the residuals (all ones where nothing was judged).
#[must_use]
pub fn verdict_to_words(verdict: &Verdict) -> [u32; VERDICT_WORDS] {
    let phase = match verdict.phase() {
        Phase::Settling(_) => 0,
        Phase::Learning => 1,
        Phase::ModelDue => 2,
        Phase::Monitoring => 3,
    };
    let diagnosis = match verdict.diagnosis() {
        Diagnosis::Healthy => 0,
        Diagnosis::Fault(Fault::LoadTorque) => 1,
        Diagnosis::Fault(Fault::SpeedSensor) => 2,
        Diagnosis::Fault(Fault::CurrentSensor) => 3,
        Diagnosis::Unknown => 4,
    };
    let rejected = match verdict.rejected() {
        None => 0,
        Some(Rejected::NonFinite(channel)) => 1 + channel.position() as u32,
        Some(Rejected::NonFiniteSetPoint) => 4,
        Some(Rejected::OutOfRange(channel)) => 5 + channel.position() as u32,
        Some(Rejected::Absent(Absence::Late)) => 8,
        Some(Rejected::Absent(Absence::Missing)) => 9,
        Some(_) => 15,
    };
    let relays = ModelId::ALL.iter().fold(0, |bits, model| bits << 1 | u32::from(*verdict.relays().get(*model)));
    let [full, r1, r2, r3] =
        ModelId::ALL.map(|model| verdict.residuals().map_or(u32::MAX, |residuals| residuals.get(model).to_bits()));
    // A mission of 2^32 samples does not fit into a test; the low halves tell them apart.
    let low = |sample: Option<u64>| sample.map_or(u32::MAX, |sample| sample as u32);
    let flags = phase | diagnosis << 4 | rejected << 8 | relays << 12;
    [verdict.sample() as u32, flags, full, r1, r2, r3, low(verdict.alarm_since())]
}

/// Decomposes a symmetric matrix given as the words of its lower triangle by rows; the words of its eigenvalues and
/// eigenvectors, and whether there are any.
#[must_use]
pub fn eigen_to_words(matrix: [u32; MATRIX_WORDS]) -> [u32; EIGEN_WORDS] {
    let [a00, a10, a11, a20, a21, a22] = matrix.map(f32::from_bits);
    let mut words = [0; EIGEN_WORDS];
    if let Ok(eigen) = Matrix3::new(a00, a10, a20, a10, a11, a21, a20, a21, a22).closed_form_eigen() {
        let numbers = eigen.values.iter().chain(eigen.vectors.iter()).map(|x| x.to_bits());
        for (word, bits) in words.iter_mut().zip(core::iter::once(1).chain(numbers)) {
            *word = bits;
        }
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_header_is_read_as_it_was_written_and_anything_else_is_refused() {
        let config = Config::paper(
            1000.0,
            Bank { full: 1.5, pairs: PerPair { speed_current: 2.0, current_voltage: 3.0, speed_voltage: 4.0 } },
        );
        for kind in [Kind::Mission, Kind::Matrices] {
            let header = Header { kind, records: 7, config };
            assert_eq!(Header::from_words(header.to_words()), Some(header));
        }
        assert_eq!(Header::from_words([0; HEADER_WORDS]), None);
    }

    #[test]
    fn a_sample_is_read_as_it_was_written() {
        let sample = Sample { speed: RadPerSec(1.0), armature_current: Amperes(-2.0), armature_voltage: Volts(3.5) };
        assert_eq!(sample_from_words(sample_to_words(RadPerSec(300.0), sample)), (RadPerSec(300.0), sample));
    }
}
