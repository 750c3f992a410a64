//! The model of an arm from logs of its motion: inertial parameters, friction, payload.
//!
//! | module | holds |
//! |---|---|
//! | [`log`] | a log: columns of a CSV file, and what is wrong with them |
//! | [`clock`] | time stamps that jitter |
//! | [`correction`] | signs, scales, order of columns, delay |
//! | [`filter`] | even time, a low-pass without delay, derivatives |
//! | [`arm`] | what identification sees of an arm: torque by inertial parameters |
//! | [`base`] | the combinations of parameters that torques depend on |
//! | [`friction`] | laws of friction, linear in their coefficients |
//! | [`held`] | samples in which friction holds a joint, which tell nothing |
//! | [`prepare`] | a log and an arm together: filtered torques and columns |
//! | [`fit`] | weighted least squares with robust weights, held-out error, deviations |
//! | [`choose`] | which terms of friction and which cut-off earn their place |
//! | [`audit`] | the mass matrix over all postures, against the maker's |
//! | [`consistent`] | bodies that some mass distribution could have, nearest to data and maker |
//! | [`delay`] | delay between torques and positions |
//! | [`identify`] | all of it in order, and predictions |
//! | [`evidence`] | the score of a log: residuals, distance from the maker's numbers, friction |
//! | [`hypotheses`] | faults of a log that explain it: signs, units, order of columns, gravity |
//! | [`verdict`] | trusted, doubtful or refused, with reasons |
//! | [`payload`] | what an arm holds, from a log against a known arm |
//! | [`excite`] | motions worth recording |
//!
//! `tau = Y(q, qd, qdd) pi + friction(q, qd, load)`, SI units throughout. Nothing here reads robot files or prints.
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
pub mod prepare;
pub mod verdict;

/// One list of samples for each joint.
pub type Series = Vec<Vec<f64>>;
