//! Reports of a board: state, action of the drives, readings and costs.

use super::request::Denial;
use super::values::{Cost, Joints, Reference, Sensed};
use crate::state::StateCode;
use dynamics_core::control;
use dynamics_core::safety::HoldCause;
use serde::{Deserialize, Serialize};

/// State of a board's input lines: everything it senses except the joints' readings.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "PackedLines", into = "PackedLines")]
pub struct Lines {
    /// The emergency stop is pressed, or its wire is broken.
    pub emergency_stop: bool,
    /// The previous tick had not ended when this one was due.
    pub overrun: bool,
    /// Every joint knows its zero.
    pub zeroed: bool,
    /// Joints with a drive that reports a fault: bit 0 is the first.
    pub drive_fault: u8,
    /// Joints with a drive that has confirmed, after its enable frame, that it is on: bit 0 is the first.
    pub on: u8,
    /// A drive may have lost its zero since the previous tick.
    pub zero_lost: bool,
    /// Supply voltage, V, if it is measured.
    pub supply: Option<f32>,
    /// Highest temperature, degrees Celsius, if it is measured.
    pub temperature: Option<f32>,
}

/// [`Lines`] as they are sent. Packed, because a status with encoder counts of six joints must take less than 1 ms on the line.
#[derive(Clone, Copy, Serialize, Deserialize)]
struct PackedLines {
    /// Sum of emergency stop (1), overrun (2), zeroed (4) and zero lost (8).
    flags: u8,
    drive_fault: u8,
    on: u8,
    supply: Option<f32>,
    temperature: Option<f32>,
}

impl From<Lines> for PackedLines {
    fn from(lines: Lines) -> Self {
        let Lines { emergency_stop, overrun, zeroed, drive_fault, on, zero_lost, supply, temperature } = lines;
        let bits = [emergency_stop, overrun, zeroed, zero_lost];
        let flags = bits.iter().rev().fold(0, |flags, &bit| flags << 1 | u8::from(bit));
        Self { flags, drive_fault, on, supply, temperature }
    }
}

impl From<PackedLines> for Lines {
    fn from(packed: PackedLines) -> Self {
        let PackedLines { flags, drive_fault, on, supply, temperature } = packed;
        let is_set = |bit: u8| flags & bit != 0;
        let (emergency_stop, overrun, zeroed, zero_lost) = (is_set(1), is_set(2), is_set(4), is_set(8));
        Self { emergency_stop, overrun, zeroed, drive_fault, on, zero_lost, supply, temperature }
    }
}

/// Fault of a joint's drive or sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub struct DriveFaultReport {
    /// The joint, counted from 0.
    pub joint: u8,
    /// As the bits of `session::readings::JointFaults`.
    pub faults: u16,
    /// The drive's own error code; 0 for none.
    pub error: u8,
}

impl Lines {
    /// No fault, every drive on, every joint knows its zero, and nothing else is measured.
    pub const CALM: Self = Self {
        emergency_stop: false,
        overrun: false,
        zeroed: true,
        drive_fault: 0,
        on: u8::MAX,
        zero_lost: false,
        supply: None,
        temperature: None,
    };
}

/// Choice of reports, and their rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Watch {
    /// Number of ticks from one report to the next; 0 for no reports.
    pub every: u16,
    /// The optional [`Parts`] of each status.
    pub parts: Parts,
}

/// Parts of a [`Status`] that can be left out: a set of bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Parts(u8);

impl Parts {
    /// None of them.
    pub const NONE: Self = Self(0);
    /// Readings and lines: all inputs of the tick that the board measures.
    pub const SENSED: Self = Self(1);
    /// Torques and limits.
    pub const TORQUE: Self = Self(2);
    /// The trajectory's reference.
    pub const REFERENCE: Self = Self(4);
    /// Cost of the tick.
    pub const COST: Self = Self(8);
    /// All parts that a recorded tick has.
    pub const ALL: Self = Self(15);
    /// External torque on each joint, if the scene estimates it; sent instead of the reference.
    pub const EXTERNAL: Self = Self(16);

    /// Union of two sets.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// True if the set contains all of `other`.
    #[must_use]
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }
}

