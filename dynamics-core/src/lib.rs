//! Fixed-size recursive Newton-Euler dynamics and computed-torque control for serial arms of one to six joints.
//!
//! `no_std`, no allocation, no `unsafe`. SI units and radians throughout; joint vectors are `[S; N]`, geometry is
//! nalgebra's fixed-size vectors and matrices. The same source gives the same bits on every machine with IEEE-754
//! arithmetic: nothing here fuses a multiplication with an addition or calls a platform's mathematics library.
//!
//! | module | holds |
//! |---|---|
//! | [`scalar`] | the ring that the recursions are written on, and the ordered field that the controller needs |
//! | [`trig`] | sine and cosine: our own polynomials, or libm's |
//! | [`joint`] | how a person describes a joint: frame convention, body, rotor, limits |
//! | [`geometry`] | small products, written out; right angles exact |
//! | [`inertia`] | mass, first moment and inertia about an origin; wrenches |
//! | [`model`] | what the arm is: checked, immutable, every joint about its own z |
//! | [`scene`] | what acts on the arm and which terms are worth computing |
//! | [`newton_euler`] | joint torques and joint wrenches from the motion |
//! | [`mass_matrix`] | the joint-space inertia matrix |
//! | [`forward_dynamics`] | accelerations from torques |
//! | [`kinematics`] | the poses of the links and the tip |
//! | [`energy`] | kinetic and potential energy |
//! | [`control`] | laws, limits, observer, reference motions, the controller and its faults |
//!
//! Frames are named so that products read: `parent_from_link * x_link = x_parent`. Equation numbers are those of the
//! robot-dynamics chapter that this crate implements, in the corrected form that `docs/dynamics.md` derives.
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

pub mod control;
pub mod energy;
pub mod forward_dynamics;
pub mod geometry;
pub mod inertia;
pub mod joint;
pub mod kinematics;
pub mod mass_matrix;
pub mod model;
pub mod newton_euler;
pub mod scalar;
pub mod scene;
pub mod trig;

pub use control::{Command, Controller, ControllerConfig, Fault, Measurement, Reference, Sensed};
pub use inertia::{Inertia, Wrench};
pub use joint::{Body, Dh, Frame, JointKind, JointSpec, Limits, Rotor, Tool};
pub use model::{Model, ModelError};
pub use newton_euler::InverseDynamics;
pub use scalar::{Real, Scalar};
pub use scene::{Dynamics, Live, Scene, Term};
pub use trig::{SinCos, Trig};
