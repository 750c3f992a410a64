//! Distances of an arm from itself and its surroundings, along motions.
//!
//! Metres and radians throughout. The shapes are all that is known: what they do not contain (cables, a gripper, a mesh that is missing)
//! can be hit.

pub mod arm;
pub mod cell;
pub mod mesh;
pub mod motion;
pub mod shape;
