//! Two precisions in one controller: the recursion and the sine in f32, everything about them in f64.
//!
//! A position is a large number whose small differences count: at 1,000 turns an f32 angle steps by 0.5 mrad, in its
//! error as in its sine. The recursion has no such differences: it adds numbers of one size, and 24 bits are enough.
//! So observer, law, limits, friction and the reduction of the angles to one turn stay in f64, and what costs most
//! runs in f32 ([`Narrow`], [`Reduced`]).

use crate::newton_euler::InverseDynamics;
use crate::scene::Live;
use crate::trig::{SinCos, Trig};

/// Inverse dynamics in f32 for a controller in f64.
///
/// Every input is rounded to f32, nearest first, and every torque widened. A number beyond f32's range becomes an
/// infinity, as an f32 scene would have it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Narrow<D>(pub D);

/// Element by element to f32, rounded to nearest.
#[inline]
fn narrow<const N: usize>(x: &[f64; N]) -> [f32; N] {
    x.map(|x| x as f32)
}

/// Element by element to f32, rounded to nearest; exact for what [`Reduced`] gives.
#[inline]
fn narrow_turns<const N: usize>(turn: &[SinCos<f64>; N]) -> [SinCos<f32>; N] {
    turn.map(|SinCos { sin, cos }| SinCos { sin: sin as f32, cos: cos as f32 })
}

impl<const N: usize, D: InverseDynamics<f32, N>> InverseDynamics<f64, N> for Narrow<D> {
    #[inline]
    fn inverse_dynamics(
        &self,
        turn: &[SinCos<f64>; N],
        q: &[f64; N],
        qd: &[f64; N],
        qdd: &[f64; N],
        live: &Live<f64, N>,
    ) -> [f64; N] {
        self.0.inverse_dynamics(&narrow_turns(turn), &narrow(q), &narrow(qd), &narrow(qdd), &live.cast()).map(f64::from)
    }

    #[inline]
    fn tick(
        &mut self,
        turn: impl FnOnce() -> [SinCos<f64>; N],
        q: &[f64; N],
        qd: &[f64; N],
        qdd: &[f64; N],
        live: &Live<f64, N>,
    ) -> [f64; N] {
        self.0.tick(|| narrow_turns(&turn()), &narrow(q), &narrow(qd), &narrow(qdd), &live.cast()).map(f64::from)
    }

    #[inline]
    fn forget(&mut self) {
        self.0.forget();
    }
}

/// Sine and cosine in f32 of an angle in f64, which is reduced to one turn first.
///
/// `r = x - 2 pi round(x / 2 pi)`, in `[-pi, pi]` but for the rounding of the quotient, then `T` of `r` in f32.
///
/// 2 pi is split in two, and the leading part has so few bits that its product with the number of turns, and the difference
/// from the angle, are exact: `r` is as good as an f64 near pi. What is left is the rounding of `r` to f32, at most
/// `2^-23` (1.2e-7), and the error of `T`. No branch, no division; beyond [`Reduced::LIMIT`], and for NaN, both are NaN
/// if those of `T` are for NaN.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reduced<T>(pub T);

/// The leading 33 bits of 2 pi.
const TURN: f64 = 6.283_185_306_936_502_5;
/// 2 pi less [`TURN`].
const TURN_REST: f64 = 2.430_840_202_602_477e-10;
/// `1 / (2 pi)`.
const PER_TURN: f64 = 0.5 * core::f64::consts::FRAC_1_PI;
/// 1.5 * 2^52: added to a number and taken away again, it rounds it to the nearest integer.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// Overflows when it multiplies an angle beyond the limit, and no other.
const OVERFLOW: f64 = f64::MAX / LIMIT;
const LIMIT: f64 = 1_048_576.0;

/// The angle less whole turns, rounded to f32; NaN beyond the limit.
#[inline]
fn reduce(angle: f64) -> f32 {
    let within = angle.abs() * OVERFLOW * 0.0;
    let turns = (angle * PER_TURN + (ROUND + within)) - ROUND;
    ((angle - turns * TURN) - turns * TURN_REST) as f32
}

#[inline]
fn widen(SinCos { sin, cos }: SinCos<f32>) -> SinCos<f64> {
    SinCos { sin: sin.into(), cos: cos.into() }
}

impl<T> Reduced<T> {
    /// The largest angle, rad, either sign: 2^20, more than 166,000 turns.
    pub const LIMIT: f64 = LIMIT;
}

impl<T: Trig<f32>> Trig<f64> for Reduced<T> {
    #[inline]
    fn sin_cos(&self, angle: f64) -> SinCos<f64> {
        widen(self.0.sin_cos(reduce(angle)))
    }

    #[inline]
    fn tick<const N: usize>(&mut self, angles: &[f64; N]) -> [SinCos<f64>; N] {
        self.0.tick(&angles.map(reduce)).map(widen)
    }

    #[inline]
    fn forget(&mut self) {
        self.0.forget();
    }
}