/// Inputs and outputs of a tick under the safety state machine.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub struct Status {
    /// Number of the tick.
    pub tick: u32,
    /// Number of frames received before it, including refused and lost ones, modulo 65,536. Locates the tick between the frames of a log.
    pub taken: u16,
    /// State of the safety state machine.
    pub state: StateCode,
    /// Code of the [fault](Status::fault) or of the [cause of holding](Status::hold_cause); 0 in every other state.
    pub cause: u8,
    /// The joint that is the cause, counted from 0, if it is a single joint.
    pub joint: Option<u8>,
    /// True if the joints' zeros have been confirmed.
    pub homed: bool,
    /// Reason for which the request of this tick was rejected.
    pub refused: Option<Denial>,
    /// True if the black box keeps a fault that has not been released: it records no new ticks.
    pub kept: bool,
    /// Number of points that the trajectory buffer can still take.
    pub room: u8,
    /// Action of the drives; `None` if it was not requested.
    pub actuation: Option<Actuation>,
    /// Readings of the board's sensors and lines; `None` if they were not requested.
    pub sensed: Option<SensedLines>,
    /// One of several optional parts.
    pub extra: ExtraFields,
    /// Cost of the tick, if it was requested and can be counted exactly.
    pub cost: Option<TickCost>,
}

/// Optional part of a status. A status carries at most one of these.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub enum ExtraFields {
    /// Nothing.
    Nothing,
    /// The trajectory's reference, if it was requested and there is one.
    Reference(Reference),
    /// External torque or force on each joint, N m or N, if it was requested and the scene estimates it.
    External(Joints<f32>),
    /// Report of the first joint with a fault. Sent in the fault state if readings were requested.
    DriveFault(DriveFaultReport),
}

impl Status {
    /// Returns the fault in the fault state; `None` in every other state, and for a code that this version does not know.
    #[must_use]
    pub fn fault(&self) -> Option<control::Fault> {
        match self.state {
            StateCode::Fault => control::Fault::from_code(self.cause, self.joint.unwrap_or(0)),
            _ => None,
        }
    }

    /// Returns the cause of holding while the arm is held; `None` in every other state, and for a code that this version does not know.
    #[must_use]
    pub fn hold_cause(&self) -> Option<HoldCause> {
        match self.state {
            StateCode::Holding => HoldCause::from_code(self.cause, self.joint.unwrap_or(0)),
            _ => None,
        }
    }

    /// Returns the trajectory's reference, if it is reported.
    #[must_use]
    pub fn reference(&self) -> Option<&Reference> {
        match &self.extra {
            ExtraFields::Reference(reference) => Some(reference),
            _ => None,
        }
    }

    /// Returns the external torque or force on each joint, N m or N, if it is reported.
    #[must_use]
    pub fn external(&self) -> Option<&[f32]> {
        match &self.extra {
            ExtraFields::External(external) => Some(external),
            _ => None,
        }
    }

    /// Returns the report of the first joint with a fault, if the board sent one.
    #[must_use]
    pub fn drive_fault(&self) -> Option<DriveFaultReport> {
        match self.extra {
            ExtraFields::DriveFault(drive_fault) => Some(drive_fault),
            _ => None,
        }
    }
}

/// Action of the drives.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub enum Actuation {
    /// The drives apply these torques.
    Drive {
        /// Torque or force, N m or N; exactly the computed bits.
        torque: Joints<f32>,
        /// Limits that acted, as the bits of [`dynamics_core::control::LimitFlags`].
        limits: Joints<u8>,
    },
    /// Drives off, brakes engaged.
    Brake,
    /// The drives damp the motion without commands from the controller.
    DampedStop,
    /// Drives off.
    Off,
    /// The drives are being switched on, brakes engaged.
    Enable,
    /// The drives apply these torques against engaged brakes.
    Preload {
        /// Torque or force, N m or N; exactly the computed bits.
        torque: Joints<f32>,
        /// Limits that acted, as the bits of [`dynamics_core::control::LimitFlags`].
        limits: Joints<u8>,
    },
}

/// Readings and lines of a board in a tick.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub struct SensedLines {
    /// Readings of the joints.
    pub sensed: Sensed,
    /// Age of each reading, ticks; 65,535 means 65,535 or older.
    pub age_ticks: Joints<u16>,
    /// State of the board's lines.
    pub lines: Lines,
}

/// Costs of a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "host", derive(Deserialize))]
pub struct TickCost {
    /// Trajectory, safety state machine and controller.
    pub all: Cost,
    /// The controller alone, if it was called.
    pub controller: Option<Cost>,
}
