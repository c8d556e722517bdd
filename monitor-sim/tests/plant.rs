//! The plant in closed loop: settling, limits, what each fault does in the steady state, and the noise.

use std::ops::Range;

use approx::assert_abs_diff_eq;
use monitor_sim::fault::{Fault, FaultKind, FaultPoint, FaultProfile};
use monitor_sim::motor::MotorParameters;
use monitor_sim::noise::NoiseParameters;
use monitor_sim::plant::{Plant, PlantSample, TrueState};
use monitor_sim::scenario::{Scenario, SetPoint, Start};

const K: f64 = MotorParameters::MAXON_RE_40.torque_constant_nm_per_a;
const R: f64 = MotorParameters::MAXON_RE_40.resistance_ohm;

const SILENT: NoiseParameters = NoiseParameters {
    speed_sigma_rad_per_s: 0.0,
    current_sigma_a: 0.0,
    voltage_sigma_v: 0.0,
    speed_step_rad_per_s: 0.0,
    current_step_a: 0.0,
    voltage_step_v: 0.0,
};

/// A fault-free mission of `duration_s` seconds without noise.
fn silent(duration_s: f64) -> Scenario {
    Scenario { duration_s, noise: SILENT, ..Scenario::figure_1().without_faults() }
}

/// A step fault from 5 s to 15 s.
fn fault(point: FaultPoint, kind: FaultKind, amplitude: f64) -> Fault {
    Fault {
        id: "F".to_owned(),
        name: "fault".to_owned(),
        point,
        kind,
        profile: FaultProfile::Step,
        amplitude,
        start_s: 5.0,
        end_s: 15.0,
        share: 1.0,
    }
}

/// Every sample with the true values of its instant.
fn run(scenario: &Scenario) -> Vec<(PlantSample, TrueState)> {
    scenario.validate().unwrap();
    let mut plant = Plant::new(scenario, 1);
    std::iter::from_fn(|| plant.next().map(|sample| (sample, plant.true_state()))).collect()
}

/// Samples before the fault, at the fault's end, and long after it, of a 25 s silent mission with `fault`.
fn before_during_after(scenario: &Scenario, fault: Fault) -> [(PlantSample, TrueState); 3] {
    let mission = run(&Scenario { duration_s: 25.0, faults: vec![fault], ..scenario.clone() });
    [mission[4_999], mission[14_999], mission[24_999]]
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0.0), |(sum, n), x| (sum + x, n + 1.0));
    sum / n
}

fn sigma(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let centre = mean(values.clone());
    mean(values.map(|x| (x - centre).powi(2))).sqrt()
}

/// Speed samples of a mission in a window of time.
fn speeds(mission: &[(PlantSample, TrueState)], window_s: Range<f64>) -> Vec<f64> {
    let within = mission.iter().filter(|(sample, _)| window_s.contains(&sample.t_s));
    within.map(|(_, state)| state.speed).collect()
}

#[test]
fn from_standstill_the_loop_has_settled_before_learning_begins_at_5_s() {
    let mission = run(&silent(20.0));
    assert_eq!(mission[0].1.speed, 0.0);
    assert_eq!(mission[0].0.armature_current, 0.0);
    for (sample, state) in &mission[4_000..] {
        assert_abs_diff_eq!(state.speed, 300.0, epsilon = 1e-3);
        assert_abs_diff_eq!(state.armature_current, 0.06 / K, epsilon = 1e-4);
        assert_abs_diff_eq!(sample.armature_voltage, R * 0.06 / K + K * 300.0, epsilon = 1e-4);
    }
}

#[test]
fn the_start_up_is_a_real_transient_at_the_current_limit() {
    let mission = run(&silent(20.0));
    // At the 6 A limit the shaft accelerates evenly at a: J a = K i - T. The back-EMF's ramp K a leaves the current PI
    // an error, ki (6 A - i) = K a. Together a = ki (6 A - T/K)/(K + ki J/K) = 59.8 * 4.013/(0.0302 + 0.2261) = 936
    // rad/s^2; the voltage held for 1 ms against the rising back-EMF adds 0.6 %.
    let acceleration = (mission[150].1.speed - mission[100].1.speed) / 0.05;
    assert_abs_diff_eq!(acceleration, 936.0, epsilon = 10.0);
    let highest = mission.iter().map(|(_, state)| state.armature_current).fold(0.0, f64::max);
    assert!(highest < 6.0, "highest current {highest}");
    assert!(speeds(&mission, 0.0..0.2).iter().all(|&w| w < 250.0));
}

