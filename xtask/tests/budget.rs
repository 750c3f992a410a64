//! `budget --port` up to the program that talks to the board: its arguments, and the handling of its output. A scripted cargo replaces that program.
//! `xtask/trials/tests/budget_board.rs` tests the board.
#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

mod task;

use serde_json::Value;
use std::os::unix::fs::PermissionsExt as _;
use std::path::PathBuf;
use task::{folder, told, xtask};

const PORT: [&str; 2] = ["--port", "/dev/ttyACM0"];
const MEASURED: &str = r#"{"hash":"25bb0af18768f6a5","rate_hz":1000.0,"ticks":10000,"bits_differ":0,"cycles_per_tick":{"min":2790,"max":2831,"mean":2805.5}}"#;

/// A cargo that records its arguments, and then does what the script says.
struct FakeCargo(PathBuf);

impl FakeCargo {
    fn new(test: &str, script: &str) -> Self {
        let path = folder(&format!("budget-{test}")).join("cargo");
        let calls = path.with_extension("calls");
        std::fs::write(&path, format!("#!/bin/sh\necho \"$@\" >> '{}'\n{script}\n", calls.display())).unwrap();
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o755)).unwrap();
        Self(path)
    }

    fn budget(&self, arguments: &[&str]) -> (i32, String, String) {
        told(xtask().arg("budget").args(arguments).env("CARGO", &self.0).output().unwrap())
    }

    fn calls(&self) -> String {
        std::fs::read_to_string(self.0.with_extension("calls")).unwrap_or_default()
    }
}

#[test]
fn the_board_is_asked_for_the_emulators_ticks_and_its_cycles_are_printed() {
    let cargo = FakeCargo::new("asked", &format!("echo '{MEASURED}'"));
    let arguments = [&PORT[..], &["--board", "odrive-v3", "--scene", "scenes/puma560_pick.toml"]].concat();
    let (code, printed, error) = cargo.budget(&arguments);
    assert_eq!(code, 0, "{error}");
    assert!(printed.contains("fewest 2,790, most 2,831, mean 2805.5"), "{printed}");
    assert!(printed.contains("1.69 % of 168,000 cycles at 1,000 Hz") && printed.contains("estimated"), "{printed}");
    let calls = cargo.calls();
    assert!(
        calls.contains("--package trials --bin chip-budget -- board --scene ") && calls.lines().count() == 1,
        "{calls}"
    );
    assert!(calls.contains("scenes/puma560_pick.toml --port /dev/ttyACM0 --ticks 10000 --instructions "), "{calls}");

    let (code, printed, _) = cargo.budget(&[&arguments[..], &["--json", "--ticks", "250"]].concat());
    let report: Value = serde_json::from_str(&printed).unwrap();
    assert_eq!((code, report["board"].as_str(), report["robot"].as_str()), (0, Some("odrive-v3"), Some("puma560")));
    assert_eq!(report["cycles_per_tick"], serde_json::json!({ "min": 2790, "max": 2831, "mean": 2805.5 }));
    assert!(cargo.calls().contains("--ticks 250"), "{}", cargo.calls());
}

#[test]
fn a_board_without_a_scene_has_its_example_of_which_no_emulator_knows() {
    let cargo = FakeCargo::new("example", &format!("echo '{MEASURED}'"));
    let (code, printed, error) = cargo.budget(&[&PORT[..], &["--board", "f405-can"]].concat());
    assert_eq!(code, 0, "{error}");
    assert!(printed.starts_with("mit6_wave on f405-can: ") && printed.contains("no row of this scene"), "{printed}");
    assert!(!cargo.calls().contains("--instructions"), "{}", cargo.calls());
}

#[test]
fn what_the_board_fails_in_keeps_its_words_and_its_code() {
    for (code, why) in
        [(2, "tick 1 has no cost: the cycle counter stood still"), (1, "serial port: the other end is gone")]
    {
        let cargo = FakeCargo::new(&format!("fails-{code}"), &format!("echo 'error: {why}' >&2; exit {code}"));
        let (found, printed, error) = cargo.budget(&[&PORT[..], &["--board", "f405-pwm", "--json"]].concat());
        assert_eq!((found, printed.as_str()), (code, ""));
        assert_eq!(error.lines().last().unwrap(), format!("error: {why}"));
    }
}

#[test]
fn what_does_not_fit_is_refused_before_the_port_is_touched() {
    let cargo = FakeCargo::new("refused", "exit 0");
    let can = ["--board", "f405-can"];
    let cases: [(&[&str], &str); 9] = [
        (&PORT, "--board <BOARD>"),
        (&can, "--port <PORT>"),
        (&["--ticks", "5"], "--port <PORT>"),
        (&[&PORT[..], &can, &["--bless"]].concat(), "cannot be used with"),
        (&[&PORT[..], &can, &["--ticks", "0"]].concat(), "0 is not in 1..=1000000"),
        (&[&PORT[..], &["--board", "netduinoplus2"]].concat(), "found the emulated board, expected one of odrive-v3,"),
        (
            &[&PORT[..], &can, &["--scene", "scenes/puma560_pick.toml"]].concat(),
            "expected CAN drives (MIT mode), which f405-can has lines for",
        ),
        (&[&PORT[..], &can, &["--scene", "scenes/nowhere.toml"]].concat(), "nowhere.toml"),
        (&[&PORT[..], &can, &["--scene", "a.toml", "--scene", "b.toml"]].concat(), "found 2 scenes, expected the one"),
    ];
    for (arguments, expected) in cases {
        let (code, printed, error) = cargo.budget(arguments);
        assert_eq!((code, printed.as_str()), (2, ""), "{arguments:?}: {error}");
        assert!(error.contains(expected), "{arguments:?}: {error}");
    }
    assert_eq!(cargo.calls(), "");
}
