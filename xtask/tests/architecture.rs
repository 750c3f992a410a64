//! Check of the architecture against cargo's metadata: eleven folders, at most twenty packages and the two of the Python wheel, and their allowed dependencies
//! (`docs/develop/architecture.md`).
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Top-level folders. `bench` is a separate workspace.
const ROOMS: [&str; 11] = [
    "dynamics-core",
    "robot-compiler",
    "link",
    "firmware",
    "host-sim",
    "xtask",
    "bench",
    "python",
    "robots",
    "scenes",
    "docs",
];

/// Top-level folders that are not in git.
const MADE: [&str; 2] = ["target", "out"];

/// Largest number of packages: twenty of the product, each of which is one to learn, and two of the Python wheel.
const PACKAGES_MAX: usize = 22;

/// A package, its folder, and the workspace packages that it may depend on: in its build, and additionally in its tests.
struct Row {
    package: &'static str,
    folder: &'static str,
    knows: &'static [&'static str],
    in_tests: &'static [&'static str],
}

const fn row(
    package: &'static str,
    folder: &'static str,
    knows: &'static [&'static str],
    in_tests: &'static [&'static str],
) -> Row {
    Row { package, folder, knows, in_tests }
}

/// Every package except `xtask` itself; the packages under `xtask` may depend on all of these.
const ALL: &[&str] = &[
    "dynamics-core",
    "robot-compiler",
    "machine-code",
    "newtau-link",
    "newtau-session",
    "joint-io",
    "actuator-model",
    "arm",
    "probe",
    "firmware",
    "sim",
    "board",
    "studies",
    "host-sim",
    "firmware-image",
    "identification",
    "report",
    "chip-image",
    "batch-engine",
    "newtau-python",
    "trials",
];

const ROWS: [Row; 22] = [
    row("dynamics-core", "dynamics-core", &[], &[]),
    row("robot-compiler", "robot-compiler", &["dynamics-core"], &[]),
    row("machine-code", "robot-compiler/machine-code", &["robot-compiler"], &["dynamics-core"]),
    // Its tests use host features, so the package depends on itself with another feature.
    row("newtau-link", "link", &["dynamics-core"], &["newtau-link"]),
    row("newtau-session", "link/session", &["dynamics-core", "newtau-link"], &["robot-compiler"]),
    row("joint-io", "link/joint-io", &["dynamics-core", "newtau-session"], &["actuator-model", "newtau-link"]),
    row("actuator-model", "link/actuators", &[], &[]),
    row("arm", "firmware/arm", &["dynamics-core"], &[]),
    row("probe", "firmware/probe", &["dynamics-core"], &[]),
    row("firmware", "firmware", &["arm", "dynamics-core", "joint-io", "newtau-link", "newtau-session"], &[]),
    row(
        "sim",
        "host-sim/sim",
        &[
            "actuator-model",
            "dynamics-core",
            "joint-io",
            "newtau-link",
            "machine-code",
            "report",
            "robot-compiler",
            "newtau-session",
        ],
        &[],
    ),
    row(
        "board",
        "host-sim/board",
        &[
            "actuator-model",
            "dynamics-core",
            "firmware-image",
            "identification",
            "joint-io",
            "newtau-link",
            "report",
            "robot-compiler",
            "newtau-session",
            "sim",
        ],
        &[],
    ),
    row(
        "studies",
        "host-sim/studies",
        &[
            "board",
            "dynamics-core",
            "firmware-image",
            "identification",
            "joint-io",
            "newtau-link",
            "report",
            "robot-compiler",
            "newtau-session",
            "sim",
        ],
        &[],
    ),
    row(
        "host-sim",
        "host-sim",
        &[
            "board",
            "dynamics-core",
            "firmware-image",
            "identification",
            "newtau-link",
            "report",
            "robot-compiler",
            "newtau-session",
            "sim",
            "studies",
        ],
        &[],
    ),
    row("firmware-image", "host-sim/firmware-image", &["dynamics-core", "robot-compiler"], &[]),
    row("identification", "host-sim/identification", &["dynamics-core"], &["robot-compiler"]),
    row("report", "host-sim/report", &[], &[]),
    row("chip-image", "xtask/image", &["firmware-image"], &[]),
    row("batch-engine", "python/engine", &["dynamics-core", "robot-compiler"], &[]),
    row(
        "newtau-python",
        "python",
        &["batch-engine", "dynamics-core", "identification", "robot-compiler", "sim", "studies"],
        &[],
    ),
    row("trials", "xtask/trials", ALL, ALL),
    row("xtask", "xtask", ALL, ALL),
];

