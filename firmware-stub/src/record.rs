//! What host and emulated board tell each other: words of 32 bits, little endian, of fixed size per record.
//!
//! Host to board: one [`Header`], then as many records as it announces: slots of the sampling clock (5 words) or symmetric
//! matrices (6 words), in chunks of [`CHUNK`] records (the last may be shorter). A check word ([`check_word`]) follows the
//! header and every chunk. Board to host: for each slot the verdict (7 words in `paper` mode, 15 in `guard` mode), for each
//! matrix the decomposition (13 words). Floating-point numbers travel as their bits, so equality means equality of every bit.

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use monitor_core::Sample;
use monitor_core::eigen::ClosedFormEigen;
use monitor_core::paper::localize::{Diagnosis, Fault};
use monitor_core::paper::verdict::Rejected;
use monitor_core::paper::{Config, Phase, Verdict};
use monitor_core::sample::Absence;
use monitor_core::sample::{Bank, ModelId, PerPair};
use monitor_core::units::{Amperes, RadPerSec, Volts};
use nalgebra::Matrix3;

use crate::request::Request;
use crate::sampling::Reading;

mod guarded;

pub use guarded::{GUARDED_WORDS, guarded_to_words};

/// Words of a header, of a slot, of a verdict, of a matrix and of a decomposition.
pub const HEADER_WORDS: usize = 14;
/// See [`HEADER_WORDS`].
pub const SLOT_WORDS: usize = 5;
/// See [`HEADER_WORDS`].
pub const VERDICT_WORDS: usize = 7;
/// See [`HEADER_WORDS`].
pub const MATRIX_WORDS: usize = 6;
/// See [`HEADER_WORDS`].
pub const EIGEN_WORDS: usize = 13;

/// Records between two check words: a semihosting call costs far more than a step.
pub const CHUNK: usize = 64;

/// "TFM" and the version of this format.
const MAGIC: u32 = u32::from_le_bytes(*b"TFM2");

/// The check that Ethernet and zlib use; without a table, because a board has little flash and this is not for its
/// interrupt.
const CHECK: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);

/// The check word of a header or of a chunk of records: CRC-32 of its bytes as they travel.
#[must_use]
pub fn check_word(words: &[u32]) -> u32 {
    let mut digest = CHECK.digest();
    words.iter().for_each(|word| digest.update(&word.to_le_bytes()));
    digest.finalize()
}

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

/// What reaches the board in one slot of the sampling clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrival {
    /// The set point that stands.
    pub set_point: RadPerSec,
    /// The sample, or why there is none.
    pub reading: Reading,
    /// What is asked of the main loop after this slot.
    pub request: Option<Request>,
}

impl Arrival {
    /// A sample in time, and nothing asked.
    #[must_use]
    pub const fn sample(set_point: RadPerSec, sample: Sample) -> Self {
        Arrival { set_point, reading: Reading::Taken(sample), request: None }
    }

    /// The slot as words: flags, set point, and the three channels.
    #[must_use]
    pub fn to_words(self) -> [u32; SLOT_WORDS] {
        let (arrival, sample) = match self.reading {
            Reading::Taken(sample) => (0, sample),
            Reading::Absent(Absence::Late) => (1, Sample::default()),
            Reading::Absent(Absence::Missing) => (2, Sample::default()),
        };
        let request = match self.request {
            Some(Request::ByChannel) => 1,
            Some(Request::Statistics) => 2,
            Some(Request::Verdict) => 3,
            Some(Request::Acknowledge) => 4,
            // A mission's set points are part of its slots.
            None | Some(Request::SetPoint(_)) => 0,
        };
        let [speed, current, voltage] = <[f32; 3]>::from(sample).map(f32::to_bits);
        [arrival | request << 8, self.set_point.0.to_bits(), speed, current, voltage]
    }

    /// Reads a slot; none when the words are not one.
    #[must_use]
    pub fn from_words([flags, numbers @ ..]: [u32; SLOT_WORDS]) -> Option<Self> {
        let [set_point, speed, current, voltage] = numbers.map(f32::from_bits);
        let sample =
            Sample { speed: RadPerSec(speed), armature_current: Amperes(current), armature_voltage: Volts(voltage) };
        let reading = match flags & 0xff {
            0 => Reading::Taken(sample),
            1 => Reading::Absent(Absence::Late),
            2 => Reading::Absent(Absence::Missing),
            _ => return None,
        };
        let request = match flags >> 8 {
            0 => None,
            1 => Some(Request::ByChannel),
            2 => Some(Request::Statistics),
            3 => Some(Request::Verdict),
            4 => Some(Request::Acknowledge),
            _ => return None,
        };
        Some(Arrival { set_point: RadPerSec(set_point), reading, request })
    }
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
    fn a_slot_is_read_as_it_was_written_and_flags_of_no_meaning_are_refused() {
        let sample = Sample { speed: RadPerSec(1.0), armature_current: Amperes(-2.0), armature_voltage: Volts(3.5) };
        let slot = Arrival::sample(RadPerSec(300.0), sample);
        let late = Arrival { reading: Reading::Absent(Absence::Late), request: Some(Request::Verdict), ..slot };
        let missing =
            Arrival { reading: Reading::Absent(Absence::Missing), request: Some(Request::Statistics), ..slot };
        let asking =
            [Request::ByChannel, Request::Acknowledge].map(|request| Arrival { request: Some(request), ..slot });
        for slot in [slot, late, missing].into_iter().chain(asking) {
            assert_eq!(Arrival::from_words(slot.to_words()), Some(slot));
        }
        assert_eq!(Arrival::from_words([3, 0, 0, 0, 0]), None);
        assert_eq!(Arrival::from_words([5 << 8, 0, 0, 0, 0]), None);
    }

    #[test]
    fn the_check_word_is_the_crc_of_the_bytes_and_moves_with_every_bit() {
        // The catalogue's check of "123456789", here without its last byte: zlib.crc32(b"12345678").
        let words = [u32::from_le_bytes(*b"1234"), u32::from_le_bytes(*b"5678")];
        assert_eq!(check_word(&words), 0x9ae0_daaf);
        for bit in 0..64 {
            let mut other = words;
            other[bit / 32] ^= 1 << (bit % 32);
            assert_ne!(check_word(&other), check_word(&words), "bit {bit}");
        }
    }
}
