//! What is kept of a run to be drawn, and to go back to: a ring of bins of a hundredth of a second, or of a slot.

use std::collections::VecDeque;

use super::chronicle::Tally;
use super::slot::{DISTANCES, Says, Slot};

/// Bins that are kept: 164 s at a hundredth of a second, 5 MB.
const KEPT: usize = 16_384;

/// Length of a bin, s, unless a slot is longer.
const BIN_S: f64 = 0.01;

/// Some slots in a row.
#[derive(Clone, Copy, Debug)]
pub struct Bin {
    /// When its last slot was, s.
    pub t_s: f64,
    /// Set point of its last slot.
    pub set_point: f64,
    /// Least reading of each channel; not a number if there was none.
    pub least: [f32; 3],
    /// Greatest reading of each channel.
    pub greatest: [f32; 3],
    /// Greatest of each distance over its limit.
    pub ratios: [f32; DISTANCES],
    /// Whether an alarm stood in any of its slots.
    pub alarm: bool,
    /// What was said of its last slot.
    pub says: Says,
    /// What was counted up to its last slot.
    pub tally: Tally,
    sum: [f64; 3],
    readings: [u32; 3],
    slots: u64,
}

impl Bin {
    /// Mean reading of a channel; not a number if there was none.
    #[must_use]
    pub fn reading(&self, channel: usize) -> f64 {
        let (sum, readings) = (self.sum.get(channel).copied(), self.readings.get(channel).copied());
        sum.unwrap_or(f64::NAN) / f64::from(readings.unwrap_or(0))
    }

    fn of(slot: &Slot, tally: Tally) -> Self {
        let x = slot.x.map(|x| x as f32);
        Bin {
            t_s: slot.t_s,
            set_point: slot.set_point,
            least: x,
            greatest: x,
            ratios: slot.says.ratios,
            alarm: slot.says.alarm,
            says: slot.says,
            tally,
            sum: slot.x.map(|x| if x.is_finite() { x } else { 0.0 }),
            readings: slot.x.map(|x| u32::from(x.is_finite())),
            slots: 1,
        }
    }

    fn join(&mut self, next: &Bin) {
        // The lesser and the greater of two, or the one that is a number.
        for k in 0..3 {
            self.least[k] = self.least[k].min(next.least[k]);
            self.greatest[k] = self.greatest[k].max(next.greatest[k]);
            self.sum[k] += next.sum[k];
            self.readings[k] += next.readings[k];
        }
        for k in 0..DISTANCES {
            self.ratios[k] = self.ratios[k].max(next.ratios[k]);
        }
        self.alarm |= next.alarm;
        (self.t_s, self.set_point, self.says, self.tally) = (next.t_s, next.set_point, next.says, next.tally);
        self.slots += 1;
    }
}

/// The latest bins of a run; each keeps its number, counted from the beginning of the run.
#[derive(Clone, Debug)]
pub struct History {
    bins: VecDeque<Bin>,
    first: u64,
    slots_per_bin: u64,
    rate_hz: f64,
}

impl History {
    /// Nothing yet, of a run at `rate_hz` slots per second.
    #[must_use]
    pub fn new(rate_hz: f64) -> Self {
        let slots_per_bin = ((BIN_S * rate_hz).round() as u64).max(1);
        History { bins: VecDeque::with_capacity(KEPT), first: 0, slots_per_bin, rate_hz }
    }

    /// Takes a slot.
    pub fn push(&mut self, slot: &Slot, tally: Tally) {
        let bin = Bin::of(slot, tally);
        match self.bins.back_mut() {
            Some(last) if last.slots < self.slots_per_bin => last.join(&bin),
            _ => {
                if self.bins.len() == KEPT {
                    self.bins.pop_front();
                    self.first += 1;
                }
                self.bins.push_back(bin);
            }
        }
    }

    /// Length of a bin, s.
    #[must_use]
    pub fn bin_s(&self) -> f64 {
        self.slots_per_bin as f64 / self.rate_hz
    }

    /// How far back it goes when it is full, s.
    #[must_use]
    pub fn reach_s(&self) -> f64 {
        KEPT as f64 * self.bin_s()
    }

    /// Numbers of the first and the last bin; none before the first slot.
    #[must_use]
    pub fn ends(&self) -> Option<(u64, u64)> {
        let last = (self.bins.len() as u64).checked_sub(1)?;
        Some((self.first, self.first + last))
    }

    /// A bin by its number.
    #[must_use]
    pub fn get(&self, number: u64) -> Option<&Bin> {
        self.bins.get(usize::try_from(number.checked_sub(self.first)?).ok()?)
    }

    /// The bins of some numbers that are kept, each with its number.
    pub fn bins(&self, numbers: std::ops::RangeInclusive<u64>) -> impl Iterator<Item = (u64, &Bin)> {
        let from = numbers.start().saturating_sub(self.first) as usize;
        let count = (numbers.end() + 1).saturating_sub(self.first.max(*numbers.start())) as usize;
        let first = self.first + from as u64;
        (first..).zip(self.bins.iter().skip(from).take(count))
    }
}
