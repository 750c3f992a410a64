//! Vectors of floats as scalars, with the width of the registers that the compiler may use.
//!
//! | `target_feature` | f64 | f32 |
//! |---|---|---|
//! | `avx512f` | [`F64x8`] | [`F32x16`] |
//! | `avx` | [`F64x4`] | [`F32x8`] |
//! | neither | [`F64x2`] | [`F32x4`] |
//!
//! [`F64Lanes`] and [`F32Lanes`] are the selected types. Wider vectors would work too, in two halves, but would need too many registers.

use core::ops::{Add, AddAssign, Mul, MulAssign, Neg, Sub, SubAssign};
use dynamics_core::{Real, Scalar};
use num_traits::{One, Zero};
use wide::{f32x4, f32x8, f32x16, f64x2, f64x4, f64x8};

/// A float that has a vector.
pub trait Float: Real + Into<f64> + Send + Sync {
    /// The vector.
    type Lanes: Lanes<Float = Self>;
}

/// A vector of floats; each lane computes exactly as the float alone.
pub trait Lanes: Scalar {
    /// Type of a lane.
    type Float: Float;

    /// Number of lanes.
    const COUNT: usize;

    /// Loads vector number `place` of the list, which is divided into vectors from its start; zero if the list has no whole vector there.
    fn load(list: &[Self::Float], place: usize) -> Self;

    /// Stores the vector as number `place` of the list; does nothing if the list has no whole vector there.
    fn store(self, list: &mut [Self::Float], place: usize);
}

macro_rules! impl_lanes {
    ($(#[$doc:meta])* $name:ident, $wide:ty, $float:ty, $count:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[repr(transparent)]
        pub struct $name(pub $wide);

        impl_lanes!(@operator $name, Add, add, AddAssign, add_assign);
        impl_lanes!(@operator $name, Sub, sub, SubAssign, sub_assign);
        impl_lanes!(@operator $name, Mul, mul, MulAssign, mul_assign);

        impl Neg for $name {
            type Output = Self;
            #[inline]
            fn neg(self) -> Self {
                Self(-self.0)
            }
        }

        impl Zero for $name {
            #[inline]
            fn zero() -> Self {
                Self(<$wide>::splat(0.0))
            }
            #[inline]
            fn is_zero(&self) -> bool {
                *self == Self::zero()
            }
        }

        impl One for $name {
            #[inline]
            fn one() -> Self {
                Self(<$wide>::splat(1.0))
            }
        }

        impl Scalar for $name {
            /// The same number in every lane.
            #[inline]
            fn literal(x: f64) -> Self {
                Self(<$wide>::splat(<$float>::literal(x)))
            }
        }

        impl Lanes for $name {
            type Float = $float;

            const COUNT: usize = $count;

            #[inline]
            fn load(list: &[$float], place: usize) -> Self {
                let (vectors, _) = list.as_chunks::<$count>();
                Self(vectors.get(place).map_or(<$wide>::splat(0.0), |vector| <$wide>::new(*vector)))
            }

            #[inline]
            fn store(self, list: &mut [$float], place: usize) {
                let (vectors, _) = list.as_chunks_mut::<$count>();
                if let Some(vector) = vectors.get_mut(place) {
                    *vector = self.0.to_array();
                }
            }
        }
    };
    (@operator $name:ident, $operator:ident, $function:ident, $assigning:ident, $assign:ident) => {
        impl $operator for $name {
            type Output = Self;
            #[inline]
            fn $function(self, other: Self) -> Self {
                Self($operator::$function(self.0, other.0))
            }
        }

        impl $assigning for $name {
            #[inline]
            fn $assign(&mut self, other: Self) {
                *self = $operator::$function(*self, other);
            }
        }
    };
}

impl_lanes!(
    /// A vector of two `f64`.
    F64x2, f64x2, f64, 2
);
impl_lanes!(
    /// A vector of four `f64`.
    F64x4, f64x4, f64, 4
);
impl_lanes!(
    /// A vector of eight `f64`.
    F64x8, f64x8, f64, 8
);
impl_lanes!(
    /// A vector of four `f32`.
    F32x4, f32x4, f32, 4
);
impl_lanes!(
    /// A vector of eight `f32`.
    F32x8, f32x8, f32, 8
);
impl_lanes!(
    /// A vector of sixteen `f32`.
    F32x16, f32x16, f32, 16
);

/// The widest vectors of the build.
mod widest {
    #[cfg(not(target_feature = "avx"))]
    pub(super) use super::{F32x4 as Single, F64x2 as Double};
    #[cfg(all(target_feature = "avx", not(target_feature = "avx512f")))]
    pub(super) use super::{F32x8 as Single, F64x4 as Double};
    #[cfg(target_feature = "avx512f")]
    pub(super) use super::{F32x16 as Single, F64x8 as Double};
}

/// Vector of as many `f64` as a register of the build holds.
pub type F64Lanes = widest::Double;
/// Vector of as many `f32` as a register of the build holds.
pub type F32Lanes = widest::Single;

impl Float for f64 {
    type Lanes = F64Lanes;
}

impl Float for f32 {
    type Lanes = F32Lanes;
}
