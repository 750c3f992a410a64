//! Bounds of a motion.

use super::MotionError;
use crate::joint::Limits;
use crate::scalar::Real;

/// Bounds of a motion on position, speed and acceleration. Infinity means "no bound".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds<S, const N: usize> {
    /// Lowest and highest position per joint, rad or m.
    pub position: [(S, S); N],
    /// Greatest speed per joint, rad/s or m/s.
    pub velocity: [S; N],
    /// Greatest acceleration per joint, rad/s^2 or m/s^2.
    pub acceleration: [S; N],
}

/// Greatest speed and acceleration of each joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peaks<S, const N: usize> {
    /// Greatest speed per joint, rad/s or m/s.
    pub velocity: [S; N],
    /// Greatest magnitude of the acceleration per joint, rad/s^2 or m/s^2.
    pub acceleration: [S; N],
}

impl<S: Real, const N: usize> Bounds<S, N> {
    /// Relative margin by which a motion is made slower than its bounds allow: 4e-6 of the time. So the rounding of a reference to `f32`
    /// never puts it beyond a limit, which the controller would report.
    pub const MARGIN: f64 = 4e-6;

    /// No bounds.
    #[must_use]
    pub fn none() -> Self {
        let free = S::literal(f64::INFINITY);
        Self { position: [(-free, free); N], velocity: [free; N], acceleration: [free; N] }
    }

    /// Position and velocity limits of the joints; acceleration without a bound.
    #[must_use]
    pub fn from_limits(limits: &[Limits<S>; N]) -> Self {
        Self { position: limits.map(|l| l.position), velocity: limits.map(|l| l.velocity), ..Self::none() }
    }

    /// The same with these acceleration bounds, rad/s^2 or m/s^2.
    #[must_use]
    pub fn with_acceleration(self, acceleration: [S; N]) -> Self {
        Self { acceleration, ..self }
    }

    pub(super) fn check(&self) -> Result<(), MotionError> {
        let bad = |what, joint| Err(MotionError::BadBound { what, joint });
        for joint in 0..N {
            let (lo, hi) = self.position[joint];
            // Written so that NaN fails the comparison.
            let ordered = lo <= hi;
            let bounded = self.velocity[joint] > S::zero();
            let gentle = self.acceleration[joint] > S::zero();
            match (ordered, bounded, gentle) {
                (true, true, true) => {}
                (false, _, _) => return bad("position", joint),
                (_, false, _) => return bad("velocity", joint),
                (_, _, false) => return bad("acceleration", joint),
            }
        }
        Ok(())
    }

    pub(super) fn check_position(&self, point: usize, q: &[S; N]) -> Result<(), MotionError> {
        for joint in 0..N {
            if !q[joint].is_finite() {
                return Err(MotionError::NotFinite { what: "position", point, joint });
            }
            let (lo, hi) = self.position[joint];
            if q[joint] < lo || q[joint] > hi {
                let limits = (lo.to_f64(), hi.to_f64());
                return Err(MotionError::PositionOutOfLimits { point, joint, position: q[joint].to_f64(), limits });
            }
        }
        Ok(())
    }

    /// Rejects peaks that exceed the bounds by more than rounding.
    pub(super) fn check_peaks(&self, peaks: &Peaks<S, N>) -> Result<(), MotionError> {
        let rounding = S::literal(1.0 + Self::MARGIN);
        for joint in 0..N {
            let (peak, limit) = (peaks.velocity[joint], self.velocity[joint]);
            if peak > limit * rounding {
                return Err(MotionError::TooFast { joint, peak: peak.to_f64(), limit: limit.to_f64() });
            }
            let (peak, limit) = (peaks.acceleration[joint], self.acceleration[joint]);
            if peak > limit * rounding {
                return Err(MotionError::TooSteep { joint, peak: peak.to_f64(), limit: limit.to_f64() });
            }
        }
        Ok(())
    }

    /// The factor of [`super::Motion::time_scale`].
    pub(super) fn time_scale(&self, peaks: &Peaks<S, N>) -> Result<S, MotionError> {
        let mut factor = S::zero();
        let mut moves = false;
        for joint in 0..N {
            moves |= peaks.velocity[joint] > S::zero();
            let by_velocity = peaks.velocity[joint] / self.velocity[joint];
            let by_acceleration = (peaks.acceleration[joint] / self.acceleration[joint]).sqrt();
            factor = largest(factor, largest(by_velocity, by_acceleration));
        }
        if factor > S::zero() {
            Ok(factor * S::literal(1.0 + Self::MARGIN))
        } else if moves {
            Err(MotionError::Unbounded { segment: 0 })
        } else {
            Err(MotionError::Standstill { segment: 0 })
        }
    }
}

/// The larger of two numbers, neither of them NaN.
pub(super) fn largest<S: Real>(a: S, b: S) -> S {
    if a > b { a } else { b }
}
