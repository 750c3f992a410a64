//! The firmware's session with its host, on the desk and at a board.
//!
//! | module | holds |
//! |---|---|
//! | [`drive`] | the firmware's session in this program, with the drives at CAN adapters |
//! | [`dry_run`] | the firmware under its safety state machine, on the desk and in the chip |
//! | [`states`] | the numbers of that machine's states, and the transitions between them |
//! | [`operate`] | an operator at a board on a serial port, or in a dry run |
//! | [`frame_log`] | all frames over a link, as a file |
//! | [`local`] | access to a running session for other programs on this computer |
//! | [`replay`] | such a file through the same session on the desk |
//! | [`serial`] | a serial port to a board, as whole frames |
//! | [`doctor`] | checks of everything that a use of the project needs |

pub mod doctor;
pub mod drive;
pub mod dry_run;
pub mod frame_log;
pub mod local;
pub mod operate;
pub mod replay;
pub mod serial;
pub mod states;