#[test]
fn started_steady_the_loop_stays_where_it_is() {
    for (sample, state) in run(&Scenario { start: Start::Steady, ..silent(20.0) }) {
        assert_abs_diff_eq!(state.speed, 300.0, epsilon = 1e-9);
        assert_abs_diff_eq!(sample.armature_current, 0.06 / K, epsilon = 1e-9);
        assert_abs_diff_eq!(sample.speed, 300.0, epsilon = 1e-9);
    }
}

#[test]
fn a_start_at_the_current_limit_does_not_wind_up_into_an_overshoot() {
    // The integral stands still in the 0.25 s at the limit, so the set point is approached from below. Wound up by
    // ki * 150 rad/s * 0.25 s = 11 A it would carry the speed far beyond.
    let highest = speeds(&run(&silent(20.0)), 0.0..20.0).into_iter().fold(0.0, f64::max);
    assert!(highest < 300.5, "highest speed {highest}");
}

#[test]
fn the_voltage_never_exceeds_the_supply() {
    // 750 rad/s needs 23.2 V; the way there and a fault beyond reach (3 A more) do not get more than 24 V.
    let mut scenario = Scenario { duration_s: 25.0, ..silent(20.0) };
    scenario.set_points = vec![SetPoint { at_s: 0.0, rad_per_s: 750.0 }];
    scenario.faults = vec![fault(FaultPoint::LoadTorque, FaultKind::Offset, 0.1)];
    let mission = run(&scenario);
    assert!(mission.iter().all(|(_, state)| state.armature_voltage.abs() <= 24.0));
    // Against the supply: w = (U - R T/K)/K.
    assert_abs_diff_eq!(mission[14_999].1.speed, (24.0 - R * 0.16 / K) / K, epsilon = 1e-3);
    // The integral did not wind up in those 10 s: back within 3 s, without overshoot beyond what the load step makes.
    let highest = speeds(&mission, 15.0..25.0).into_iter().fold(0.0, f64::max);
    assert!(highest < 790.0, "highest speed {highest}");
    assert_abs_diff_eq!(mission[18_000].1.speed, 750.0, epsilon = 0.1);
}

#[test]
fn a_set_point_step_is_followed_and_recorded_from_its_instant_on() {
    let mut scenario = silent(20.0);
    scenario.set_points.push(SetPoint { at_s: 10.0, rad_per_s: 200.0 });
    let mission = run(&scenario);
    assert_eq!((mission[9_999].0.set_point, mission[10_000].0.set_point), (300.0, 200.0));
    assert_abs_diff_eq!(mission[9_999].1.speed, 300.0, epsilon = 1e-3);
    assert_abs_diff_eq!(mission[14_999].1.speed, 200.0, epsilon = 1e-3);
}

#[test]
fn a_load_torque_fault_moves_current_by_torque_over_k_and_voltage_by_r_times_that() {
    let f1 = fault(FaultPoint::LoadTorque, FaultKind::Offset, 0.03);
    let [before, during, after] = before_during_after(&silent(25.0), f1);
    let shift = 0.03 / K;
    for (sample, di) in [(during.0, shift), (after.0, 0.0)] {
        assert_abs_diff_eq!(sample.speed, 300.0, epsilon = 1e-3);
        assert_abs_diff_eq!(sample.armature_current - before.0.armature_current, di, epsilon = 1e-3);
        let dv = sample.armature_voltage - before.0.armature_voltage;
        assert_abs_diff_eq!(dv, R * di, epsilon = 1e-3);
    }
    assert_abs_diff_eq!(during.1.load_torque, 0.09, epsilon = 1e-12);
}

