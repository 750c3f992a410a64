//! Check for phrases over which outside readers stumble, and for uninformative first lines of documentation.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::path::{Path, PathBuf};

/// Phrases that are never clear, and their replacements. Words that also have a right use ("place", "way") are left to human readers.
const BANNED: [(&str, &str); 19] = [
    ("there and back", "back and forth"),
    ("led by hand", "hand-guided, hand guiding"),
    ("drill", "dry run"),
    ("drills", "dry runs"),
    ("rub", "friction"),
    ("rubs", "friction"),
    ("rubbing", "friction"),
    ("physicist", "impossible, improbable or missing"),
    ("fifth wrong", "20 % error"),
    ("nobody knows", "unknown"),
    ("last words", "the log"),
    ("own words", "error text"),
    ("what is asked for", "the request, the commanded value"),
    ("it is told", "it is sent, it is commanded"),
    ("is told", "is sent, is reported"),
    ("are told", "are sent, are reported"),
    ("comes of", "is caused by, results from"),
    ("who leaves live", "if the firmware leaves live mode"),
    ("so many kg", "MASS kg"),
];

/// A file, and a banned phrase that has its ordinary meaning there.
const ALLOWED: [(&str, &str); 2] = [
    // The title of a study; its result uses it as an anchor.
    ("docs/control/hand-guiding.md", "led by hand"),
    // `.words(own).words(..)`.
    ("xtask/src/peers/chip.rs", "own words"),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

/// Sources and pages below a folder, without generated and built files.
fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap();
        if path.is_dir() {
            if !name.starts_with('.') && !["target", "measured", "node_modules", "tests"].contains(&name) {
                files(&path, found);
            }
        } else if name != "CHANGELOG.md" && (name.ends_with(".md") || name.ends_with(".rs")) {
            found.push(path);
        }
    }
}

fn all() -> Vec<(String, String)> {
    let mut found = Vec::new();
    files(&root(), &mut found);
    assert!(found.len() > 500, "{}", found.len());
    let name = |path: &Path| path.strip_prefix(root()).unwrap().to_str().unwrap().to_owned();
    found.into_iter().map(|path| (name(&path), std::fs::read_to_string(&path).unwrap())).collect()
}

/// The words of a text in lower case, each between two spaces, so that line breaks do not matter.
fn words(text: &str) -> String {
    let lower = text.to_lowercase();
    let words: Vec<_> =
        lower.split(|c: char| !(c.is_alphanumeric() || c == '\'')).filter(|word| !word.is_empty()).collect();
    format!(" {} ", words.join(" "))
}

/// Banned phrases of a text.
fn banned(text: &str) -> Vec<(&'static str, &'static str)> {
    let words = words(text);
    BANNED.into_iter().filter(|(phrase, _)| words.contains(&format!(" {phrase} "))).collect()
}

#[test]
fn no_page_and_no_source_has_a_phrase_that_readers_stumbled_over() {
    let mut found = Vec::new();
    for (file, text) in all().iter().filter(|(file, _)| file != "xtask/tests/voice.rs") {
        for (phrase, better) in banned(text) {
            if !ALLOWED.contains(&(file.as_str(), phrase)) {
                found.push(format!("{file}: {phrase:?}; write {better}"));
            }
        }
    }
    assert!(found.is_empty(), "{} phrases:\n{}", found.len(), found.join("\n"));
}

/// Counts first lines of documentation that ask instead of state.
fn questions(text: &str) -> usize {
    let starts = |line: &str, marker: &str| {
        let rest = line.trim_start().strip_prefix(marker);
        rest.is_some_and(|rest| ["What ", "Whether ", "How "].iter().any(|word| rest.trim_start().starts_with(word)))
    };
    let mut before = "";
    let mut count = 0;
    for line in text.lines() {
        let first = !before.trim_start().starts_with("//");
        count += usize::from(first && (starts(line, "///") || starts(line, "//!")));
        before = line;
    }
    count
}

#[test]
fn documentation_begins_with_a_noun_or_a_verb() {
    let asking: Vec<_> =
        all().into_iter().filter(|(file, text)| file.ends_with(".rs") && questions(text) > 0).collect();
    let asking: Vec<_> = asking.iter().map(|(file, _)| file).collect();
    assert!(asking.is_empty(), "documentation that begins with What, Whether or How: {asking:?}");
}

#[test]
fn phrases_and_questions_are_found_across_lines_and_markers() {
    assert_eq!(banned("/// the arm is led\n/// by  hand").len(), 1);
    assert_eq!(banned("the drive's `Rubs`, which rub").len(), 2);
    assert!(banned("a scrub, drilled, and handled by hand").is_empty());
    assert_eq!(questions("/// What it is.\npub struct X;\n    /// How it goes.\n    y: u8,"), 2);
    assert_eq!(questions("/// A thing.\n/// What else."), 0);
}
