//! Other methods of the textbook (Jazar, *Theory of Applied Robotics*, chapter 12). They give the same numbers for the same arms as the recursions,
//! at a higher cost. Read them together with the chapter, or check the recursions against them. No controller needs them.
//!
//! | module | holds |
//! |---|---|
//! | [`posture`] | axes, points, mass centres and motion in the base frame, as the chapter draws them |
//! | [`lagrange`] | Lagrange's equations from the links' Jacobians: matrices, Christoffel symbols, torques |
//! | [`trace_form`] | the same from derivatives of 4x4 transforms, sharing nothing with the others |
//! | [`global`] | every link's Newton and Euler equation in the base frame, and all of them as one linear system |
//! | [`statics`] | joint wrenches and torques at rest, inward and outward, in the base frame and in the links' |
//! | [`contact`] | the wrench at the tip from the one that the base measures |
//! | [`reactions`] | the split of a joint's wrench between its actuator and its bearings |
//! | [`rotor_coupling`] | torques that reflected rotor inertia leaves out |
//! | [`work`] | work done by the actuators along a motion |

pub mod contact;
pub mod global;
pub mod lagrange;
pub mod posture;
pub mod reactions;
pub mod rotor_coupling;
pub mod statics;
pub mod trace_form;
pub mod work;
