//! Build of the documentation as a searchable book, together with the crates' API documentation.

use crate::process::{output, root, run, target_directory, which};
use anyhow::{Context as _, Result, ensure};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Component, Path, PathBuf};
use std::process::Command;

/// Order of the chapters: folders of `docs` and their titles. A folder's README comes first. Pages directly in `docs` are guides.
const PARTS: [(&str, &str); 9] = [
    ("docs/start", "Start"),
    ("docs", "Guides"),
    ("docs/operate", "Operate"),
    ("docs/control", "Control laws"),
    ("docs/safety", "Safety"),
    ("docs/reference", "Reference"),
    ("docs/theory", "Theory"),
    ("docs/develop", "Develop"),
    ("docs/decisions", "Decisions"),
];

/// Builds the book and the API documentation, and prints their paths.
pub(crate) fn build() -> Result<()> {
    if which("mdbook").is_none() {
        eprintln!("docs: cargo install --locked mdbook");
        run(Command::new("cargo").args(["install", "--locked", "mdbook", "--version", "^0.5"]))?;
    }
    let version = output(Command::new("mdbook").arg("--version")).unwrap_or_default();
    ensure!(version.contains("v0.5"), "found {version:?}; expected mdbook 0.5: cargo install --locked mdbook");
    let folder = target_directory().join("book");
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    let source = folder.join("src");
    let summary = summary()?;
    for page in linked(&summary) {
        copy(&page, &source)?;
    }
    fs::write(source.join("SUMMARY.md"), &summary)?;
    fs::write(
        folder.join("book.toml"),
        "[book]\ntitle = \"newtau\"\nlanguage = \"en\"\n\n[output.html]\nno-section-label = true\n\n[output.html.fold]\nenable = true\nlevel = 0\n",
    )?;
    run(Command::new("mdbook").arg("build").arg(&folder))?;
    let book = folder.join("book/index.html");
    ensure!(book.is_file(), "mdbook wrote no {}", book.display());
    run(Command::new("cargo").args(["doc", "--workspace", "--no-deps", "--locked"]).current_dir(root()))?;
    println!("{}\n{}", book.display(), target_directory().join("doc/dynamics_core/index.html").display());
    Ok(())
}

/// The title of a page: its first heading.
fn title(page: &str) -> Result<String> {
    let text = fs::read_to_string(root().join(page)).with_context(|| page.to_owned())?;
    let heading = text.lines().find_map(|line| line.strip_prefix("# "));
    Ok(heading.with_context(|| format!("{page} has no title"))?.replace('`', ""))
}

/// Pages of a folder, its README first.
fn pages(folder: &str) -> Result<Vec<String>> {
    let entries = fs::read_dir(root().join(folder)).with_context(|| folder.to_owned())?;
    let names = entries.map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned()));
    let mut names: Vec<String> = names.collect::<Result<_>>()?;
    names.retain(|name| name.ends_with(".md"));
    names.sort_by_key(|name| (name != "README.md", name.clone()));
    Ok(names.into_iter().map(|name| format!("{folder}/{name}")).collect())
}

/// The book's table of contents: every page of the documentation.
fn summary() -> Result<String> {
    let mut text = format!("# Summary\n\n[{}](README.md)\n", title("README.md")?);
    let entry = |page: &str, indent: &str| Ok::<_, anyhow::Error>(format!("{indent}- [{}]({page})\n", title(page)?));
    for (folder, part) in PARTS {
        text += &format!("\n# {part}\n\n");
        for page in pages(folder)? {
            text += &entry(&page, "")?;
        }
        if folder == "docs/reference" {
            text += &entry("robots/README.md", "")?;
            text += &entry("scenes/README.md", "")?;
        }
    }
    text += "\n# Measured\n\n";
    for page in pages("docs/measured")? {
        text += &entry(&page, "")?;
    }
    text += "\n# Project\n\n";
    for page in ["CONTRIBUTING.md", "CHANGELOG.md"] {
        text += &entry(page, "")?;
    }
    Ok(text)
}

/// Targets of the links in a text, without anchors; web addresses are left out.
fn targets(text: &str) -> impl Iterator<Item = &str> {
    let links = text.split("](").skip(1).filter_map(|rest| rest.split([')', ' ', '#']).next());
    links.filter(|link| !link.is_empty() && !link.contains("://"))
}

/// Files of the project that the book needs: its pages, and what these link to.
fn linked(summary: &str) -> BTreeSet<PathBuf> {
    let pages: BTreeSet<PathBuf> = targets(summary).map(PathBuf::from).collect();
    let mut all = pages.clone();
    for page in pages {
        let text = fs::read_to_string(root().join(&page)).unwrap_or_default();
        let folder = page.parent().unwrap_or(Path::new(""));
        all.extend(targets(&text).map(|link| plain(&folder.join(link))).filter(|file| root().join(file).is_file()));
    }
    all
}

/// A path without `..`.
fn plain(path: &Path) -> PathBuf {
    path.components().fold(PathBuf::new(), |mut plain, part| {
        match part {
            Component::ParentDir => _ = plain.pop(),
            other => plain.push(other),
        }
        plain
    })
}

fn copy(file: &Path, to: &Path) -> Result<()> {
    let target = to.join(file);
    if let Some(folder) = target.parent() {
        fs::create_dir_all(folder)?;
    }
    fs::copy(root().join(file), &target).with_context(|| file.display().to_string())?;
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

    use super::{PARTS, linked, plain, summary, targets};
    use crate::process::root;
    use std::collections::BTreeSet;
    use std::path::Path;

    #[test]
    fn every_folder_of_the_documentation_is_a_part_of_the_book() {
        let folders = std::fs::read_dir(root().join("docs")).unwrap().map(|entry| entry.unwrap());
        let folders = folders.filter(|entry| entry.path().is_dir()).map(|entry| entry.file_name());
        let found: BTreeSet<_> = folders.map(|name| format!("docs/{}", name.to_str().unwrap())).collect();
        let parts = PARTS.into_iter().map(|(folder, _)| folder.to_owned());
        // Figures are not pages, and the measured pages have a separate part.
        let listed: BTreeSet<_> = parts.chain(["docs/figures", "docs/measured"].map(str::to_owned)).collect();
        assert!(found.is_subset(&listed), "{:?}", found.difference(&listed).collect::<Vec<_>>());
        let summary = summary().unwrap();
        assert!(
            targets(&summary).count() > 70 && linked(&summary).contains(Path::new("docs/figures/control-tick.svg"))
        );
    }

    #[test]
    fn paths_lose_their_way_up() {
        assert_eq!(plain(Path::new("docs/start/../figures/./a.svg")), Path::new("docs/figures/a.svg"));
    }
}
