//! The workspace `bench` must be built like the product, so that its measurements apply to the product's code. Lints, profiles and versions are
//! written twice, because cargo cannot share them between workspaces.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use toml::{Table, Value};

fn read(path: &str) -> Table {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().join(path);
    toml::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// Versions of every package in a lock file. A package without a source belongs to the project.
fn locked(lock: &Table, ours: bool) -> BTreeMap<String, BTreeSet<String>> {
    let mut all = BTreeMap::<_, BTreeSet<_>>::new();
    let text = |package: &Value, key| package[key].as_str().unwrap().to_owned();
    for package in lock["package"].as_array().unwrap() {
        if package.get("source").is_none() == ours {
            all.entry(text(package, "name")).or_default().insert(text(package, "version"));
        }
    }
    all
}

/// Part of a version within which versions are compatible: `1` of 1.2.3, `0.2` of 0.2.3.
fn line(version: &str) -> &str {
    let first = version.starts_with("0.");
    version.match_indices('.').nth(usize::from(first)).map_or(version, |(at, _)| &version[..at])
}

/// A profile of the product as the other workspace must have it: only packages that exist there, and the product's packages by name. In the product
/// `"*"` means dependencies only; in the other workspace it also includes the product's packages.
fn moved(profile: &Table, level: i64, there: &BTreeSet<String>, ours: &BTreeSet<String>) -> Table {
    let mut profile = profile.clone();
    let Some(packages) = profile.get_mut("package").and_then(Value::as_table_mut) else { return profile };
    packages.retain(|name, _| name == "*" || there.contains(name));
    let others = packages.get("*").and_then(|all| all.get("opt-level")).and_then(Value::as_integer);
    if others.is_some_and(|others| others != level) {
        for name in ours {
            let own = packages.entry(name.clone()).or_insert_with(|| Value::Table(Table::new()));
            own.as_table_mut().unwrap().entry("opt-level").or_insert(Value::Integer(level));
        }
    }
    profile
}

/// The differences as text.
fn differing(product: &Table, bench: &Table, product_lock: &Table, bench_lock: &Table) -> Vec<String> {
    let mut found = Vec::new();
    let workspace = |table: &Table, key: &str| table["workspace"].get(key).cloned();
    for key in ["resolver", "package", "lints"] {
        if workspace(product, key) != workspace(bench, key) {
            found.push(format!("workspace.{key}"));
        }
    }
    let wanted = product["workspace"]["dependencies"].as_table().unwrap();
    for (name, dependency) in bench["workspace"]["dependencies"].as_table().unwrap() {
        if dependency.get("path").is_none() && wanted.get(name).is_some_and(|wanted| wanted != dependency) {
            found.push(format!("workspace.dependencies.{name}"));
        }
    }
    let (theirs, ours) = (locked(product_lock, false), locked(product_lock, true));
    for (name, versions) in locked(bench_lock, false) {
        for version in &versions {
            let mut known =
                theirs.get(&name).into_iter().flatten().filter(|known| line(known) == line(version)).peekable();
            if known.peek().is_some() && !known.any(|known| known == version) {
                found.push(format!("{name} {version} in bench/Cargo.lock, {:?} in Cargo.lock", theirs[&name]));
            }
        }
    }
    let there: BTreeSet<String> =
        [false, true].into_iter().flat_map(|ours| locked(bench_lock, ours).into_keys()).collect();
    let ours: BTreeSet<String> = ours.into_keys().filter(|name| there.contains(name)).collect();
    for (name, profile) in product["profile"].as_table().unwrap() {
        let level = profile.get("opt-level").and_then(Value::as_integer).unwrap_or(3);
        let mut wanted = moved(profile.as_table().unwrap(), level, &there, &ours);
        if ["dev", "release"].contains(&name.as_str()) {
            // What is measured is not the robot compiler's code, but for one command, which optimises it.
            let not_optimised = Value::Integer(0);
            wanted["package"]["robot-compiler"]["opt-level"] = not_optimised.clone();
            wanted["build-override"]["opt-level"] = not_optimised;
        }
        let is = bench["profile"].get(name).cloned();
        if is.as_ref().and_then(Value::as_table) != Some(&wanted) {
            found.push(format!("profile.{name}: {is:?}, expected {wanted:?}"));
        }
    }
    found
}

fn all() -> [Table; 4] {
    ["Cargo.toml", "bench/Cargo.toml", "Cargo.lock", "bench/Cargo.lock"].map(read)
}

#[test]
fn what_is_measured_is_built_as_the_product_is() {
    let [product, bench, product_lock, bench_lock] = all();
    assert!(locked(&bench_lock, true).contains_key("dynamics-core"));
    let found = differing(&product, &bench, &product_lock, &bench_lock);
    assert!(found.is_empty(), "\n{}", found.join("\n"));
}

#[test]
fn a_lint_a_profile_and_a_version_of_its_own_are_found() {
    let [product, bench, product_lock, bench_lock] = all();
    let found = |change: &dyn Fn(&mut Table)| {
        let mut bench = bench.clone();
        change(&mut bench);
        differing(&product, &bench, &product_lock, &bench_lock)
    };
    assert_eq!(found(&|bench| drop(bench["workspace"].as_table_mut().unwrap().remove("lints"))), ["workspace.lints"]);
    let slow = found(&|bench| {
        let packages = bench["profile"]["release"]["package"].as_table_mut().unwrap();
        packages.remove("dynamics-core").unwrap();
    });
    assert!(slow.len() == 1 && slow[0].starts_with("profile.release: "), "{slow:?}");
    let mut old = product_lock.clone();
    let libm =
        old["package"].as_array_mut().unwrap().iter_mut().find(|it| it["name"].as_str() == Some("libm")).unwrap();
    libm.as_table_mut().unwrap().insert("version".into(), "0.2.1".into());
    let old = differing(&product, &bench, &old, &bench_lock);
    assert!(old.len() == 1 && old[0].starts_with("libm "), "{old:?}");
}
