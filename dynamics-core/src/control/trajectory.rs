//! Reference motions: the desired position, velocity and acceleration of the joints at every moment.
//!
//! | motion | joints follow | smooth in |
//! |---|---|---|
//! | [`Motion::hold`] | nothing: they stay | everything |
//! | [`Motion::quintic`] | quintic polynomials through up to [`POINTS_MAX`] points | `q, qd, qdd` |
//! | [`Motion::trapezoid`] | a straight line: constant acceleration, constant speed, constant deceleration | `q, qd` |
//! | [`Motion::sweep`] | a sine whose frequency rises or falls linearly | `q, qd, qdd` |
//! | [`Motion::fourier`] | a finite Fourier series each | `q, qd, qdd` |
//!
//! Every motion starts and ends at rest. Making one checks it against [`Bounds`]; sampling one never fails. A motion can
//! be slowed and hastened ([`Motion::stretched`]) without leaving its path, and so fitted to bounds on velocity and
//! acceleration ([`Motion::fastest`]) and on torque ([`Motion::scale_to_torque`]).
//!
//! References are made on the desk and sent to the chip. Sweep and series compute their sines with libm in double precision, which a
//! control tick on a chip without a double-precision unit should not do. For the other motions [`Motion::sample`] may run on the chip too;
//! everything else here is meant for the desk.
//!
//! ```
//! use dynamics_core::control::trajectory::{Bounds, Motion, Timing, Waypoint};
//!
//! let bounds = Bounds { velocity: [1.5, 3.0], ..Bounds::none() };
//! let points = [Waypoint::through([0.0, 0.0]), Waypoint::through([1.0, 0.5]), Waypoint::through([1.5, 2.0])];
//! let motion = Motion::quintic(&points, Timing::Fastest, &bounds)?;
//! assert_eq!(motion.sample(motion.duration()).q, [1.5, 2.0]);
//! # Ok::<(), dynamics_core::control::trajectory::MotionError>(())
//! ```

mod bounds;
mod error;
mod fourier;
mod quintic;
mod sweep;
mod torque;
mod trapezoid;

pub use bounds::{Bounds, Peaks};
pub use error::MotionError;
pub use fourier::{Fourier, FourierSpec, HARMONICS_MAX};
pub use quintic::{POINTS_MAX, Quintic, Timing, Waypoint};
pub use sweep::{Sweep, SweepSpec};
pub use torque::TorqueLimits;
pub use trapezoid::Trapezoid;

use super::Reference;
use crate::scalar::Real;
use error::check_time;

/// A reference motion of `N` joints, from rest to rest.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "without an allocator there is nowhere else to put the points")]
pub enum Motion<S, const N: usize> {
    /// Standing still.
    Hold {
        /// Position of each joint, rad or m.
        q: [S; N],
        /// Duration, s.
        duration: S,
    },
    /// Quintic polynomials through points.
    Quintic(Quintic<S, N>),
    /// Trapezoidal speed along a straight line.
    Trapezoid(Trapezoid<S, N>),
    /// A sine of changing frequency.
    Sweep(Sweep<S, N>),
    /// Sums of sines and cosines.
    Fourier(Fourier<S, N>),
}

impl<S: Real, const N: usize> Motion<S, N> {
    /// Stand still at `q` for `duration` seconds.
    ///
    /// # Errors
    /// A position that is NaN, infinite or outside its bounds; a duration that is not above zero and finite.
    pub fn hold(q: [S; N], duration: S, bounds: &Bounds<S, N>) -> Result<Self, MotionError> {
        bounds.check()?;
        bounds.check_position(0, &q)?;
        check_time("duration", duration)?;
        Ok(Self::Hold { q, duration })
    }

    /// From point to point along quintic polynomials; see [`Quintic`].
    ///
    /// # Errors
    /// Fewer than 2 or more than [`POINTS_MAX`] points; a value that is NaN or infinite; a point outside the position
    /// bounds; a negative dwell; not as many durations as segments; durations that break a bound; [`Timing::Fastest`]
    /// for a segment on which no joint moves, or none that moves has a bound.
    pub fn quintic(
        points: &[Waypoint<S, N>],
        timing: Timing<'_, S>,
        bounds: &Bounds<S, N>,
    ) -> Result<Self, MotionError> {
        Quintic::new(points, timing, bounds).map(Self::Quintic)
    }

