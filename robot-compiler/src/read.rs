//! Readers of files, from text to descriptions.

mod fields;
mod friction;
mod linkage;
#[cfg(test)]
mod reference_tests;
mod rest;
mod robot;
mod scene;
mod shown;
pub(crate) mod study;
mod table;
mod text;
mod urdf;

pub use robot::actuators::all as actuators;
pub use robot::drive_bus::conflict_on_one_bus;
