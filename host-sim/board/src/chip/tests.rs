//! Behaviour of the client when the emulator fails. The tests use small stand-in programs in place of the emulator; `firmware_tests` tests the
//! answers of a real chip.
#![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

use super::{Chip, ChipError, Emulator, Timeouts};
use link::{Hello, Pacing};
use std::path::Path;
use std::time::{Duration, Instant};

const HELLO: Hello = Hello { robot: 1, joints: 2, rate_hz: 1000.0, pacing: Pacing::LockStep };

fn short() -> Timeouts {
    Timeouts { connect: Duration::from_millis(300), answer: Duration::from_millis(300) }
}

/// Starts a stand-in. Stand-ins are files of the project, because a file that was just written may be "busy" when it is executed.
fn start(stand_in: &str) -> (Result<Emulator, ChipError>, Duration) {
    let program = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/chip/fixtures").join(stand_in);
    let begun = Instant::now();
    let result = Emulator::start(&program, Path::new("none.elf"), short());
    (result, begun.elapsed())
}

#[test]
fn a_missing_emulator_is_named_with_the_way_to_get_it() {
    let error = Emulator::start(Path::new("no-such-emulator"), Path::new("none.elf"), short()).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("no-such-emulator") && text.contains("cargo xtask setup"), "{text}");
}

#[test]
fn an_emulator_that_ends_at_once_is_dead_and_its_words_are_repeated() {
    let (result, took) = start("ends");
    let text = result.unwrap_err().to_string();
    assert!(text.contains("died (exit status: 3)") && text.contains("no such machine"), "{text}");
    assert!(took < Duration::from_secs(2), "{took:?}");
}

#[test]
fn an_emulator_that_never_connects_is_silent_within_its_time() {
    let (result, took) = start("waits");
    assert!(matches!(result, Err(ChipError::Silent { .. })));
    assert!(took >= Duration::from_millis(300) && took < Duration::from_secs(3), "{took:?}");
}

#[test]
fn the_command_line_of_the_readme_reaches_the_emulator() {
    let (result, _) = start("says");
    let text = result.unwrap_err().to_string();
    for part in ["-M netduinoplus2", "-icount shift=0", "-kernel none.elf", "-serial null -serial chardev:link"] {
        assert!(text.contains(part), "{part} in {text}");
    }
}

#[test]
fn a_program_that_is_no_firmware_is_silent_or_dead_and_never_a_hang() {
    let begun = Instant::now();
    let result = Emulator::start(Path::new("qemu-system-arm"), Path::new("/dev/null"), short())
        .and_then(|emulator| Chip::over(emulator, HELLO));
    let error = result.unwrap_err();
    let expected = matches!(error, ChipError::Silent { .. } | ChipError::Dead { .. } | ChipError::CannotStart { .. });
    assert!(expected, "{error}");
    assert!(begun.elapsed() < Duration::from_secs(5));
}
