//! The frames that host and MCU exchange.
#![no_std]
#![forbid(unsafe_code)]
