//! The arm and its control loop: everything that also runs on your computer.
#![no_std]
#![forbid(unsafe_code)]

pub mod control;
pub mod dry_run;
pub mod joints;

/// The arm, compiled from `arm/move.toml` by `build.rs`.
pub mod robot {
    include!(concat!(env!("OUT_DIR"), "/arm.rs"));
}

/// Pose in which the simulated arm of the tests starts, rad. Change it if your arm cannot be there.
pub const TEST_POSE: [f32; robot::N] = [0.0, 0.9, -1.6, 0.0, 0.5, 0.0];

/// Hash of every command of the simulated session. It changes with the arm: `cargo desk` reports the new one.
pub const GOLDEN: u64 = 0x7fd3_4e7d_49da_fb12;
