//! `firmware flash` up to the compiler: the choice of scene, board and commands.

use crate::program::probe::{FakeProbe, folder, path_without_probe};
use crate::program::{at_the_top, told};

const SCENE: &str = "scenes/examples/mit6_wave.toml";

fn flash(arguments: &[&str]) -> (i32, String, String) {
    told(at_the_top().args(["firmware", "flash"]).args(arguments).output().unwrap())
}

/// The commands of a dry run, without the program's folder and without the hash in its name.
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
        at_the_top().args(["firmware", "flash", "--board", "f405-can", "--dry-run"]).env("PATH", probe.path()).output();
    assert_eq!(told(output.unwrap()).0, 0);
    assert!(probe.calls().is_empty(), "{:?}", probe.calls());
    assert_eq!(
        commands(&["--board", "f405-can", "--scene", SCENE]),
        [
            "newtau firmware build --board f405-can --scene scenes/examples/mit6_wave.toml",
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
    std::fs::copy(at_the_top().get_current_dir().unwrap().join("robots/planar2r.toml"), &alone).unwrap();
    let (code, _, error) = flash(&["--board", "odrive-v3", "--robot", alone.to_str().unwrap()]);
    assert_eq!(code, 2);
    assert!(error.contains("found no scene under scenes/"), "{error}");
}

#[test]
fn drives_that_the_board_has_no_lines_for_are_refused_with_file_line_and_kinds() {
    let (code, printed, error) = flash(&["--board", "f405-can", "--scene", "scenes/examples/pwm2_swing.toml"]);
    assert_eq!((code, printed.as_str()), (2, ""));
    assert!(error.contains("pwm2_swing.toml:3: robot: found PWM power stages"), "{error}");
    assert!(error.contains("expected CAN drives (MIT mode), which f405-can has lines for"), "{error}");
    let (code, _, error) = flash(&["--board", "f405-pwm", "--scene", "scenes/puma560_pick.toml"]);
    assert_eq!(code, 2);
    assert!(error.contains("found joints over the link") && error.contains("expected PWM power stages"), "{error}");
    let (code, _, error) = flash(&["--board", "f405-pwm", "--robot", "robots/examples/mit6.toml"]);
    assert_eq!(code, 2);
    assert!(error.contains("none of its scenes fits f405-pwm") && error.contains("mit6_wave.toml"), "{error}");
}

#[test]
fn a_rate_that_the_buses_do_not_hold_is_refused_with_file_and_line() {
    let scene = folder("too-fast").join("too_fast.toml");
    let root = at_the_top().get_current_dir().unwrap().canonicalize().unwrap();
    let text = std::fs::read_to_string(root.join(SCENE)).unwrap();
    let text =
        text.replace("../../robots", root.join("robots").to_str().unwrap()).replace("rate = 1000", "rate = 1100");
    std::fs::write(&scene, text).unwrap();
    let (code, printed, error) = flash(&["--board", "f405-can", "--scene", scene.to_str().unwrap()]);
    assert_eq!((code, printed.as_str()), (2, ""));
    let expected = "too_fast.toml:6: control.rate: found 1100 Hz, expected at most 1098, which bus 1 holds on f405-can";
    assert!(error.contains(expected), "{error}");
    let (code, _, error) = flash(&["--board", "f405-can", "--scene", "scenes/examples/mit6_fd_wave.toml"]);
    assert_eq!(code, 2);
    assert!(error.contains("mit6_fd.toml:") && error.contains("f405-can has classic CAN alone"), "{error}");
}

#[test]
fn the_emulated_board_is_not_flashed_and_a_wrong_scene_is_shown_in_its_line() {
    let (code, _, error) = flash(&["--board", "netduinoplus2"]);
    assert_eq!(code, 2);
    assert!(error.contains("expected one of odrive-v3, f405-can, f405-pwm, g474-fdcan"), "{error}");
    let scene = folder("wrong").join("wrong.toml");
    std::fs::write(&scene, "name = \"wrong\"\nrobot = \"nowhere.toml\"\n").unwrap();
    let (code, _, error) = flash(&["--board", "f405-can", "--scene", scene.to_str().unwrap()]);
    assert_eq!(code, 2);
    assert!(error.contains("wrong.toml:2:9: robot: there is no file") && error.contains("expected"), "{error}");
}

#[test]
fn without_probe_rs_nothing_is_built_and_the_way_to_get_it_is_told() {
    let flash =
        at_the_top().args(["firmware", "flash", "--board", "f405-can"]).env("PATH", path_without_probe()).output();
    let (code, printed, error) = told(flash.unwrap());
    assert_eq!(code, 2);
    assert!(error.contains("cargo install probe-rs-tools --locked"), "{error}");
    assert!(!printed.contains("program"), "{printed}");
}

const KEY_FILE: &str = "newtau link key 1\n00112233445566778899aabbccddeeff00112233445566778899aabbccddeeff\n";

fn key_file(name: &str, text: &str) -> std::path::PathBuf {
    use std::os::unix::fs::PermissionsExt as _;
    let file = folder(name).join("arm.key");
    std::fs::write(&file, text).unwrap();
    std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o600)).unwrap();
    file
}

