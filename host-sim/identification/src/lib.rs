//! Identification of an arm's model from logs of its motion: inertial parameters, friction and payload.
//!
//! `tau = Y(q, qd, qdd) pi + friction(q, qd, load)`, in SI units. This package reads no robot files and prints nothing.
#![forbid(unsafe_code)]

pub mod arm;
pub mod audit;
pub mod base;
pub mod choose;
pub mod clock;
pub mod consistent;
pub mod correction;
pub mod delay;
pub mod evidence;
pub mod excite;
pub mod filter;
pub mod fit;
pub mod friction;
pub mod held;
pub mod hypotheses;
pub mod identify;
pub mod log;
pub mod payload;
pub mod prediction;
pub mod prepare;
mod random;
mod statistics;
pub mod verdict;

/// Samples of a quantity: one list for each joint.
pub type Series = Vec<Vec<f64>>;
