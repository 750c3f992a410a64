//! Listings of the public interface of the packages that others depend on, one item a line: written, or compared with the interface of today.
//!
//! rustdoc describes a package as JSON, which the stable compiler writes only with `RUSTC_BOOTSTRAP`. The format of this JSON changes between
//! compilers, and the tool that turns it into lines reads one format: [`TOOL`] and [`FORMAT`] belong together.

use crate::process::{cargo, output, root, run, target_directory};
use anyhow::{Context as _, Result, bail, ensure};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Packages with a public interface.
const PACKAGES: [&str; 4] = ["dynamics-core", "robot-compiler", "newtau-link", "newtau-session"];

/// Version of `cargo-public-api`.
const TOOL: &str = "0.52.0";

/// Format of rustdoc's JSON that this version reads: the one of Rust 1.95.
const FORMAT: u64 = 57;

/// Beginnings of what follows the type in lines about methods of derived traits. Their `impl` has a line of its own, so they say nothing new.
const DERIVED: [&str; 6] = [
    "::clone(&self)",
    "::eq(&self, ",
    "::partial_cmp(&self, ",
    "::cmp(&self, ",
    "::hash<",
    "::fmt(&self, &mut core::fmt::Formatter",
];

/// Most lines of a difference that are printed.
const SHOWN: usize = 20;

/// Writes the listings, or compares them.
pub(crate) fn run_task(check: bool) -> Result<()> {
    let tool = tool()?;
    let mut differences = Vec::new();
    for package in PACKAGES {
        let listing = listing(&tool, package)?;
        let name = format!("docs/reference/api/{package}.txt");
        let file = root().join(&name);
        let held = fs::read_to_string(&file).unwrap_or_default();
        if held == listing {
            println!("api: {name} is current");
        } else if check {
            differences.push(format!("{name}:\n{}", difference(&held, &listing)));
        } else {
            fs::create_dir_all(file.parent().unwrap_or(&file))?;
            fs::write(&file, listing).with_context(|| name.clone())?;
            println!("api: {name} is written");
        }
    }
    if differences.is_empty() {
        return Ok(());
    }
    bail!(
        "the public interface has changed:\n{}\nIf that is intended, run `cargo xtask api`, and describe the change in CHANGELOG.md",
        differences.join("\n")
    )
}

/// The program that lists an interface, installed below the build folder if it is missing.
fn tool() -> Result<PathBuf> {
    let folder = target_directory().join("tools");
    let program = folder.join("bin/cargo-public-api");
    let found = output(Command::new(&program).arg("--version")).unwrap_or_default();
    if !found.split(' ').any(|word| word == TOOL) {
        eprintln!("api: cargo install --locked cargo-public-api --version {TOOL}, into {}", folder.display());
        run(cargo(["install", "--quiet", "--locked", "cargo-public-api", "--version", TOOL, "--root"]).arg(&folder))?;
    }
    Ok(program)
}

/// The interface of a package with all its features, one item a line. Implementations that the compiler makes by itself (blanket, automatic) are
/// left out, and so are [methods of derived traits](DERIVED); the implementations of these traits are in it.
fn listing(tool: &Path, package: &str) -> Result<String> {
    // A build folder of its own: `RUSTC_BOOTSTRAP` would make cargo compile dependencies of the other builds again.
    let target = target_directory().join("api");
    let mut rustdoc = cargo(["rustdoc", "--quiet", "--locked", "--lib", "--all-features", "--package", package]);
    rustdoc.args(["--", "-Z", "unstable-options", "--output-format", "json"]);
    run(rustdoc.env("RUSTC_BOOTSTRAP", "1").env("CARGO_TARGET_DIR", &target))?;
    let json = target.join("doc").join(package.replace('-', "_")).with_extension("json");
    let format = format_of(&fs::read_to_string(&json).with_context(|| json.display().to_string())?)?;
    ensure!(
        format == FORMAT,
        "{}: found format {format}; expected {FORMAT}, which Rust 1.95 writes. Choose the version of cargo-public-api that reads format {format}, in {}",
        json.display(),
        file!()
    );
    let listed = Command::new(tool)
        .args(["--simplified", "--simplified", "--color", "never", "--rustdoc-json"])
        .arg(&json)
        .output()
        .with_context(|| tool.display().to_string())?;
    ensure!(listed.status.success(), "{}: {}", tool.display(), String::from_utf8_lossy(&listed.stderr).trim());
    let listing = short(&String::from_utf8(listed.stdout).context("the listing is not text")?);
    ensure!(listing.lines().count() > 1, "{package}: the listing is empty");
    Ok(listing)
}

/// The lines that say something of their own.
fn short(listing: &str) -> String {
    let implied = |line: &&str| {
        line.contains("core::marker::StructuralPartialEq") || DERIVED.iter().any(|method| line.contains(method))
    };
    listing.lines().filter(|line| !implied(line)).flat_map(|line| [line, "\n"]).collect()
}

/// Number of the format in rustdoc's JSON.
fn format_of(json: &str) -> Result<u64> {
    #[derive(serde::Deserialize)]
    struct Head {
        format_version: u64,
    }
    Ok(serde_json::from_str::<Head>(json).context("rustdoc's JSON has no format_version")?.format_version)
}

/// Lines that were removed and added, as many as [`SHOWN`].
fn difference(old: &str, new: &str) -> String {
    let missing = |text: &str, other: &str, mark| {
        let others: std::collections::HashSet<&str> = other.lines().collect();
        text.lines().filter(|line| !others.contains(line)).map(|line| format!("{mark} {line}")).collect::<Vec<_>>()
    };
    let mut lines = missing(old, new, '-');
    lines.extend(missing(new, old, '+'));
    if lines.is_empty() {
        return "the same items in another order".to_owned();
    }
    let more = lines.len().saturating_sub(SHOWN);
    lines.truncate(SHOWN);
    if more > 0 {
        lines.push(format!("... and {more} more"));
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::{SHOWN, difference, format_of, short};

    #[test]
    fn methods_of_derived_traits_are_left_out() {
        let kept = "impl core::clone::Clone for a::B\npub fn a::B::clone_from_slice(&self)\n";
        let derived = "pub fn a::B::clone(&self) -> a::B\npub fn a::B::eq(&self, &a::B) -> bool\n";
        assert_eq!(short(&(kept.to_owned() + derived)), kept);
    }

    #[test]
    fn a_difference_names_removed_and_added_items() {
        assert_eq!(difference("a\nb\nc\n", "a\nc\nd\n"), "- b\n+ d");
        assert_eq!(difference("a\nb\n", "b\na\n"), "the same items in another order");
        let many: String = (0..SHOWN + 3).map(|i| format!("{i}\n")).collect();
        let text = difference("", &many);
        assert!(text.starts_with("+ 0\n") && text.ends_with("\n... and 3 more"), "{text}");
    }

    #[test]
    fn the_format_is_read_from_the_json() {
        assert_eq!(format_of(r#"{"root":1,"index":{"0":{}},"format_version":57}"#).ok(), Some(57));
        assert!(format_of("{}").is_err());
    }
}