/// The page goes to its own sector, after the program's flash, and no file with the key is left.
#[test]
fn a_key_is_written_to_its_page_and_the_program_stays() {
    key_is_written("f405-can", "STM32F405RGTx", "stm32f405");
    key_is_written("g474-fdcan", "STM32G474RETx", "stm32g474");
}

fn key_is_written(board: &str, chip: &str, map: &str) {
    let file = key_file(&format!("key-{board}"), KEY_FILE);
    let probe = FakeProbe::new(
        &format!("key-probe-{board}"),
        "for word; do last=$word; done; [ ! -f \"$last\" ] || wc -c < \"$last\"; exit 0",
    );
    let key = at_the_top()
        .args(["firmware", "key", "write", file.to_str().unwrap(), "--board", board])
        .env("PATH", probe.path())
        .output();
    let (code, printed, error) = told(key.unwrap());
    assert_eq!(code, 0, "{error}");
    assert!(printed.lines().any(|line| line.trim() == "60"), "{printed}");
    let calls = probe.calls();
    assert_eq!(calls.len(), 2, "{calls:?}");
    let place = format!("--binary-format bin --base-address {} ", key_sector(map));
    assert!(
        calls[0].starts_with(&format!("download --chip {chip} --verify ")) && calls[0].contains(&place),
        "{calls:?}"
    );
    assert_eq!(calls[1], format!("reset --chip {chip}"));
    let page = calls[0].rsplit(' ').next().unwrap();
    assert!(!std::path::Path::new(page).exists(), "{page}");
    assert!(!printed.contains("0011223344") && !error.contains("0011223344"));
}

/// Start of the key's flash sector in the chip's linker script.
fn key_sector(chip: &str) -> String {
    let folder = at_the_top().get_current_dir().unwrap().join("firmware/memory").join(chip);
    let map = std::fs::read_to_string(folder.join("chip_memory.x")).unwrap();
    let line = map.lines().find(|line| line.trim_start().starts_with("KEY ")).unwrap();
    line.split("ORIGIN = ").nth(1).unwrap().split(',').next().unwrap().to_lowercase()
}

#[test]
fn a_file_that_is_no_key_and_a_board_that_is_none_are_refused() {
    let file = key_file("no-key", "newtau link key 1\n0011\n");
    let asked = |board: &str| {
        told(
            at_the_top()
                .args(["firmware", "key", "write", file.to_str().unwrap(), "--board", board, "--dry-run"])
                .output()
                .unwrap(),
        )
    };
    let (code, printed, error) = asked("f405-can");
    assert_eq!((code, printed.as_str()), (2, ""));
    assert!(error.contains("arm.key:2: found 4 characters, expected 64 hexadecimal digits"), "{error}");
    let (code, _, error) = asked("netduinoplus2");
    assert_eq!(code, 2);
    assert!(error.contains("expected one of odrive-v3, f405-can, f405-pwm, g474-fdcan"), "{error}");
}

#[test]
fn an_insecure_program_is_another_file_and_is_said_to_be_insecure() {
    let insecure = commands(&["--board", "f405-can", "--scene", SCENE, "--insecure"]);
    assert!(insecure[0].ends_with(" --insecure"), "{insecure:?}");
    assert!(insecure[1].ends_with("mit6_wave-f405-can-insecure.elf"), "{insecure:?}");
}