#[test]
fn a_speed_sensor_offset_lowers_the_true_speed_by_it_and_the_voltage_by_k_times_it() {
    // The loop brings the reading back to the set point, so the shaft runs 8 rad/s slow; the load does not change with
    // speed, so neither does the current.
    let f2 = fault(FaultPoint::SpeedSensor, FaultKind::Offset, 8.0);
    let [before, during, after] = before_during_after(&silent(25.0), f2);
    for ((sample, state), dw) in [(during, -8.0), (after, 0.0)] {
        assert_abs_diff_eq!(sample.speed, 300.0, epsilon = 1e-3);
        assert_abs_diff_eq!(state.speed - before.1.speed, dw, epsilon = 2e-3);
        let di = sample.armature_current - before.0.armature_current;
        assert_abs_diff_eq!(di, 0.0, epsilon = 1e-3);
        let dv = sample.armature_voltage - before.0.armature_voltage;
        assert_abs_diff_eq!(dv, K * dw, epsilon = 1e-3);
    }
}

#[test]
fn a_current_sensor_offset_stays_in_the_reading_and_leaves_true_current_speed_and_voltage() {
    // The speed loop raises the current reference by the offset until the true current carries the load again; so the
    // reading keeps the offset, and nothing else moves.
    let f3 = fault(FaultPoint::CurrentSensor, FaultKind::Offset, 0.5);
    let [before, during, after] = before_during_after(&silent(25.0), f3);
    for ((sample, state), offset) in [(during, 0.5), (after, 0.0)] {
        let di = sample.armature_current - before.0.armature_current;
        assert_abs_diff_eq!(di, offset, epsilon = 1e-3);
        assert_abs_diff_eq!(state.armature_current, before.1.armature_current, epsilon = 1e-3);
        assert_abs_diff_eq!(state.speed, 300.0, epsilon = 1e-3);
        let dv = sample.armature_voltage - before.0.armature_voltage;
        assert_abs_diff_eq!(dv, 0.0, epsilon = 1e-3);
    }
}

#[test]
fn a_load_that_grows_with_speed_makes_a_speed_sensor_offset_visible_in_the_current() {
    let f2 = fault(FaultPoint::SpeedSensor, FaultKind::Offset, 8.0);
    let viscous = silent(25.0).with_speed_dependent_load();
    let [before, during, _] = before_during_after(&viscous, f2);
    assert_abs_diff_eq!(before.0.armature_current, 0.06 / K, epsilon = 1e-3);
    let di = during.0.armature_current - before.0.armature_current;
    assert_abs_diff_eq!(di, -8.0 * (0.06 / 300.0) / K, epsilon = 1e-3);
}

#[test]
fn gain_faults_scale_the_reading_or_the_whole_load() {
    let gain = |point| fault(point, FaultKind::Gain, 0.25);
    // Reading = 1.25 times the truth, and the loop holds the reading at the set point.
    let [_, during, after] = before_during_after(&silent(25.0), gain(FaultPoint::SpeedSensor));
    assert_abs_diff_eq!(during.1.speed, 300.0 / 1.25, epsilon = 2e-3);
    assert_abs_diff_eq!(after.1.speed, 300.0, epsilon = 2e-3);
    // The true current carries the load, the reading is 1.25 times that.
    let [_, during, _] = before_during_after(&silent(25.0), gain(FaultPoint::CurrentSensor));
    assert_abs_diff_eq!(during.1.armature_current, 0.06 / K, epsilon = 1e-3);
    assert_abs_diff_eq!(during.0.armature_current, 1.25 * 0.06 / K, epsilon = 1e-3);
    // Every part of the load: 1.25 (T0 + b w + q w^2).
    let mut scenario = silent(25.0);
    scenario.load.constant_nm = 0.02;
    scenario.load.viscous_nm_s = 1e-4;
    scenario.load.quadratic_nm_s2 = 1e-7;
    let [_, during, _] = before_during_after(&scenario, gain(FaultPoint::LoadTorque));
    assert_abs_diff_eq!(during.1.load_torque, 1.25 * (0.02 + 0.03 + 0.009), epsilon = 1e-6);
    assert_abs_diff_eq!(during.0.armature_current, 1.25 * 0.059 / K, epsilon = 1e-3);
}

