//! A mission as data: motor, load, controller, noise, set-point schedule and fault schedule, read from TOML.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::controller::ControllerParameters;
use crate::fault::{Fault, FaultKind, FaultPoint, FaultProfile};
use crate::motor::{LoadParameters, MotorParameters};
use crate::noise::NoiseParameters;

mod locate;
mod validate;

/// The scenario of the paper's figure 1 as TOML, with every key and its comment: the file to start from. It reads as
/// [`Scenario::figure_1`].
pub const FIGURE_1_TOML: &str = include_str!("../scenarios/figure-1.toml");

/// One mission. Only `name` and `duration_s` must be given in TOML; unknown keys are refused.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Name for people.
    pub name: String,
    /// Length of the mission, s.
    pub duration_s: f64,
    /// Rate of the control loop, Hz. Default 1000.
    #[serde(default = "default_control_rate_hz")]
    pub control_rate_hz: f64,
    /// Every how many control periods a sample is recorded, at least 1. Default 1.
    #[serde(default = "default_record_every")]
    pub record_every: u32,
    /// State of plant and controllers at time 0. Default [`Start::Standstill`].
    #[serde(default)]
    pub start: Start,
    /// Fault-free window the monitor learns from. Default 5 s to 20 s (the paper's section III.B).
    #[serde(default)]
    pub learn: LearnWindow,
    /// The motor with its propeller.
    #[serde(default)]
    pub motor: MotorParameters,
    /// The load on its shaft.
    #[serde(default)]
    pub load: LoadParameters,
    /// The drive.
    #[serde(default)]
    pub controller: ControllerParameters,
    /// The sensors.
    #[serde(default)]
    pub noise: NoiseParameters,
    /// Set-point steps in order of time, the first at 0 s. Default 300 rad/s throughout. TOML: `[[set_point]]`.
    #[serde(rename = "set_point", default = "default_set_points")]
    pub set_points: Vec<SetPoint>,
    /// Faults in any order; they may overlap. Default none. TOML: `[[fault]]`.
    #[serde(rename = "fault", default)]
    pub faults: Vec<Fault>,
}

/// State of plant and controllers at time 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Start {
    /// At rest without current, integrals empty: the start-up transient is part of the mission.
    #[default]
    Standstill,
    /// Turning at the first set point, everything settled.
    Steady,
}

/// Half-open interval of time, s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LearnWindow {
    /// First instant, s.
    pub start_s: f64,
    /// First instant after it, s.
    pub end_s: f64,
}

impl Default for LearnWindow {
    fn default() -> Self {
        Self { start_s: 5.0, end_s: 20.0 }
    }
}

/// One step of the set-point schedule.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SetPoint {
    /// From this instant on, s.
    pub at_s: f64,
    /// Speed set point, rad/s.
    pub rad_per_s: f64,
}

/// Set point in force at `t_s` seconds, rad/s; 0 before the first.
pub(crate) fn set_point_at(set_points: &[SetPoint], t_s: f64) -> f64 {
    // By halves: a mission of hours has hundreds.
    let in_force = set_points.partition_point(|step| step.at_s <= t_s).checked_sub(1);
    in_force.and_then(|n| set_points.get(n)).map_or(0.0, |step| step.rad_per_s)
}

fn default_control_rate_hz() -> f64 {
    1000.0
}

fn default_record_every() -> u32 {
    1
}

/// 300 rad/s = 2865 rpm: 9.66 V of the RE 40's 24 V, so that the faults' effects stay far from the supply.
fn default_set_points() -> Vec<SetPoint> {
    vec![SetPoint { at_s: 0.0, rad_per_s: 300.0 }]
}

/// Why a scenario is refused.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ScenarioError {
    /// Not TOML, or a key that is unknown, missing or of another type. The message shows the line and lists the allowed
    /// keys.
    #[error("{0}")]
    Toml(#[from] toml::de::Error),
    /// A value that no mission can have.
    #[error("{}`{key}` {problem}; {remedy}", line.map(|n| format!("line {n}: ")).unwrap_or_default())]
    Value {
        /// Dotted path of the key; list entries count from 0: `fault[1].end_s`.
        key: String,
        /// Line in the text (from 1) of the key, or of its table where the key is left out. `None` if not read from
        /// text.
        line: Option<usize>,
        /// What is wrong with it.
        problem: String,
        /// What to do.
        remedy: String,
    },
}

