//! A closed-loop run: from a scene to a record, a summary and plots.
//!
//! | module | holds |
//! |---|---|
//! | [`target`] | who computes the torques: the desk, the chip, or both beside each other |
//! | [`closed_loop`] | the loop itself, once per control period |
//! | [`simulate`] | from a scene to a finished run |
//! | [`record`] | what happened, tick by tick, and its CSV |
//! | [`summary`] | a run in a few numbers |
//! | [`plot`] | a run in pictures |

pub mod closed_loop;
pub mod plot;
pub mod record;
pub mod simulate;
pub mod summary;
pub mod target;
