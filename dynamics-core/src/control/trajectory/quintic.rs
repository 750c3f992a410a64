//! Quintic polynomials through points.

use super::bounds::{Bounds, Peaks, largest};
use super::error::{MotionError, check_time};
use crate::control::Reference;
use crate::scalar::Real;
use heapless::Vec;

/// Largest number of points of a motion, its ends included.
pub const POINTS_MAX: usize = 16;

/// A point of a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Waypoint<S, const N: usize> {
    /// Joint position, rad or m.
    pub q: [S; N],
    /// Rest at this point, s. With 0, joints that keep their direction do not stop.
    pub dwell: S,
}

impl<S: Real, const N: usize> Waypoint<S, N> {
    /// A point without a dwell.
    #[must_use]
    pub fn through(q: [S; N]) -> Self {
        Self { q, dwell: S::zero() }
    }
}

/// Durations of the segments between points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Timing<'a, S> {
    /// The duration of each segment, s.
    Durations(&'a [S]),
    /// As short as the bounds on velocity and acceleration allow.
    ///
    /// Each segment first gets the shortest time that it needs from rest to rest,
    /// `max_i max(15/8 |D_i| / qd_i, sqrt(10 / sqrt(3) |D_i| / qdd_i))`; then one factor for the whole motion, from its
    /// exact peaks, makes some joint just touch a bound.
    Fastest,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Knot<S, const N: usize> {
    q: [S; N],
    qd: [S; N],
    dwell: S,
    /// Duration of the segment from here to the next knot; 0 at the last.
    ahead: S,
}

/// Quintic polynomials through points, with continuous position, velocity and acceleration.
///
/// On a segment of duration `T` from `q0` to `q1`, with `s = t / T`, `D = q1 - q0`, `V = T qd` at its ends and no
/// acceleration there:
///
/// ```text
/// q   = q0 + V0 s + c3 s^3 + c4 s^4 + c5 s^5
/// c3  = 10 D - 6 V0 - 4 V1,   c4 = -15 D + 8 V0 + 7 V1,   c5 = 6 D - 3 V0 - 3 V1
/// qdd = s (1 - s) (6 c3 - 20 c5 s) / T^2
/// ```
///
/// The velocity of a joint at a point between two segments is zero if it turns back, rests there or dwells; otherwise
/// the mean of the slopes `D / T` of both segments, but at most twice the lesser. With `V0` and `V1` between 0 and `2 D` the
/// velocity never changes its sign within a segment (it is affine in `V0` and `V1`, so its least value lies at a corner of
/// that square, and there it is not negative): no joint overshoots a point, and a motion between points inside the
/// position limits stays inside.
///
/// Peaks are exact: `qdd` has one root within a segment at most, `6 c3 / (20 c5)`, and its extrema are the roots of a
/// quadratic.
#[derive(Clone, Debug, PartialEq)]
pub struct Quintic<S, const N: usize> {
    knots: Vec<Knot<S, N>, POINTS_MAX>,
}

impl<S: Real, const N: usize> Quintic<S, N> {
    pub(super) fn new(
        points: &[Waypoint<S, N>],
        timing: Timing<'_, S>,
        bounds: &Bounds<S, N>,
    ) -> Result<Self, MotionError> {
        bounds.check()?;
        let given = points.len();
        if given < 2 {
            return Err(MotionError::TooFewPoints { given });
        }
        if let Timing::Durations(durations) = timing
            && durations.len() != given - 1
        {
            return Err(MotionError::DurationCount { given: durations.len(), wanted: given - 1 });
        }
        let mut knots = Vec::new();
        for (i, point) in points.iter().enumerate() {
            bounds.check_position(i, &point.q)?;
            if !(point.dwell >= S::zero() && point.dwell.is_finite()) {
                let value = point.dwell.to_f64();
                return Err(MotionError::OutOfRange { what: "dwell", value, wanted: "finite and not negative" });
            }
            let ahead = match (points.get(i + 1), timing) {
                (None, _) => S::zero(),
                (Some(_), Timing::Durations(durations)) => durations[i],
                (Some(next), Timing::Fastest) => rest_to_rest(i, &point.q, &next.q, bounds)?,
            };
            if i + 1 < given {
                check_time("duration", ahead)?;
            }
            let knot = Knot { q: point.q, qd: [S::zero(); N], dwell: point.dwell, ahead };
            knots.push(knot).map_err(|_| MotionError::TooManyPoints { given, room: POINTS_MAX })?;
        }
        let mut motion = Self { knots };
        motion.set_velocities();
        match timing {
            Timing::Durations(_) => bounds.check_peaks(&motion.peaks())?,
            Timing::Fastest => motion = motion.stretched(bounds.time_scale(&motion.peaks())?),
        }
        Ok(motion)
    }

    fn set_velocities(&mut self) {
        for k in 1..self.knots.len() - 1 {
            let (before, here, after) = (self.knots[k - 1], self.knots[k], self.knots[k + 1]);
            if here.dwell > S::zero() {
                continue;
            }
            self.knots[k].qd = core::array::from_fn(|i| {
                passing_velocity((here.q[i] - before.q[i]) / before.ahead, (after.q[i] - here.q[i]) / here.ahead)
            });
        }
    }

    pub(super) fn first(&self) -> [S; N] {
        self.knots[0].q
    }

    pub(super) fn last(&self) -> [S; N] {
        self.knots[self.knots.len() - 1].q
    }

    pub(super) fn duration(&self) -> S {
        self.knots.iter().fold(S::zero(), |sum, knot| sum + knot.dwell + knot.ahead)
    }

    pub(super) fn arrival(&self, index: usize) -> Option<S> {
        let before = self.knots.get(..=index)?.split_last()?.1;
        Some(before.iter().fold(S::zero(), |sum, knot| sum + knot.dwell + knot.ahead))
    }

    /// Time spent standing at points, s.
    pub(super) fn dwell(&self) -> S {
        self.knots.iter().fold(S::zero(), |sum, knot| sum + knot.dwell)
    }

    pub(super) fn stretched(&self, factor: S) -> Self {
        let mut stretched = self.clone();
        for knot in &mut stretched.knots {
            knot.ahead *= factor;
            knot.qd = knot.qd.map(|qd| qd / factor);
        }
        stretched
    }

    pub(super) fn sample(&self, t: S) -> Reference<S, N> {
        let mut left = t;
        for (knot, next) in self.segments() {
            left -= knot.dwell;
            if left < S::zero() {
                return Reference::at_rest(knot.q);
            }
            if left < knot.ahead {
                return sample_segment(knot, next, left / knot.ahead);
            }
            left -= knot.ahead;
        }
        Reference::at_rest(self.last())
    }

    pub(super) fn peaks(&self) -> Peaks<S, N> {
        let mut peaks = Peaks { velocity: [S::zero(); N], acceleration: [S::zero(); N] };
        for (knot, next) in self.segments() {
            for i in 0..N {
                let (velocity, acceleration) = Segment::new(knot, next, i).peaks();
                peaks.velocity[i] = largest(peaks.velocity[i], velocity / knot.ahead);
                peaks.acceleration[i] = largest(peaks.acceleration[i], acceleration / (knot.ahead * knot.ahead));
            }
        }
        peaks
    }

    fn segments(&self) -> impl Iterator<Item = (&Knot<S, N>, &Knot<S, N>)> {
        self.knots.iter().zip(self.knots.iter().skip(1))
    }
}

/// Time for one segment from rest to rest, s.
fn rest_to_rest<S: Real, const N: usize>(
    segment: usize,
    from: &[S; N],
    to: &[S; N],
    bounds: &Bounds<S, N>,
) -> Result<S, MotionError> {
    let mut time = S::zero();
    let mut moves = false;
    for i in 0..N {
        let way = (to[i] - from[i]).abs();
        moves |= way > S::zero();
        let by_velocity = S::literal(15.0 / 8.0) * way / bounds.velocity[i];
        let by_acceleration = (S::literal(REST_TO_REST_ACCELERATION) * way / bounds.acceleration[i]).sqrt();
        time = largest(time, largest(by_velocity, by_acceleration));
    }
    if time > S::zero() {
        Ok(time)
    } else if moves {
        Err(MotionError::Unbounded { segment })
    } else {
        Err(MotionError::Standstill { segment })
    }
}

/// `10 / sqrt(3)`: greatest acceleration of a quintic from rest to rest over unit distance in unit time.
const REST_TO_REST_ACCELERATION: f64 = 5.773_502_691_896_258;

/// Velocity at a point between segments of these slopes; see [`Quintic`].
fn passing_velocity<S: Real>(before: S, after: S) -> S {
    let zero = S::zero();
    let keeps_on = (before > zero && after > zero) || (before < zero && after < zero);
    if !keeps_on {
        return zero;
    }
    let lesser = if before.abs() < after.abs() { before } else { after };
    let mean = S::literal(0.5) * (before + after);
    mean.clamp_symmetric(S::literal(2.0) * lesser.abs())
}

/// One joint on one segment, in the time `s` that runs from 0 to 1.
struct Segment<S> {
    q: (S, S),
    v0: S,
    v1: S,
    c3: S,
    c4: S,
    c5: S,
}

impl<S: Real> Segment<S> {
    fn new<const N: usize>(knot: &Knot<S, N>, next: &Knot<S, N>, i: usize) -> Self {
        let t = S::literal;
        let d = next.q[i] - knot.q[i];
        let (v0, v1) = (knot.qd[i] * knot.ahead, next.qd[i] * knot.ahead);
        Self {
            q: (knot.q[i], next.q[i]),
            v0,
            v1,
            c3: t(10.0) * d - t(6.0) * v0 - t(4.0) * v1,
            c4: t(-15.0) * d + t(8.0) * v0 + t(7.0) * v1,
            c5: t(6.0) * d - t(3.0) * (v0 + v1),
        }
    }

    fn position(&self, s: S) -> S {
        let (from, to) = self.q;
        let (lo, hi) = if from < to { (from, to) } else { (to, from) };
        let q = from + s * (self.v0 + s * s * (self.c3 + s * (self.c4 + s * self.c5)));
        // It is monotone; rounding must not carry it past a point that lies on a position limit.
        q.clamp_to(lo, hi)
    }

    fn velocity(&self, s: S) -> S {
        let t = S::literal;
        self.v0 + s * s * (t(3.0) * self.c3 + s * (t(4.0) * self.c4 + s * (t(5.0) * self.c5)))
    }

    fn acceleration(&self, s: S) -> S {
        s * (S::one() - s) * (S::literal(6.0) * self.c3 - S::literal(20.0) * self.c5 * s)
    }

    /// Greatest speed and acceleration, per unit of `s` and of `s^2`.
    fn peaks(&self) -> (S, S) {
        let t = S::literal;
        let (a, b) = (t(6.0) * self.c3, t(-20.0) * self.c5);
        // qdd = s (1 - s) (a + b s) has its extrema where a + 2 (b - a) s - 3 b s^2 = 0, and one inner root at most.
        let root = (a * a + b * b + a * b).sqrt();
        let mut velocity = largest(self.v0.abs(), self.v1.abs());
        let mut acceleration = S::zero();
        let inside = |s: S| s > S::zero() && s < S::one();
        let turn = -a / b;
        if inside(turn) {
            velocity = largest(velocity, self.velocity(turn).abs());
        }
        // In the form a / (..) as well as (..) / b: one of them is well conditioned, and with b = 0 defined.
        let sum = b - a;
        let far = if sum < S::zero() { sum - root } else { sum + root };
        for s in [far / (t(3.0) * b), -a / far] {
            if inside(s) {
                acceleration = largest(acceleration, self.acceleration(s).abs());
            }
        }
        (velocity, acceleration)
    }
}

fn sample_segment<S: Real, const N: usize>(knot: &Knot<S, N>, next: &Knot<S, N>, s: S) -> Reference<S, N> {
    let per_time = S::one() / knot.ahead;
    let mut reference = Reference::at_rest(knot.q);
    for i in 0..N {
        let segment = Segment::new(knot, next, i);
        reference.q[i] = segment.position(s);
        reference.qd[i] = segment.velocity(s) * per_time;
        reference.qdd[i] = segment.acceleration(s) * per_time * per_time;
    }
    reference
}
