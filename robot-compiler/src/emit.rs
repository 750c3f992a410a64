//! Output of a checked arm: as Rust source for the chip with its controller, as a robot file, and as a URDF.
//!
//! The desk reads and checks the files; the chip gets numbers. Every literal is the shortest decimal that reads back as the
//! same number, so the chip computes with exactly the bits that the desk hashed. A firmware computes in single precision,
//! whatever scalar the scene sets for the desk. Programs that only measure costs ([`cost`]) compute in the scene's own
//! scalar.

mod angles;
mod arm;
mod arm_crate;
pub mod c;
mod changed;
pub mod cost;
mod drives;
mod dynamics;
mod expression;
mod fields;
mod firmware;
mod first_scene;
mod items;
pub mod kernel;
pub mod kernel_file;
pub mod modules;
pub mod page;
mod protection;
mod robot_file;
pub mod urdf;

pub use arm::{arm_module, arm_module_in};
pub use arm_crate::{ArmCrate, arm_crate, build_arm, write_arm, write_arm_of};
pub use drives::drives_module;
pub use dynamics::{dynamics_module, dynamics_module_in};
pub use firmware::{Choices, write_firmware};
pub use first_scene::first_scene;
pub use protection::protection_module;
pub use robot_file::robot_file;
pub use urdf::urdf;
