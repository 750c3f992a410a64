//! Vectors of floats as scalars.

use core::ops::{Add, AddAssign, Mul, MulAssign, Neg, Sub, SubAssign};
use dynamics_core::{Real, Scalar};
use num_traits::{One, Zero};
use wide::{f32x8, f64x4};

/// A float that has a vector.
pub trait Float: Real + Into<f64> + Send + Sync {
    /// The vector.
    type Lanes: Lanes<Float = Self>;
}

/// A vector of floats that computes as each of them would alone.
pub trait Lanes: Scalar {
    /// What it is a vector of.
    type Float: Float;

    /// How many.
    const COUNT: usize;

    /// The floats from `at` on; zero where the list has ended.
    fn load(list: &[Self::Float], at: usize) -> Self;

    /// Put them into a list from `at` on, as far as it goes.
    fn store(self, list: &mut [Self::Float], at: usize);
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

        impl Float for $float {
            type Lanes = $name;
        }

        impl Lanes for $name {
            type Float = $float;

            const COUNT: usize = $count;

            #[inline]
            fn load(list: &[$float], at: usize) -> Self {
                let rest = list.get(at..).unwrap_or(&[]);
                let lanes = match rest.first_chunk::<$count>() {
                    Some(all) => *all,
                    None => {
                        let mut lanes = [0.0; $count];
                        for (lane, x) in lanes.iter_mut().zip(rest) {
                            *lane = *x;
                        }
                        lanes
                    }
                };
                Self(<$wide>::new(lanes))
            }

            #[inline]
            fn store(self, list: &mut [$float], at: usize) {
                let lanes = self.0.to_array();
                let rest = list.get_mut(at..).unwrap_or(&mut []);
                match rest.first_chunk_mut::<$count>() {
                    Some(all) => *all = lanes,
                    None => {
                        for (x, lane) in rest.iter_mut().zip(lanes) {
                            *x = lane;
                        }
                    }
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
    /// Four `f64` side by side.
    F64x4, f64x4, f64, 4
);
impl_lanes!(
    /// Eight `f32` side by side.
    F32x8, f32x8, f32, 8
);
