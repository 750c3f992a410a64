//! Studies: answers that are computed, for the command line to print.
//!
//! | module | holds |
//! |---|---|
//! | [`campaign`] | every fault in every state of the safety state machine, each tick judged |
//! | [`extremes`] | what happens at the edges, cell by cell |
//! | [`linkage_turn`], [`linkage_run`] | a closed loop, driven round and let run |
//! | [`posture_search`] | the posture that makes least of something |
//! | [`torque_error`] | how wrong single precision is: what is proven, what was found |
//! | [`trade`] | speed for accuracy: what every choice costs |

pub mod campaign;
pub mod extremes;
pub mod linkage_run;
pub mod linkage_turn;
pub mod posture_search;
mod subject;
pub mod torque_error;
pub mod trade;

pub(crate) use subject::Subject;
