//! Closed-loop simulation on the desk and against the emulated chip.
//!
//! | module | holds |
//! |---|---|
//! | [`plant`] | the simulated arm, its actuators and sensors: f64, an algorithm of its own |
//! | [`chip`] | the firmware in an emulated STM32F405, driven in lock step |
//! | [`chip_cost`] | what a control tick of each of many scenes costs on the chip |
//! | [`target`] | who computes the torques: the desk, the chip, or both beside each other |
//! | [`closed_loop`] | the loop itself, once per control period |
//! | [`simulate`] | from a scene to a finished run |
//! | [`on_chip`] | a run with the chip in the loop |
//! | [`record`] | what happened, tick by tick, and its CSV |
//! | [`summary`] | a run in a few numbers |
//! | [`plot`] | a run in pictures |
//! | [`extremes`] | what happens at the edges, cell by cell |
//! | [`posture_search`] | the posture that makes least of something |
//! | [`linkage_turn`], [`linkage_run`] | a closed loop, driven round and let run |
//! | [`torque_error`] | how wrong single precision is: what is proven, what was found |
//! | [`trade`] | speed for accuracy: what every choice costs |
//! | [`cli`], [`trade_command`], [`run_command`], [`dynamics_command`], [`terms_command`], [`statics_command`], [`energy_command`], [`info_command`], [`kernel_command`], [`linkage_command`], [`explain_command`], [`bound_command`], [`extremes_command`], [`exit`] | the command line |
#![forbid(unsafe_code)]

pub mod bound_command;
pub mod chip;
pub mod chip_cost;
pub mod cli;
pub mod closed_loop;
mod document;
pub mod dynamics_command;
pub mod energy_command;
pub mod exit;
pub mod explain_command;
pub mod extremes;
pub mod extremes_command;
pub mod info_command;
pub mod kernel_command;
pub mod linkage_command;
pub mod linkage_run;
pub mod linkage_turn;
pub mod on_chip;
pub mod plant;
pub mod plot;
pub mod posture_search;
mod progress;
pub mod record;
pub mod run_command;
pub mod simulate;
pub mod statics_command;
mod subject;
pub mod summary;
pub mod target;
pub mod terms_command;
pub mod torque_error;
pub mod trade;
pub mod trade_command;
