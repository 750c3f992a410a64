//! Readings of a board's joints and lines in a tick; the same types for every kind of board.

use core::ops::{BitOr, BitOrAssign};
use dynamics_core::control::Sensed;
use link::DriveFaultReport;

/// Faults of a joint: a set of bits with stable meanings in telemetry. Any of them stops the arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct JointFaults(u16);

impl JointFaults {
    /// No fault.
    pub const NONE: Self = Self(0);
    /// No measurement for more ticks than its connection allows, or none ever.
    pub const MISSING: Self = Self(1);
    /// The drive reports an error.
    pub const DRIVE: Self = Self(2);
    /// The position is at the end of a reply's range: the true position may be beyond it.
    pub const RANGE: Self = Self(4);
    /// The sensor reports that its reading is unreliable: its magnet is too far away or too near.
    pub const SENSOR: Self = Self(8);
    /// The sensor moved further than the joint can, so its turn count is lost. Stays until the sensor is restarted.
    pub const LOST: Self = Self(16);
    /// The bus is off.
    pub const BUS: Self = Self(32);
    /// The last torque was NaN or infinite, and none was driven.
    pub const NON_FINITE: Self = Self(64);
    /// Setting a pin or a PWM channel failed.
    pub const OUTPUT: Self = Self(128);
    /// The drive's replies show less torque than commanded. If they carry no state, the drive may be off.
    pub const TORQUE: Self = Self(256);
    /// The drive has not confirmed its own communication timeout.
    pub const TIMEOUT: Self = Self(512);

    /// Faults that count as drive faults. A missing measurement is not among them: its age shows it.
    pub const OF_DRIVE: Self = Self::NONE
        .and(Self::DRIVE)
        .and(Self::RANGE)
        .and(Self::SENSOR)
        .and(Self::LOST)
        .and(Self::BUS)
        .and(Self::NON_FINITE)
        .and(Self::OUTPUT)
        .and(Self::TORQUE)
        .and(Self::TIMEOUT);

    /// Each single bit with its name.
    pub const NAMES: [(Self, &'static str); 10] = [
        (Self::MISSING, "measurement missing"),
        (Self::DRIVE, "drive error"),
        (Self::RANGE, "position at the end of its range"),
        (Self::SENSOR, "sensor doubtful"),
        (Self::LOST, "turn lost"),
        (Self::BUS, "bus off"),
        (Self::NON_FINITE, "torque not finite"),
        (Self::OUTPUT, "output refused"),
        (Self::TORQUE, "torque missing: the drive may be off"),
        (Self::TIMEOUT, "the drive's communication timeout is not confirmed"),
    ];

    /// Returns the bits.
    #[must_use]
    pub const fn bits(self) -> u16 {
        self.0
    }

    /// True if every bit of `other` is set.
    #[must_use]
    pub const fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// True if any bit of `other` is set.
    #[inline]
    #[must_use]
    pub const fn intersects(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }

    /// Returns the union of both sets.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Returns the set without the bits of `other`.
    #[inline]
    #[must_use]
    pub const fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Returns these bits if the condition holds, otherwise none.
    #[inline]
    #[must_use]
    pub fn when(self, condition: bool) -> Self {
        if condition { self } else { Self::NONE }
    }
}

impl BitOr for JointFaults {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl BitOrAssign for JointFaults {
    fn bitor_assign(&mut self, other: Self) {
        *self = *self | other;
    }
}

/// Positions, torques, ages and faults of all joints in a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Readings<const N: usize> {
    /// Positions and velocities, or encoder counts.
    pub sensed: Sensed<f32, N>,
    /// Reported or estimated torque or force of each drive, N m or N.
    pub torque: [f32; N],
    /// Age of each joint's measurement, ticks; 0 is fresh, `u32::MAX` means that there has been none.
    pub age_ticks: [u32; N],
    /// Faults of each joint.
    pub faults: [JointFaults; N],
    /// Error code that each drive reports; 0 for none. `joint_io::frames::Frames::error_text` returns its text.
    pub errors: [u8; N],
    /// True for each drive that has confirmed, in answer to its enable frame, that it is on.
    pub on: [bool; N],
    /// True for one tick if a drive may have lost its zero since the previous tick: the arm must be homed again.
    pub zero_lost: bool,
}

impl<const N: usize> Readings<N> {
    /// Returns the report of the first joint with a fault.
    #[must_use]
    pub fn drive_fault(&self) -> Option<DriveFaultReport> {
        let mut joints = self.faults.iter().zip(&self.errors).zip(0..);
        let found = |((faults, error), joint): ((&JointFaults, &u8), u8)| {
            let (faults, error) = (faults.bits(), *error);
            (faults != 0 || error != 0).then_some(DriveFaultReport { joint, faults, error })
        };
        joints.find_map(found)
    }
}

/// State of a board's input lines: everything it senses except the joints' readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lines {
    /// The emergency stop is pressed, or its wire is broken.
    pub emergency_stop: bool,
    /// Supply voltage, V, if the board measures it.
    pub supply: Option<f32>,
    /// Highest temperature, degrees Celsius, if the board measures it.
    pub temperature: Option<f32>,
}

impl Lines {
    /// No emergency stop, and nothing measured.
    pub const NONE: Self = Self { emergency_stop: false, supply: None, temperature: None };
}
