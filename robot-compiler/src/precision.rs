//! Two scalars that tell what rounding costs: both run through the recursion and the kernels as they stand.
//!
//! | module | holds |
//! |---|---|
//! | [`double_double`] | a reference with about 31 digits: what is left out cannot be seen beside the error of `f64` |
//! | [`error_bound`] | a value's interval and a proven bound on its rounding error, for every state of a box at once |

pub mod double_double;
pub mod error_bound;

pub use double_double::DoubleDouble;
pub use error_bound::{Bounded, Double, Rounding, Single};
