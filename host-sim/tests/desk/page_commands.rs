//! The reference of the command line, and the commands of all pages: compared with the program's own parser.

use clap::{ArgAction, Command, CommandFactory as _};
use host_sim::cli::Cli;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

const PAGE: &str = "docs/reference/command-line.md";

const HEAD: &str = "# Command line

> Generated from the program by `UPDATE_EMITTED=1 cargo nextest run --workspace -E 'test(reference_of_the_command_line)'`; a test compares it.

`newtau COMMAND --help` shows the same on a screen, with an example. Every command takes `-h, --help`. An option without a default is off, or is
explained in its row. `--json` prints machine-readable output; [output files](output-files.md) has the keys.

| exit code | meaning |
|---|---|
| 0 | done |
| 1 | something outside failed: a file could not be written, the target died; a replay that differs, or ends before its record |
| 2 | bad input: a file, a line or an option; the message says where and what was expected |
| 3 | the run ended in a fault, a command of a session was refused, the simulated arm diverged, the linkage came to a dead point, `check` found something wrong, or `identify` does not trust its result |
| 4 | chip and desk differed in some tick |
| 130 | interrupted; everything recorded until then was written |
";

fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ").replace('|', "\\|").replace('<', "&lt;")
}

/// Writes the section of a command, and those of its subcommands.
fn section(command: &Command, path: &str, page: &mut String) {
    let about = command.get_about().map(|about| one_line(&about.to_string())).unwrap_or_default();
    let _ = write!(page, "\n## {path}\n\n{about}\n");
    let arguments: Vec<_> = command.get_arguments().filter(|a| !a.is_hide_set() && a.get_id() != "help").collect();
    if !arguments.is_empty() {
        page.push_str("\n| argument | default | meaning |\n|---|---|---|\n");
    }
    for argument in arguments {
        let value = argument.get_value_names().map(|names| names.join(" ")).unwrap_or_default();
        let takes = matches!(argument.get_action(), ArgAction::Set | ArgAction::Append);
        let name = match (argument.get_long(), takes) {
            (Some(long), true) => format!("--{long} {value}"),
            (Some(long), false) => format!("--{long}"),
            (None, _) if argument.is_required_set() => value,
            (None, _) => format!("[{value}]"),
        };
        let default: Vec<_> = argument.get_default_values().iter().map(|value| value.to_string_lossy()).collect();
        let help = argument.get_help().map(|help| one_line(&help.to_string())).unwrap_or_default();
        let choices: Vec<_> = if takes { argument.get_possible_values() } else { Vec::new() };
        let choices: Vec<_> =
            choices.iter().filter(|v| !v.is_hide_set()).map(|v| format!("`{}`", v.get_name())).collect();
        let choices = if choices.is_empty() {
            String::new()
        } else {
            format!("{} One of {}", if help.ends_with('.') { "" } else { "." }, choices.join(", "))
        };
        let _ = writeln!(page, "| `{}` | {} | {help}{choices} |", name.replace('|', "\\|"), default.join(" "));
    }
    for part in command.get_subcommands().filter(|part| part.get_name() != "help" && !part.is_hide_set()) {
        section(part, &format!("{path} {}", part.get_name()), page);
    }
}

#[test]
fn the_reference_of_the_command_line_is_the_parsers_own() {
    let mut page = HEAD.to_owned();
    for command in Cli::command().get_subcommands().filter(|command| !command.is_hide_set()) {
        section(command, &format!("newtau {}", command.get_name()), &mut page);
    }
    let file = top().join(PAGE);
    if std::env::var_os("UPDATE_EMITTED").is_some() {
        fs::write(&file, &page).unwrap();
    }
    let shown = fs::read_to_string(&file).unwrap_or_default();
    let differs = shown.lines().zip(page.lines()).position(|(a, b)| a != b);
    assert!(shown == page, "{PAGE} is not the program's, from line {differs:?} on: {HEAD}");
}

