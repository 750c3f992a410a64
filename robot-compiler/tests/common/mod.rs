//! Paths of the project's files, and helpers of several tests.
#![allow(unreachable_pub, reason = "a module of a test program")]

pub mod cases;
pub mod rooms;
pub mod skipping;

use robot_compiler::{Robot, SceneFile};
pub use skipping::skipped;
use std::path::{Path, PathBuf};

/// Runs the formatter on these files, with the project's settings; `None`, reported by [`skipped`], if it is not installed.
pub fn rustfmt<'a>(options: &[&str], files: impl IntoIterator<Item = &'a PathBuf>) -> Option<std::process::ExitStatus> {
    let mut rustfmt = std::process::Command::new(std::env::var_os("RUSTFMT").unwrap_or_else(|| "rustfmt".into()));
    rustfmt.args(["--edition", "2024", "--config", "max_width=120,use_small_heuristics=Max"]).args(options).args(files);
    let status = rustfmt.status();
    if status.is_err() {
        skipped("there is no rustfmt on this machine");
    }
    status.ok()
}

/// A scene in which a robot of `robots/` stays in the middle of its range, with these lines added.
#[allow(clippy::unwrap_used, reason = "a file of the project that cannot be read should stop the test")]
pub fn standing(robot: &str, lines: &str) -> SceneFile {
    let loaded = Robot::load(&top("robots").join(format!("{robot}.toml"))).unwrap();
    let middle = |(low, high): (f64, f64)| if low.is_finite() && high.is_finite() { 0.5 * (low + high) } else { 0.0 };
    let q: Vec<f64> = loaded.joints.iter().map(|joint| middle(joint.spec.limits.position)).collect();
    let motion = format!("[motion]\nkind = \"hold\"\nq = {q:?}\nduration = 1.0\n");
    let text = format!("name = \"test\"\nrobot = \"../robots/{robot}.toml\"\n{lines}\n{motion}");
    SceneFile::from_toml_str(&text, &top("scenes").join("test.toml")).unwrap()
}

/// Compares an output with the one of this name in `tests/data/outputs.txt`.
pub fn compare_output(name: &str, found: String) {
    cases::check(Path::new("tests/data/outputs.txt"), &[(name, found)]);
}

/// A folder at the top of the project.
pub fn top(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("")).join(folder)
}

/// The files of a folder with one of these extensions, sorted.
pub fn files(folder: &Path, extensions: &[&str]) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let wanted = |path: &PathBuf| path.extension().is_some_and(|e| extensions.iter().any(|wanted| e == *wanted));
    let mut files: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).filter(wanted).collect();
    files.sort();
    files
}
