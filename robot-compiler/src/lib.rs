//! Robot and scene files: read, checked, and converted to the data that the core and the firmware use.
//!
//! | module | holds |
//! |---|---|
//! | `describe` | the types of an arm, a linkage and a scene, and the core's numbers for them; in public [`scene`], [`drive`], [`study`] |
//! | `read` | TOML and URDF files: `load` of [`Robot`], [`LinkageFile`] and [`SceneFile`]; errors name file, line and field |
//! | [`check`] | rules about the numbers of an arm: impossible, improbable and missing values |
//! | [`choose`] | choices for a scene: the fewest terms, the remaining loop gain, the inverse dynamics |
//! | [`kernel`] | from a model and a scene to a straight-line program |
//! | [`emit`] | a checked arm, its controller and its kernels as Rust source for the chip |
//! | [`names`] | choices by name: laws, scalars, sines and cosines, levels, functions |
//! | [`precision`] | rounding errors: a reference with 31 digits, and a bound on the error for a whole box of states |
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

/// Runs the examples of the README as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

pub mod check;
pub mod choose;
mod describe;
pub mod emit;
pub mod kernel;
pub mod names;
pub mod precision;
mod read;

/// The core, in the version that this package's types are made of.
pub use dynamics_core;

pub use describe::cut::{Ends, UrdfArm};
pub use describe::diagnostics::FileError;
pub use describe::friction::{Breakaway, FrictionPart, JointFriction};
pub use describe::link_shape::{Geometry, LinkShape};
pub use describe::linkage::{LinkageFile, Mechanism};
pub use describe::robot::{JointEncoder, JointHeat, Robot, RobotJoint};
pub use describe::scene::SceneFile;
pub use describe::{drive, scene};
pub use read::{actuators, conflict_on_one_bus};

/// Studies: many runs of one scene.
pub mod study {
    pub use crate::describe::study::{
        Design, Experiment, Figure, Key, Literal, Metric, Relative, Runs, Setting, Study, Values, Vary,
    };
    pub use crate::read::study::{Drawn, Template, with_robot};
}
