//! Known distances and clearances, and bounds compared with dense sampling.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so")]

mod avoid;
mod meshes;
mod motions;
mod shapes;
