//! Readers of files, from text to descriptions.

mod fields;
mod friction;
mod linkage;
mod rest;
mod robot;
mod scene;
pub(crate) mod study;
mod table;
mod text;
mod urdf;

pub use robot::actuators::all as actuators;
