//! Whole closed loops in the emulated chip, run as by a user: every tick has the same bits as on the desk.

use crate::pinned::assert_pinned;
use crate::program::new;
use serde_json::Value;
use std::path::Path;
use std::process::Command;

/// Summary of a run in the emulator, with additional options.
fn run(scene: &str, options: &[&str]) -> Value {
    run_file(&format!("scenes/{scene}.toml"), scene, options)
}

/// As [`run`], for a scene file anywhere in the project.
fn run_file(file: &str, scene: &str, options: &[&str]) -> Value {
    let workspace = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let out = workspace.join("target/tmp").join(format!("closed_loop-{scene}{}", options.join("")));
    let mut command = Command::new(env!("CARGO_BIN_EXE_newtau"));
    command.current_dir(&workspace).args(["run", file, "--target", "qemu", "--json"]);
    let output = command.arg("--out").arg(new(&out)).args(options).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn assert_parity(summary: &Value, ticks: u64) {
    assert_eq!(summary["parity"]["ticks"], ticks);
    assert_eq!(summary["parity"]["mismatches"], 0);
    assert_eq!(summary["faults"], Value::Array(Vec::new()));
    let count = |which: &str| summary["instructions_per_tick"][which].as_u64().unwrap();
    assert!(count("min") > 0 && count("min") <= count("max"));
}

#[test]
fn the_whole_puma_run_gives_the_desks_bits() {
    let summary = run("puma560_pick", &[]);
    assert_parity(&summary, 2_100);
    // The whole tick (encoders, observer, sine and cosine, kernel, control law, friction, guard and limits) always has the same number of
    // instructions.
    let [least, most] = ["min", "max"].map(|which| summary["instructions_per_tick"][which].as_u64().unwrap());
    assert_pinned("puma560_pick", [least, most]);
    assert_eq!(least, most, "no tick of this run is unlike the others");
}

#[test]
fn prismatic_joints_and_delays_give_the_desks_bits() {
    assert_parity(&run("scara_pick", &["--duration", "0.4"]), 400);
}

#[test]
fn another_law_and_measured_states_give_the_desks_bits() {
    assert_parity(&run("puma560_pd_gravity", &["--duration", "0.4"]), 400);
    assert_parity(&run("planar2r_sine", &["--duration", "0.4"]), 400);
}

#[test]
fn a_model_evaluated_in_some_ticks_gives_the_desks_bits_and_a_cheap_tick_between() {
    let summary = run("puma560_slow_model", &[]);
    assert_parity(&summary, 2_100);
    let [least, most] = ["min", "max"].map(|which| summary["instructions_per_tick"][which].as_u64().unwrap());
    // Ticks without an evaluation of the model, and with one.
    assert_pinned("puma560_slow_model", [least, most]);
}

#[test]
fn a_scene_whose_gains_can_be_changed_builds_and_gives_the_desks_bits() {
    assert_parity(&run_file("host-sim/tests/fixtures/tunable.toml", "tunable", &[]), 1_000);
}

#[test]
fn a_law_and_trig_chosen_on_the_command_line_reach_the_chip() {
    let summary = run("scara_pick", &["--duration", "0.2", "--law", "pd", "--trig", "libm"]);
    assert_parity(&summary, 200);
    assert_eq!((summary["law"].as_str(), summary["trig"].as_str()), (Some("pd"), Some("libm")));
    // A loop without a model computes no sine and no kernel. It needs instructions for a prediction only if a reading is late.
    let [least, most] = ["min", "max"].map(|which| summary["instructions_per_tick"][which].as_u64().unwrap());
    assert!(least < 450 && most < 650, "{least} to {most}");
}

#[test]
fn measurements_of_simulated_drives_give_the_desks_bits() {
    let summary = run_file("scenes/examples/mit6_wave.toml", "mit6_wave", &["--duration", "0.2"]);
    assert_parity(&summary, 200);
    assert_eq!(summary["drives"]["kind"], "mit");
}

#[test]
fn arms_that_people_own_give_the_desks_bits() {
    let summary = run_file("scenes/rebot_move.toml", "rebot_move", &["--duration", "0.3"]);
    assert_parity(&summary, 300);
    assert_eq!(summary["drives"]["kind"], "robstride");
    // The arm holds its position, is pushed, and reaches a joint's wall.
    let summary = run_file("scenes/yam_teach.toml", "yam_teach", &["--duration", "1.2"]);
    assert_parity(&summary, 1_200);
    assert_eq!((summary["law"].as_str(), summary["drives"]["kind"].as_str()), (Some("teach"), Some("damiao")));
    let summary = run_file("scenes/yam_split.toml", "yam_split", &["--duration", "0.3"]);
    assert_parity(&summary, 300);
    assert_eq!(summary["law"], "split");
}
