//! A closed loop of links, driven round or let run.
//!
//! | module | holds |
//! |---|---|
//! | [`turn`] | the crank driven round at a constant speed |
//! | [`run`] | the loop let run under a constant moment |
//! | `report` | both as tables |
//! | `files` | both as files |

pub(crate) mod files;
pub(crate) mod report;
pub mod run;
pub mod turn;