/// Pairs of packages; the first must not depend on the second, directly or indirectly.
const NEVER: [(&str, &str); 9] = [
    ("host-sim", "firmware"),
    ("sim", "board"),
    ("board", "studies"),
    ("host-sim", "arm"),
    ("firmware", "host-sim"),
    ("firmware", "actuator-model"),
    ("trials", "firmware"),
    ("newtau-session", "robot-compiler"),
    ("dynamics-core", "newtau-link"),
];

fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

fn metadata() -> Value {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(top()).args(["metadata", "--no-deps", "--format-version", "1", "--locked"]);
    let output = cargo.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Dependencies of one package on others of the workspace.
#[derive(Default)]
struct Known {
    folder: String,
    built: BTreeSet<String>,
    tested: BTreeSet<String>,
}

fn packages(metadata: &Value) -> BTreeMap<String, Known> {
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let root = PathBuf::from(text(&metadata["workspace_root"]));
    let all = metadata["packages"].as_array().cloned().unwrap_or_default();
    let names: BTreeSet<String> = all.iter().map(|package| text(&package["name"])).collect();
    let known = |package: &Value| {
        let manifest = PathBuf::from(text(&package["manifest_path"]));
        let folder = manifest.parent().and_then(|folder| folder.strip_prefix(&root).ok()).unwrap_or(Path::new(""));
        let mut known = Known { folder: folder.display().to_string(), ..Known::default() };
        for dependency in package["dependencies"].as_array().into_iter().flatten() {
            let name = text(&dependency["name"]);
            // A path leads to a package of the project, in this workspace or the other.
            if names.contains(&name) || dependency["path"].is_string() {
                if dependency["kind"] == "dev" {
                    known.tested.insert(name)
                } else {
                    known.built.insert(name)
                };
            }
        }
        known
    };
    all.iter().map(|package| (text(&package["name"]), known(package))).collect()
}

/// All packages that one depends on when it is built, directly or indirectly.
fn reached<'a>(from: &'a str, packages: &'a BTreeMap<String, Known>) -> BTreeSet<&'a str> {
    let mut found = BTreeSet::new();
    let mut open = vec![from];
    while let Some(known) = open.pop().and_then(|name| packages.get(name)) {
        open.extend(known.built.iter().map(String::as_str).filter(|name| found.insert(*name)));
    }
    found
}

/// Deviations from the tables, one line each.
fn violations(metadata: &Value) -> Vec<String> {
    let packages = packages(metadata);
    let mut found = Vec::new();
    for name in packages.keys().filter(|name| ROWS.iter().all(|row| row.package != **name)) {
        found.push(format!("{name} has no row in the table"));
    }
    for Row { package, folder, knows, in_tests } in &ROWS {
        let Some(known) = packages.get(*package) else {
            found.push(format!("there is no package {package}"));
            continue;
        };
        if known.folder != *folder {
            found.push(format!("{package} is in {}, not in {folder}", known.folder));
        }
        for name in known.built.iter().filter(|name| !knows.contains(&name.as_str())) {
            found.push(format!("{package} knows {name}"));
        }
        let may = |name: &&String| knows.contains(&name.as_str()) || in_tests.contains(&name.as_str());
        for name in known.tested.iter().filter(|name| !may(name)) {
            found.push(format!("{package} knows {name} in its tests"));
        }
    }
    for (from, to) in NEVER.into_iter().filter(|(from, to)| reached(from, &packages).contains(to)) {
        found.push(format!("{from} comes to know {to}"));
    }
    found
}

#[test]
fn every_package_is_in_its_room_and_knows_only_whom_it_may() {
    let found = violations(&metadata());
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

#[test]
fn the_top_level_has_these_folders_and_no_other() {
    let entries = std::fs::read_dir(top()).unwrap().map(|entry| entry.unwrap());
    let folders = entries.filter(|entry| entry.file_type().unwrap().is_dir());
    let names: BTreeSet<String> = folders.map(|folder| folder.file_name().into_string().unwrap()).collect();
    let kept = names.iter().map(String::as_str).filter(|name| !name.starts_with('.') && !MADE.contains(name));
    assert_eq!(kept.collect::<BTreeSet<_>>(), BTreeSet::from(ROOMS));
}

#[test]
fn every_row_names_a_package_once_and_nobody_may_know_xtask() {
    let names: BTreeSet<&str> = ROWS.iter().map(|row| row.package).collect();
    assert_eq!(names.len(), ROWS.len());
    let named = || ROWS.iter().flat_map(|row| row.knows.iter().chain(row.in_tests));
    assert!(named().all(|name| names.contains(name)));
    assert!(named().all(|name| *name != "xtask"));
}

#[test]
fn there_are_few_packages_and_the_page_says_of_each_why_it_is_one() {
    let page = std::fs::read_to_string(top().join("docs/develop/architecture.md")).unwrap();
    let section = page.split("\n## ").find(|section| section.starts_with("Packages\n")).unwrap();
    let told = section.lines().filter_map(|line| line.strip_prefix("| `")?.split_once("` | "));
    let told: BTreeMap<&str, &str> = told.collect();
    assert_eq!(told.keys().copied().collect::<BTreeSet<_>>(), ROWS.iter().map(|row| row.package).collect());
    assert!(told.len() <= PACKAGES_MAX, "{}", told.len());
    for (package, why) in told {
        assert!(why.trim_end_matches(" |").ends_with('.'), "{package}: {why}");
    }
}

/// Invented packages in their right folders, with these dependencies: from, to, and the kind, `dev` or a build kind.
fn made_up(arrows: &[(&str, &str, &str)]) -> Value {
    let package = |row: &Row| {
        let of_it = arrows.iter().filter(|(from, ..)| *from == row.package);
        let dependencies: Vec<Value> = of_it
            .map(
                |(_, to, kind)| json!({ "name": to, "kind": kind, "path": (*to == "bench").then_some("/house/bench") }),
            )
            .collect();
        let manifest = format!("/house/{}/Cargo.toml", row.folder);
        json!({ "name": row.package, "manifest_path": manifest, "dependencies": dependencies })
    };
    json!({ "workspace_root": "/house", "packages": ROWS.iter().map(package).collect::<Vec<_>>() })
}

#[test]
fn a_house_as_it_should_be_is_left_in_peace() {
    let right =
        [("newtau-link", "dynamics-core", ""), ("joint-io", "actuator-model", "dev"), ("xtask", "host-sim", "")];
    assert_eq!(violations(&made_up(&right)), [""; 0]);
    assert_eq!(violations(&made_up(&[("newtau-link", "serde", "")])), [""; 0], "crates of others are nobody's room");
}

#[test]
fn arrows_that_must_not_be_are_seen() {
    for (arrow, said) in [
        (("host-sim", "firmware", ""), "host-sim knows firmware"),
        (("firmware", "host-sim", "build"), "firmware knows host-sim"),
        (("dynamics-core", "newtau-link", "dev"), "dynamics-core knows newtau-link in its tests"),
        (("newtau-session", "robot-compiler", ""), "newtau-session knows robot-compiler"),
        (("newtau-link", "xtask", ""), "newtau-link knows xtask"),
        (("probe", "bench", ""), "probe knows bench"),
        (("trials", "xtask", "dev"), "trials knows xtask in its tests"),
    ] {
        let found = violations(&made_up(&[arrow]));
        assert!(found.iter().any(|line| line == said), "{arrow:?}: {found:?}");
    }
    let round = violations(&made_up(&[("host-sim", "newtau-session", ""), ("newtau-session", "firmware", "")]));
    assert!(round.contains(&"host-sim comes to know firmware".to_owned()), "{round:?}");
}

#[test]
fn a_package_that_is_new_gone_or_elsewhere_is_seen() {
    let mut house = made_up(&[]);
    house["packages"][0]["name"] = json!("attic");
    house["packages"][1]["manifest_path"] = json!("/house/elsewhere/Cargo.toml");
    let expected = [
        "attic has no row in the table",
        "there is no package dynamics-core",
        "robot-compiler is in elsewhere, not in robot-compiler",
    ];
    assert_eq!(violations(&house), expected);
}