impl Scenario {
    /// The paper's figure 1: 140 s, learning from 5 s to 20 s, F1 from 20 s to 40 s, F2 from 60 s to 80 s, F3 from 100
    /// s to 120 s, as steps. Amplitudes are ours, the paper gives none.
    ///
    /// Built here and not read from [`FIGURE_1_TOML`], so that it cannot fail; a test keeps the two equal.
    #[must_use]
    pub fn figure_1() -> Self {
        let fault = |id: &str, name: &str, point, amplitude, start_s: f64| Fault {
            id: id.to_owned(),
            name: name.to_owned(),
            point,
            kind: FaultKind::Offset,
            profile: FaultProfile::Step,
            amplitude,
            start_s,
            // Both tables of the paper print 104.07 as the end of fault 3; see the TOML file for our reading.
            end_s: start_s + 20.0,
            share: 1.0,
        };
        Self {
            name: "figure 1".to_owned(),
            duration_s: 140.0,
            control_rate_hz: default_control_rate_hz(),
            record_every: default_record_every(),
            start: Start::default(),
            learn: LearnWindow::default(),
            motor: MotorParameters::default(),
            load: LoadParameters::default(),
            controller: ControllerParameters::default(),
            noise: NoiseParameters::default(),
            set_points: default_set_points(),
            faults: vec![
                // N m: half the load, 0.03/0.0302 = 1 A.
                fault("F1", "load torque", FaultPoint::LoadTorque, 0.03, 20.0),
                // rad/s: 2.7 % of the set point.
                fault("F2", "speed sensor", FaultPoint::SpeedSensor, 8.0, 60.0),
                // A: a quarter of the current.
                fault("F3", "armature current sensor", FaultPoint::CurrentSensor, 0.5, 100.0),
            ],
        }
    }

    /// Reads and validates a scenario.
    ///
    /// # Errors
    /// [`ScenarioError::Toml`] for text that is no scenario, [`ScenarioError::Value`] for what
    /// [`validate`](Self::validate) refuses, with the line.
    pub fn from_toml(text: &str) -> Result<Self, ScenarioError> {
        let scenario: Self = toml::from_str(text)?;
        scenario.validate().map_err(|error| locate::with_line(error, text))?;
        Ok(scenario)
    }

    /// Refuses what no mission can have: non-finite and (where meaningless) negative values, empty intervals, faults
    /// and learning outside the mission, set points the supply cannot reach, loops the control rate cannot run.
    ///
    /// # Errors
    /// [`ScenarioError::Value`] for the first such value.
    pub fn validate(&self) -> Result<(), ScenarioError> {
        validate::check(self)
    }

    /// Rate of the recorded samples, which is the monitor's, Hz.
    #[must_use]
    pub fn rate_hz(&self) -> f64 {
        self.control_rate_hz / f64::from(self.record_every)
    }

    /// Set point in force at `t_s` seconds, rad/s; 0 before the first.
    #[must_use]
    pub fn set_point(&self, t_s: f64) -> f64 {
        set_point_at(&self.set_points, t_s)
    }

    /// The same mission with every fault growing from 0 to its amplitude (the paper's last figure).
    #[must_use]
    pub fn with_ramps(&self) -> Self {
        self.with_each_fault(|fault| fault.profile = FaultProfile::Ramp)
    }

    /// The same mission with every amplitude times `factor`.
    #[must_use]
    pub fn scaled_faults(&self, factor: f64) -> Self {
        self.with_each_fault(|fault| fault.amplitude *= factor)
    }

    /// The same mission without faults.
    #[must_use]
    pub fn without_faults(&self) -> Self {
        Self { faults: Vec::new(), ..self.clone() }
    }

    /// The same mission with a purely viscous load of the same torque at the first set point: 0.06 N m at 300 rad/s
    /// becomes 2e-4 N m s. The paper's fault table fails on it. Unchanged if the first set point is 0, where no viscous
    /// load brakes.
    #[must_use]
    pub fn with_speed_dependent_load(&self) -> Self {
        let speed = self.set_point(0.0);
        if speed == 0.0 {
            return self.clone();
        }
        let load = LoadParameters {
            constant_nm: 0.0,
            viscous_nm_s: self.load.mean().torque(speed) / speed,
            quadratic_nm_s2: 0.0,
            ..self.load
        };
        Self { load, ..self.clone() }
    }

    fn with_each_fault(&self, change: impl FnMut(&mut Fault)) -> Self {
        let mut scenario = self.clone();
        scenario.faults.iter_mut().for_each(change);
        scenario
    }
}
