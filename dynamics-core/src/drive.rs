//! Scales, offsets and ranges that convert between a joint and the frames of its drive.
//!
//! A robot file gives these in the units of a data sheet. They are converted once, on the desk, and rounded to single
//! precision. Everything here converts between the drive's own units and the joint's SI units.
//!
//! [`bus_time`] computes how long the frames of such drives take on their buses.

pub mod bus_time;
pub mod kind;

use crate::control::Spring;

pub use kind::{Damiao, DriveFacts, DriveKind, MiniCheetah, MyActuator, PositionMemory, Protocol, RobStride};

/// The lowest and the highest value that a field of a frame can carry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The value of code 0.
    pub min: f32,
    /// The value of the highest code.
    pub max: f32,
}

impl Range {
    /// The code nearest to `x`, with `bits` bits; values outside the range give the code of the nearer end. `None` for NaN.
    ///
    /// `code = floor((x - min) (2^bits - 1) / (max - min) + 1/2)`
    ///
    /// Inside the range, [`Range::value`] of the code is at most half of [`Range::step`] from `x`, plus f32's rounding
    /// of the ends. (The mini-cheetah's own firmware truncates instead of rounding, and is a whole step away at worst.)
    #[inline]
    #[must_use]
    pub fn code(&self, x: f32, bits: u32) -> Option<u16> {
        if x.is_nan() {
            return None;
        }
        let top = top(bits);
        let share = (x - self.min) / (self.max - self.min) * f32::from(top);
        // The cast saturates below; above, the last code is the range's end.
        Some(((share + 0.5) as u16).min(top))
    }

    /// The value of a code of `bits` bits: `min + code (max - min) / (2^bits - 1)`.
    #[inline]
    #[must_use]
    pub fn value(&self, code: u16, bits: u32) -> f32 {
        f32::from(code) * self.step(bits) + self.min
    }

    /// Distance between neighbouring codes: `(max - min) / (2^bits - 1)`.
    #[inline]
    #[must_use]
    pub fn step(&self, bits: u32) -> f32 {
        (self.max - self.min) / f32::from(top(bits))
    }
}

/// The highest code of `bits` bits, for 1 to 16 of them.
const fn top(bits: u32) -> u16 {
    u16::MAX >> (16 - bits)
}

/// Gearing between a joint and the shaft of its drive.
///
/// ```text
/// p   = ratio q + zero         position, rad of the drive's shaft
/// v   = ratio qd
/// tau = ratio tau_drive        torque of the joint, N m or N
/// ```
///
/// `ratio` is drive turns per joint turn (rad per m on a prismatic joint), negative if they turn in opposite directions.
/// `per_ratio` is its reciprocal, rounded once, so that no tick divides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gearing {
    /// Drive radians per joint radian or metre; never zero.
    pub ratio: f32,
    /// `1 / ratio`.
    pub per_ratio: f32,
    /// The drive's position at `q = 0`, rad.
    pub zero: f32,
}

impl Gearing {
    /// Joint position, rad or m, from the drive's, rad.
    #[inline]
    #[must_use]
    pub fn joint_position(&self, drive: f32) -> f32 {
        (drive - self.zero) * self.per_ratio
    }

    /// The drive's position, rad, from the joint's, rad or m.
    #[inline]
    #[must_use]
    pub fn drive_position(&self, joint: f32) -> f32 {
        joint * self.ratio + self.zero
    }

    /// Joint velocity, rad/s or m/s, from the drive's, rad/s.
    #[inline]
    #[must_use]
    pub fn joint_velocity(&self, drive: f32) -> f32 {
        drive * self.per_ratio
    }

    /// The drive's velocity, rad/s, from the joint's, rad/s or m/s.
    #[inline]
    #[must_use]
    pub fn drive_velocity(&self, joint: f32) -> f32 {
        joint * self.ratio
    }

    /// Converts a spring and a damper at the joint to N m/rad and N m s/rad at the drive's shaft: divides by `ratio^2`.
    #[inline]
    #[must_use]
    pub fn drive_spring(&self, joint: &Spring<f32>) -> Spring<f32> {
        let share = self.per_ratio * self.per_ratio;
        Spring { stiffness: joint.stiffness * share, damping: joint.damping * share }
    }

    /// Torque or force of the joint, N m or N, from the drive's torque, N m.
    #[inline]
    #[must_use]
    pub fn joint_torque(&self, drive: f32) -> f32 {
        drive * self.ratio
    }

