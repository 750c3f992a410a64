//! Numbered reasons to stop.

use core::fmt;

/// Why the controller stopped. Numbers are stable: they are what telemetry carries.
///
/// | code | fault | what to look at |
/// |---|---|---|
/// | 1 | a measured position, velocity or age makes no number | the sensor, its cable, the frame decoder |
/// | 2 | a reference value is NaN or infinite | whoever makes the reference |
/// | 3 | the measurement is older than allowed | the link, the sensor's rate |
/// | 4 | a joint is outside its position limits | the reference, the homing offset |
/// | 5 | a joint is faster than allowed | gains, payload, the encoder's scale |
/// | 6 | a tick had not ended when the next was due | the rate, other interrupts |
/// | 7 | a computed torque is NaN or infinite | the model's numbers, the size of the reference |
/// | 14 | a joint has felt a collision | the arm's surroundings; the payload, the friction and the thresholds |
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// A measured value is NaN or infinite on this joint.
    NonFiniteMeasurement {
        /// Joint, counted from 0.
        joint: u8,
    },
    /// A reference value is NaN or infinite on this joint.
    NonFiniteReference {
        /// Joint, counted from 0.
        joint: u8,
    },
    /// The measurement is older than the guard allows.
    StaleMeasurement,
    /// A joint is outside its position limits by more than the guard's margin.
    PositionOutOfBounds {
        /// Joint, counted from 0.
        joint: u8,
    },
    /// A joint is faster than the guard allows.
    VelocityOutOfBounds {
        /// Joint, counted from 0.
        joint: u8,
    },
    /// A tick had not ended when the next was due.
    Overrun,
    /// A computed torque is NaN or infinite on this joint.
    NonFiniteTorque {
        /// Joint, counted from 0.
        joint: u8,
    },
    /// The external torque on this joint is above its threshold, and the configuration asks to stop.
    Collision {
        /// Joint, counted from 0.
        joint: u8,
    },
}

impl Fault {
    /// The stable number.
    #[must_use]
    pub const fn code(&self) -> u8 {
        match self {
            Self::NonFiniteMeasurement { .. } => 1,
            Self::NonFiniteReference { .. } => 2,
            Self::StaleMeasurement => 3,
            Self::PositionOutOfBounds { .. } => 4,
            Self::VelocityOutOfBounds { .. } => 5,
            Self::Overrun => 6,
            Self::NonFiniteTorque { .. } => 7,
            Self::Collision { .. } => 14,
        }
    }

    /// The joint at fault, counted from 0, if it is one joint's.
    #[must_use]
    pub const fn joint(&self) -> Option<u8> {
        match *self {
            Self::NonFiniteMeasurement { joint }
            | Self::NonFiniteReference { joint }
            | Self::PositionOutOfBounds { joint }
            | Self::VelocityOutOfBounds { joint }
            | Self::NonFiniteTorque { joint }
            | Self::Collision { joint } => Some(joint),
            Self::StaleMeasurement | Self::Overrun => None,
        }
    }

    /// The fault with this number, on this joint where it is one joint's. The inverse of [`Fault::code`] and [`Fault::joint`].
    #[must_use]
    pub const fn from_code(code: u8, joint: u8) -> Option<Self> {
        Some(match code {
            1 => Self::NonFiniteMeasurement { joint },
            2 => Self::NonFiniteReference { joint },
            3 => Self::StaleMeasurement,
            4 => Self::PositionOutOfBounds { joint },
            5 => Self::VelocityOutOfBounds { joint },
            6 => Self::Overrun,
            7 => Self::NonFiniteTorque { joint },
            14 => Self::Collision { joint },
            _ => return None,
        })
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self {
            Self::NonFiniteMeasurement { .. } => "measurement is not a finite number",
            Self::NonFiniteReference { .. } => "reference is not a finite number",
            Self::StaleMeasurement => "measurement is stale",
            Self::PositionOutOfBounds { .. } => "position out of bounds",
            Self::VelocityOutOfBounds { .. } => "velocity out of bounds",
            Self::Overrun => "control tick overran",
            Self::NonFiniteTorque { .. } => "computed torque is not a finite number",
            Self::Collision { .. } => "collision",
        };
        write!(f, "fault {}: {what}", self.code())?;
        match self.joint() {
            Some(joint) => write!(f, " (joint {})", u32::from(joint) + 1),
            None => Ok(()),
        }
    }
}
