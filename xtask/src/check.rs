//! `cargo xtask check`: fast checks during development. Format, lints and unit tests of the changed packages.

use crate::process::{output, root, run};
use crate::setup;
use crate::workspace::Workspace;
use anyhow::{Context as _, Result};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Checks the files that differ from the last commit. If none differ, checks those that the last commit changed.
pub(crate) fn changed() -> Result<()> {
    let files = changed_files()?;
    let mut any = false;
    for workspace in Workspace::ALL {
        run(&mut workspace.cargo(["fmt", "--all", "--check"]))?;
        let folders = packages(workspace)?;
        let packages = packages_of(&files, &folders);
        if packages.is_empty() {
            continue;
        }
        any = true;
        println!("check: {}", packages.iter().copied().collect::<Vec<_>>().join(", "));
        let named: Vec<&str> = packages.iter().flat_map(|package| ["--package", package]).collect();
        run(workspace.cargo(["clippy"]).args(&named).args(["--lib", "--bins", "--", "-D", "warnings"]))?;
        setup::nextest()?;
        run(workspace.cargo(["nextest", "run", "--no-tests", "pass", "--lib", "--bins"]).args(&named))?;
    }
    if !any {
        println!("check: the format is right; no package has changed");
    }
    Ok(())
}

/// Paths below the workspace's folder.
fn changed_files() -> Result<Vec<PathBuf>> {
    let git = |arguments: &[&str]| {
        output(Command::new("git").current_dir(root()).args(arguments)).context("git does not say what has changed")
    };
    let mut names =
        git(&["diff", "--name-only", "HEAD"])? + "\n" + &git(&["ls-files", "--others", "--exclude-standard"])?;
    if names.trim().is_empty() {
        names = git(&["diff", "--name-only", "HEAD~1", "HEAD"])?;
    }
    Ok(names.lines().filter(|line| !line.is_empty()).map(PathBuf::from).collect())
}

/// Every package of a workspace and its folder, relative to the project's.
pub(crate) fn packages(workspace: Workspace) -> Result<Vec<(String, PathBuf)>> {
    let mut metadata = workspace.cargo(["metadata", "--no-deps", "--format-version", "1"]);
    let text = output(&mut metadata).context("cargo metadata failed")?;
    let metadata: Value = serde_json::from_str(&text)?;
    let packages = metadata["packages"].as_array().context("cargo metadata names no packages")?;
    let folder = |package: &Value| {
        let manifest = Path::new(package["manifest_path"].as_str()?).parent()?;
        Some((package["name"].as_str()?.to_owned(), manifest.strip_prefix(root()).ok()?.to_owned()))
    };
    Ok(packages.iter().filter_map(folder).collect())
}

/// Packages that contain one of the files; for nested folders, the innermost.
fn packages_of<'a>(files: &[PathBuf], folders: &'a [(String, PathBuf)]) -> BTreeSet<&'a str> {
    let holder = |file: &PathBuf| {
        let around = folders.iter().filter(|(_, folder)| file.starts_with(folder));
        around.max_by_key(|(_, folder)| folder.components().count()).map(|(name, _)| name.as_str())
    };
    files.iter().filter_map(holder).collect()
}

#[cfg(test)]
mod tests {
    use super::packages_of;
    use std::path::PathBuf;

    #[test]
    fn a_file_belongs_to_the_innermost_package_and_a_page_to_none() {
        let folders = [("xtask", "xtask"), ("chip-image", "xtask/image"), ("link", "link")];
        let folders = folders.map(|(name, folder)| (name.to_owned(), PathBuf::from(folder)));
        let of = |files: &[&str]| {
            let files: Vec<PathBuf> = files.iter().map(PathBuf::from).collect();
            packages_of(&files, &folders).into_iter().collect::<Vec<_>>()
        };
        assert_eq!(of(&["xtask/image/src/elf.rs", "docs/link.md", "README.md"]), ["chip-image"]);
        assert_eq!(of(&["xtask/src/main.rs", "xtask/Cargo.toml", "link/src/lib.rs"]), ["link", "xtask"]);
        assert!(of(&["linkage.md"]).is_empty());
    }
}
