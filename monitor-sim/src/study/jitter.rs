//! Samples taken late within their slot, at random: a timer that competes with other interrupts.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::plant::{Plant, PlantSample, TrueState};

/// A plant whose monitor reads late by a random share of the control period; the drive itself keeps time.
///
/// Between two control periods speed and current move nearly in a straight line, and the voltage is held. The noise of a
/// reading is that of its slot.
#[derive(Clone, Debug)]
pub(super) struct Jittered {
    plant: Plant,
    latest: f64,
    generator: ChaCha8Rng,
    held: Option<(PlantSample, TrueState)>,
}

impl Jittered {
    /// Samples of `plant` that are late by up to `latest` control periods, evenly distributed.
    #[must_use]
    pub(super) fn new(mut plant: Plant, latest: f64, seed: u64) -> Self {
        let held = plant.next().map(|sample| (sample, plant.true_state()));
        Self { plant, latest, generator: ChaCha8Rng::seed_from_u64(seed), held }
    }
}

impl Iterator for Jittered {
    type Item = PlantSample;

    fn next(&mut self) -> Option<PlantSample> {
        let (sample, here) = self.held.take()?;
        self.held = self.plant.next().map(|next| (next, self.plant.true_state()));
        let there = self.held.as_ref().map_or(here, |(_, state)| *state);
        let late = self.latest * self.generator.random::<f64>();
        Some(PlantSample {
            speed: sample.speed + late * (there.speed - here.speed),
            armature_current: sample.armature_current + late * (there.armature_current - here.armature_current),
            ..sample
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;

    #[test]
    fn late_readings_lie_between_those_of_their_neighbours_and_no_jitter_changes_nothing() {
        let mut scenario = Scenario { duration_s: 20.0, ..Scenario::figure_1().without_faults() };
        scenario.noise.speed_sigma_rad_per_s = 0.0;
        scenario.noise.current_sigma_a = 0.0;
        scenario.noise.voltage_sigma_v = 0.0;
        let on_time: Vec<_> = Plant::new(&scenario, 1).collect();
        assert!(Jittered::new(Plant::new(&scenario, 1), 0.0, 2).eq(on_time.iter().copied()));
        let late: Vec<_> = Jittered::new(Plant::new(&scenario, 1), 1.0, 2).collect();
        assert_eq!(late.len(), on_time.len());
        // From 10 ms to 110 ms the motor starts up, and its speed only grows.
        let mut moved = 0.0;
        for (k, sample) in late.iter().enumerate().skip(10).take(100) {
            let (before, after) = (on_time[k].speed, on_time[k + 1].speed);
            assert!((before..=after).contains(&sample.speed), "sample {k}");
            moved += (sample.speed - before) / (after - before) / 100.0;
        }
        // Even over the period: a half, with a standard error of 0.029; four of it.
        assert!((moved - 0.5).abs() < 0.12, "{moved}");
    }
}
