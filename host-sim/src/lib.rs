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
//! | [`drill`] | the firmware under its safety state machine, on the desk and in the chip |
//! | [`states`] | the numbers of that machine's states, and the ways between them |
//! | [`campaign`] | every fault in every state of that machine, each tick judged |
//! | [`operate`] | an operator at a board on a serial port, or in a drill |
//! | [`frame_log`] | all that was said over a link, as a file |
//! | [`replay`] | such a file through the same session on the desk |
//! | [`record`] | what happened, tick by tick, and its CSV |
//! | [`summary`] | a run in a few numbers |
//! | [`plot`] | a run in pictures |
//! | [`extremes`] | what happens at the edges, cell by cell |
//! | [`posture_search`] | the posture that makes least of something |
//! | [`linkage_turn`], [`linkage_run`] | a closed loop, driven round and let run |
//! | [`serial`] | a serial port to a board, as whole frames |
//! | [`doctor`] | is everything there that a use of the project needs |
//! | [`torque_error`] | how wrong single precision is: what is proven, what was found |
//! | [`trade`] | speed for accuracy: what every choice costs |
//! | [`cli`], [`trade_command`], [`run_command`], [`dynamics_command`], [`terms_command`], [`statics_command`], [`energy_command`], [`info_command`], [`kernel_command`], [`linkage_command`], [`explain_command`], [`bound_command`], [`extremes_command`], [`campaign_command`], [`doctor_command`], [`connect_command`], [`replay_command`], [`exit`] | the command line |
#![forbid(unsafe_code)]

pub mod bound_command;
pub mod campaign;
pub mod campaign_command;
pub mod chip;
pub mod chip_cost;
pub mod cli;
pub mod closed_loop;
pub mod connect_command;
pub mod doctor;
pub mod doctor_command;
mod document;
pub mod drill;
pub mod dynamics_command;
pub mod energy_command;
pub mod exit;
pub mod explain_command;
pub mod extremes;
pub mod extremes_command;
pub mod frame_log;
pub mod info_command;
pub mod kernel_command;
pub mod linkage_command;
pub mod linkage_run;
pub mod linkage_turn;
pub mod on_chip;
pub mod operate;
pub mod plant;
pub mod plot;
pub mod posture_search;
mod progress;
pub mod record;
pub mod replay;
pub mod replay_command;
pub mod run_command;
pub mod serial;
pub mod simulate;
pub mod states;
pub mod statics_command;
mod subject;
pub mod summary;
pub mod target;
pub mod terms_command;
pub mod torque_error;
pub mod trade;
pub mod trade_command;
