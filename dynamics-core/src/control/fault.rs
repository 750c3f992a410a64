//! Numbered reasons to stop: the controller's own, 1 to 7, and those of the state machine around it, from 8.

use core::fmt;

/// Why the controller stopped. Numbers are stable: they are what telemetry carries.
///
/// | code | fault | what to look at |
/// |---|---|---|
/// | 1 | a measured position, velocity or age gives NaN or infinity | the sensor, its cable, the frame decoder |
/// | 2 | a reference value is NaN or infinite | the source of the reference |
/// | 3 | the measurement is older than allowed | the link, the sensor's rate |
/// | 4 | a joint is outside its position limits | the reference, the homing offset |
/// | 5 | a joint is faster than allowed | gains, payload, the encoder's scale |
/// | 6 | a tick had not ended when the next was due | the rate, other interrupts |
/// | 7 | a computed torque is NaN or infinite | the model's numbers, the size of the reference |
/// | 8 | a joint was measured farther from its last position than it can have moved | the encoder, its cable; the arm must be homed again |
/// | 9 | the emergency stop is pressed | the person who pressed it |
/// | 10 | the host was silent for longer than the arm holds | the host, the link |
/// | 11 | a drive reports a fault | the drive's own diagnosis |
/// | 12 | the supply voltage is outside its bounds | the supply, a brake resistor |
/// | 13 | a temperature is outside its bounds | cooling, the load |
/// | 14 | a joint has felt a collision | the arm's surroundings; the payload, the friction and the thresholds |
/// | 15 | a joint is out of reach of where the arm holds | whoever pushes it; payload, wrench and rotors told; the model |
/// | 16 | a joint would need more than its torque limit to hold the arm | payload, wrench and gravity told; the posture |
/// | 17 | a drive did not come on when the arm was armed | its power, its bus, its own error |
/// | 18 | a drive went off while torque acted | its power, its protections (current, voltage, temperature) |
/// | 19 | a drive lost its zero while torque acted | its power; the arm must be homed again |
/// | 20 | a joint is too hot by its heat model | the load, the posture, pauses |
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
    /// This joint was measured farther from its last position than it can have moved.
    ImpossibleJump {
        /// Joint, counted from 0.
        joint: u8,
    },
    /// The emergency stop is pressed.
    EmergencyStop,
    /// The host was silent for longer than the arm holds without it.
    HeartbeatLost,
    /// The drive of this joint reports a fault.
    DriveFault {
        /// Joint, counted from 0.
        joint: u8,
    },
    /// The supply voltage is outside its bounds.
    SupplyOutOfBounds,
    /// A temperature is outside its bounds.
    TemperatureOutOfBounds,
    /// The external torque on this joint is above its threshold, and the configuration asks to stop.
    Collision {
        /// Joint, counted from 0.
        joint: u8,
    },
    /// This joint is farther than its reach from where it should stand, or from the way of its stop; or it lagged for too long while the arm was
    /// lowered without a host.
    FollowingError {
        /// Joint, counted from 0.
        joint: u8,
    },
    /// This joint's torque limit is too small to hold the arm where it was to be armed, by the model and the live inputs.
    Overload {
        /// Joint, counted from 0.
        joint: u8,
    },
    /// The drive of this joint did not show in time that it is on.
    DriveNotOn {
        /// Joint, counted from 0.
        joint: u8,
    },
    /// The drive of this joint went off while torque acted.
    DriveOff {
        /// Joint, counted from 0.
        joint: u8,
    },
    /// A drive may have lost its zero while torque acted.
    ZeroLost,
    /// This joint is too hot, by its heat model.
    Overheated {
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
            Self::ImpossibleJump { .. } => 8,
            Self::EmergencyStop => 9,
            Self::HeartbeatLost => 10,
            Self::DriveFault { .. } => 11,
            Self::SupplyOutOfBounds => 12,
            Self::TemperatureOutOfBounds => 13,
            Self::Collision { .. } => 14,
            Self::FollowingError { .. } => 15,
            Self::Overload { .. } => 16,
            Self::DriveNotOn { .. } => 17,
            Self::DriveOff { .. } => 18,
            Self::ZeroLost => 19,
            Self::Overheated { .. } => 20,
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
            | Self::ImpossibleJump { joint }
            | Self::DriveFault { joint }
            | Self::Collision { joint }
            | Self::FollowingError { joint }
            | Self::Overload { joint }
            | Self::DriveNotOn { joint }
            | Self::DriveOff { joint }
            | Self::Overheated { joint } => Some(joint),
            Self::StaleMeasurement
            | Self::Overrun
            | Self::EmergencyStop
            | Self::HeartbeatLost
            | Self::SupplyOutOfBounds
            | Self::TemperatureOutOfBounds
            | Self::ZeroLost => None,
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
            8 => Self::ImpossibleJump { joint },
            9 => Self::EmergencyStop,
            10 => Self::HeartbeatLost,
            11 => Self::DriveFault { joint },
            12 => Self::SupplyOutOfBounds,
            13 => Self::TemperatureOutOfBounds,
            14 => Self::Collision { joint },
            15 => Self::FollowingError { joint },
            16 => Self::Overload { joint },
            17 => Self::DriveNotOn { joint },
            18 => Self::DriveOff { joint },
            19 => Self::ZeroLost,
            20 => Self::Overheated { joint },
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
            Self::ImpossibleJump { .. } => "measured position jumped farther than the joint can move",
            Self::EmergencyStop => "emergency stop",
            Self::HeartbeatLost => "the host was silent for too long",
            Self::DriveFault { .. } => "the drive reports a fault",
            Self::SupplyOutOfBounds => "supply voltage out of bounds",
            Self::TemperatureOutOfBounds => "temperature out of bounds",
            Self::Collision { .. } => "collision",
            Self::FollowingError { .. } => "the joint is out of reach of where the arm holds",
            Self::Overload { .. } => "the joint cannot hold what the arm carries",
            Self::DriveNotOn { .. } => "the drive did not come on",
            Self::DriveOff { .. } => "the drive went off while torque acted",
            Self::ZeroLost => "a drive may have lost its zero while torque acted",
            Self::Overheated { .. } => "the joint is too hot",
        };
        write!(f, "fault {}: {what}", self.code())?;
        match self.joint() {
            Some(joint) => write!(f, " (joint {})", u32::from(joint) + 1),
            None => Ok(()),
        }
    }
}
