//! The command line: one file per command, with its arguments, its help, the call and what it prints.
#![forbid(unsafe_code)]

pub mod cli;
