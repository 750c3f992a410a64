//! Fixed-size recursive Newton-Euler dynamics and computed-torque control for serial arms of one to six joints.
//!
//! `no_std`, no allocation, no `unsafe`. SI units and radians throughout; joint vectors are `[S; N]`, geometry is
//! nalgebra's fixed-size vectors and matrices. The same source gives the same bits on every machine with IEEE-754
//! arithmetic: nothing here fuses a multiplication with an addition or calls a platform's mathematics library.
//!
//! For a controller:
//!
//! | module | holds |
//! |---|---|
//! | [`scalar`] | the ring that the recursions are written on, and the fields that solving and control need |
//! | [`dual`] | a scalar that carries a derivative |
//! | [`trig`] | sine and cosine: our own polynomials, a table, or libm's |
//! | [`joint`] | how a person describes a joint: frame convention, body, rotor, limits |
//! | [`geometry`] | small products, written out; right angles exact |
//! | [`inertia`] | mass, first moment and inertia about an origin; wrenches |
//! | [`model`] | the arm: checked, immutable, every joint about its own z |
//! | [`scene`] | loads on the arm, and the choice of terms to compute |
//! | [`newton_euler`] | joint torques and joint wrenches from the motion |
//! | [`regressor`] | the matrix that carries inertial parameters to joint torques |
//! | [`mass_matrix`] | the joint-space inertia matrix |
//! | [`momentum`] | generalised momentum and its rate, for observers of external torques |
//! | [`forward_dynamics`] | accelerations from torques, by factoring the inertia matrix |
//! | [`kinematics`] | the poses of the links and the tip, and the tip's Jacobian |
//! | [`energy`] | kinetic and potential energy |
//! | [`linkage`] | planar closed loops: four-bar and slider-crank |
//! | [`drive`] | scales, offsets and ranges between a joint and its drive |
//! | [`fields`] | records whose fields are listed once: for casting, hashing, writing out |
//! | [`control`] | laws, models evaluated every few ticks, limits, observers, collisions, reference motions, the controller and its faults |
//! | [`safety`] | the state machine around the controller: when torque acts, and the safe action otherwise |
//!
//! The textbook's other methods, for checks and for reading, are in [`chapter`]: Lagrange's equations, traces, free bodies in the base
//! frame, statics, reactions, rotors, work.
//!
//! Frames are named so that products read: `parent_from_link * x_link = x_parent`. Equation numbers are those of the
//! robot-dynamics chapter that this crate implements, in the corrected form that `docs/theory/dynamics.md` derives.
//!
//! # Example
//! A pendulum of one link, and the torque that holds it horizontally:
//!
//! ```
//! use dynamics_core::trig::Polynomial;
//! use dynamics_core::{Body, Dh, Dynamics, Frame, InverseDynamics, JointKind, JointSpec, Limits, Live, Model, Rotor, Scene, Tool, Trig};
//! use dynamics_core::nalgebra::{Matrix3, Vector3};
//!
//! let rod = JointSpec {
//!     kind: JointKind::Revolute,
//!     // The link's frame is at its far end, 1 m along x; its mass centre is half way back.
//!     frame: Frame::ClassicalDh(Dh { a: 1.0, ..Dh::default() }),
//!     body: Body { mass: 2.0, com: Vector3::new(-0.5, 0.0, 0.0), inertia: Matrix3::from_diagonal(&Vector3::new(0.0, 0.17, 0.17)) },
//!     rotor: Rotor::default(),
//!     limits: Limits::none(),
//! };
//! let model = Model::new(&[rod], &Tool::default())?.cast::<f32>();
//! let dynamics = Dynamics::new(model, Scene::with_gravity(Vector3::new(0.0, -9.81, 0.0), &model));
//!
//! let q = [0.0];
//! let tau = dynamics.inverse_dynamics(&Polynomial.sin_cos_all(&q), &q, &[0.0], &[0.0], &Live::zero());
//! assert_eq!(tau, [2.0 * 9.81 * 0.5]);
//! # Ok::<(), dynamics_core::ModelError>(())
//! ```
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

/// Runs the examples of the README as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

pub mod chapter;
pub mod control;
pub mod drive;
pub mod dual;
mod dynamics;
pub mod fields;
pub mod geometry;
pub mod inertia;
pub mod joint;
pub mod linkage;
pub mod model;
pub mod safety;
pub mod scalar;
pub mod scene;
pub mod trig;

/// Vectors and matrices of the public types. Use this one: its version fits, and its features do not turn on `std`.
pub use nalgebra;

pub use control::{Command, Controller, ControllerConfig, Fault, Measurement, Reference, Sensed};
pub use dynamics::{energy, forward_dynamics, kinematics, mass_matrix, momentum, newton_euler, regressor};
pub use forward_dynamics::Singular;
pub use inertia::{Inertia, InertiaBounds, Wrench};
pub use joint::{Body, Dh, Frame, JointKind, JointSpec, Limits, Rotor, Tool};
pub use model::{Model, ModelError};
pub use newton_euler::InverseDynamics;
pub use scalar::{Field, Real, Scalar};
pub use scene::{Dynamics, Live, Scene, Term};
pub use trig::{SinCos, Trig};
