//! The recursions, the control loop and the chapter on a desk.

mod assembled;
mod chapter12;
mod chapter12_map;
mod common;
mod contact;
mod control;
mod example_324;
mod exercise_07;
mod fields;
mod forward_dynamics;
mod golden;
mod identities;
mod impossible;
mod inertia_bounds;
mod methods;
mod momentum;
mod operations;
mod reactions;
mod regressor;
mod rotor_coupling;
mod safety;
mod statics;
mod trace_energies;
mod trajectory;
mod trig;
mod work;
