//! Phase II: a baseline, the filters behind it, and what the relays say; one call per sample.

use core::hint::select_unpredictable;

use super::baseline::Baseline;
use super::verdict::{Slot, Standing, Verdict};
use crate::relay::Relay;
use crate::sample::Bank;
use crate::smoother::Smoother;

/// The mean of the scaled T2 (1.6) in control. Filters start at rest there, so that monitoring can begin with the first
/// sample after learning instead of waiting until they have charged.
const T2_IN_CONTROL: f32 = 1.0;

/// The frozen part of the chain behind T2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Chain<S> {
    pub(crate) smoother: S,
    pub(crate) relays: Bank<Relay>,
}

/// The moving part: what a monitor carries while it judges.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Detector<S: Smoother> {
    pub(crate) baseline: Baseline,
    filters: Bank<S::State>,
}

impl<S: Smoother> Detector<S> {
    pub(crate) fn new(baseline: Baseline, smoother: &S) -> Self {
        let filters = Bank::from_fn(|_| smoother.at_rest(T2_IN_CONTROL));
        Detector { baseline, filters }
    }

    /// Judges one sample, and brings the verdict on the sample before up to date. Reads as figures 3 and 9 of the paper.
    ///
    /// A sample that is no measurement takes the same path and changes nothing but what the verdict says of it.
    #[inline(always)]
    pub(crate) fn step(&mut self, chain: &Chain<S>, x: [f32; 3], verdict: &mut Verdict) {
        // An alarm that no relay held up at the sample before can begin with this one.
        verdict.alarm_since = select_unpredictable(verdict.standing.alarm(), verdict.alarm_since, verdict.sample);
        let deviation = self.baseline.deviation(x); //                                          standardize, (1.7)
        let t2 = self.baseline.t2(deviation); //                                                Hotelling, (1.6)
        let held = beyond_measure(&t2);
        let t2 = t2.map(|t2| if held { 0.0 } else { t2 });
        let residuals = chain.smoother.step_bank(held, &mut self.filters, t2); //               low-pass, fig. 3
        let relays = verdict.standing.step(&chain.relays, residuals); //                        relays, figs. 7 and 9
        verdict.standing = if held { verdict.standing.with(Slot::Unfit) } else { relays };
        verdict.residuals = residuals;
    }
}

/// Whether some T2 is not finite, or so large that a filter could overflow: a deviation of 1e15 sigmas and more, which no
/// sensor measures. Decided once for all four, without a branch: a reading that is not finite makes the sum so, too.
#[inline(always)]
fn beyond_measure(t2: &Bank<f32>) -> bool {
    // 6.6e35. One instruction of the target compares with a number of so few bits.
    const LARGEST: u32 = 0x7b00_0000;
    let pairs = &t2.pairs;
    let sum = t2.full + pairs.speed_current + (pairs.current_voltage + pairs.speed_voltage);
    // Bits of numbers not below zero are ordered as the numbers are, and those of NaN, of either sign, are above all.
    sum.to_bits() > LARGEST
}

impl Standing {
    /// Takes the four residuals; says which relays are up after them.
    #[inline(always)]
    fn step(self, relays: &Bank<Relay>, residuals: Bank<f32>) -> Standing {
        let relay = |bit: u32, relay: &Relay, residual: f32| {
            let mut up = self.relay(bit);
            u32::from(relay.step(&mut up, residual)) << bit
        };
        let (pairs, of) = (&relays.pairs, residuals.pairs);
        let up = relay(0, &relays.full, residuals.full)
            | relay(1, &pairs.speed_current, of.speed_current)
            | relay(2, &pairs.current_voltage, of.current_voltage)
            | relay(3, &pairs.speed_voltage, of.speed_voltage);
        Standing::new(up, Slot::Taken)
    }
}
