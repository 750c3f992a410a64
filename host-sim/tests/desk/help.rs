//! The program's description of itself: commands, help on one screen, examples that run.

use crate::program::{at_the_top, new, printed, told};
use clap::CommandFactory as _;
use host_sim::cli::{Cli, renamed};
use std::fs;
use std::path::{Path, PathBuf};

/// Number of lines on a screen.
const SCREEN: usize = 50;

/// Every command and subcommand, as words.
fn commands() -> Vec<Vec<String>> {
    fn below(command: &clap::Command, path: &[String], found: &mut Vec<Vec<String>>) {
        for part in command.get_subcommands().filter(|part| part.get_name() != "help") {
            let path = [path, &[part.get_name().to_owned()]].concat();
            found.push(path.clone());
            below(part, &path, found);
        }
    }
    let mut found = Vec::new();
    below(&Cli::command(), &[], &mut found);
    found
}

fn help(words: &[String]) -> String {
    printed(at_the_top().args(words).arg("--help").output().unwrap())
}

#[test]
fn there_are_sixteen_commands_and_the_help_lists_each() {
    let shown: Vec<String> = Cli::command()
        .get_subcommands()
        .filter(|command| !command.is_hide_set())
        .map(|command| command.get_name().to_owned())
        .collect();
    assert_eq!(shown.len(), 16, "{shown:?}");
    let text = help(&[]);
    let listed: Vec<&str> = text
        .lines()
        .filter_map(|line| line.strip_prefix("  ")?.split_once(' '))
        .filter(|(name, about)| about.starts_with(' ') && name.chars().all(char::is_alphabetic))
        .map(|(name, _)| name)
        .collect();
    assert_eq!(listed, shown);
}

#[test]
fn help_fits_on_a_screen_and_ends_with_an_example_of_the_command() {
    for words in commands() {
        let text = help(&words);
        let lines = text.lines().count();
        assert!(lines <= SCREEN, "{words:?}: {lines} lines");
        // A command that can be called itself has an example. A command above it may show one of its subcommands'.
        let last = text.lines().last().unwrap();
        let called = format!("  newtau {}", words.join(" "));
        assert!(last.starts_with(&called), "{words:?}: {last}");
    }
    assert!(help(&[]).lines().count() <= SCREEN);
}

#[test]
fn every_earlier_name_answers_with_a_command_that_there_is() {
    let known = commands();
    for (earlier, present) in renamed::RENAMED {
        let words: Vec<String> = present.split(' ').map(str::to_owned).collect();
        assert!(known.contains(&words), "{present}");
        let (code, out, error) = told(at_the_top().args([earlier, "x"]).output().unwrap());
        assert_eq!((code, out.as_str()), (2, ""), "{error}");
        assert!(error.contains(&format!("expected `newtau {present}`")), "{error}");
        assert!(!known.contains(&vec![earlier.to_owned()]), "{earlier} is a command again");
    }
}

#[test]
fn a_shell_completes_the_commands() {
    for shell in ["bash", "zsh", "fish"] {
        let script = printed(at_the_top().args(["completions", shell]).output().unwrap());
        assert!(script.contains("identify") && script.contains("margins"), "{shell}");
    }
}

/// A folder with the robots and scenes of the project, and what the examples read.
fn work() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("help");
    fs::create_dir_all(new(&folder)).unwrap();
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().unwrap();
    for (from, to) in [("robots", "robots"), ("scenes", "scenes")] {
        copy(&top.join(from), &folder.join(to));
    }
    fs::copy(top.join("host-sim/tests/fixtures/traps.urdf"), folder.join("arm.urdf")).unwrap();
    for line in [
        "run scenes/planar2r_swing.toml --quiet --no-report",
        "run scenes/yam_teach.toml --quiet --no-report",
        "run scenes/puma560_pick.toml --quiet --duration 0.1",
        "run scenes/puma560_pick.toml --quiet --duration 0.1 --law pd --out out/pd",
        "sweep scenes/studies/delay_stiffness.toml --quiet --out out/shards/1",
        "connect scenes/planar2r_swing.toml --target desk --record out/session.log",
    ] {
        let (code, out, error) = told(at_the_top().current_dir(&folder).args(line.split(' ')).output().unwrap());
        assert_eq!(code, 0, "{line}: {out}{error}");
    }
    folder
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let copied = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy(&path, &copied);
        } else {
            fs::copy(&path, &copied).unwrap();
        }
    }
}

/// Examples that build firmware. The README has them too, and another test runs its commands.
const OF_README: [&str; 3] = ["choose", "choose trade", "firmware build"];

#[test]
fn every_example_runs() {
    let folder = work();
    let readme = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../README.md")).unwrap();
    let mut done: Vec<String> = Vec::new();
    for words in commands().into_iter().chain([vec![]]) {
        let text = help(&words);
        let example = text.lines().rev().find_map(|line| line.strip_prefix("  newtau ")).unwrap();
        // A command above may show the example of a subcommand.
        if done.iter().any(|other| other == example) {
            continue;
        }
        done.push(example.to_owned());
        if OF_README.contains(&words.join(" ").as_str()) {
            assert!(readme.contains(&format!("cargo newtau {example}")), "{example}");
            continue;
        }
        let output =
            at_the_top().current_dir(&folder).args(example.split(' ')).stdin(std::process::Stdio::null()).output();
        let (code, out, error) = told(output.unwrap());
        if words.first().is_some_and(|word| word == "motors") {
            // There is no adapter here.
            assert!(
                code == 1 && (error.contains("/dev/ttyACM0: ") || error.contains("can0: ")),
                "{example}: {code}\n{error}"
            );
            continue;
        }
        // A short log of a moving arm may give a doubtful model.
        let fine: &[i32] = match words.join(" ").as_str() {
            "identify" => &[0, 3],
            // There is no session to stop.
            "stop" => &[3],
            _ => &[0],
        };
        assert!(fine.contains(&code), "{example}: {code}\n{out}{error}");
    }
}
