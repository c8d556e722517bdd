//! Phase II: a baseline, the filters behind it, and what the relays say; one call per sample.

use crate::baseline::Baseline;
use crate::localize::{Diagnosis, localize};
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
    pub(crate) alarm: Alarm,
}

/// What stands at a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Alarm {
    pub(crate) up: Bank<bool>,
    pub(crate) diagnosis: Diagnosis,
    /// Sample at which the first relay of this alarm went up; meaningless when all are down.
    since: u64,
    /// Sample from which the diagnosis stands; meaningless when it is healthy.
    located_since: u64,
}

impl<S: Smoother> Detector<S> {
    pub(crate) fn new(baseline: Baseline, smoother: &S) -> Self {
        let filters = Bank::from_fn(|_| smoother.at_rest(T2_IN_CONTROL));
        Detector { baseline, filters, alarm: Alarm::default() }
    }

    /// Judges one sample; returns the smoothed residuals. Reads as figures 3 and 9 of the paper.
    #[inline]
    pub(crate) fn step(&mut self, chain: &Chain<S>, sample: u64, x: [f32; 3]) -> Bank<f32> {
        let deviation = self.baseline.deviation(x); //                                             standardize, (1.7)
        let t2 = self.baseline.t2(deviation); //                                                   Hotelling, (1.6)
        let residuals = t2.drive(&mut self.filters, |state, t2| chain.smoother.step(state, t2)); // low-pass, fig. 3
        self.alarm.step(&chain.relays, sample, residuals); //                                      relays, table (1.8)
        residuals
    }
}

impl Alarm {
    #[inline]
    fn step(&mut self, relays: &Bank<Relay>, sample: u64, residuals: Bank<f32>) {
        let alarmed = self.up.any();
        relays.zip(residuals).drive(&mut self.up, |up, (relay, residual)| relay.step(up, residual));
        if !alarmed {
            self.since = sample;
        }
        let diagnosis = localize(self.up.pairs);
        if diagnosis != self.diagnosis {
            self.located_since = sample;
        }
        self.diagnosis = diagnosis;
    }

    pub(crate) fn since(&self) -> Option<u64> {
        self.up.any().then_some(self.since)
    }

    pub(crate) fn located_since(&self) -> Option<u64> {
        (self.diagnosis != Diagnosis::Healthy).then_some(self.located_since)
    }
}
