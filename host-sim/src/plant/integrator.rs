//! Integrators: they advance the simulated arm from one instant to the next.
//!
//! The torque is constant over a tick, so the right-hand side jumps between ticks. Every method therefore restarts at
//! each tick, and also inside a tick if a jitter moves the jump there: no step crosses a jump.
//!
//! The embedded pair is our own. Two crates, `ode_solvers` 0.6 (another nalgebra, a vector of results allocated in
//! every tick) and `differential-equations` 0.7, accept no right-hand side that can fail. They also compute powers with
//! the platform's library, so that a run would not have the same bits on every machine. A third, `diffsol` 0.18, is
//! made for stiff systems and brings a matrix library.

use super::{Diverged, State};
use robot_compiler::scene::Integrator;

/// Limit on the adaptive method's steps in a tick, accepted or not.
const ATTEMPTS_MAX: u32 = 100_000;

/// A point of the state space, with positions and velocities.
pub(super) trait Point: Copy {
    /// Apply `f` to every component and the same components of the others.
    fn combine<const K: usize>(&self, others: [&Self; K], f: impl Fn(f64, [f64; K]) -> f64) -> Self;

    /// Advance the velocities along the slope, then the positions along the new velocities.
    fn kicked(&self, slope: &Self, h: f64) -> Self;

    /// Largest magnitude of a component; NaN if any is NaN.
    fn largest(&self) -> f64;
}

impl<const N: usize> Point for State<N> {
    #[inline]
    fn combine<const K: usize>(&self, others: [&Self; K], f: impl Fn(f64, [f64; K]) -> f64) -> Self {
        Self {
            q: core::array::from_fn(|i| f(self.q[i], others.map(|other| other.q[i]))),
            qd: core::array::from_fn(|i| f(self.qd[i], others.map(|other| other.qd[i]))),
        }
    }

    fn kicked(&self, slope: &Self, h: f64) -> Self {
        let qd: [f64; N] = core::array::from_fn(|i| self.qd[i] + slope.qd[i] * h);
        Self { q: core::array::from_fn(|i| self.q[i] + qd[i] * h), qd }
    }

    fn largest(&self) -> f64 {
        self.q.iter().chain(&self.qd).fold(0.0, |most, x| if x.abs() <= most { most } else { x.abs() })
    }
}

/// Differential equation of a point.
pub(super) trait Flow<Y> {
    /// Inputs from outside at one instant.
    type Input;

    /// Inputs at `t` (s into the tick).
    fn input(&self, t: f64) -> Self::Input;

    /// Write the rate of change of the point under the input, per second, to `slope`.
    async fn slope(&self, point: &Y, input: &Self::Input, slope: &mut Y) -> Result<(), Diverged>;
}

/// A part of a tick without a jump, s, and its number of steps.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stretch {
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) steps: u32,
}

/// A completed step: from `t`, of length `h` (s).
pub(super) struct Step<'a, Y> {
    pub(super) t: f64,
    pub(super) h: f64,
    pub(super) before: &'a Y,
    pub(super) after: &'a Y,
}