/// Pages below a folder.
fn pages(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            pages(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "md") {
            found.push(path);
        }
    }
}

/// Calls of the program in a page's blocks of code, without what a shell does with their output.
fn calls(text: &str) -> Vec<String> {
    let blocks = text.split("\n```").skip(1).step_by(2);
    let joined: Vec<String> = blocks.map(|block| block.replace("\\\n", " ")).collect();
    let lines = joined.iter().flat_map(|block| block.lines());
    let called = lines.filter_map(|line| {
        let line = line.trim_start().trim_start_matches("$ ");
        line.strip_prefix("cargo newtau ").or_else(|| line.strip_prefix("newtau ")).map(str::to_owned)
    });
    called
        .map(|call| {
            call.split(" # ")
                .next()
                .unwrap()
                .split(" | ")
                .next()
                .unwrap()
                .split(" > ")
                .next()
                .unwrap()
                .trim()
                .to_owned()
        })
        .collect()
}

/// True for a word in capitals, which stands for a value of the reader's.
fn is_placeholder(word: &str) -> bool {
    word.len() > 1
        && word.chars().any(char::is_alphabetic)
        && word.chars().all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || "_-.".contains(c))
}

/// Description of a mistake in a call: the parser rejects it with every meaning of its placeholders, or a file of the project is missing.
fn complaint(call: &str) -> Option<String> {
    let Some(words) = shlex::split(call) else { return Some("an open quote".to_owned()) };
    let parsed = |stand_in: &str| {
        let filled = words.iter().map(|word| if is_placeholder(word) { stand_in.to_owned() } else { word.clone() });
        Cli::command().try_get_matches_from(core::iter::once("newtau".to_owned()).chain(filled))
    };
    let tries = ["scenes/yours.toml", "1", "1,1", "qemu", "computed-torque"].map(parsed);
    let refused = |error: &clap::Error| {
        !matches!(error.kind(), clap::error::ErrorKind::DisplayHelp | clap::error::ErrorKind::DisplayVersion)
    };
    if let [Err(error), ..] = &tries
        && tries.iter().all(|one| one.as_ref().is_err_and(refused))
    {
        return Some(error.to_string().lines().next().unwrap_or_default().to_owned());
    }
    let ours = words.iter().filter(|word| word.starts_with("robots/") || word.starts_with("scenes/"));
    let mut missing = ours.filter(|word| {
        let own = ["yours", "mine", "my-", "my_", "your", "NAME"].iter().any(|part| word.contains(part));
        !own && !word.contains('*') && !word.contains('{') && !top().join(word.as_str()).exists()
    });
    missing.next().map(|file| format!("{file} does not exist"))
}

#[test]
fn every_call_of_every_page_parses_and_names_files_that_exist() {
    let mut files = vec![top().join("README.md"), top().join("robots/README.md"), top().join("scenes/README.md")];
    pages(&top().join("docs"), &mut files);
    let mut count = 0;
    let mut wrong = Vec::new();
    for file in files {
        for call in calls(&fs::read_to_string(&file).unwrap()) {
            count += 1;
            if let Some(complaint) = complaint(&call) {
                wrong.push(format!("{}: newtau {call}: {complaint}", file.strip_prefix(top()).unwrap().display()));
            }
        }
    }
    assert!(count > 80, "{count} calls");
    assert!(wrong.is_empty(), "{} of {count} calls:\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn a_call_that_would_fail_is_found() {
    let text = "text\n```console\n$ cargo newtau run SCENE \\\n   --duration 2 # two seconds\nnewtau bogus\n```\n";
    assert_eq!(calls(text), ["run SCENE     --duration 2", "bogus"]);
    assert_eq!(complaint("run SCENE --duration 2"), None);
    assert!(complaint("bogus").is_some() && complaint("run scenes/none.toml").is_some());
    assert!(complaint("run SCENE --no-such-option").is_some());
    assert!(complaint("run 'scenes/a.toml").is_some());
}
