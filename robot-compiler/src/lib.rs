//! Robot and scene files, read, checked, and turned into what the core and the firmware run on.
//!
//! | module | holds |
//! |---|---|
//! | [`robot`] | what an arm is: joints, links, motors, sensors, tool |
//! | [`linkage`] | what a planar closed loop is: four-bar or slider-crank |
//! | [`scene`] | what acts on an arm, how it is controlled, what is simulated |
//! | [`drive`] | what drives a joint, in a file's units and in the chip's |
//! | [`diagnostics`] | errors that point at file, line and field |
//! | [`emit`] | a checked arm and its controller as Rust source for the chip |
//! | [`hash`] | one number for everything that decides the bits of a tick |
//! | [`precision`] | what rounding costs: a reference with 31 digits, and a bound on the error for a whole box of states |
//!
//! ```
//! use robot_compiler::{Robot, with_dof};
//!
//! let text = r#"
//!     name = "pendulum"
//!     source = "a rod of 1 kg and 1 m"
//!     [[joint]]
//!     name = "swing"
//!     type = "revolute"
//!     dh = { a = 1.0, alpha = 0.0, d = 0.0, theta = 0.0 }
//!     mass = 1.0
//!     com = [-0.5, 0.0, 0.0]
//! "#;
//! let robot = Robot::from_toml_str(text, "pendulum.toml")?;
//! let mass = with_dof!(robot.dof(), N => robot.model::<N>()?.links()[0].inertia.mass);
//! assert_eq!(mass, 1.0);
//! # Ok::<(), robot_compiler::FileError>(())
//! ```
#![forbid(unsafe_code)]

mod body_fields;
pub mod diagnostics;
mod dof;
pub mod drive;
mod drive_file;
pub mod emit;
pub mod hash;
pub mod kernel;
pub mod linkage;
mod linkage_file;
pub mod precision;
mod reader;
pub mod robot;
mod robot_file;
pub mod scene;
mod scene_file;
mod urdf;

pub use diagnostics::FileError;
pub use linkage::{LinkageFile, Mechanism};
pub use robot::{JointEncoder, JointFriction, Robot, RobotJoint};
pub use scene::SceneFile;