/// Advance a point along a stretch and call `each` after every step; `next` is the adaptive method's next step, s.
/// After an error, `point` holds the last good state.
pub(super) async fn advance<Y: Point, F: Flow<Y>>(
    integrator: Integrator,
    flow: &F,
    point: &mut Y,
    stretch: Stretch,
    next: &mut f64,
    mut each: impl FnMut(&Step<'_, Y>),
) -> Result<(), Diverged> {
    if let Integrator::Adaptive { tolerance } = integrator {
        return adapt(flow, point, stretch, tolerance, next, each).await;
    }
    let h = (stretch.to - stretch.from) / f64::from(stretch.steps);
    for step in 0..stretch.steps {
        let t = stretch.from + f64::from(step) * h;
        let after = match integrator {
            Integrator::SemiImplicitEuler => semi_implicit_euler(flow, point, t, h).await?,
            _ => runge_kutta(flow, point, t, h).await?,
        };
        if !after.largest().is_finite() {
            return Err(Diverged::NotFinite);
        }
        each(&Step { t, h, before: point, after: &after });
        *point = after;
    }
    Ok(())
}

/// `start + slope * h`.
fn along<Y: Point>(start: &Y, slope: &Y, h: f64) -> Y {
    start.combine([slope], |x, [k]| x + k * h)
}

/// One classical fourth-order step from `t` (s into the tick).
async fn runge_kutta<Y: Point, F: Flow<Y>>(flow: &F, start: &Y, t: f64, h: f64) -> Result<Y, Diverged> {
    let middle = flow.input(t + h / 2.0);
    // Every slope is written before it is read.
    let mut k = [*start; 4];
    flow.slope(start, &flow.input(t), &mut k[0]).await?;
    flow.slope(&along(start, &k[0], h / 2.0), &middle, &mut k[1]).await?;
    flow.slope(&along(start, &k[1], h / 2.0), &middle, &mut k[2]).await?;
    flow.slope(&along(start, &k[2], h), &flow.input(t + h), &mut k[3]).await?;
    Ok(start.combine(k.each_ref(), |x, k| x + (k[0] + 2.0 * (k[1] + k[2]) + k[3]) * (h / 6.0)))
}

/// One step of first order, symplectic for a free arm of constant inertia.
async fn semi_implicit_euler<Y: Point, F: Flow<Y>>(flow: &F, start: &Y, t: f64, h: f64) -> Result<Y, Diverged> {
    let mut slope = *start;
    flow.slope(start, &flow.input(t), &mut slope).await?;
    Ok(start.kicked(&slope, h))
}

/// `sum a_i k_i`.
fn sum<const K: usize>(a: [f64; K], k: [f64; K]) -> f64 {
    a.into_iter().zip(k).fold(0.0, |sum, (a, k)| sum + a * k)
}

/// One step of Dormand and Prince's pair. Returns the point of fifth order, its slope, and the error of the point of
/// fourth order relative to the tolerance. (J. R. Dormand, P. J. Prince, A family of embedded Runge-Kutta formulae,
/// 1980.)
async fn dormand_prince<Y: Point, F: Flow<Y>>(
    flow: &F,
    start: &Y,
    k1: &Y,
    (t, h): (f64, f64),
    tolerance: f64,
) -> Result<(Y, Y, f64), Diverged> {
    // Every slope is written before it is read.
    let [mut k2, mut k3, mut k4, mut k5, mut k6, mut k7] = [*k1; 6];
    let slope = async |c: f64, at: Y, k: &mut Y| flow.slope(&at, &flow.input(t + c * h), k).await;
    slope(1.0 / 5.0, along(start, k1, h / 5.0), &mut k2).await?;
    let at = start.combine([k1, &k2], |x, k| x + h * sum([3.0 / 40.0, 9.0 / 40.0], k));
    slope(3.0 / 10.0, at, &mut k3).await?;
    let at = start.combine([k1, &k2, &k3], |x, k| x + h * sum([44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0], k));
    slope(4.0 / 5.0, at, &mut k4).await?;
    const A5: [f64; 4] = [19_372.0 / 6561.0, -25_360.0 / 2187.0, 64_448.0 / 6561.0, -212.0 / 729.0];
    slope(8.0 / 9.0, start.combine([k1, &k2, &k3, &k4], |x, k| x + h * sum(A5, k)), &mut k5).await?;
    const A6: [f64; 5] = [9017.0 / 3168.0, -355.0 / 33.0, 46_732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18_656.0];
    slope(1.0, start.combine([k1, &k2, &k3, &k4, &k5], |x, k| x + h * sum(A6, k)), &mut k6).await?;
    const B5: [f64; 5] = [35.0 / 384.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0];
    let end = start.combine([k1, &k3, &k4, &k5, &k6], |x, k| x + h * sum(B5, k));
    slope(1.0, end, &mut k7).await?;
    // The weights of fifth order less the weights of fourth.
    const E: [f64; 6] =
        [71.0 / 57_600.0, -71.0 / 16_695.0, 71.0 / 1920.0, -17_253.0 / 339_200.0, 22.0 / 525.0, -1.0 / 40.0];
    let error = start.combine([&end, k1, &k3, &k4, &k5, &k6, &k7], |x, [end, k @ ..]| {
        h * sum(E, k) / (tolerance * (1.0 + x.abs().max(end.abs())))
    });
    Ok((end, k7, error.largest()))
}

/// Advance along a stretch in steps as long as the tolerance allows.
async fn adapt<Y: Point, F: Flow<Y>>(
    flow: &F,
    point: &mut Y,
    stretch: Stretch,
    tolerance: f64,
    next: &mut f64,
    mut each: impl FnMut(&Step<'_, Y>),
) -> Result<(), Diverged> {
    let mut t = stretch.from;
    let mut slope = *point;
    flow.slope(point, &flow.input(t), &mut slope).await?;
    for _ in 0..ATTEMPTS_MAX {
        let left = stretch.to - t;
        // A remainder of the size of a rounding error gets no step of its own.
        let last = *next >= left * (1.0 - 1e-9);
        let h = if last { left } else { *next };
        let (after, slope_after, error) = match dormand_prince(flow, point, &slope, (t, h), tolerance).await {
            Ok(found) => found,
            // A stage can be so far out that it has no sine: the step is too long, so try a shorter one.
            Err(Diverged::NotFinite) => (*point, slope, f64::INFINITY),
            Err(diverged) => return Err(diverged),
        };
        let factor = if error.is_finite() { (0.9 * libm::pow(error, -0.2)).clamp(0.2, 5.0) } else { 0.2 };
        if error <= 1.0 {
            // The end of the stretch may have cut the last step short; then keep the longer one.
            *next = if last { next.max(h * factor) } else { h * factor };
            each(&Step { t, h, before: point, after: &after });
            (*point, slope) = (after, slope_after);
            if last {
                return Ok(());
            }
            t += h;
        } else {
            *next = h * factor.min(0.9);
        }
    }
    Err(Diverged::ToleranceOutOfReach)
}
