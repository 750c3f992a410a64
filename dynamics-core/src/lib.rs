//! Newton-Euler.
#![no_std]
#![forbid(unsafe_code)]
