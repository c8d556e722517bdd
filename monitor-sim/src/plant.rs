//! The whole of the paper's figure 2, run: set point, cascade, motor, sensors, and faults where they enter.

use crate::controller::{Cascade, CascadeState};
use crate::exponential::ExponentialMotor;
use crate::fault::{ActingFaults, Actions, Fault, FaultPoint, Injection};
use crate::motor::{Load, Motor, MotorParameters, MotorState};
use crate::noise::{GaussMarkov, Sensor, Stream};
use crate::scenario::{Scenario, SetPoint, Start, set_point_at};

/// What the drive reads in one control period: measured values, with noise, ADC step and sensor faults.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlantSample {
    /// Instant of the sample, s.
    pub t_s: f64,
    /// Speed set point in force, rad/s.
    pub set_point: f64,
    /// Speed, rad/s.
    pub speed: f64,
    /// Armature current, A.
    pub armature_current: f64,
    /// Armature voltage (output of the current controller), V.
    pub armature_voltage: f64,
    /// The monitor gets no sample in this slot: a fault of the sampling. The readings are those of the drive.
    pub missing: bool,
}

impl PlantSample {
    /// Speed (rad/s), armature current (A), armature voltage (V).
    #[must_use]
    pub fn channels(&self) -> [f64; 3] {
        [self.speed, self.armature_current, self.armature_voltage]
    }
}

/// What no sensor shows: the true values at the instant of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrueState {
    /// Shaft speed, rad/s.
    pub speed: f64,
    /// Armature current, A.
    pub armature_current: f64,
    /// Armature voltage from this instant until the next control period, V.
    pub armature_voltage: f64,
    /// Load torque with turbulence and faults, N m.
    pub load_torque: f64,
}

/// A mission under way: an iterator over its samples.
///
/// Sample k is taken at t = k / [`Scenario::rate_hz`], before the plant moves on; the controllers run on every control
/// period, recorded or not. The number of samples is duration times rate, rounded to a whole.
/// The same scenario and seed give the same samples.
#[derive(Debug, Clone)]
pub struct Plant {
    cascade: Cascade,
    motor: Motor,
    /// Takes the place of `motor` in long studies.
    exponential: Option<ExponentialMotor>,
    parameters: MotorParameters,
    load: Load,
    set_points: Vec<SetPoint>,
    faults: ActingFaults,
    control_rate_hz: f64,
    record_every: u32,

    /// None where there is none: a draw costs as much as a sensor's.
    turbulence: Option<GaussMarkov>,
    speed_sensor: Sensor,
    current_sensor: Sensor,
    voltage_sensor: Sensor,
    cascade_state: CascadeState,
    motor_state: MotorState,
    /// Held from one control period to the next.
    armature_voltage: f64,
    held_load: Load,
    /// The motor of this period, if its constants are not those it was designed for.
    faulty_motor: Option<Motor>,
    /// Last readings: speed, current, voltage.
    last: [f64; 3],
    /// Control periods begun.
    period: u64,
    samples_left: usize,
}

impl Plant {
    /// The plant of `scenario` at time 0. `seed` chooses the noise and turbulence of this mission.
    ///
    /// Expects a scenario that [`Scenario::validate`] accepts; another one runs to no useful end, but does not panic.
    #[must_use]
    pub fn new(scenario: &Scenario, seed: u64) -> Self {
        let (noise, load) = (&scenario.noise, &scenario.load);
        let period_s = 1.0 / scenario.control_rate_hz;
        let sensor = |stream, sigma, step| Sensor::new(seed, stream, sigma, step);
        let (motor_state, cascade_state) = match scenario.start {
            Start::Standstill => Default::default(),
            Start::Steady => {
                let (state, voltage) = scenario.motor.steady_state(scenario.set_point(0.0), &load.mean());
                (state, CascadeState::at_rest_with(state.armature_current, voltage))
            }
        };
        Self {
            cascade: Cascade::new(&scenario.controller, &scenario.motor, period_s),
            motor: Motor::new(&scenario.motor, period_s),
            exponential: None,
            parameters: scenario.motor,
            load: load.mean(),
            set_points: scenario.set_points.clone(),
            faults: ActingFaults::new(seed, &scenario.faults),
            control_rate_hz: scenario.control_rate_hz,
            record_every: scenario.record_every,
            turbulence: (load.turbulence_sigma_nm > 0.0).then(|| {
                let (sigma, bandwidth_hz) = (load.turbulence_sigma_nm, load.turbulence_bandwidth_hz);
                GaussMarkov::new(seed, Stream::Turbulence, sigma, bandwidth_hz, period_s)
            }),
            speed_sensor: sensor(Stream::Speed, noise.speed_sigma_rad_per_s, noise.speed_step_rad_per_s),
            current_sensor: sensor(Stream::ArmatureCurrent, noise.current_sigma_a, noise.current_step_a),
            voltage_sensor: sensor(Stream::ArmatureVoltage, noise.voltage_sigma_v, noise.voltage_step_v),
            cascade_state,
            motor_state,
            armature_voltage: 0.0,
            held_load: load.mean(),
            faulty_motor: None,
            last: [motor_state.speed, motor_state.armature_current, cascade_state.current.integral],
            period: 0,
            samples_left: (scenario.duration_s * scenario.rate_hz()).round() as usize,
        }
    }

