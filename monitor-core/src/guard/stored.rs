//! What is known of a set point, in a form that outlives a loss of power: in flash, or in a file.
//!
//! A model is worth nothing under other settings than it was learned with, so those that it depends on are kept beside it and
//! compared when it is restored.

use super::SCALES;
use super::design::Design;
use super::known::Known;

/// Says what the bytes are, and in which version.
const FORMAT: u32 = 0x4755_0003;

/// Numbers of the settings that are kept, of a model, and bytes of all with format, set point, and checksum.
const SETTINGS: usize = 2 + SCALES;
const NUMBERS: usize = 18 + 14 * SCALES;
const WORDS: usize = 1 + SETTINGS + 1 + NUMBERS + 1;

/// What is known of one set point, as bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stored([u8; Stored::BYTES]);

/// Why something stored was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum RestoreError {
    /// There are not [`Stored::BYTES`] bytes.
    Length,
    /// These bytes are no model, or one of another version.
    Format,
    /// The checksum does not agree: bytes were lost or changed.
    Damaged,
    /// It was learned at this sampling rate, Hz, which is not the one configured.
    SampleRate(f32),
    /// It was learned with other time constants.
    TimeConstants,
    /// Its limits are for another rate of false alarms.
    FalseAlarmRate,
    /// Its numbers are no model's.
    Values,
}

impl Stored {
    /// Bytes of a stored model.
    pub const BYTES: usize = 4 * WORDS;

    /// The bytes, the same on every machine.
    #[must_use]
    pub const fn bytes(&self) -> &[u8; Self::BYTES] {
        &self.0
    }

    /// Takes bytes for a stored model.
    ///
    /// # Errors
    /// [`RestoreError::Length`], [`RestoreError::Format`], [`RestoreError::Damaged`].
    pub fn of_bytes(bytes: &[u8]) -> Result<Self, RestoreError> {
        let stored = Stored(bytes.try_into().map_err(|_| RestoreError::Length)?);
        let mut words = stored.words();
        if words.next() != Some(FORMAT) {
            return Err(RestoreError::Format);
        }
        let (body, checksum) = stored.0.split_at(Self::BYTES - 4);
        if crc_32(body).to_le_bytes() != *checksum {
            return Err(RestoreError::Damaged);
        }
        Ok(stored)
    }

    /// The set point that it is of.
    #[must_use]
    pub fn set_point(&self) -> f32 {
        self.words().nth(1 + SETTINGS).map_or(f32::NAN, f32::from_bits)
    }

    pub(super) fn of(design: &Design, set_point: f32, known: &Known) -> Self {
        let mut bytes = [0; Self::BYTES];
        let (body, checksum) = bytes.split_at_mut(Self::BYTES - 4);
        // Cells of a known length: slices that are copied into one another bring a panic into a board's image.
        let mut cells = body.as_chunks_mut().0.iter_mut();
        let mut put = |word: u32| {
            if let Some(cell) = cells.next() {
                *cell = word.to_le_bytes();
            }
        };
        put(FORMAT);
        settings(design).into_iter().chain([set_point]).for_each(|number| put(number.to_bits()));
        let mut known = *known;
        known.each_number(&mut |number| put(number.to_bits()));
        let check = crc_32(body).to_le_bytes();
        checksum.iter_mut().zip(check).for_each(|(byte, check)| *byte = check);
        Stored(bytes)
    }

    /// The set point, and what is known of it.
    pub(super) fn restored(&self, design: &Design) -> Result<(f32, Known), RestoreError> {
        let mut numbers = self.words().skip(1).map(f32::from_bits);
        let mut next = || numbers.next().unwrap_or(f32::NAN);
        let mut kept = settings(design);
        kept.fill_with(&mut next);
        compared(kept, settings(design))?;
        let (set_point, mut known) = (next(), Known::BLANK);
        known.each_number(&mut |number| *number = next());
        let usable = set_point.is_finite() && known.is_usable();
        usable.then_some((set_point, known)).ok_or(RestoreError::Values)
    }

    fn words(&self) -> impl Iterator<Item = u32> {
        self.0.chunks_exact(4).filter_map(|cell| cell.try_into().ok().map(u32::from_le_bytes))
    }
}

/// What a model depends on: sampling rate, samples between false alarms, and the weights of the time scales.
const fn settings(design: &Design) -> [f32; SETTINGS] {
    let [fast, middle, slow, trend] = &design.scales;
    let [rate, interval] = [design.sample_rate_hz, design.interval_samples];
    [rate, interval, fast.weight(), middle.weight(), slow.weight(), trend.weight()]
}

fn compared(kept: [f32; SETTINGS], now: [f32; SETTINGS]) -> Result<(), RestoreError> {
    let ([rate, interval, scales @ ..], [rate_now, interval_now, scales_now @ ..]) = (kept, now);
    let same = |a: f32, b: f32| a.to_bits() == b.to_bits();
    if !same(rate, rate_now) {
        return Err(RestoreError::SampleRate(rate));
    }
    if !scales.into_iter().zip(scales_now).all(|(a, b)| same(a, b)) {
        return Err(RestoreError::TimeConstants);
    }
    if same(interval, interval_now) { Ok(()) } else { Err(RestoreError::FalseAlarmRate) }
}

/// The checksum of Ethernet and ZIP (ISO 3309), bit by bit: a table would cost more flash than it saves time.
fn crc_32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| crc >> 1 ^ (0xedb8_8320 & 0_u32.wrapping_sub(crc & 1)))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_the_one_of_the_standard() {
        assert_eq!(crc_32(b"123456789"), 0xcbf4_3926);
    }

    #[test]
    fn a_stored_model_has_room_for_all_of_it() {
        let mut numbers = 0;
        let mut known = Known::BLANK;
        known.each_number(&mut |_| numbers += 1);
        assert_eq!(numbers, NUMBERS);
    }
}
