//! The reference motion, buffered ahead of time: a bounded queue of segments, each a fifth-degree polynomial between two points.
//!
//! The polynomial matches position, velocity and acceleration at both points, so the host is free to choose the time between points. A segment
//! has `T` ticks of the control period `h`. With `s = k / T` in tick `k`, and `D = T h`:
//!
//! ```text
//! q(s) = c0 + c1 s + c2 s^2 + c3 s^3 + c4 s^4 + c5 s^5,   q' = (dq/ds) / D,   q'' = (d2q/ds2) / D^2
//! c0 = q0,  c1 = q0' D,  c2 = q0'' D^2 / 2,               d = q1 - q0
//! c3 =  10 d - 6 q0' D - 4 q1' D - (3 q0'' - q1'') D^2 / 2
//! c4 = -15 d + 8 q0' D + 7 q1' D + (3 q0'' - 2 q1'') D^2 / 2
//! c5 =   6 d - 3 q0' D - 3 q1' D - (q0'' - q1'') D^2 / 2
//! ```
//!
//! In the tick of a point the reference equals the point, to the last bit. In between, rounding to f32 affects the acceleration most. A position
//! of 1 rad is rounded by up to 6e-8 rad, so `d` is wrong by up to 1.2e-7 rad. The acceleration error is up to 5.8 / D^2 times that, or
//! 0.007 rad/s^2 on a segment of 10 ms. At 1 kHz a segment of 1 ms has no tick in between. The coefficients are computed when a point arrives, at
//! a lower priority than the tick's and outside its lock.

use dynamics_core::control::Reference;
use heapless::Deque;

/// Number of segments between points that the buffer holds.
pub const WAYS: usize = 16;

/// Reason why a point was refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotTaken {
    /// The point, or a coefficient of the segment to it, is NaN or infinite.
    NonFinite,
    /// The buffer is full.
    Full,
    /// The point has a duration, but there is no point to start from.
    NoStart,
    /// The point is a start, but the arm is following the trajectory.
    Running,
}

/// A segment between two points. Its end is the start of the next segment, or the last point of the trajectory.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment<const N: usize> {
    start: Reference<f32, N>,
    /// Coefficients of `s^3`, `s^4` and `s^5`; the lower ones are the start's values, scaled.
    upper: [[f32; N]; 3],
    /// `1 / T`.
    per_tick: f32,
    /// `D`, s.
    duration: f32,
    /// `1 / D`, 1/s.
    rate: f32,
    ticks: u16,
}

/// A point whose numbers are all finite. Checked before a tick is locked out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FinitePoint<const N: usize>(Reference<f32, N>);

impl<const N: usize> FinitePoint<N> {
    /// Checks a point.
    ///
    /// # Errors
    /// [`NotTaken::NonFinite`].
    pub fn new(point: Reference<f32, N>) -> Result<Self, NotTaken> {
        let all = point.q.iter().chain(&point.qd).chain(&point.qdd);
        if all.copied().all(f32::is_finite) { Ok(Self(point)) } else { Err(NotTaken::NonFinite) }
    }
}

/// Factor from the acceleration at the start to the coefficient of `s^2`, for a segment of this duration in s.
fn square(duration: f32) -> f32 {
    0.5 * duration * duration
}

impl<const N: usize> Segment<N> {
    /// Computes the segment from `start` to `end`, `ticks` control periods long (0 counts as 1). `period` is the control period, s. Returns `None`
    /// if a number of it is NaN or infinite.
    #[must_use]
    pub fn new(start: &Reference<f32, N>, end: &Reference<f32, N>, ticks: u16, period: f32) -> Option<Self> {
        let ticks = ticks.max(1);
        let per_tick = 1.0 / f32::from(ticks);
        let duration = f32::from(ticks) * period;
        let square = square(duration);
        let mut upper = [[0.0; N]; 3];
        let mut sum = 0.0;
        for i in 0..N {
            let d = end.q[i] - start.q[i];
            let (v0, v1) = (start.qd[i] * duration, end.qd[i] * duration);
            let (a0, a1) = (start.qdd[i] * square, end.qdd[i] * square);
            let all = [
                10.0 * d - 6.0 * v0 - 4.0 * v1 - 3.0 * a0 + a1,
                -15.0 * d + 8.0 * v0 + 7.0 * v1 + 3.0 * a0 - 2.0 * a1,
                6.0 * d - 3.0 * v0 - 3.0 * v1 - a0 + a1,
            ];
            for (power, c) in all.into_iter().enumerate() {
                upper[power][i] = c;
                // An infinite or NaN coefficient makes the sum NaN.
                sum += 0.0 * c;
            }
            sum += 0.0 * (start.q[i] + v0 + a0 + end.qd[i] + end.qdd[i]);
        }
        let rate = 1.0 / duration;
        (sum == 0.0 && rate.is_finite()).then_some(Self { start: *start, upper, per_tick, duration, rate, ticks })
    }

