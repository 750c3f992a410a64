//! Studies: answers that are computed, for the command line to print.
//!
//! | module | holds |
//! |---|---|
//! | [`bound`] | how wrong single precision is: what is proven, what was found |
//! | [`campaign`] | every fault in every state of the safety state machine, each tick judged |
//! | [`dynamics`] | inverse and forward dynamics of given states |
//! | [`energy`] | where the energy of a run came from and went |
//! | [`explain`] | what each term of a model costs, and what goes wrong without it |
//! | [`extremes`] | what happens at the edges, cell by cell |
//! | [`kernel`] | the arm's dynamics as source, and what each rewrite is worth |
//! | [`linkage`] | a closed loop, driven round and let run |
//! | [`posture_search`] | the posture that makes least of something |
//! | [`statics`] | what holds an arm at rest |
//! | [`terms`] | the matrices of the equations of motion |
//! | [`trade`] | speed for accuracy: what every choice costs |

pub mod bound;
pub mod campaign;
pub mod dynamics;
pub mod energy;
pub mod explain;
pub mod extremes;
pub mod kernel;
pub mod linkage;
mod numbers;
mod parallel;
pub mod posture_search;
pub mod statics;
pub(crate) mod subject;
pub mod terms;
pub mod trade;
