//! How wrong the joint torques of single precision are: never more than a proven bound, and at least what was found.
//!
//! The exact torque is that of the robot file's numbers (`f64`) in exact arithmetic, at inputs that `f32` holds. Single
//! precision rounds the constants, computes sine and cosine with [`dynamics_core::trig::Polynomial`], and rounds every
//! operation: all three are in the bound, and in what is found. At level `regrouped` the constants are those that the kernel
//! holds, already in single precision: there the bound is of sine, cosine and arithmetic.
//!
//! - **Found.** Random states and corners of the box, then a climb on the error from the worst of them, both against the same
//!   computation in double-double arithmetic. One seed gives one answer, however many threads there are.
//! - **Proven.** The same computation on [`Bounded`](robot_compiler::precision::Bounded), for boxes of states that together are all of them. The worst box is cut
//!   in two, along the input that helps most, until a number of boxes has been looked at: the bound holds after any number,
//!   and falls with it.

mod answer;
mod region;
mod report;
mod search;
mod torque_error;

pub use answer::{Answer, JointAnswer, Question};
pub(crate) use answer::{answer, load, work};
pub use region::{Region, State};
pub use report::markdown;
pub use search::{Effort, Found, random_states, search};
pub use torque_error::{Bounds, TRIG_ERROR, TorqueError};
