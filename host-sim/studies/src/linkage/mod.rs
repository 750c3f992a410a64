//! A closed loop of links, driven at constant speed or simulated under a constant moment.
//!
//! | module | holds |
//! |---|---|
//! | [`turn`] | one turn of the crank at a constant speed |
//! | [`run`] | motion under a constant moment on the crank |
//! | `report` | both as tables |
//! | `files` | both as files |

pub mod files;
pub mod report;
pub mod run;
pub mod turn;
