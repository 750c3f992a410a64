//! The ring that the recursions are written on, the field that forward dynamics needs, and the ordered field that the
//! controller needs.
//!
//! A recursion over [`Scalar`] can add, subtract, multiply and negate, and nothing else: it cannot compare or divide, so
//! its path cannot depend on data. That makes its cost constant, its bits reproducible, and lets a tape, an interval or a
//! dual number run through the same source. [`Field`] adds division, for forward dynamics alone; [`Real`] adds order.

use core::ops::{Div, Neg};
use nalgebra::{ClosedAddAssign, ClosedMulAssign, ClosedSubAssign, Vector3};
use num_traits::{One, Zero};

/// Copyable ring arithmetic: `+`, `-`, `*`, negation, zero, one, and a literal.
pub trait Scalar:
    nalgebra::Scalar + Copy + Zero + One + ClosedAddAssign + ClosedSubAssign + ClosedMulAssign + Neg<Output = Self>
{
    /// The value nearest to `x`. Used when a model is built or cast, never inside a recursion.
    fn literal(x: f64) -> Self;

    /// Returns the value itself. A scalar that records its operations may note the label.
    #[inline]
    #[must_use]
    fn labelled(self, _label: Label) -> Self {
        self
    }
}

/// Implements `+=`, `-=` and `*=` of a scalar by its `+`, `-` and `*`: nalgebra requires them, and no scalar has a faster implementation.
///
/// `assign_by_operators!(MyScalar)`, or `assign_by_operators!(MyScalar<R>, R: MyBound)`.
#[macro_export]
macro_rules! assign_by_operators {
    ($scalar:ty $(, $parameter:ident: $bound:path)?) => {
        $crate::assign_by_operators!(@one $scalar, AddAssign, add_assign, Add::add $(, $parameter: $bound)?);
        $crate::assign_by_operators!(@one $scalar, SubAssign, sub_assign, Sub::sub $(, $parameter: $bound)?);
        $crate::assign_by_operators!(@one $scalar, MulAssign, mul_assign, Mul::mul $(, $parameter: $bound)?);
    };
    (@one $scalar:ty, $assign:ident, $method:ident, $operator:ident::$by:ident $(, $parameter:ident: $bound:path)?) => {
        impl$(<$parameter: $bound>)? ::core::ops::$assign for $scalar {
            #[inline]
            fn $method(&mut self, other: Self) {
                *self = ::core::ops::$operator::$by(*self, other);
            }
        }
    };
}

/// Name of an intermediate value of a recursion: which component of which vector of which link. For scalars that record operations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Label {
    /// The quantity's symbol, for example `w` for the angular velocity.
    pub symbol: &'static str,
    /// The link, counted from 1.
    pub link: usize,
    /// `x`, `y` or `z`, in the link's frame.
    pub axis: char,
}

impl Label {
    /// The same vector with every component labelled.
    #[inline]
    #[must_use]
    pub fn vector<S: Scalar>(symbol: &'static str, link: usize, v: Vector3<S>) -> Vector3<S> {
        Vector3::new(
            v.x.labelled(Self { symbol, link, axis: 'x' }),
            v.y.labelled(Self { symbol, link, axis: 'y' }),
            v.z.labelled(Self { symbol, link, axis: 'z' }),
        )
    }
}

/// A scalar that can be divided, still without order.
///
/// Only code that solves for accelerations needs it. A division by zero gives NaN or infinity; functions that divide
/// document where that appears.
pub trait Field: Scalar + Div<Output = Self> {}

/// An ordered field with a notion of "finite": `f32` or `f64`.
///
/// The comparisons below are total in the sense that a NaN never slips through: [`Real::clamp_symmetric`] of NaN is NaN,
/// and [`Real::is_finite`] of NaN is false.
pub trait Real: Field + PartialOrd {
    /// The largest finite number.
    const MAX: Self;

    /// Neither infinite nor NaN.
    fn is_finite(self) -> bool;

    /// Magnitude, exact.
    fn abs(self) -> Self;

    /// Square root, correctly rounded on every target.
    fn sqrt(self) -> Self;

    /// The same number in double precision, exact.
    fn to_f64(self) -> f64;

    /// A whole number, rounded to nearest when the type cannot hold it.
    fn from_i32(x: i32) -> Self;

    /// `self` limited to `[lo, hi]`; NaN stays NaN. The caller ensures `lo <= hi`.
    #[inline]
    fn clamp_to(self, lo: Self, hi: Self) -> Self {
        if self < lo {
            lo
        } else if self > hi {
            hi
        } else {
            self
        }
    }

    /// `self` limited to `[-bound, bound]`; NaN stays NaN.
    #[inline]
    fn clamp_symmetric(self, bound: Self) -> Self {
        self.clamp_to(-bound, bound)
    }

    /// `self` limited to `[-bound, bound]`, by its bits and therefore without a branch; NaN becomes a bound.
    ///
    /// On a Cortex-M4F it needs 6 instructions. Two comparisons need up to 11, and their number depends on the value.
    fn saturated(self, bound: Self) -> Self;
}

macro_rules! impl_scalar {
    ($float:ty, $sqrt:path, $literal:expr) => {
        impl Scalar for $float {
            #[inline]
            fn literal(x: f64) -> Self {
                $literal(x)
            }
        }

        impl Field for $float {}

        impl Real for $float {
            const MAX: Self = <$float>::MAX;

            #[inline]
            fn is_finite(self) -> bool {
                <$float>::is_finite(self)
            }
            #[inline]
            fn abs(self) -> Self {
                <$float>::abs(self)
            }
            #[inline]
            fn sqrt(self) -> Self {
                $sqrt(self)
            }
            #[inline]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline]
            fn from_i32(x: i32) -> Self {
                x as $float
            }
            #[inline]
            fn saturated(self, bound: Self) -> Self {
                // Without their sign, floats are ordered like their bits.
                let (bits, bound) = (self.to_bits(), bound.to_bits());
                let sign = bits & (-0.0 as $float).to_bits();
                Self::from_bits(if bits << 1 > bound << 1 { sign | bound } else { bits })
            }
        }
    };
}

impl_scalar!(f32, libm::sqrtf, |x: f64| x as f32);
impl_scalar!(f64, libm::sqrt, |x: f64| x);
