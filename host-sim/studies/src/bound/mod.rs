//! Error of the joint torques in single precision: a proven upper bound, and the largest error found.
//!
//! The exact torque follows from the numbers of the robot file (`f64`) in exact arithmetic, at inputs that `f32` represents exactly. Single precision
//! rounds the constants, computes sine and cosine with [`dynamics_core::trig::Polynomial`], and rounds every operation. The proven bound and the
//! found errors include all three. At level `regrouped` the constants are those of the kernel, already in single precision, so the bound covers sine,
//! cosine and arithmetic.
//!
//! - **Found.** Random states and corners of the box are evaluated, then the error is increased by climbs from the
//!   worst of them. Both are compared with the same computation in double-double arithmetic. The result depends on the
//!   seed, not on the number of threads.
//! - **Proven.** The same computation runs on [`Bounded`](robot_compiler::precision::Bounded), for boxes of states that
//!   together cover all states. The worst box is repeatedly cut in two along the input that helps most, up to a given
//!   number of boxes. The bound holds after any number and falls with it.

mod answer;
mod region;
mod report;
mod search;
mod torque_error;

pub use answer::{BoundRequest, JointErrorBound, TorqueErrorBound};
pub use answer::{answer, load, work};
pub use region::{Region, State};
pub use report::markdown;
pub use search::{Effort, LargestError, random_states, search};
pub use torque_error::{Bounds, TRIG_ERROR, TorqueError};
