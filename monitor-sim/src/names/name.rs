//! What a fault is called, whichever monitor calls it.

use monitor_core::guard::Cause;
use serde::{Deserialize, Serialize};

use crate::fault::FaultPoint;

/// What a monitor may call a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Name {
    /// See [`FaultPoint::LoadTorque`].
    LoadTorque,
    /// See [`FaultPoint::SpeedSensor`].
    SpeedSensor,
    /// See [`FaultPoint::CurrentSensor`].
    CurrentSensor,
    /// See [`FaultPoint::VoltageSensor`].
    VoltageSensor,
    /// See [`FaultPoint::VoltageActuator`].
    VoltageActuator,
    /// See [`FaultPoint::LoadInertia`].
    LoadInertia,
    /// See [`FaultPoint::ArmatureResistance`].
    ArmatureResistance,
    /// See [`FaultPoint::TorqueConstant`].
    TorqueConstant,
    /// A sensor that is stuck or dead, or samples that do not come.
    SensorLoss,
    /// Two faults or more that cannot be told apart here.
    Ambiguous,
    /// No fault that the monitor knows.
    Unknown,
}

impl Name {
    /// All, in the order of the tables.
    pub const ALL: [Self; 11] = [
        Self::LoadTorque,
        Self::SpeedSensor,
        Self::CurrentSensor,
        Self::VoltageSensor,
        Self::VoltageActuator,
        Self::LoadInertia,
        Self::ArmatureResistance,
        Self::TorqueConstant,
        Self::SensorLoss,
        Self::Ambiguous,
        Self::Unknown,
    ];

    /// The right name for a fault at `point`.
    #[must_use]
    pub const fn of(point: FaultPoint) -> Self {
        match point {
            FaultPoint::LoadTorque => Self::LoadTorque,
            FaultPoint::SpeedSensor => Self::SpeedSensor,
            FaultPoint::CurrentSensor => Self::CurrentSensor,
            FaultPoint::VoltageSensor => Self::VoltageSensor,
            FaultPoint::VoltageActuator => Self::VoltageActuator,
            FaultPoint::LoadInertia => Self::LoadInertia,
            FaultPoint::ArmatureResistance => Self::ArmatureResistance,
            FaultPoint::TorqueConstant => Self::TorqueConstant,
            FaultPoint::Sampling => Self::SensorLoss,
        }
    }

    /// The name for a cause that the monitor in `guard` mode knows.
    #[must_use]
    pub const fn of_cause(cause: Cause) -> Self {
        match cause {
            Cause::LoadTorque => Self::LoadTorque,
            Cause::SpeedSensor => Self::SpeedSensor,
            Cause::CurrentSensor => Self::CurrentSensor,
            Cause::Resistance => Self::ArmatureResistance,
            Cause::TorqueConstant => Self::TorqueConstant,
            Cause::Supply => Self::VoltageActuator,
            _ => Self::Unknown,
        }
    }

    /// The identifier in tables, traces and JSON: the paper's number, or a letter.
    #[must_use]
    pub const fn id(self) -> &'static str {
        match self {
            Self::LoadTorque => "F1",
            Self::SpeedSensor => "F2",
            Self::CurrentSensor => "F3",
            Self::VoltageSensor => "V",
            Self::VoltageActuator => "U",
            Self::LoadInertia => "J",
            Self::ArmatureResistance => "R",
            Self::TorqueConstant => "K",
            Self::SensorLoss | Self::Ambiguous | Self::Unknown => self.words(),
        }
    }

    /// Identifier and words.
    #[must_use]
    pub fn shown(self) -> String {
        match self {
            Self::SensorLoss | Self::Ambiguous | Self::Unknown => self.words().to_owned(),
            _ => format!("{} {}", self.id(), self.words()),
        }
    }

    /// Unit of the size that the monitor gives a fault of this name.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::LoadTorque => FaultPoint::LoadTorque.unit(),
            Self::SpeedSensor => FaultPoint::SpeedSensor.unit(),
            Self::CurrentSensor => FaultPoint::CurrentSensor.unit(),
            Self::VoltageSensor | Self::VoltageActuator => FaultPoint::VoltageActuator.unit(),
            Self::LoadInertia => FaultPoint::LoadInertia.unit(),
            Self::ArmatureResistance => FaultPoint::ArmatureResistance.unit(),
            Self::TorqueConstant => FaultPoint::TorqueConstant.unit(),
            Self::SensorLoss | Self::Ambiguous | Self::Unknown => "",
        }
    }

    /// In words.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::LoadTorque => "load torque",
            Self::SpeedSensor => "speed sensor",
            Self::CurrentSensor => "current sensor",
            Self::VoltageSensor => "voltage sensor",
            Self::VoltageActuator => "voltage actuator",
            Self::LoadInertia => "load inertia",
            Self::ArmatureResistance => "armature resistance",
            Self::TorqueConstant => "torque constant",
            Self::SensorLoss => "sensor loss",
            Self::Ambiguous => "ambiguous",
            Self::Unknown => "unknown",
        }
    }
}
