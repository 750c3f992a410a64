//! Kernels of the shipped scenes, generated when this crate is built and compiled under the lints of the workspace.
//!
//! The tests of this crate compare them with the recursion that they were traced from; the tests of `dynamics-batch` run them on lanes.
#![no_std]
#![forbid(unsafe_code)]

include!(concat!(env!("OUT_DIR"), "/kernels.rs"));
