//! Parameters of a RobStride motor. Source: the maker's manuals, "read and write single parameters".

use super::motors::Value;

/// Kind of a parameter's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Byte,
    Integer,
    Float,
}

/// A parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameter {
    pub(super) index: u16,
    kind: Kind,
    /// Name for users.
    pub name: &'static str,
    /// Unit of the shown value.
    pub unit: &'static str,
}

impl Parameter {
    const fn new(index: u16, kind: Kind, name: &'static str, unit: &'static str) -> Self {
        Self { index, kind, name, unit }
    }

    /// The value in these bytes, low byte first. The bytes after a value of one byte mean nothing.
    pub(super) fn value(self, bytes: [u8; 4]) -> Value {
        match self.kind {
            Kind::Byte => Value::Integer(bytes[0].into()),
            Kind::Integer => Value::Integer(u32::from_le_bytes(bytes)),
            Kind::Float => Value::Float(f32::from_le_bytes(bytes)),
        }
    }
}

pub(super) const POSITION: Parameter = Parameter::new(0x7019, Kind::Float, "position", "rad");
pub(super) const TIMEOUT: Parameter = Parameter::new(0x7028, Kind::Integer, "communication timeout", "x 50 us");
pub(super) const TORQUE_LIMIT: Parameter = Parameter::new(0x700B, Kind::Float, "torque limit", "N m");
pub(super) const POWER_UP_RANGE: Parameter =
    Parameter::new(0x7029, Kind::Byte, "power-up range (0: 0 to 2pi, 1: ±pi)", "");

/// Parameters that are shown.
pub const SHOWN: [Parameter; 8] = [
    POSITION,
    Parameter::new(0x701B, Kind::Float, "velocity", "rad/s"),
    Parameter::new(0x701C, Kind::Float, "supply", "V"),
    TIMEOUT,
    Parameter::new(0x7005, Kind::Byte, "control mode (0 MIT)", ""),
    TORQUE_LIMIT,
    Parameter::new(0x7018, Kind::Float, "current limit of other modes", "A"),
    POWER_UP_RANGE,
];