    /// Computes the reference `k` ticks after the start. The polynomial and its derivatives come from three synthetic divisions by `s - k / T`; the
    /// remainders are `q`, `dq/ds` and half of `d2q/ds2`.
    ///
    /// Cost: 16 products and 12 sums per joint. Forward differences would need only 12 sums, but loading and storing their 15 numbers takes longer
    /// than the products, and their rounding errors add up over a segment.
    #[inline]
    fn at(&self, k: f32, reference: &mut Reference<f32, N>) {
        let Self { start, upper: [c3, c4, c5], per_tick, duration, rate, .. } = self;
        let s = k * per_tick;
        let square = square(*duration);
        let twice_square = 2.0 * rate * rate;
        for i in 0..N {
            let b4 = c4[i] + s * c5[i];
            let b3 = c3[i] + s * b4;
            let b2 = start.qdd[i] * square + s * b3;
            let b1 = start.qd[i] * duration + s * b2;
            reference.q[i] = start.q[i] + s * b1;
            let d4 = b4 + s * c5[i];
            let d3 = b3 + s * d4;
            let d2 = b2 + s * d3;
            reference.qd[i] = rate * (b1 + s * d2);
            let e4 = d4 + s * c5[i];
            let e3 = d3 + s * e4;
            reference.qdd[i] = twice_square * (d2 + s * e3);
        }
    }
}

/// The buffer of the reference motion. The caller holds the reference of the next tick, so that no tick copies it. That reference is `None` before
/// a start, and after the last point if the motion did not end at rest.
#[derive(Clone, Debug)]
pub struct Trajectory<const N: usize> {
    ways: Deque<Segment<N>, WAYS>,
    /// The last accepted point: the next segment starts there.
    last: Option<Reference<f32, N>>,
    /// Ticks since the start of the first segment.
    k: u16,
    /// Fraction of a tick in addition to `k`, while the arm stops.
    fraction: f32,
    /// Path time per tick while the arm stops, in ticks; `None` means 1. So the initial value is all zeros and needs no flash.
    pace: Option<f32>,
}

impl<const N: usize> Trajectory<N> {
    /// Creates an empty trajectory.
    #[must_use]
    pub const fn new() -> Self {
        Self { ways: Deque::new(), last: None, k: 0, fraction: 0.0, pace: None }
    }

    /// Deletes all points.
    #[inline]
    pub fn clear(&mut self) {
        self.ways.clear();
        (self.last, self.k, self.fraction, self.pace) = (None, 0, 0.0, None);
    }

    /// Returns the number of points that the buffer can still take.
    #[must_use]
    pub fn room(&self) -> usize {
        WAYS - self.ways.len()
    }

    /// Takes the start of a new trajectory.
    pub fn start(&mut self, FinitePoint(point): &FinitePoint<N>, reference: &mut Option<Reference<f32, N>>) {
        self.clear();
        (self.last, *reference) = (Some(*point), Some(*point));
    }

    /// Takes the next point, `ticks` control periods after the previous one (0 counts as 1). `period` is the control period, s.
    ///
    /// # Errors
    /// [`NotTaken`]; nothing is changed.
    pub fn push(&mut self, ticks: u16, period: f32, point: &Reference<f32, N>) -> Result<(), NotTaken> {
        let way = self.last.as_ref().and_then(|last| Segment::new(last, point, ticks, period));
        self.add(way.as_ref(), point)
    }

    /// Returns the last accepted point: the start of the next segment.
    #[must_use]
    pub fn last(&self) -> Option<&Reference<f32, N>> {
        self.last.as_ref()
    }