    /// From rest to rest along a straight line, as fast as velocity and acceleration bounds allow; see [`Trapezoid`].
    ///
    /// # Errors
    /// A value that is NaN or infinite; an end outside the position bounds; no joint moves, or none that moves has an
    /// acceleration bound.
    pub fn trapezoid(from: [S; N], to: [S; N], bounds: &Bounds<S, N>) -> Result<Self, MotionError> {
        Trapezoid::fastest(from, to, bounds).map(Self::Trapezoid)
    }

    /// From rest to rest along a straight line in `duration` seconds. The share `ramp_share` in `(0, 1/2]` of it is
    /// used to speed up, and the same share to slow down; see [`Trapezoid`].
    ///
    /// # Errors
    /// As [`Motion::trapezoid`], and a duration or a share out of its range; a motion that breaks a bound.
    pub fn trapezoid_in(
        from: [S; N],
        to: [S; N],
        duration: S,
        ramp_share: S,
        bounds: &Bounds<S, N>,
    ) -> Result<Self, MotionError> {
        Trapezoid::timed(from, to, duration, ramp_share, bounds).map(Self::Trapezoid)
    }

    /// A sine of rising or falling frequency about a centre; see [`Sweep`].
    ///
    /// # Errors
    /// A value that is NaN or infinite; an amplitude that leads out of the position bounds; a duration or ramp out of
    /// its range; frequencies that are negative or both zero; a motion that breaks a bound.
    pub fn sweep(spec: &SweepSpec<S, N>, bounds: &Bounds<S, N>) -> Result<Self, MotionError> {
        Sweep::new(spec, bounds).map(Self::Sweep)
    }

    /// A finite Fourier series for each joint about a centre; see [`Fourier`].
    ///
    /// # Errors
    /// A value that is NaN or infinite; a series that leads out of the position bounds; a duration or ramp out of its range; a motion
    /// that breaks a bound.
    pub fn fourier(spec: &FourierSpec<S, N>, bounds: &Bounds<S, N>) -> Result<Self, MotionError> {
        Fourier::new(spec, bounds).map(Self::Fourier)
    }

    /// From the start to the end, s.
    #[must_use]
    pub fn duration(&self) -> S {
        match self {
            Self::Hold { duration, .. } => *duration,
            Self::Quintic(motion) => motion.duration(),
            Self::Trapezoid(motion) => motion.duration(),
            Self::Sweep(motion) => motion.duration(),
            Self::Fourier(motion) => motion.duration(),
        }
    }

    /// Time at which point `index` (counted from 0, the start) is reached, s; `None` beyond the last. Motions without intermediate points
    /// have two points, their ends.
    #[must_use]
    pub fn arrival(&self, index: usize) -> Option<S> {
        match (self, index) {
            (Self::Quintic(motion), _) => motion.arrival(index),
            (_, 0) => Some(S::zero()),
            (_, 1) => Some(self.duration()),
            _ => None,
        }
    }

    /// Position of the start, rad or m; the motion starts at rest.
    #[must_use]
    pub fn start(&self) -> Reference<S, N> {
        Reference::at_rest(match self {
            Self::Hold { q, .. } => *q,
            Self::Quintic(motion) => motion.first(),
            Self::Trapezoid(motion) => motion.first(),
            Self::Sweep(motion) => motion.centre(),
            Self::Fourier(motion) => motion.centre(),
        })
    }

    /// Position of the end, rad or m; the motion ends at rest.
    #[must_use]
    pub fn end(&self) -> Reference<S, N> {
        Reference::at_rest(match self {
            Self::Hold { q, .. } => *q,
            Self::Quintic(motion) => motion.last(),
            Self::Trapezoid(motion) => motion.last(),
            Self::Sweep(motion) => motion.centre(),
            Self::Fourier(motion) => motion.centre(),
        })
    }

