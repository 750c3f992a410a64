//! Inverse dynamics of many states at once, on the desk: for sweeps and Monte Carlo runs.
//!
//! Several states run through the *same* recursion, or the same generated kernel, at once: the scalar is a vector of floats ([`F64Lanes`],
//! [`F32Lanes`]) instead of a single float. Nothing else changes, so each state's torques have the same bits as with single floats.
//!
//! | module | holds |
//! |---|---|
//! | [`lanes`] | vectors of floats as scalars |
//! | [`states`] | memory layout of the states |
//! | [`inverse_dynamics`] | the loop over the states, on one core and on all |
//!
//! # Example
//! A thousand states of an arm:
//!
//! ```
//! use dynamics_batch::{F64Lanes, States, inverse_dynamics_batch};
//! use dynamics_core::trig::Polynomial;
//! use dynamics_core::{Body, Dynamics, Frame, JointKind, JointSpec, Limits, Live, Model, Rotor, Scene, Tool};
//! use nalgebra::Vector3;
//!
//! let rod = JointSpec {
//!     kind: JointKind::Revolute,
//!     frame: Frame::ClassicalDh(dynamics_core::Dh { a: 1.0, ..Default::default() }),
//!     body: Body { mass: 2.0, com: Vector3::new(-0.5, 0.0, 0.0), ..Body::massless() },
//!     rotor: Rotor::default(),
//!     limits: Limits::none(),
//! };
//! let model = Model::new(&[rod], &Tool::default())?;
//! let scene = Scene::with_gravity(Vector3::new(0.0, -9.81, 0.0), &model);
//! // The model and the scene in lanes: every lane holds the same arm.
//! let dynamics = Dynamics::new(model.cast::<F64Lanes>(), scene.cast());
//!
//! let q: Vec<f64> = (0..1000).map(|i| f64::from(i) * 0.001).collect();
//! let still = vec![0.0; 1000];
//! let states = States::new([&q], [&still], [&still])?;
//! let mut tau = vec![0.0; 1000];
//! inverse_dynamics_batch(&dynamics, &Polynomial, &states, &Live::zero(), [&mut tau])?;
//! assert_eq!(tau[0], 9.81);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Instruction set
//! The crate `wide` selects its instructions at compile time. An ordinary build for x86-64 uses SSE2 only, and [`F64Lanes`] is then a vector of
//! two. `RUSTFLAGS="-C target-cpu=native" cargo build --release` uses all instructions of the machine. The bits are the same in both cases, because
//! no multiplication is fused with an addition.
#![forbid(unsafe_code)]

pub mod inverse_dynamics;
pub mod lanes;
pub mod states;

pub use inverse_dynamics::{inverse_dynamics_batch, inverse_dynamics_batch_parallel};
pub use lanes::{F32Lanes, F32x4, F32x8, F32x16, F64Lanes, F64x2, F64x4, F64x8, Float, Lanes};
pub use states::{LengthError, States};
