//! Choices that follow from a scene: its terms, its loop gain and its inverse dynamics.
//!
//! | module | holds |
//! |---|---|
//! | `terms` | the fewest terms of a model that a tolerance allows |
//! | `loop_gain` | the strength of the feedback that remains with these terms |
//! | `dynamics` | the inverse dynamics that a scene selects, run on the desk |

mod dynamics;
mod loop_gain;
mod terms;

pub use dynamics::ArmDynamics;
pub use loop_gain::LoopGain;
pub use terms::{Along, FewestTerms, TorqueError, operations_of};
