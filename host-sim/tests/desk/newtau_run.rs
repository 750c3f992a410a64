//! The program that `cargo newtau` starts: it runs scenes itself, and gives every other command to cargo.

use crate::program::probe::{FakeProbe, folder};
use crate::program::{at_the_top, told};
use std::path::Path;
use std::process::Command;

const SCENE: &str = "scenes/chapter12/one_link.toml";

fn newtau_run(program: &Path) -> Command {
    let mut command = Command::new(program);
    command.current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/..")).env("NO_COLOR", "1");
    command
}

fn here() -> &'static Path {
    Path::new(env!("CARGO_BIN_EXE_newtau-run"))
}

/// A cargo that writes down its arguments and ends with this code.
fn cargo(test: &str, code: i32) -> FakeProbe {
    FakeProbe::new(test, &format!("exit {code}"))
}

#[test]
fn a_scene_has_the_log_and_the_messages_of_the_whole_program() {
    let cargo = cargo("newtau-run-scene", 0);
    let run = |mut program: Command, name: &str| {
        let out = folder(name).join("out");
        program.args(["run", SCENE, "--no-report", "--quiet", "--duration", "0.1", "--out"]).arg(&out);
        let said = told(program.env("CARGO", cargo.program()).output().unwrap());
        (said, std::fs::read(out.join("log.csv")).unwrap())
    };
    let first = run(newtau_run(here()), "newtau-run-first");
    assert_eq!(first, run(at_the_top(), "newtau-run-whole"));
    assert!(first.0.0 == 0 && first.1.len() > 1000, "{first:?}");

    let bad = |mut program: Command, words: &[&str]| told(program.args(words).output().unwrap());
    for words in [&["run", "no such file.toml"][..], &["run", SCENE, "--law", "best"], &["run", "-h"]] {
        assert_eq!(bad(newtau_run(here()), words), bad(at_the_top(), words), "{words:?}");
    }
    assert!(cargo.calls().is_empty(), "{:?}", cargo.calls());
}

#[test]
fn every_other_command_is_given_to_cargo_word_by_word_with_its_exit_code() {
    let cargo = cargo("newtau-run-other", 7);
    for words in
        [&["stop"][..], &["motors", "scan", "--can", "a b"], &["--help"], &[], &["help", "run"], &["-h", "run"]]
    {
        let (code, printed, error) =
            told(newtau_run(here()).args(words).env("CARGO", cargo.program()).output().unwrap());
        assert_eq!((code, printed.as_str(), error.as_str()), (7, "", ""), "{words:?}");
        let call = cargo.calls().pop().unwrap();
        let (cargo, given) = call
            .split_once(" --")
            .map(|(cargo, _)| (cargo, call.rsplit_once("-- ").map_or("", |(_, given)| given)))
            .unwrap();
        assert_eq!((cargo, given), ("run", words.join(" ").as_str()), "{call}");
        assert!(
            call.contains(" --release ") && call.contains(" --bin newtau ") && call.contains(" --quiet "),
            "{call}"
        );
    }
}

#[test]
fn before_the_whole_program_is_compiled_a_line_says_why_it_takes_long() {
    let alone = folder("newtau-run-alone").join("newtau-run");
    std::fs::copy(here(), &alone).unwrap();
    let cargo = cargo("newtau-run-alone-cargo", 0);
    let (code, _, error) = told(newtau_run(&alone).arg("doctor").env("CARGO", cargo.program()).output().unwrap());
    assert_eq!(code, 0);
    assert!(error.contains("are compiled when they are first used"), "{error}");
    assert!(!cargo.calls().pop().unwrap().contains("--quiet"));
}

#[test]
fn without_cargo_the_message_names_it() {
    let (code, _, error) = told(newtau_run(here()).arg("stop").env("CARGO", "/no/such/cargo").output().unwrap());
    assert_eq!(code, 1);
    assert!(error.contains("cargo") && error.contains("Rust toolchain"), "{error}");
}
