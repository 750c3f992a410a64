//! Properties that must hold for any input. Both the fuzzer and ordinary tests search for counterexamples.
//!
//! Each module has a function `check` that accepts any bytes and panics if a property does not hold for them. `cargo fuzz run NAME` passes it to
//! libFuzzer, which searches for bytes that reach new code (needs a nightly compiler, see `docs/develop/testing.md`). `cargo test -p trials` passes
//! it the examples, every input that was ever a finding, and thousands of inputs that [`damage`] makes from them with a fixed seed.
//!
//! | module | meaning of the bytes | property |
//! |---|---|---|
//! | [`link_channel`] | an intruder on the wire of a sealed session | only the host's frames are accepted, once, in order; the host gets through |
//! | [`link_decoder`] | bytes on the wire, and the inside of a packet | no panic; a frame comes back the same; the next packet is read |
//! | [`link_stream`] | packets and events on the link | exactly the whole packets arrive, and missing ones are counted |
//! | [`session`] | packets, damage, readings and ticks | refused input leaves no trace; torque acts only by `docs/safety/rules.md` |
//! | [`robot_file`] | TOML of a robot or a linkage | a robot with a model, or an error with its location |
//! | [`urdf_file`] | URDF of a robot | the same |
//! | [`scene_file`] | TOML of a scene | a scene with a source, a motion and a controller that keeps its limits, or an error with its location |
//! | [`json_lines`] | states for `newtau model dynamics` | each line is answered with consistent numbers, up to the one that an error names |
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a check says by a panic that something does not hold; that is what a fuzzer looks for"
)]

#[path = "../../../robot-compiler/tests/common/cases.rs"]
#[allow(dead_code, reason = "tests compare outputs; here inputs are taken alone")]
mod cases;
pub mod damage;
mod examples;
mod files;
pub mod json_lines;
pub mod link_channel;
pub mod link_decoder;
pub mod link_stream;
mod packets;
pub mod robot_file;
pub mod scene_file;
pub mod session;
mod target;
pub mod urdf_file;

pub use examples::found;
pub use target::FuzzTarget;

/// All fuzz targets.
pub const TARGETS: [FuzzTarget; 8] = [
    link_channel::TARGET,
    link_decoder::TARGET,
    link_stream::TARGET,
    session::TARGET,
    robot_file::TARGET,
    urdf_file::TARGET,
    scene_file::TARGET,
    json_lines::TARGET,
];

/// Checks the files named on the command line, to examine a finding without a fuzzer.
///
/// # Errors
/// A file cannot be read.
pub fn replay(check: fn(&[u8])) -> std::io::Result<()> {
    for path in std::env::args_os().skip(1) {
        check(&std::fs::read(&path)?);
        println!("{}: holds", path.display());
    }
    Ok(())
}

/// Defines the program of a fuzz target. `cargo fuzz` builds it for libFuzzer; without it, the program is [`replay`](crate::fuzz::replay).
#[macro_export]
macro_rules! fuzz_program {
    ($target:ident) => {
        #[cfg(fuzzing)]
        libfuzzer_sys::fuzz_target!(|bytes: &[u8]| $crate::fuzz::$target::check(bytes));

        #[cfg(not(fuzzing))]
        fn main() -> std::io::Result<()> {
            $crate::fuzz::replay($crate::fuzz::$target::check)
        }
    };
}
