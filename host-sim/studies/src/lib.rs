//! Studies: computations whose results the command line prints.
//!
//! | module | holds |
//! |---|---|
//! | [`bound`] | error of single precision: a proven bound, and the largest error found |
//! | [`check`] | rules about the numbers of a robot file, with the loads that they compare with |
//! | [`clearance`] | distances of an arm from itself and its surroundings, along motions |
//! | [`compare`] | two runs on one page |
//! | [`contact`] | the wrench at the tip, felt through a sensor in the base |
//! | [`dynamics`] | inverse and forward dynamics of given states |
//! | [`energy`] | energy balance of a run |
//! | [`excite`] | motions worth recording |
//! | [`explain`] | cost of each term of a model, and the errors without it |
//! | [`identify`] | the model of an arm from logs: its files, its report, the robot file that it becomes |
//! | [`kernel`] | the arm's dynamics as source code, and the operations that each rewrite saves |
//! | [`linkage`] | a closed loop of links, driven at constant speed or simulated under a constant moment |
//! | [`margins`] | how far each number of a scene may go before the arm is lost |
//! | [`path_work`] | work of the actuators along given states |
//! | [`posture_search`] | the posture that minimises a function |
//! | [`statics`] | torques and forces that hold an arm at rest |
//! | [`sweep`] | very many runs whose keys vary, on one machine or many |
//! | [`terms`] | the matrices of the equations of motion |
//! | [`trade`] | speed against accuracy: the cost and the errors of every choice |
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
pub mod path_work;
pub mod posture_search;
pub mod robot_or_scene;
pub mod statics;
pub mod sweep;
pub mod taught;
pub mod terms;
pub mod trade;