    /// The reference at `t` seconds after the start. Total: for `t <= 0` and for NaN it is the start at rest; from the duration
    /// on, the end at rest.
    ///
    /// Cost: at most [`POINTS_MAX`] additions, then 1 division and about 20 operations per joint; a sweep: one sine and one
    /// cosine in double precision.
    #[must_use]
    pub fn sample(&self, t: S) -> Reference<S, N> {
        if t >= self.duration() {
            return self.end();
        }
        if t > S::zero() {
            match self {
                Self::Hold { .. } => self.start(),
                Self::Quintic(motion) => motion.sample(t),
                Self::Trapezoid(motion) => motion.sample(t),
                Self::Sweep(motion) => motion.sample(t),
                Self::Fourier(motion) => motion.sample(t),
            }
        } else {
            self.start()
        }
    }

    /// Greatest speed and acceleration of each joint over the whole motion.
    ///
    /// Exact up to rounding for all motions but sweep and series. Their peaks are never understated, and overstated by at most 1 % if the
    /// ramps are not too short (see [`Sweep`]).
    #[must_use]
    pub fn peaks(&self) -> Peaks<S, N> {
        match self {
            Self::Hold { .. } => Peaks { velocity: [S::zero(); N], acceleration: [S::zero(); N] },
            Self::Quintic(motion) => motion.peaks(),
            Self::Trapezoid(motion) => motion.peaks(),
            Self::Sweep(motion) => motion.peaks(),
            Self::Fourier(motion) => motion.peaks(),
        }
    }

    /// The same path, `factor` times as slow: `q'(k t) = q(t)`, `qd' = qd / k`, `qdd' = qdd / k^2`.
    ///
    /// Dwells keep their length: nothing moves in them.
    ///
    /// # Errors
    /// A factor that is not above zero and finite.
    pub fn stretched(&self, factor: S) -> Result<Self, MotionError> {
        check_time("time factor", factor)?;
        Ok(match self {
            Self::Hold { q, duration } => Self::Hold { q: *q, duration: *duration * factor },
            Self::Quintic(motion) => Self::Quintic(motion.stretched(factor)),
            Self::Trapezoid(motion) => Self::Trapezoid(motion.stretched(factor)),
            Self::Sweep(motion) => Self::Sweep(motion.stretched(factor)),
            Self::Fourier(motion) => Self::Fourier(motion.stretched(factor)),
        })
    }

    /// The same path in `duration` seconds, dwells and all.
    ///
    /// # Errors
    /// A duration that is not above zero and finite, or not longer than the dwells.
    pub fn with_duration(&self, duration: S) -> Result<Self, MotionError> {
        check_time("duration", duration)?;
        let dwell = match self {
            Self::Quintic(motion) => motion.dwell(),
            Self::Hold { .. } | Self::Trapezoid(_) | Self::Sweep(_) | Self::Fourier(_) => S::zero(),
        };
        self.stretched((duration - dwell) / (self.duration() - dwell))
    }

    /// The factor `k` for [`Motion::stretched`] at which some joint just touches its bound and none breaks one; below 1
    /// if the motion can be faster.
    ///
    /// `k = max_i max(peak_qd_i / qd_i, sqrt(peak_qdd_i / qdd_i))`, plus the margin of [`Bounds::MARGIN`] that keeps the
    /// motion inside its bounds after rounding to `f32`.
    ///
    /// # Errors
    /// An invalid bound; no joint moves, or none that moves has a bound.
    pub fn time_scale(&self, bounds: &Bounds<S, N>) -> Result<S, MotionError> {
        bounds.check()?;
        bounds.time_scale(&self.peaks())
    }

    /// The same path as fast as the bounds on velocity and acceleration allow, by one factor for the whole motion.
    ///
    /// # Errors
    /// As [`Motion::time_scale`].
    pub fn fastest(&self, bounds: &Bounds<S, N>) -> Result<Self, MotionError> {
        self.stretched(self.time_scale(bounds)?)
    }
}
