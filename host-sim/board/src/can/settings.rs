//! Settings stored in motors, compared with the robot file.
//!
//! A Damiao motor maps the codes of its frames to the ranges in its registers. If the robot file has other ranges, the motor gives another torque
//! than commanded, and its position is read wrongly. Nothing in a session would show this before the arm moves. RobStride motors have fixed ranges;
//! those of the kinds `mit` and `myactuator` cannot be read.

use super::adapter::Adapter;
use super::damiao_motor::{DamiaoMotor, FrameRanges, MotorSettings};
use dynamics_core::drive::{MitDrive, MitRanges, Protocol};
use std::fmt;
use std::io;

/// Largest difference between a range in a motor and one in a file that is only rounding, as a share of the range.
const ROUNDING: f64 = 1e-4;

/// Value of the register of the control mode in which a motor takes the frames of this program.
const MIT_MODE: u32 = 1;

/// A motor that does not fit its drive in the robot file.
#[derive(Clone, Debug, PartialEq)]
pub enum Mismatch {
    /// It does not answer.
    Silent,
    /// It is in another control mode, or answers nothing about it.
    Mode(Option<u32>),
    /// Its replies have another identifier than in the file.
    ReplyId {
        /// In the motor.
        motor: u32,
        /// In the file.
        file: u32,
    },
    /// A range differs. The field is the name of the range in the file.
    Range {
        /// `position`, `velocity` or `torque`.
        field: &'static str,
        /// Highest value in the motor, in the unit of the field.
        motor: f64,
        /// Lowest and highest value in the file.
        file: (f64, f64),
    },
}

impl fmt::Display for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Silent => write!(f, "does not answer"),
            Self::Mode(None) => write!(f, "control mode: no answer, expected 1 (MIT)"),
            Self::Mode(Some(mode)) => {
                write!(f, "control mode: found {mode}, expected 1 (MIT): it would not follow torques")
            }
            Self::ReplyId { motor, file } => {
                write!(
                    f,
                    "reply_id: found {motor} in the motor and {file} in the robot file: its replies would not be heard"
                )
            }
            Self::Range { field, motor, file: (lo, hi) } => {
                write!(f, "{field}: found a range of ±{motor} in the motor and [{lo}, {hi}] in the robot file: ")?;
                let factor = 2.0 * motor / (hi - lo);
                match *field {
                    _ if !(factor.is_finite() && factor > 0.0) => write!(f, "no motor can have this range"),
                    _ if !is_near(-lo, *hi) => write!(f, "a motor's range is symmetric"),
                    "torque" => write!(f, "it would give {factor:.3} times the commanded torque"),
                    _ => write!(f, "its {field} would be {factor:.3} times what is read"),
                }
            }
        }
    }
}

/// True if a range is that of the file, up to rounding. False for NaN and infinity.
fn is_near(motor: f64, file: f64) -> bool {
    (motor - file).abs() <= ROUNDING * file.abs()
}

/// Compares a motor's settings with those that a file expects.
#[must_use]
pub fn mismatches(motor: &MotorSettings, drive: &MitDrive) -> Vec<Mismatch> {
    let MotorSettings { reply_id, mode, ranges: FrameRanges { position, velocity, torque } } = *motor;
    let MitRanges { position: p, velocity: v, torque: t, .. } = drive.ranges;
    let mut found = Vec::new();
    if mode != Some(MIT_MODE) {
        found.push(Mismatch::Mode(mode));
    }
    if reply_id != u32::from(drive.reply_id) {
        found.push(Mismatch::ReplyId { motor: reply_id, file: u32::from(drive.reply_id) });
    }
    for (field, motor, range) in [("position", position, p), ("velocity", velocity, v), ("torque", torque, t)] {
        let (lo, hi) = (f64::from(range.min), f64::from(range.max));
        if !(is_near(motor, hi) && is_near(motor, -lo)) {
            found.push(Mismatch::Range { field, motor, file: (lo, hi) });
        }
    }
    found
}

/// A motor that does not fit, and the joint that it drives.
#[derive(Clone, Debug, PartialEq)]
pub struct JointMismatch {
    /// Joint, counted from 0.
    pub joint: usize,
    /// Identifier of the motor.
    pub id: u8,
    /// The difference.
    pub mismatch: Mismatch,
}

impl fmt::Display for JointMismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { joint, id, mismatch } = self;
        write!(f, "joint {}: motor {id}: {mismatch}", joint + 1)
    }
}

/// Advice for motors that do not fit.
#[must_use]
pub fn advice(found: &[JointMismatch]) -> &'static str {
    let is_some = |of: fn(&Mismatch) -> bool| found.iter().any(|it| of(&it.mismatch));
    if is_some(|it| matches!(it, Mismatch::Silent)) {
        "switch the drives' power on, and look for the motors with `newtau motors scan`; they stay off until the arm is armed"
    } else if is_some(|it| matches!(it, Mismatch::Range { .. })) {
        "`newtau motors show ID` prints a motor's values. Write its ranges into its `[joint.drive]` (`position`, `velocity`, `torque`), or store the file's in the \
         motor (`newtau motors set-limits`)"
    } else {
        "`newtau motors show ID` prints a motor's values; set the control mode with the maker's tool, and write the identifier of its replies into its \
         `[joint.drive]` (`reply_id`)"
    }
}

/// Reads the settings of the drives of these joints, counted from 0, and returns those that differ. `None` if drives of this kind have no settings
/// that can be read. Neither enables nor moves anything.
///
/// # Errors
/// The adapter is gone, or does not send; a motor answers only in part.
pub fn check(
    adapter: &mut dyn Adapter,
    kind: Protocol,
    drives: impl Iterator<Item = (usize, MitDrive)>,
) -> io::Result<Option<Vec<JointMismatch>>> {
    if kind != Protocol::Damiao {
        return Ok(None);
    }
    let mut found = Vec::new();
    for (joint, drive) in drives {
        let these = match DamiaoMotor::new(adapter, drive.id).settings()? {
            None => vec![Mismatch::Silent],
            Some(settings) => mismatches(&settings, &drive),
        };
        found.extend(these.into_iter().map(|mismatch| JointMismatch { joint, id: drive.id, mismatch }));
    }
    Ok(Some(found))
}

#[cfg(test)]
mod tests;
