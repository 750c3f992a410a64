//! What a scene needs.
//!
//! | module | holds |
//! |---|---|
//! | `terms` | the fewest terms of a model that a tolerance allows |
//! | `loop_gain` | how strong the feedback is with them |
//! | `dynamics` | the inverse dynamics that a scene asks for, on the desk |

mod dynamics;
mod loop_gain;
mod terms;

pub use dynamics::{ArmDynamics, Ready};
pub use loop_gain::LoopGain;
pub use terms::{Along, FewestTerms, TorqueError};