#[test]
fn a_constant_of_the_motor_that_changes_moves_the_loop_to_its_new_steady_state() {
    let gain = |point, amplitude| fault(point, FaultKind::Gain, amplitude);
    let i = 0.06 / K;
    let steady = |point, amplitude| before_during_after(&silent(25.0), gain(point, amplitude));
    // u = R i + K w, i = T / K, with the constant that has changed.
    let [_, during, after] = steady(FaultPoint::ArmatureResistance, 0.5);
    assert_abs_diff_eq!(during.0.armature_current, i, epsilon = 1e-3);
    assert_abs_diff_eq!(during.0.armature_voltage, 1.5 * R * i + K * 300.0, epsilon = 1e-3);
    assert_abs_diff_eq!(after.0.armature_voltage, R * i + K * 300.0, epsilon = 1e-3);
    let [_, during, _] = steady(FaultPoint::TorqueConstant, -0.2);
    assert_abs_diff_eq!(during.0.armature_current, i / 0.8, epsilon = 1e-3);
    assert_abs_diff_eq!(during.0.armature_voltage, R * i / 0.8 + 0.8 * K * 300.0, epsilon = 1e-3);
    // The current controller asks for more, and its output is what is read.
    let [_, during, _] = steady(FaultPoint::VoltageActuator, -0.1);
    assert_abs_diff_eq!(during.0.armature_voltage, (R * i + K * 300.0) / 0.9, epsilon = 1e-3);
    assert_abs_diff_eq!(during.1.armature_voltage, R * i + K * 300.0, epsilon = 1e-3);
    let [before, during, _] = steady(FaultPoint::LoadInertia, 1.0);
    assert_abs_diff_eq!(during.0.speed, before.0.speed, epsilon = 2e-3);
    assert_abs_diff_eq!(during.0.armature_voltage, before.0.armature_voltage, epsilon = 1e-3);
    // Outside of the loop.
    let [_, during, _] = steady(FaultPoint::VoltageSensor, 0.1);
    assert_abs_diff_eq!(during.0.armature_voltage, 1.1 * (R * i + K * 300.0), epsilon = 1e-3);
    assert_abs_diff_eq!(during.1.armature_voltage, R * i + K * 300.0, epsilon = 1e-3);
}

#[test]
fn twice_the_inertia_loses_half_the_speed_in_the_first_moments_of_a_load_step() {
    // 5 ms after the step the loop of 20 rad/s has hardly answered: dw = T t / J.
    let drop = |faults: Vec<Fault>| {
        let mission = run(&Scenario { faults, ..silent(20.0) });
        mission[9_999].1.speed - mission[10_005].1.speed
    };
    let step = fault(FaultPoint::LoadTorque, FaultKind::Offset, 0.03);
    let load = Fault { id: "L".to_owned(), start_s: 10.0, ..step };
    let inertia = fault(FaultPoint::LoadInertia, FaultKind::Gain, 1.0);
    let (light, heavy) = (drop(vec![load.clone()]), drop(vec![load, inertia]));
    assert_abs_diff_eq!(light, 0.03 * 5e-3 / MotorParameters::default().inertia_kg_m2(), epsilon = 0.1);
    assert_abs_diff_eq!(light / heavy, 2.0, epsilon = 0.1);
}

#[test]
fn a_stuck_sensor_repeats_its_last_reading_and_the_loop_acts_on_it() {
    let noisy = Scenario { duration_s: 20.0, ..Scenario::figure_1().without_faults() };
    for (point, of) in [(FaultPoint::SpeedSensor, 0), (FaultPoint::CurrentSensor, 1), (FaultPoint::VoltageSensor, 2)] {
        // Not longer: a loop that sees no error any more integrates what is left of it.
        let stuck = Fault { end_s: 5.2, ..fault(point, FaultKind::Stuck, 1.0) };
        let mission = run(&Scenario { faults: vec![stuck], ..noisy.clone() });
        let readings = |range: Range<usize>| mission[range].iter().map(|(sample, _)| sample.channels()[of]);
        assert!(readings(5_000..5_200).all(|x| x == mission[4_999].0.channels()[of]), "{point:?}");
        assert!(readings(5_200..5_300).any(|x| x != mission[4_999].0.channels()[of]), "{point:?}");
    }
}

