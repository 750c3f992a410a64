//! Computations for the commands of the command line: their results, tables and pages.
#![forbid(unsafe_code)]

pub mod bound;
pub mod check;
pub mod clearance;
pub mod compare;
pub mod contact;
pub mod dynamics;
pub mod energy;
pub mod excite;
pub mod explain;
pub mod identify;
pub mod kernel;
pub mod linkage;
pub mod margins;
mod numbers;
pub mod options;
pub mod path_work;
pub mod posture_search;
mod ranked;
pub mod robot_or_scene;
pub mod statics;
pub mod sweep;
pub mod taught;
pub mod terms;
pub mod trade;
