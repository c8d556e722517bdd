//! Phase II: a baseline, the filters behind it, and what the relays say; one call per sample.

use crate::baseline::Baseline;
use crate::range::{Look, Range};
use crate::relay::Relay;
use crate::sample::Bank;
use crate::smoother::Smoother;
use crate::verdict::Up;

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
    pub(crate) up: Up,
    /// Sample at which the first relay of this alarm went up; meaningless when all are down.
    pub(crate) alarm_since: u64,
}

impl<S: Smoother> Detector<S> {
    pub(crate) fn new(baseline: Baseline, smoother: &S, ranges: &[Range; 3]) -> Self {
        let filters = Bank::from_fn(|_| smoother.at_rest(T2_IN_CONTROL));
        Detector { baseline: baseline.within(ranges), filters, up: Up::default(), alarm_since: 0 }
    }

    /// Judges one sample; returns the smoothed residuals. Reads as figures 3 and 9 of the paper.
    ///
    /// A sample that is not fit takes the same path and changes nothing.
    #[inline(always)]
    pub(crate) fn step(&mut self, chain: &Chain<S>, sample: u64, look: Look, x: [f32; 3]) -> Bank<f32> {
        let live = look.fit();
        let deviation = self.baseline.deviation(x).map(|d| if live { d } else { 0.0 }); //  standardize, (1.7)
        let t2 = self.baseline.t2(deviation); //                                            Hotelling, (1.6)
        let residuals = t2.drive(&mut self.filters, |state, t2| chain.smoother.step_if(live, state, t2)); // fig. 3
        let up = self.up.step(&chain.relays, residuals); //                                 relays, figs. 7 and 9
        if !self.up.any() {
            self.alarm_since = sample;
        }
        self.up = if live { up } else { self.up };
        residuals
    }
}

impl Up {
    /// Takes the four residuals; says which relays are up after them.
    #[inline(always)]
    fn step(self, relays: &Bank<Relay>, residuals: Bank<f32>) -> Up {
        let relay = |bit: u32, relay: &Relay, residual: f32| {
            let mut up = self.0 >> bit & 1 != 0;
            u32::from(relay.step(&mut up, residual)) << bit
        };
        let (relays_of, of) = (&relays.pairs, residuals.pairs);
        Up(relay(0, &relays.full, residuals.full)
            | relay(1, &relays_of.speed_current, of.speed_current)
            | relay(2, &relays_of.current_voltage, of.current_voltage)
            | relay(3, &relays_of.speed_voltage, of.speed_voltage))
    }
}