    /// Takes the next point and the segment to it from [`Trajectory::last`]; `None` stands for a segment that is not finite.
    ///
    /// # Errors
    /// [`NotTaken`]; nothing is changed.
    pub fn add(&mut self, way: Option<&Segment<N>>, point: &Reference<f32, N>) -> Result<(), NotTaken> {
        if self.last.is_none() {
            return Err(NotTaken::NoStart);
        }
        if self.ways.is_full() {
            return Err(NotTaken::Full);
        }
        let way = way.ok_or(NotTaken::NonFinite)?;
        self.ways.push_back(*way).map_err(|_| NotTaken::Full)?;
        self.last = Some(*point);
        Ok(())
    }

    /// Advances the reference by one tick.
    ///
    /// After the last point the reference stays there if the point is at rest. Otherwise it becomes `None`, and a new start is needed.
    #[inline]
    pub fn advance(&mut self, reference: &mut Option<Reference<f32, N>>) {
        let (Some(way), Some(now)) = (self.ways.front(), &mut *reference) else {
            let rests = |r: &Reference<f32, N>| (0..N).all(|i| r.qd[i] == 0.0 && r.qdd[i] == 0.0);
            if !reference.as_ref().is_some_and(rests) {
                self.clear();
                *reference = None;
            }
            return;
        };
        self.k += 1;
        if self.k < way.ticks {
            way.at(f32::from(self.k), now);
        } else {
            self.k = 0;
            self.ways.pop_front();
            if let Some(end) = self.ways.front().map(|next| &next.start).or(self.last.as_ref()) {
                *now = *end;
            }
        }
    }
}

impl<const N: usize> Trajectory<N> {
    /// Advances the reference of an arm that stops along its path by one tick. `period` is the control period, s.
    ///
    /// The path time slows down. With `q'` and `q''` along the path and the pace `p`,
    ///
    /// ```text
    /// qd = q' p,   qdd = q'' p^2 + q' dp/dt,   |qdd| <= deceleration
    /// ```
    ///
    /// `dp/dt` is the lowest value for which the last condition holds for every joint that is slowed down: the arm stays on its path, and no joint
    /// decelerates more than it can. The reference becomes `None` if the points end in motion. The trajectory is empty once the arm has stopped.
    #[cold]
    #[inline(never)]
    pub fn slow_down(
        &mut self,
        reference: &mut Option<Reference<f32, N>>,
        deceleration: impl Fn(usize) -> f32,
        period: f32,
    ) {
        let Some(now) = &mut *reference else { return };
        let Some(way) = self.ways.front() else {
            // The last point is reached, at rest or in motion.
            let rests = (0..N).all(|i| now.qd[i] == 0.0 && now.qdd[i] == 0.0);
            self.clear();
            if !rests {
                *reference = None;
            }
            return;
        };
        let before = self.pace.unwrap_or(1.0);
        let mut along = *now;
        way.at(f32::from(self.k) + self.fraction, &mut along);
        let mut change = -before / period;
        for i in 0..N {
            let (speed, way) = (along.qd[i].abs(), along.qd[i]);
            let own = if way >= 0.0 { along.qdd[i] } else { -along.qdd[i] };
            let most = deceleration(i) + own * before * before;
            // A joint that its path alone already slows down by the limit is not slowed down further.
            if speed * -change > most {
                change = -(most.max(0.0) / speed);
            }
        }
        let pace = (before + change * period).max(0.0);
        self.pace = Some(pace);
        self.fraction += 0.5 * (before + pace);
        while self.fraction >= 1.0 {
            self.fraction -= 1.0;
            self.k += 1;
            if self.ways.front().is_some_and(|way| self.k >= way.ticks) {
                self.k = 0;
                self.ways.pop_front();
            }
        }
        match (self.ways.front(), &self.last) {
            (Some(way), _) => way.at(f32::from(self.k) + self.fraction, now),
            (None, Some(last)) => *now = *last,
            (None, None) => {}
        }
        for i in 0..N {
            now.qdd[i] = now.qdd[i] * pace * pace + now.qd[i] * ((pace - before) / period);
            now.qd[i] *= pace;
        }
        if pace <= 0.0 {
            (now.qd, now.qdd) = ([0.0; N], [0.0; N]);
            self.clear();
        }
    }
}

impl<const N: usize> Default for Trajectory<N> {
    fn default() -> Self {
        Self::new()
    }
}
