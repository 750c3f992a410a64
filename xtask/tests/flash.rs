//! `firmware flash` up to the compiler: the choice of scene, board and commands.
#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

mod task;

use task::{FakeProbe, folder, path_without_probe, told, xtask};

const SCENE: &str = "scenes/examples/mit6_wave.toml";

fn flash(arguments: &[&str]) -> (i32, String, String) {
    told(xtask().args(["firmware", "flash"]).args(arguments).output().unwrap())
}

/// The commands of a dry run, without the program's folder and the hash in its name.
fn commands(arguments: &[&str]) -> Vec<String> {
    let (code, printed, error) = flash(&[arguments, &["--dry-run"]].concat());
    assert_eq!(code, 0, "{error}");
    let commands = printed.lines().filter_map(|line| line.strip_prefix("$ "));
    commands.map(|line| line.split(' ').map(shortened).collect::<Vec<_>>().join(" ")).collect()
}

/// `/somewhere/mit6_wave-0123abcd-f405-can.elf` as `mit6_wave-f405-can.elf`.
fn shortened(word: &str) -> String {
    let Some(stem) = word.strip_suffix(".elf") else { return word.into() };
    let name = stem.rsplit('/').next().unwrap();
    let (scene, rest) = name.split_once('-').unwrap();
    let (hash, board) = rest.split_once('-').unwrap();
    assert!(hash.len() == 8 && hash.chars().all(|digit| digit.is_ascii_hexdigit()), "{word}");
    format!("{scene}-{board}.elf")
}

#[test]
fn a_dry_run_prints_what_would_be_run_and_runs_nothing() {
    let probe = FakeProbe::new("dry", "exit 0");
    let output =
        xtask().args(["firmware", "flash", "--board", "f405-can", "--dry-run"]).env("PATH", probe.path()).output();
    assert_eq!(told(output.unwrap()).0, 0);
    assert!(probe.calls().is_empty(), "{:?}", probe.calls());
    assert_eq!(
        commands(&["--board", "f405-can", "--scene", SCENE]),
        [
            "cargo xtask firmware build --board f405-can --scene scenes/examples/mit6_wave.toml",
            "probe-rs download --chip STM32F405RGTx --verify mit6_wave-f405-can.elf",
            "probe-rs reset --chip STM32F405RGTx",
        ]
    );
}

#[test]
fn with_log_one_command_writes_starts_and_stays() {
    assert_eq!(
        commands(&["--board", "odrive-v3", "--scene", "scenes/ur5_wave.toml", "--log", "--probe", "0483:374e"])[1..],
        ["probe-rs run --chip STM32F405RGTx --probe 0483:374e --verify ur5_wave-odrive-v3.elf"]
    );
}

#[test]
fn a_robot_stands_for_its_only_scene_that_fits() {
    let by_robot = commands(&["--board", "f405-can", "--robot", "robots/examples/mit6.toml"]);
    assert_eq!(by_robot, commands(&["--board", "f405-can", "--scene", SCENE]));
}

#[test]
fn a_robot_with_several_scenes_names_them_and_one_with_none_says_so() {
    let (code, printed, error) = flash(&["--board", "odrive-v3", "--robot", "robots/planar2r.toml"]);
    assert_eq!((code, printed.as_str()), (2, ""));
    for scene in ["scenes/planar2r_swing.toml", "scenes/planar2r_sine.toml", "name it by --scene"] {
        assert!(error.contains(scene), "{scene} in {error}");
    }
    let alone = folder("alone").join("alone.toml");
    std::fs::copy(xtask().get_current_dir().unwrap().join("robots/planar2r.toml"), &alone).unwrap();
    let (code, _, error) = flash(&["--board", "odrive-v3", "--robot", alone.to_str().unwrap()]);
    assert_eq!(code, 2);
    assert!(error.contains("found no scene under scenes/"), "{error}");
}

#[test]
fn drives_that_the_board_has_no_lines_for_are_refused_with_file_line_and_kinds() {
    let (code, printed, error) = flash(&["--board", "f405-can", "--scene", "scenes/examples/pwm2_swing.toml"]);
    assert_eq!((code, printed.as_str()), (2, ""));
    assert!(error.contains("pwm2_swing.toml:3: robot: found drives of the kind pwm"), "{error}");
    assert!(error.contains("expected drives of the kind mit, which f405-can has lines for"), "{error}");
    let (code, _, error) = flash(&["--board", "f405-pwm", "--scene", "scenes/puma560_pick.toml"]);
    assert_eq!(code, 2);
    assert!(error.contains("found drives over the link") && error.contains("kind pwm"), "{error}");
    let (code, _, error) = flash(&["--board", "f405-pwm", "--robot", "robots/examples/mit6.toml"]);
    assert_eq!(code, 2);
    assert!(error.contains("none of its scenes fits f405-pwm") && error.contains("mit6_wave.toml"), "{error}");
}

#[test]
fn the_emulated_board_is_not_flashed_and_a_wrong_scene_is_shown_in_its_line() {
    let (code, _, error) = flash(&["--board", "netduinoplus2"]);
    assert_eq!(code, 2);
    assert!(error.contains("expected one of odrive-v3, f405-can, f405-pwm"), "{error}");
    let scene = folder("wrong").join("wrong.toml");
    std::fs::write(&scene, "name = \"wrong\"\nrobot = \"nowhere.toml\"\n").unwrap();
    let (code, _, error) = flash(&["--board", "f405-can", "--scene", scene.to_str().unwrap()]);
    assert_eq!(code, 2);
    assert!(error.contains("wrong.toml:2:9: robot: there is no file") && error.contains("expected"), "{error}");
}

#[test]
fn without_probe_rs_nothing_is_built_and_the_way_to_get_it_is_told() {
    let flash = xtask().args(["firmware", "flash", "--board", "f405-can"]).env("PATH", path_without_probe()).output();
    let (code, printed, error) = told(flash.unwrap());
    assert_eq!(code, 2);
    assert!(error.contains("cargo install probe-rs-tools --locked"), "{error}");
    assert!(!printed.contains("program"), "{printed}");
}
