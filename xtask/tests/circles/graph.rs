//! Graph of the uses between files, and its circles.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Files, with the files that they use and the names by which they use them.
#[derive(Default)]
pub(crate) struct Graph(BTreeMap<PathBuf, BTreeMap<PathBuf, BTreeSet<String>>>);

impl Graph {
    /// Adds a use; a file's use of its own items is ignored.
    pub(crate) fn add(&mut self, from: &Path, to: &Path, name: &str) {
        if from != to {
            let names = self.0.entry(from.to_owned()).or_default().entry(to.to_owned()).or_default();
            names.insert(name.to_owned());
        }
    }

    /// The files that one uses, directly or through others.
    fn reached<'a>(&'a self, from: &'a Path) -> BTreeSet<&'a Path> {
        let mut found = BTreeSet::new();
        let mut open = vec![from];
        while let Some(file) = open.pop() {
            let used = self.0.get(file).into_iter().flat_map(BTreeMap::keys).map(PathBuf::as_path);
            open.extend(used.filter(|file| found.insert(*file)));
        }
        found
    }

    /// The circles, each as a text: its files, relative to a folder, and the names by which they use each other.
    pub(crate) fn circles(&self, folder: &Path) -> Vec<String> {
        let reached: BTreeMap<&Path, BTreeSet<&Path>> =
            self.0.keys().map(|file| (file.as_path(), self.reached(file))).collect();
        let circle = |file: &&Path| -> BTreeSet<&Path> {
            reached[file]
                .iter()
                .copied()
                .filter(|other| reached.get(other).is_some_and(|back| back.contains(file)))
                .collect()
        };
        let circles: BTreeSet<_> = reached.keys().map(circle).filter(|circle| !circle.is_empty()).collect();
        circles.iter().map(|circle| self.text(circle, folder)).collect()
    }

    fn text(&self, circle: &BTreeSet<&Path>, folder: &Path) -> String {
        let short = |file: &Path| file.strip_prefix(folder).unwrap_or(file).display().to_string();
        let mut text = circle.iter().map(|file| short(file)).collect::<Vec<_>>().join(", ") + "\n";
        for from in circle {
            for (to, names) in self.0[*from].iter().filter(|(to, _)| circle.contains(to.as_path())) {
                let names = names.iter().map(String::as_str).collect::<Vec<_>>().join(", ");
                writeln!(text, "  {} -> {}: {names}", short(from), short(to)).unwrap();
            }
        }
        text
    }
}
