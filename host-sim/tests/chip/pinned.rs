//! Instruction counts of a scene's tick, from `firmware/budget.toml`. They are pinned only there.

use std::ops::RangeInclusive;
use std::path::Path;
use std::process::Command;
use toml_edit::{DocumentMut, Item};

/// Fewest and most instructions of a scene's tick on the emulated board, exactly. If the firmware is built by another compiler than that of the file,
/// within 10 %.
pub(crate) fn instructions(scene: &str) -> [RangeInclusive<u64>; 2] {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../firmware/budget.toml");
    let file: DocumentMut = std::fs::read_to_string(path).unwrap().parse().unwrap();
    let is = |row: &toml_edit::Table, key: &str, value: &str| row.get(key).and_then(Item::as_str) == Some(value);
    let mut rows = file["row"].as_array_of_tables().unwrap().iter();
    let row = rows.find(|row| is(row, "scene", scene) && is(row, "board", "netduinoplus2"));
    let row = row.unwrap_or_else(|| panic!("firmware/budget.toml has no row of {scene}"));
    let number = |key: &str| {
        let range: Vec<i64> = row[key].as_array().unwrap().iter().map(|value| value.as_integer().unwrap()).collect();
        assert!(range.len() == 2 && range[0] == range[1], "{scene}: {key} repeats and is pinned at {range:?}");
        u64::try_from(range[0]).unwrap()
    };
    let (most, spread) = (number("instructions"), number("instructions_spread"));
    let slack = if is_of_this_compiler(file["rustc"].as_str().unwrap()) { 0 } else { most.div_ceil(10) };
    [most - spread, most].map(|count| count - slack.min(count)..=count + slack)
}

fn is_of_this_compiler(blessed: &str) -> bool {
    let debian = std::env::var("NEWTAU_TOOLCHAIN").is_ok_and(|choice| choice == "debian");
    let program = if debian { "/usr/bin/rustc" } else { "rustc" };
    let output = Command::new(program).arg("--version").output();
    output.is_ok_and(|output| String::from_utf8_lossy(&output.stdout).starts_with(&format!("{blessed} ")))
}

/// Asserts the pinned counts.
pub(crate) fn assert_pinned(scene: &str, found: [u64; 2]) {
    for (found, pinned) in found.iter().zip(instructions(scene)) {
        assert!(pinned.contains(found), "{scene}: {found} instructions in a tick, pinned at {pinned:?}");
    }
}