#[test]
fn a_slot_without_a_sample_is_missing_to_the_monitor_and_not_to_the_loop() {
    let noisy = Scenario { duration_s: 20.0, ..Scenario::figure_1().without_faults() };
    let missing = fault(FaultPoint::Sampling, FaultKind::Missing, 0.3);
    let lossy = Scenario { faults: vec![missing], ..noisy.clone() };
    let healthy: Vec<_> = Plant::new(&noisy, 1).map(|s| s.channels()).collect();
    let samples: Vec<_> = Plant::new(&lossy, 1).collect();
    assert!(samples.iter().map(|s| s.channels()).eq(healthy));
    let count = samples.iter().filter(|s| s.missing).count();
    // Of 10,000: standard error 46; four of it.
    assert!(count.abs_diff(3000) < 184, "{count}");
    assert!(samples.iter().filter(|s| s.missing).all(|s| (5.0..15.0).contains(&s.t_s)));
}

#[test]
fn a_coarse_sensor_reads_multiples_of_its_step() {
    let coarse = fault(FaultPoint::SpeedSensor, FaultKind::Coarse, 0.5);
    let scenario = Scenario { duration_s: 20.0, faults: vec![coarse], ..Scenario::figure_1() };
    let samples: Vec<_> = Plant::new(&scenario, 1).collect();
    assert!(samples[5_000..15_000].iter().all(|s| (s.speed / 0.5).fract() == 0.0));
    assert!(samples[15_000..].iter().any(|s| (s.speed / 0.5).fract() != 0.0));
}

#[test]
fn a_step_fault_acts_from_its_start_and_is_gone_at_its_end() {
    let f2 = fault(FaultPoint::SpeedSensor, FaultKind::Offset, 8.0);
    let mission = run(&Scenario { faults: vec![f2], ..silent(20.0) });
    let error = |k: usize| mission[k].0.speed - mission[k].1.speed;
    let at = [4_999, 5_000, 14_999, 15_000].map(error);
    for (found, expected) in at.into_iter().zip([0.0, 8.0, 8.0, 0.0]) {
        assert_abs_diff_eq!(found, expected, epsilon = 1e-9);
    }
}

#[test]
fn a_ramp_fault_reaches_the_sensor_with_its_value_of_the_instant() {
    let f2 = fault(FaultPoint::SpeedSensor, FaultKind::Offset, 8.0);
    let mission = run(&Scenario { faults: vec![f2], ..silent(20.0) }.with_ramps());
    for (sample, state) in &mission {
        let expected = if (5.0..15.0).contains(&sample.t_s) { 0.8 * (sample.t_s - 5.0) } else { 0.0 };
        assert_abs_diff_eq!(sample.speed - state.speed, expected, epsilon = 1e-9);
    }
}

#[test]
fn the_same_seed_gives_the_same_mission_and_another_seed_another() {
    let scenario = Scenario { duration_s: 20.0, ..Scenario::figure_1().without_faults() };
    let mission = |seed| Plant::new(&scenario, seed).collect::<Vec<_>>();
    assert_eq!(mission(1), mission(1));
    assert_ne!(mission(1)[..10], mission(2)[..10]);
}

#[test]
fn silencing_the_voltage_sensor_changes_no_other_reading() {
    // Speed and current noise also move the loop; the voltage sensor is outside it.
    let noisy = Scenario { duration_s: 20.0, ..Scenario::figure_1().without_faults() };
    let mut quiet = noisy.clone();
    quiet.noise.voltage_sigma_v = 0.0;
    for (a, b) in Plant::new(&noisy, 3).zip(Plant::new(&quiet, 3)) {
        assert_eq!((a.speed, a.armature_current), (b.speed, b.armature_current));
    }
}

