//! Reasons why a motion cannot be made.

use crate::scalar::Real;
use core::fmt;

/// Reason why a motion cannot be made. Points, segments and joints are counted from 0 here and from 1 in the message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotionError {
    /// A motion needs two points.
    TooFewPoints {
        /// Number of points.
        given: usize,
    },
    /// More points than a motion can hold.
    TooManyPoints {
        /// Number of points.
        given: usize,
        /// Largest number of points.
        room: usize,
    },
    /// One duration is needed for each segment between two points.
    DurationCount {
        /// Number of durations.
        given: usize,
        /// Expected number.
        wanted: usize,
    },
    /// A number that is NaN or infinite.
    NotFinite {
        /// Name of the quantity.
        what: &'static str,
        /// The point.
        point: usize,
        /// The joint.
        joint: usize,
    },
    /// An invalid time, frequency or share: NaN, infinite, zero or negative, or out of its range.
    OutOfRange {
        /// Name of the quantity.
        what: &'static str,
        /// Its value.
        value: f64,
        /// The allowed range, in words.
        wanted: &'static str,
    },
    /// A bound that is NaN or not above zero, or a lower bound above its upper one.
    BadBound {
        /// Which bound.
        what: &'static str,
        /// The joint.
        joint: usize,
    },
    /// A point outside the position limits.
    PositionOutOfLimits {
        /// The point.
        point: usize,
        /// The joint.
        joint: usize,
        /// Its position, rad or m.
        position: f64,
        /// Lowest and highest position allowed, rad or m.
        limits: (f64, f64),
    },
    /// A sweep that leads outside the position limits.
    AmplitudeBeyondLimits {
        /// The joint.
        joint: usize,
        /// Lowest and highest position of the sweep, rad or m.
        reach: (f64, f64),
        /// Lowest and highest position allowed, rad or m.
        limits: (f64, f64),
    },
    /// A given duration or frequency at which a joint would be faster than allowed.
    TooFast {
        /// The joint.
        joint: usize,
        /// Its greatest speed, rad/s or m/s.
        peak: f64,
        /// The greatest allowed, rad/s or m/s.
        limit: f64,
    },
    /// A given duration or frequency at which a joint would accelerate more than allowed.
    TooSteep {
        /// The joint.
        joint: usize,
        /// Its greatest acceleration, rad/s^2 or m/s^2.
        peak: f64,
        /// The greatest allowed, rad/s^2 or m/s^2.
        limit: f64,
    },
    /// No joint moves on this segment, so it has no shortest duration.
    Standstill {
        /// The segment.
        segment: usize,
    },
    /// No joint that moves on this segment has a finite bound, so it has no shortest duration.
    Unbounded {
        /// The segment.
        segment: usize,
    },
    /// Holding the arm at rest needs more than the torque limit: no duration is long enough.
    TorqueTooSmall {
        /// The joint.
        joint: usize,
        /// Time in the motion, s.
        time: f64,
        /// Torque that holds it still there, N m or N.
        holding: f64,
        /// The limit, N m or N.
        limit: f64,
    },
    /// The inverse dynamics gave a torque that is NaN or infinite.
    TorqueNotFinite {
        /// The joint.
        joint: usize,
        /// Time in the motion, s.
        time: f64,
    },
}

impl core::error::Error for MotionError {}

impl fmt::Display for MotionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::TooFewPoints { given } => write!(f, "a motion needs at least 2 points, not {given}"),
            Self::TooManyPoints { given, room } => write!(f, "a motion has at most {room} points, not {given}"),
            Self::DurationCount { given, wanted } => {
                write!(f, "{given} durations given, but {wanted} are needed: one between each point and the next")
            }
            Self::NotFinite { what, point, joint } => {
                write!(f, "{what} of joint {} at point {} is not a finite number", joint + 1, point + 1)
            }
            Self::OutOfRange { what, value, wanted } => write!(f, "{what} is {value}, but must be {wanted}"),
            Self::BadBound { what, joint } => write!(f, "{what} bound of joint {} cannot be", joint + 1),
            Self::PositionOutOfLimits { point, joint, position, limits: (lo, hi) } => write!(
                f,
                "joint {} at point {} is at {position}, outside its limits {lo} to {hi}",
                joint + 1,
                point + 1
            ),
            Self::AmplitudeBeyondLimits { joint, reach, limits } => write!(
                f,
                "joint {} would sweep from {} to {}, outside its limits {} to {}",
                joint + 1,
                reach.0,
                reach.1,
                limits.0,
                limits.1
            ),
            Self::TooFast { joint, peak, limit } => {
                let factor = peak / limit;
                write!(f, "joint {} would reach speed {peak}, above {limit}: {factor:.3} times the time", joint + 1)?;
                f.write_str(" would do")
            }
            Self::TooSteep { joint, peak, limit } => {
                let factor = libm::sqrt(peak / limit);
                let joint = joint + 1;
                write!(f, "joint {joint} would reach acceleration {peak}, above {limit}: {factor:.3} times the time")?;
                f.write_str(" would do")
            }
            Self::Standstill { segment } => {
                write!(f, "no joint moves on segment {}: give its duration, or a dwell", segment + 1)
            }
            Self::Unbounded { segment } => {
                write!(f, "no bound limits the speed on segment {}: give its duration, or bounds", segment + 1)
            }
            Self::TorqueTooSmall { joint, time, holding, limit } => {
                write!(f, "holding joint {} still at {time} s takes {holding}, more than its limit {limit}", joint + 1)
            }
            Self::TorqueNotFinite { joint, time } => {
                write!(f, "the torque of joint {} at {time} s is not a finite number", joint + 1)
            }
        }
    }
}

/// Rejects a duration or a ramp that is not above zero and finite, and ramps at both ends that are longer than the duration.
pub(super) fn check_ramp<S: Real>(duration: S, ramp: S) -> Result<(), MotionError> {
    check_time("duration", duration)?;
    check_time("ramp", ramp)?;
    if ramp > S::literal(0.5) * duration {
        let value = ramp.to_f64();
        return Err(MotionError::OutOfRange { what: "ramp", value, wanted: "at most half the duration" });
    }
    Ok(())
}

/// Rejects a value that is not above zero and finite.
pub(super) fn check_time<S: Real>(what: &'static str, value: S) -> Result<(), MotionError> {
    if value > S::zero() && value.is_finite() {
        Ok(())
    } else {
        Err(MotionError::OutOfRange { what, value: value.to_f64(), wanted: "above zero and finite" })
    }
}