    /// The drive's torque, N m, from the joint's torque or force, N m or N.
    #[inline]
    #[must_use]
    pub fn drive_torque(&self, joint: f32) -> f32 {
        joint * self.per_ratio
    }
}

/// Ranges of the fields of a MIT-mode frame, in the drive's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MitRanges {
    /// Position, rad.
    pub position: Range,
    /// Velocity, rad/s.
    pub velocity: Range,
    /// Stiffness, N m/rad.
    pub kp: Range,
    /// Damping, N m s/rad.
    pub kd: Range,
    /// Torque, N m.
    pub torque: Range,
}

/// Unit of a drive's own communication timeout, us: Damiao's register 9 and RobStride's parameter 0x7028 both count 50 us.
pub const TIMEOUT_UNIT_US: u32 = 50;

/// Bit rates of the data of CAN FD frames. Identifiers are sent at [`bus_time::NOMINAL_RATE`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DataRate {
    /// 2 Mbit/s.
    Mbit2,
    /// 5 Mbit/s.
    Mbit5,
}

impl DataRate {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Mbit2, Self::Mbit5];

    /// Bits per second.
    #[must_use]
    pub const fn bits_per_second(self) -> u32 {
        match self {
            Self::Mbit2 => 2_000_000,
            Self::Mbit5 => 5_000_000,
        }
    }
}

/// An actuator on a CAN bus with its own impedance loop: position, velocity, stiffness, damping and torque in one frame.
///
/// The frames that it understands are a type, [`MiniCheetah`], [`Damiao`], [`RobStride`] or [`MyActuator`], so that a firmware contains the code of
/// one kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MitDrive {
    /// Number of its bus, counted from 0.
    pub bus: u8,
    /// Bit rate of the data of its FD frames; `None` for classic frames. The same for all drives of a bus.
    pub data_rate: Option<DataRate>,
    /// The motor's identifier: that of its commands, and part of its replies.
    pub id: u8,
    /// The identifier of its replies. For a RobStride drive: the identifier of the host to which it replies.
    pub reply_id: u16,
    /// Bytes of a reply: 6, 7 with a temperature, 8 with temperature and error.
    pub reply_bytes: u8,
    /// Temperature of code 0 in a reply of 7 or 8 bytes, degrees Celsius; a code is a degree. `None` if replies have none.
    pub temperature_offset: Option<f32>,
    /// Ranges of the fields of its frames.
    pub ranges: MitRanges,
    /// Joint and shaft.
    pub gearing: Gearing,
    /// Damping of a damped stop at the drive's shaft, N m s/rad.
    pub damping: f32,
    /// The drive's own communication timeout, in units of [`TIMEOUT_UNIT_US`]: without a command for so long it gives no torque. It is set before
    /// the arm is armed. 0: it is neither read nor set.
    pub timeout: u32,
    /// Number of ticks without a reply after which the drive may have restarted.
    pub restart_ticks: u32,
    /// True if the joint's position is known after a restart: every position within its limits corresponds to a different angle.
    pub absolute: bool,
}

/// A motor with an H-bridge that takes a duty cycle, and a magnetic encoder of 14 bits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PwmDrive {
    /// Channel of the board, counted from 0.
    pub channel: u8,
    /// Gearing between joint and motor. Its `zero` is unused: the encoder has its own.
    pub gearing: Gearing,
    /// Reading of the encoder at `q = 0`, counts.
    pub encoder_zero: u16,
    /// True if the encoder counts down as the joint moves up.
    pub encoder_reversed: bool,
    /// Greatest possible motion of the encoder in one tick, counts.
    pub jump_max: u16,
    /// Speed of the motor at which the encoder moves by one count per tick, rad/s.
    pub speed_per_count: f32,
    /// Torque constant, N m/A, which is also the back-EMF constant, V s/rad.
    pub torque_constant: f32,
    /// Its reciprocal.
    pub per_torque_constant: f32,
    /// Resistance of the winding and the bridge, ohm.
    pub resistance: f32,
    /// Its reciprocal.
    pub per_resistance: f32,
    /// Supply voltage, V.
    pub supply: f32,
    /// Its reciprocal.
    pub per_supply: f32,
    /// The greatest current, A.
    pub current_max: f32,
}

/// Wiring of the joints of an arm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drives<const N: usize> {
    /// Not given in the robot file: measurements and commands go over the link.
    Link,
    /// MIT-mode actuators on CAN.
    Mit([MitDrive; N]),
    /// H-bridges and magnetic encoders.
    Pwm([PwmDrive; N]),
}