    /// The same plant for long studies: the motor is solved over each control period at once
    /// ([`ExponentialMotor`]) while its constants are healthy. Equal to [`new`](Self::new) but for the error of
    /// integration of either.
    #[must_use]
    pub fn exponential(scenario: &Scenario, seed: u64) -> Self {
        let (load, speed, period_s) = (scenario.load.mean(), scenario.set_point(0.0), 1.0 / scenario.control_rate_hz);
        let motor = ExponentialMotor::new(&scenario.motor, &load, speed, period_s);
        Self { exponential: Some(motor), ..Self::new(scenario, seed) }
    }

    /// From now on with these faults in place of its own. `seed` is the mission's, for faults that act at random.
    #[must_use]
    pub fn with_faults(self, seed: u64, faults: &[Fault]) -> Self {
        Self { faults: ActingFaults::new(seed, faults), ..self }
    }

    /// The true values at the instant of the sample returned last.
    #[must_use]
    pub fn true_state(&self) -> TrueState {
        TrueState {
            speed: self.motor_state.speed,
            armature_current: self.motor_state.armature_current,
            armature_voltage: self.armature_voltage,
            load_torque: self.held_load.torque(self.motor_state.speed),
        }
    }

    /// One control period up to the moment the voltage is set: read, control, and fix the load until the next.
    fn control(&mut self) -> PlantSample {
        // The division keeps t exact where k periods are a whole number of seconds; a running sum would not.
        let t_s = self.period as f64 / self.control_rate_hz;
        self.period += 1;
        let faults = self.faults.at(t_s);
        let MotorState { speed, armature_current } = self.motor_state;
        let [last_speed, last_current, last_voltage] = &mut self.last;
        let read = |sensor: &mut Sensor, truth, point, last| {
            let fault = faults.on(point);
            fault.hold(sensor.read(truth, |x| fault.apply(x)), last)
        };

        let set_point = set_point_at(&self.set_points, t_s);
        let speed = read(&mut self.speed_sensor, speed, FaultPoint::SpeedSensor, last_speed);
        let current = read(&mut self.current_sensor, armature_current, FaultPoint::CurrentSensor, last_current);
        let wanted = self.cascade.step(&mut self.cascade_state, set_point, speed, current);
        self.armature_voltage = faults.on(FaultPoint::VoltageActuator).apply(wanted);
        let turbulence = self.turbulence.as_mut().map_or(0.0, GaussMarkov::draw);
        self.held_load = faulty_load(&self.load, turbulence, faults.on(FaultPoint::LoadTorque));
        self.faulty_motor = faulty_motor(&self.parameters, faults, 1.0 / self.control_rate_hz);
        PlantSample {
            t_s,
            set_point,
            speed,
            armature_current: current,
            armature_voltage: read(&mut self.voltage_sensor, wanted, FaultPoint::VoltageSensor, last_voltage),
            missing: faults.missing,
        }
    }

    /// The motor moves on to the next control period.
    fn advance(&mut self) {
        let (x, voltage, load) = (self.motor_state, self.armature_voltage, &self.held_load);
        self.motor_state = match (&self.faulty_motor, &self.exponential) {
            (Some(faulty), _) => faulty.advance(x, voltage, load),
            (None, Some(healthy)) => healthy.advance(x, voltage, load),
            (None, None) => self.motor.advance(x, voltage, load),
        };
    }
}

impl Iterator for Plant {
    type Item = PlantSample;

    fn next(&mut self) -> Option<PlantSample> {
        self.samples_left = self.samples_left.checked_sub(1)?;
        if self.period == 0 {
            return Some(self.control());
        }
        // Up to this sample the loop closes as often as periods go unrecorded.
        for _ in 1..self.record_every {
            self.advance();
            self.control();
        }
        self.advance();
        Some(self.control())
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.samples_left, Some(self.samples_left))
    }
}

impl ExactSizeIterator for Plant {}

impl std::iter::FusedIterator for Plant {}

/// The load with `turbulence` (N m) and a fault. The fault acts on the whole torque, T -> T * factor + offset, which
/// makes a load of the same form.
fn faulty_load(load: &Load, turbulence: f64, fault: &Injection) -> Load {
    Load {
        constant_nm: fault.apply(load.constant_nm + turbulence),
        viscous_nm_s: fault.factor * load.viscous_nm_s,
        quadratic_nm_s2: fault.factor * load.quadratic_nm_s2,
    }
}

/// What overlapping faults leave of a constant at least, as a share of it: a motor without inertia or resistance has no
/// equations.
const LEAST_REMAINDER: f64 = 0.01;

/// The motor with its constants as faults have changed them; none if they have not. Controllers keep the gains they were
/// designed with.
fn faulty_motor(healthy: &MotorParameters, faults: &Actions, period_s: f64) -> Option<Motor> {
    use FaultPoint::{ArmatureResistance, LoadInertia, TorqueConstant};
    if [ArmatureResistance, LoadInertia, TorqueConstant].iter().all(|point| *faults.on(*point) == Injection::NONE) {
        return None;
    }
    let changed = |point, constant: f64| faults.on(point).apply(constant).max(LEAST_REMAINDER * constant);
    let parameters = MotorParameters {
        resistance_ohm: changed(ArmatureResistance, healthy.resistance_ohm),
        inductance_h: healthy.inductance_h,
        torque_constant_nm_per_a: changed(TorqueConstant, healthy.torque_constant_nm_per_a),
        rotor_inertia_kg_m2: changed(LoadInertia, healthy.inertia_kg_m2()),
        added_inertia_kg_m2: 0.0,
    };
    Some(Motor::new(&parameters, period_s))
}
