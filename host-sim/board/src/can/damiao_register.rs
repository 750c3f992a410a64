//! Registers of a Damiao motor. Source: the maker's `DM_CAN.py` (`DM_variable`).

use super::motors::Value;

/// Kind of a register's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Float,
    Integer,
}

impl Kind {
    /// The value with these bits.
    pub(super) fn value(self, bits: u32) -> Value {
        match self {
            Self::Float => Value::Float(f32::from_bits(bits)),
            Self::Integer => Value::Integer(bits),
        }
    }
}

/// A register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Register {
    pub(super) number: u8,
    pub(super) kind: Kind,
    /// Name for users.
    pub name: &'static str,
    /// Unit of the shown value.
    pub unit: &'static str,
}

const fn register(number: u8, kind: Kind, name: &'static str, unit: &'static str) -> Register {
    Register { number, kind, name, unit }
}

/// Registers of the identifiers and of the communication timeout.
pub(super) const REPLY_ID: Register = register(7, Kind::Integer, "identifier of replies", "");
pub(super) const ID: Register = register(8, Kind::Integer, "identifier", "");
pub(super) const TIMEOUT: Register = register(9, Kind::Integer, "communication timeout", "x 50 us");

pub(super) const MODE: Register = register(10, Kind::Integer, "control mode (1 MIT)", "");

/// Highest position of the frames, rad; the lowest is its negative.
pub const POSITION_RANGE: Register = register(21, Kind::Float, "position range of the frames", "rad");
/// Highest velocity of the frames, rad/s.
pub const VELOCITY_RANGE: Register = register(22, Kind::Float, "velocity range of the frames", "rad/s");
/// Highest torque of the frames, N m.
pub const TORQUE_RANGE: Register = register(23, Kind::Float, "torque range of the frames", "N m");

/// Registers that are shown.
pub const SHOWN: [Register; 16] = [
    ID,
    REPLY_ID,
    TIMEOUT,
    MODE,
    POSITION_RANGE,
    VELOCITY_RANGE,
    TORQUE_RANGE,
    register(20, Kind::Float, "gear", ""),
    register(1, Kind::Float, "torque constant", "N m/A"),
    register(0, Kind::Float, "lowest supply", "V"),
    register(29, Kind::Float, "highest supply", "V"),
    register(2, Kind::Float, "highest winding temperature", "degrees Celsius"),
    register(3, Kind::Float, "largest current, share of the range", ""),
    register(13, Kind::Integer, "hardware version", ""),
    register(14, Kind::Integer, "firmware version", ""),
    register(35, Kind::Integer, "bit rate (4 is 1 Mbit/s)", ""),
];
