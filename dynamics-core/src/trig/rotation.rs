//! Sine and cosine by rotating those of a near angle. The derivation is in the documentation of [`super`].

use super::{Binary, Polynomial, SinCos, Trig};

/// Largest change of an angle that is followed by a rotation, rad.
const LARGEST: f64 = 1.0 / 32.0;

/// sin d = d (1 + d^2 S0), |d| <= 1/32; absolute error 3.3e-11.
const SINE: f64 = -1.666_596e-1;

/// cos d = 1 + d^2 C0, |d| <= 1/32; absolute error 6.9e-9.
const COSINE: f64 = -4.999_663e-1;

/// Joints whose angles are remembered.
const JOINTS: usize = 6;

/// An angle with its sine and cosine.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Anchor<S> {
    /// rad; NaN as long as there is none.
    angle: S,
    turn: SinCos<S>,
}

/// From tick to tick: [`Polynomial`]'s sine and cosine of an earlier angle, rotated by the change since then.
///
/// `sin(a + d) = s + (c sin d + s (cos d - 1))`, `cos(a + d) = c + (c (cos d - 1) - s sin d)`, |d| <= 1/32, with two terms each
/// of `sin d` and `cos d`. A joint that is farther than that from its remembered angle `a`, the first tick, and an angle that is
/// not finite or not within 1/32 of the limit take [`Polynomial`], and what it gives is remembered.
///
/// `a` is not the angle of the last tick: rotating what was rotated before adds up rounding errors of the phase, which
/// restoring `sin^2 + cos^2 = 1` does not take away. Here no error outlives a tick, so none grows.
///
/// Only [`Trig::tick`] remembers, and no more than six joints; the other methods give [`Polynomial`]'s values. The sine
/// of -0 is -0 or +0 after +0, and -0 or +0 after -0: the sign of a zero is not kept by a rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotation<S> {
    anchors: [Anchor<S>; JOINTS],
}

macro_rules! rotation {
    ($float:ty) => {
        impl Rotation<$float> {
            /// Nothing remembered.
            #[must_use]
            pub const fn new() -> Self {
                let nothing = SinCos { sin: 0.0, cos: 1.0 };
                Self { anchors: [Anchor { angle: <$float>::NAN, turn: nothing }; JOINTS] }
            }
        }

        impl Default for Rotation<$float> {
            fn default() -> Self {
                Self::new()
            }
        }
    };
}

rotation!(f32);
rotation!(f64);

impl<S: Binary> Trig<S> for Rotation<S>
where
    Polynomial: Trig<S>,
{
    #[inline]
    fn sin_cos(&self, angle: S) -> SinCos<S> {
        Polynomial.sin_cos(angle)
    }

    #[inline]
    fn tick<const N: usize>(&mut self, angles: &[S; N]) -> [SinCos<S>; N] {
        core::array::from_fn(|i| match self.anchors.get_mut(i) {
            Some(anchor) => anchor.follow(angles[i]),
            None => Polynomial.sin_cos(angles[i]),
        })
    }

    #[inline]
    fn forget(&mut self) {
        for anchor in &mut self.anchors {
            anchor.angle = S::NAN;
        }
    }
}

impl<S: Binary> Anchor<S>
where
    Polynomial: Trig<S>,
{
    #[inline]
    fn follow(&mut self, angle: S) -> SinCos<S> {
        let d = angle - self.angle;
        // False for NaN.
        if d.abs() <= S::literal(LARGEST) {
            return rotated(self.turn, d);
        }
        let turn = Polynomial.sin_cos(angle);
        // Next to the limit nothing is remembered, so no rotation leads beyond it.
        let inside = angle.abs() <= S::LIMIT - S::literal(LARGEST);
        *self = Self { angle: if inside { angle } else { S::NAN }, turn };
        turn
    }
}

/// Those of the angle that is `d` rad larger, |d| <= 1/32.
#[inline]
fn rotated<S: Binary>(SinCos { sin: s, cos: c }: SinCos<S>, d: S) -> SinCos<S> {
    let z = d * d;
    let sine = d * (S::one() + z * S::literal(SINE));
    let less_one = z * S::literal(COSINE);
    SinCos { sin: s + (c * sine + s * less_one), cos: c + (c * less_one - s * sine) }
}