#[test]
fn the_readings_scatter_around_the_truth_with_the_sigma_of_each_sensor() {
    let mission = run(&Scenario { duration_s: 20.0, ..Scenario::figure_1().without_faults() });
    let errors = |of: fn(&(PlantSample, TrueState)) -> f64| mission.iter().map(of);
    let speed = errors(|(sample, state)| sample.speed - state.speed);
    let current = errors(|(sample, state)| sample.armature_current - state.armature_current);
    let voltage = errors(|(sample, state)| sample.armature_voltage - state.armature_voltage);
    // Standard error of a sigma from 20,000 samples: 0.5 %; four of it.
    assert_abs_diff_eq!(sigma(speed.clone()), 0.1, epsilon = 2e-3);
    assert_abs_diff_eq!(sigma(current.clone()), 0.02, epsilon = 4e-4);
    assert_abs_diff_eq!(sigma(voltage.clone()), 0.02, epsilon = 4e-4);
    assert_abs_diff_eq!(mean(speed), 0.0, epsilon = 3e-3);
    assert_abs_diff_eq!(mean(current), 0.0, epsilon = 6e-4);
    assert_abs_diff_eq!(mean(voltage), 0.0, epsilon = 6e-4);
}

#[test]
fn the_noise_of_one_sensor_tells_nothing_about_another() {
    let mission = run(&Scenario { duration_s: 20.0, ..Scenario::figure_1().without_faults() });
    let errors = mission.iter().map(|(sample, state)| {
        [
            (sample.speed - state.speed) / 0.1,
            (sample.armature_current - state.armature_current) / 0.02,
            (sample.armature_voltage - state.armature_voltage) / 0.02,
        ]
    });
    for (a, b) in [(0, 1), (0, 2), (1, 2)] {
        // Standard error of a correlation from 20,000 samples: 0.7 %; four of it.
        assert_abs_diff_eq!(mean(errors.clone().map(|e| e[a] * e[b])), 0.0, epsilon = 0.028);
    }
}

#[test]
fn every_channel_is_quantized_with_its_own_adc_step() {
    let mut scenario = Scenario { duration_s: 20.0, ..Scenario::figure_1().without_faults() };
    scenario.noise.speed_step_rad_per_s = 0.5;
    scenario.noise.current_step_a = 0.25;
    scenario.noise.voltage_step_v = 0.125;
    for sample in Plant::new(&scenario, 1) {
        assert_eq!((sample.speed / 0.5).fract(), 0.0);
        assert_eq!((sample.armature_current / 0.25).fract(), 0.0);
        assert_eq!((sample.armature_voltage / 0.125).fract(), 0.0);
    }
}

#[test]
fn turbulence_moves_the_load_torque_with_its_sigma() {
    let mut scenario = Scenario { duration_s: 60.0, ..silent(60.0) };
    scenario.load.turbulence_sigma_nm = 0.005;
    scenario.load.turbulence_bandwidth_hz = 20.0;
    let mission = run(&scenario);
    let torque = mission.iter().map(|(_, state)| state.load_torque);
    // 60 s at 20 Hz are 60 * 2 pi * 20 = 7500 independent values for a variance: 0.8 % of sigma; four of it.
    assert_abs_diff_eq!(sigma(torque.clone()), 0.005, epsilon = 1.6e-4);
    assert_abs_diff_eq!(mean(torque), 0.06, epsilon = 4e-4);
    let current = mission[5_000..].iter().map(|(sample, _)| sample.armature_current);
    assert!(sigma(current) > 0.01, "the loop answers the turbulence");
}

#[test]
fn the_mission_has_as_many_samples_as_duration_times_rate_and_says_so() {
    let mut plant = Plant::new(&Scenario::figure_1(), 1);
    assert_eq!(plant.len(), 140_000);
    plant.next();
    assert_eq!(plant.len(), 139_999);
    assert_eq!(plant.count(), 139_999);
}

#[test]
fn recording_every_tenth_period_gives_every_tenth_sample_of_the_same_mission() {
    let every = Scenario { duration_s: 20.0, ..Scenario::figure_1().without_faults() };
    let tenth = Scenario { record_every: 10, ..every.clone() };
    let thinned: Vec<_> = Plant::new(&every, 1).step_by(10).collect();
    assert_eq!(Plant::new(&tenth, 1).len(), 2_000);
    assert_eq!(Plant::new(&tenth, 1).collect::<Vec<_>>(), thinned);
    assert_eq!(thinned[123].t_s, 1.23);
}
