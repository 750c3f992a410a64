//! Distances of an arm from itself and its surroundings, along motions.
//!
//! | module | holds |
//! |---|---|
//! | [`shape`] | convex hulls of points, thickened by a radius, and a lower bound on the gap between two |
//! | [`arm`] | shapes of links that are known by their joints and mass centres alone |
//! | [`mesh`] | points of STL and OBJ files |
//! | [`cell`] | an arm among boxes, above a floor: the pairs that are judged and those that are exempt |
//! | [`motion`] | a guaranteed lower bound on the clearance of a whole motion |
//!
//! Metres and radians throughout. The shapes are all that is known: what they do not contain (cables, a gripper, a mesh that is missing)
//! can be hit.

pub mod arm;
pub mod cell;
pub mod mesh;
pub mod motion;
pub mod shape;
