//! The command line: a file for each command, with its arguments, its help, the call and the output.
#![forbid(unsafe_code)]

pub mod cli;
