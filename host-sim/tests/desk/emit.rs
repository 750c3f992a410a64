//! `newtau emit arm`: the emitted crate compiles by itself, and its test compares the bits.

use crate::program::{at_the_top, printed, told};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn out(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("emit_{name}"));
    if folder.exists() {
        fs::remove_dir_all(&folder).unwrap();
    }
    folder
}

fn emit(scene: &str, folder: &Path, more: &[&str]) -> String {
    printed(at_the_top().args(["emit", "arm", scene, "--out"]).arg(folder).args(more).output().unwrap())
}

/// Builds the crate's test in a folder shared by all, without a network.
fn tested(folder: &Path, subcommand: &str) -> (bool, String) {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("emitted");
    let output = Command::new(env!("CARGO"))
        .args([subcommand, "--offline", "--quiet", "--manifest-path"])
        .arg(folder.join("Cargo.toml"))
        .env("CARGO_TARGET_DIR", target)
        .env_remove("RUSTFLAGS")
        .output()
        .unwrap();
    (
        output.status.success(),
        String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr),
    )
}

#[test]
fn an_emitted_arm_compiles_alone_and_has_the_desk_s_bits() {
    // A kernel, collision detection, drive springs, live inputs, friction terms, f64.
    let scenes: [(&str, &[&str]); 6] = [
        ("scenes/puma560_pick.toml", &[]),
        ("scenes/puma560_collision.toml", &[]),
        ("scenes/yam_split.toml", &[]),
        ("scenes/campaign/yam.toml", &[]),
        ("scenes/examples/yam_friction.toml", &[]),
        ("scenes/planar2r_swing.toml", &["--scalar", "f64"]),
    ];
    for (scene, more) in scenes {
        let folder = out(Path::new(scene).file_stem().unwrap().to_str().unwrap());
        let text = emit(scene, &folder, more);
        assert!(text.contains("cargo test --manifest-path"), "{text}");
        let (passed, text) = tested(&folder, "test");
        assert!(passed && !text.contains("warning"), "{scene}: {text}");
        // The test can fail: one bit of one torque is enough.
        if scene.contains("planar2r") {
            let golden = folder.join("tests/golden.rs");
            let source = fs::read_to_string(&golden).unwrap();
            // The last number of the file is a torque.
            let end = source.rfind(|c: char| c.is_ascii_digit()).unwrap() + 1;
            let start = source[..end].rfind([' ', '[']).unwrap() + 1;
            let number = source[start..end].to_owned();
            let other = f64::from_bits(number.parse::<f64>().unwrap().to_bits() ^ 1);
            fs::write(&golden, source.replace(&number, &format!("{other:?}"))).unwrap();
            assert!(!tested(&folder, "test").0, "{number} and {other:?}");
        }
    }
}

/// The scene, in another folder and with a key that does not exist.
fn wrong_text(scene: &Path) -> String {
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots/").display().to_string();
    let text = fs::read_to_string(scene).unwrap().replace("../robots/", &robots);
    format!("ratte = 1000.0\n{text}")
}

#[test]
fn a_build_script_gets_the_same_arm() {
    let folder = out("built");
    fs::create_dir_all(folder.join("src")).unwrap();
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/planar2r_swing.toml");
    let read = robot_compiler::emit::write_arm(&scene, &folder).unwrap();
    assert!(read.len() == 2 && read[1].ends_with("planar2r.toml"), "{read:?}");
    let core = Path::new(env!("CARGO_MANIFEST_DIR")).join("../dynamics-core");
    let manifest = format!(
        "[package]\nname = \"built\"\nedition = \"2024\"\n[dependencies]\ndynamics-core = {{ path = {core:?} }}\n[workspace]\n"
    );
    fs::write(folder.join("Cargo.toml"), manifest).unwrap();
    // Beside the user's own items, in a module of his choice.
    let source = "#![no_std]\npub mod my_arm {\n    include!(\"../arm.rs\");\n}\n\n#[test]\nfn it_holds_itself() {\n    \
                  let [shoulder, _] = my_arm::gravity(&[0.0, 0.0]);\n    assert!(shoulder > 1.0, \"{shoulder}\");\n}\n";
    fs::write(folder.join("src/lib.rs"), source).unwrap();
    let (passed, text) = tested(&folder, "test");
    assert!(passed && !text.contains("warning"), "{text}");
    let wrong = folder.join("wrong.toml");
    fs::write(&wrong, wrong_text(&scene)).unwrap();
    let error = robot_compiler::emit::write_arm(&wrong, &folder).unwrap_err().to_string();
    assert!(error.contains("wrong.toml:") && error.contains("ratte") && error.contains("expected"), "{error}");
    // A build script whose `main` returns the error prints it so.
    let printed = robot_compiler::emit::write_arm(&wrong, &folder).map_err(|error| format!("{error:?}")).unwrap_err();
    assert_eq!(printed, error);
}

#[test]
fn an_arm_is_emitted_over_its_own_files_alone() {
    let folder = out("twice");
    emit("scenes/planar2r_swing.toml", &folder, &[]);
    emit("scenes/planar2r_swing.toml", &folder, &[]);
    fs::write(folder.join("src/lib.rs"), "// mine\n").unwrap();
    let again =
        at_the_top().args(["emit", "arm", "scenes/planar2r_swing.toml", "--out"]).arg(&folder).output().unwrap();
    let (code, _, message) = told(again);
    assert_eq!(code, 2);
    assert!(message.contains("lib.rs") && message.contains("--force"), "{message}");
    assert_eq!(fs::read_to_string(folder.join("src/lib.rs")).unwrap(), "// mine\n");
    let bench = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bench_only.toml");
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/planar2r_swing.toml");
    let text = wrong_text(&scene).replace("ratte = 1000.0\n", "");
    let text = text + "\n[safety]\nbench_only = true\n";
    fs::write(&bench, text).unwrap();
    let for_the_bench = at_the_top().args(["emit", "arm"]).arg(&bench).arg("--out").arg(out("bench")).output().unwrap();
    let (code, _, message) = told(for_the_bench);
    assert!(code == 2 && message.contains("bench_only"), "{message}");
    let f64_collision = at_the_top()
        .args(["emit", "arm", "scenes/puma560_collision.toml", "--scalar", "f64", "--out"])
        .arg(out("f64"))
        .output()
        .unwrap();
    let (code, _, message) = told(f64_collision);
    assert!(code == 2 && message.contains("[collision] is emitted for f32 only"), "{message}");
}
