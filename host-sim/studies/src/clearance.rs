//! Distances of an arm from itself and its surroundings, along motions.
//!
//! All quantities are in metres and radians. **Only the shapes are known: objects that they do not contain (cables, a gripper, a missing mesh) can be
//! hit.**

pub mod arm;
pub mod cell;
pub mod mesh;
pub mod motion;
pub mod shape;
