//! What must hold for any input, once, for two ways of finding an input for which it does not.
//!
//! Each module has a function `check` that takes any bytes and panics when something does not hold of them. `cargo fuzz run NAME`
//! gives it to libFuzzer, which looks for bytes that reach new code (needs a nightly compiler, see `docs/fuzzing.md`);
//! `cargo test -p fuzz` gives it the examples, every input that was ever a finding, and some thousand inputs made of them by
//! [`damage`] with a fixed seed.
//!
//! | module | the bytes are | what must hold |
//! |---|---|---|
//! | [`link_decoder`] | bytes on the wire, and the inside of a packet | never a panic; a frame comes back the same; the next packet is read |
//! | [`link_stream`] | packets and what happens to them on the way | exactly the whole packets arrive, and what is missing is counted |
//! | [`session`] | packets, damage, readings and ticks | what is refused leaves no trace; torque acts by the rules of `docs/safety.md` alone |
//! | [`robot_file`] | a robot's or a linkage's TOML | a robot with a model, or an error with a place |
//! | [`urdf_file`] | a robot's URDF | the same |
//! | [`scene_file`] | a scene's TOML | a scene with a source, a motion and a controller that keeps its limits, or an error with a place |
//! | [`json_lines`] | states for `host-sim dynamics` | each line is answered with numbers that belong together, up to the one that an error names |
#![forbid(unsafe_code)]
#![allow(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a check says by a panic that something does not hold; that is what a fuzzer looks for"
)]

pub mod damage;
mod examples;
mod files;
pub mod json_lines;
pub mod link_decoder;
pub mod link_stream;
mod packets;
pub mod robot_file;
pub mod scene_file;
pub mod session;
pub mod urdf_file;

pub use examples::found;

/// Something to hold to any input.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Its name for `cargo fuzz run`.
    pub name: &'static str,
    /// Panics when something does not hold.
    pub check: fn(&[u8]),
    /// Inputs to begin with, most of them good.
    pub examples: fn() -> Vec<Vec<u8>>,
    /// Words that mean something in an input.
    pub words: &'static [&'static str],
}

/// All of them.
pub const TARGETS: [Target; 7] = [
    link_decoder::TARGET,
    link_stream::TARGET,
    session::TARGET,
    robot_file::TARGET,
    urdf_file::TARGET,
    scene_file::TARGET,
    json_lines::TARGET,
];

/// Check the files that the command line names: how a finding is looked at without a fuzzer.
///
/// # Errors
/// A file that cannot be read.
pub fn replay(check: fn(&[u8])) -> std::io::Result<()> {
    for path in std::env::args_os().skip(1) {
        check(&std::fs::read(&path)?);
        println!("{}: holds", path.display());
    }
    Ok(())
}
