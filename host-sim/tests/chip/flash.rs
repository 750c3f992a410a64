//! `firmware flash` with the compiler and a scripted probe-rs.

use crate::program::probe::FakeProbe;
use crate::program::{at_the_top, told};
use std::path::Path;

fn flash(probe: &FakeProbe, arguments: &[&str]) -> (i32, String, String) {
    told(at_the_top().args(["firmware", "flash"]).args(arguments).env("PATH", probe.path()).output().unwrap())
}

#[test]
fn the_probe_is_given_the_program_of_the_scene_with_a_log_that_can_be_read() {
    let probe = FakeProbe::new("given", "exit 0");
    let (code, printed, error) = flash(&probe, &["--board", "f405-can", "--robot", "robots/examples/mit6.toml"]);
    assert_eq!(code, 0, "{error}");
    let calls = probe.calls();
    let program =
        calls[0].strip_prefix("download --chip STM32F405RGTx --verify ").unwrap_or_else(|| panic!("{calls:?}"));
    assert_eq!(calls[1..], ["reset --chip STM32F405RGTx"]);
    let text = std::fs::read(Path::new(program)).unwrap();
    for name in ["mit6_wave", "STM32F405, CAN"] {
        assert!(text.windows(name.len()).any(|window| window == name.as_bytes()), "{name} in {program}");
    }
    let log = printed.lines().find_map(|line| line.strip_prefix("log      ")).unwrap_or_else(|| panic!("{printed}"));
    let strings: usize = log.split(' ').next().unwrap().parse().unwrap();
    // The strings of the firmware's dependencies count too, so there are more than the firmware's own few.
    assert!((5..200).contains(&strings), "{log}");
}

#[test]
fn a_probe_that_fails_ends_the_work_with_its_command() {
    let probe = FakeProbe::new("fails", "[ \"$1\" != download ]");
    let (code, printed, error) = flash(&probe, &["--board", "f405-pwm"]);
    assert_eq!(code, 1);
    assert!(error.contains("download --chip STM32F405RGTx --verify") && error.contains("failed"), "{error}");
    assert!(!printed.contains("flashed") && probe.calls().len() == 1, "{printed}");
}

#[test]
fn with_log_the_tool_itself_is_left_to_print() {
    let probe = FakeProbe::new("log", "echo 'INFO pwm2_swing on STM32F405, PWM and encoders: 2 joints, 1000 Hz'");
    let (code, printed, error) = flash(&probe, &["--board", "f405-pwm", "--log"]);
    assert_eq!(code, 0, "{error}");
    assert!(probe.calls()[0].starts_with("run --chip STM32F405RGTx --verify "), "{:?}", probe.calls());
    assert!(printed.ends_with("INFO pwm2_swing on STM32F405, PWM and encoders: 2 joints, 1000 Hz\n"), "{printed}");
}
