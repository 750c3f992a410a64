//! Two scalars that measure rounding errors. The recursion and the kernels run on both without change.
//!
//! | module | holds |
//! |---|---|
//! | [`DoubleDouble`] | a reference with about 31 digits: its own error is negligible compared with the error of `f64` |
//! | [`Bounded`] | a value's interval and a proven bound on its rounding error, for every state of a box at once |

mod double_double;
mod error_bound;
mod rounding;

pub use double_double::DoubleDouble;
pub use error_bound::Bounded;
pub use rounding::{Double, Rounding, Single};
