//! Faults as they act, control period by control period.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::{Fault, FaultKind, FaultPoint, Injection};

/// The faults' random streams begin behind those of the sensors and the turbulence
/// ([`Stream`](crate::noise::Stream)). Part of the recorded behaviour.
const FIRST_STREAM: u64 = 16;

/// What all faults do together in one control period.
#[derive(Debug, Clone, PartialEq)]
pub struct Actions {
    by_point: [Injection; FaultPoint::COUNT],
    /// The monitor gets no sample in this slot.
    pub missing: bool,
}

impl Actions {
    const NONE: Self = Self { by_point: [Injection::NONE; FaultPoint::COUNT], missing: false };

    /// What they do at `point`.
    #[must_use]
    pub fn on(&self, point: FaultPoint) -> &Injection {
        &self.by_point[point as usize]
    }
}

/// A schedule of faults under way.
#[derive(Debug, Clone)]
pub struct ActingFaults {
    faults: Vec<(Fault, ChaCha8Rng)>,
    now: Actions,
    quiet: bool,
}

impl ActingFaults {
    /// The faults of a mission with this `seed`. Each fault that acts by chance has a random stream of its own, so that
    /// no fault changes another's.
    #[must_use]
    pub fn new(seed: u64, faults: &[Fault]) -> Self {
        let stream = |(stream, fault): (u64, &Fault)| {
            let mut generator = ChaCha8Rng::seed_from_u64(seed);
            generator.set_stream(stream);
            (fault.clone(), generator)
        };
        Self { faults: (FIRST_STREAM..).zip(faults).map(stream).collect(), now: Actions::NONE, quiet: true }
    }

    /// What they do in the control period that begins at `t_s` seconds. Ask once for each period: chance is drawn anew.
    pub fn at(&mut self, t_s: f64) -> &Actions {
        // Most periods of a long study have no fault; they shall not cost more than this comparison.
        let any = self.faults.iter().any(|(fault, _)| fault.is_active(t_s));
        if any || !self.quiet {
            self.now = Actions::NONE;
            self.quiet = !any;
        }
        for (fault, generator) in self.faults.iter_mut().filter(|(fault, _)| fault.is_active(t_s)) {
            let value = fault.value(t_s);
            let chance = if fault.kind.is_chance() { value } else { fault.share };
            // `random` is below 1, so that a chance of 1 is certain.
            if chance < 1.0 && generator.random::<f64>() >= chance {
                continue;
            }
            let here = &mut self.now.by_point[fault.point as usize];
            *here = here.and(fault.kind, value);
            self.now.missing |= fault.kind == FaultKind::Missing;
        }
        &self.now
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fault::FaultProfile;

    fn fault(point: FaultPoint, kind: FaultKind, amplitude: f64, share: f64) -> Fault {
        let (id, name, profile) = ("F".to_owned(), "fault".to_owned(), FaultProfile::Step);
        Fault { id, name, point, kind, profile, amplitude, start_s: 1.0, end_s: 11.0, share }
    }

    /// Periods of 1 ms in the ten seconds of `faults` in which `acts` holds.
    fn count(faults: &[Fault], acts: impl Fn(&Actions) -> bool) -> usize {
        let mut acting = ActingFaults::new(1, faults);
        (1000..11_000).filter(|k| acts(acting.at(f64::from(*k) / 1000.0))).count()
    }

    #[test]
    fn what_acts_by_chance_acts_as_often_as_its_share_or_value_says() {
        // Standard error of 1,000 of 10,000: 30; four of it.
        let spikes = [fault(FaultPoint::SpeedSensor, FaultKind::Offset, 5.0, 0.1)];
        assert!(count(&spikes, |now| now.on(FaultPoint::SpeedSensor).offset == 5.0).abs_diff(1000) < 120);
        let missing = [fault(FaultPoint::Sampling, FaultKind::Missing, 0.1, 1.0)];
        assert!(count(&missing, |now| now.missing).abs_diff(1000) < 120);
        let stuck = [fault(FaultPoint::VoltageSensor, FaultKind::Stuck, 1.0, 1.0)];
        assert_eq!(count(&stuck, |now| now.on(FaultPoint::VoltageSensor).stuck), 10_000);
    }

    #[test]
    fn a_fault_that_is_over_leaves_nothing_behind() {
        let mut acting = ActingFaults::new(1, &[fault(FaultPoint::Sampling, FaultKind::Missing, 1.0, 1.0)]);
        assert!(acting.at(10.999).missing);
        assert_eq!(*acting.at(11.0), Actions::NONE);
    }

    #[test]
    fn a_second_fault_does_not_change_when_the_first_acts() {
        let first = fault(FaultPoint::SpeedSensor, FaultKind::Offset, 5.0, 0.5);
        let second = fault(FaultPoint::CurrentSensor, FaultKind::Offset, 1.0, 0.5);
        let pattern = |faults: &[Fault]| {
            let mut acting = ActingFaults::new(1, faults);
            let spike = |k| acting.at(1.0 + f64::from(k) / 1000.0).on(FaultPoint::SpeedSensor).offset > 0.0;
            (0..100).map(spike).collect::<Vec<_>>()
        };
        assert_eq!(pattern(std::slice::from_ref(&first)), pattern(&[first.clone(), second]));
    }
}
