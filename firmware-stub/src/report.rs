//! What the main loop hears and answers, as `defmt` lines that a person understands: what, since when, how large against
//! its limit. Times are of the sampling clock, in seconds since the start.

use core::marker::PhantomData;

use crate::background::{Answer, Learned, Named};
use crate::fault::Reason;
use crate::mode::Mode;
use crate::sampling::{Note, NoteOf, Snapshot};

mod guarded;
mod paper;

/// What only a mode itself can say.
pub trait Spoken: Mode<Rejected: defmt::Format> {
    /// Logs what has changed with a slot.
    fn log_news(report: &Report<Self>, news: Self::News);

    /// Logs a name that was asked for.
    fn log_named(report: &Report<Self>, named: &Named<Self::Finding>);

    /// Logs what of the last verdict is due to each channel.
    fn log_by_channel(shares: Option<[f32; 3]>);

    /// Logs the last verdict, and what is wrong.
    fn log_verdict(&self, report: &Report<Self>, finding: &Self::Finding);

    /// Logs what samples are judged by.
    fn log_statistics(&self);
}

/// What turns slots into times.
#[derive(Clone, Copy, Debug)]
pub struct Report<M> {
    /// Microseconds from one slot to the next: a board's rate divides a million.
    period_us: u32,
    mode: PhantomData<M>,
}

impl<M: Spoken> Report<M> {
    /// For slots at this rate.
    #[must_use]
    pub fn new(sample_rate_hz: u32) -> Self {
        Report { period_us: 1_000_000 / sample_rate_hz.max(1), mode: PhantomData }
    }

    /// Microseconds from the start to a sample. No division: of 64 bits, that would be a routine of its own.
    fn us(&self, sample: u64) -> u64 {
        sample.wrapping_mul(u64::from(self.period_us))
    }

    /// Logs a note.
    #[inline(never)]
    pub fn note(&self, note: NoteOf<M>) {
        match note {
            Note::News(news) => M::log_news(self, news),
            Note::Rejecting { sample, why } => {
                defmt::warn!("{=u64:us} s: samples are turned away, {}", self.us(sample), why);
            }
            Note::Accepting { sample, after } => {
                defmt::info!("{=u64:us} s: samples are judged again after {=u32}", self.us(sample), after);
            }
            Note::Overrun { sample } => {
                defmt::warn!("{=u64:us} s: sampling overran, the next slot had begun", self.us(sample));
            }
        }
    }

    /// Logs a name that was asked for.
    pub fn named(&self, named: &Named<M::Finding>) {
        M::log_named(self, named);
    }

    /// Logs how a learning window ended where no note says it.
    pub fn learned(&self, learned: Learned, in_vain: u32) {
        match learned {
            Learned::Installed | Learned::Refused(_) => {}
            Learned::InVain => {
                defmt::info!("the set point changed while a model was made, {=u32} in vain so far", in_vain)
            }
        }
    }

    /// Logs an answer.
    #[inline(never)]
    pub fn answer(&self, answer: &Answer<M>) {
        match answer {
            Answer::ByChannel(shares) => M::log_by_channel(*shares),
            Answer::Statistics(state) => self.statistics(state),
            Answer::Verdict(state, finding) => state.mode.log_verdict(self, finding),
            Answer::SetPoint(set_point) => defmt::info!("set point {=f32} rad/s", set_point.0),
            Answer::Acknowledged => defmt::info!("acknowledged: the motor is taken for healthy"),
        }
    }

    fn statistics(&self, Snapshot { mode, counts }: &Snapshot<M>) {
        defmt::info!(
            "{=u64:us} s: {=u32} slots turned away, {=u32} of them late or missing, {=u32} overruns, {=u32} notes dropped",
            self.us(mode.slot()),
            counts.rejected,
            counts.absent,
            counts.overruns,
            counts.dropped
        );
        mode.log_statistics();
    }
}

/// Logs what the channels are while the motor is healthy.
fn healthy(mean: [f32; 3], sigma: [f32; 3]) {
    let ([m1, m2, m3], [s1, s2, s3]) = (mean, sigma);
    defmt::info!("speed {=f32} rad/s, sigma {=f32}", m1, s1);
    defmt::info!("armature current {=f32} A, sigma {=f32}", m2, s2);
    defmt::info!("armature voltage {=f32} V, sigma {=f32}", m3, s3);
}

/// Logs why the last run ended, at the start of this one.
pub fn last_run(reason: Reason) {
    defmt::error!("the last run ended in: {}", reason);
}
