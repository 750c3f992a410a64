//! The commands of `newtau`. Without the feature `full` there is `run` alone, in the program `newtau-run`: the packages that it needs compile in half the time.
#![forbid(unsafe_code)]

#[cfg(feature = "full")]
pub mod cli;
mod force;
mod output;
pub mod run;
