//! The firmware's log in the form in which a user of the emulator reads it.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

mod task;

use task::{told, xtask};

#[test]
fn the_log_of_the_emulated_board_is_readable() {
    let scene = "scenes/planar2r_swing.toml";
    let run = xtask().args(["firmware", "run", "--scene", scene, "--seconds", "5"]).output().unwrap();
    let (code, printed, error) = told(run);
    assert_eq!(code, 0, "{error}");
    assert!(printed.contains("planar2r_swing on netduinoplus2 (QEMU): 2 joints, 1000.0 Hz"), "{printed}");
    // The level at the start of a line shows that the log was decoded, not copied.
    assert!(printed.lines().any(|line| line.contains("INFO")), "{printed}");
}
