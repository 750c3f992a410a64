use super::{Artefact, Hash, Hashes, fresh, timeless};
use anyhow::Result;
use serde_json::json;
use sha2::{Digest as _, Sha256};
use std::path::Path;

/// Hash of the folder `a` inside `folder`.
fn of(folder: &Path) -> Result<String> {
    let mut hash = Hash(Sha256::new());
    hash.files(folder, Path::new("a"))?;
    Ok(hash.digits())
}

/// Hash of a folder with these files.
fn hash(name: &str, files: &[(&str, &str)]) -> String {
    let folder = fresh(name).unwrap();
    for (path, text) in files {
        let path = folder.join("a").join(path);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    of(&folder).unwrap()
}

#[test]
fn comments_and_layout_do_not_change_a_hash_and_anything_else_does() {
    let scene = "# A scene.\n[control]\nrate = 1000 # Hz\nlaw = \"pd\"\n";
    let here = hash("one", &[("x.toml", scene), ("b/y.rs", "fn f() {}"), ("z.py", "# why\nf()\n")]);
    assert_eq!(here.len(), 12);
    let same = [("x.toml", "[control]\nlaw = \"pd\"\nrate = 1000\n"), ("b/y.rs", "/// f\nfn f() { }"), ("z.py", "f()")];
    assert_eq!(hash("two", &[same.as_slice(), &[("page.md", "words")]].concat()), here);
    for (at, text) in [(0, "[control]\nlaw = \"pd\"\nrate = 1001\n"), (1, "fn f() { g() }"), (2, "g()")] {
        let mut other = same;
        other[at].1 = text;
        assert_ne!(hash("three", &other), here, "{text}");
    }
    let mut renamed = same;
    renamed[1].0 = "c/y.rs";
    assert_ne!(hash("four", &renamed), here);
}

#[test]
fn the_same_kernels_written_twice_have_one_hash() {
    let digits = || Hashes::default().of(Artefact::Kernels).unwrap();
    assert_eq!(digits(), digits());
    let at = |name: &str| {
        let folder = fresh(name).unwrap();
        std::fs::create_dir_all(folder.join("a")).unwrap();
        std::fs::write(folder.join("a/b.rs"), format!("#[path = \"{}/c.rs\"] mod c;", folder.display())).unwrap();
        of(&folder).unwrap()
    };
    assert_eq!(at("here"), at("there"), "the folder is no part of it");
}

#[test]
fn a_file_that_is_missing_is_an_error_with_its_path() {
    let error = of(&fresh("none").unwrap()).unwrap_err();
    assert!(format!("{error:#}").contains("-none/a"), "{error:#}");
}

#[test]
fn times_are_left_out_at_any_depth() {
    let found = timeless(json!({ "seconds": 1.5, "rows": [{ "runs": 2, "realtime_factor": 3.0 }] }));
    assert_eq!(found, json!({ "rows": [{ "runs": 2 }] }));
}
