//! A closed loop of links, driven at constant speed or simulated under a constant moment.

pub mod files;
pub mod report;
pub mod run;
pub mod turn;
