//! Identification on synthetic logs, for which the truth is known.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so")]

mod arms;
mod audits;
mod base;
mod bodies;
mod filters;
mod formats;
mod friction;
mod held;
mod hypotheses;
mod logs;
mod made;
mod motions;
mod seeds;
mod terms;
mod timing;
mod verdict;
