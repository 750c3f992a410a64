//! Rows as tables of the page, and the recorded instruction counts.

use super::row::{IN_C, Row};
use super::table::{CORES, Emulator};
use crate::process::root;
use crate::table::{Table, thousands};
use anyhow::{Context as _, Result, ensure};
use std::collections::BTreeMap;

/// Allowed difference of an instruction count from the recorded one, in per cent, either way.
const TOLERANCE: f64 = 1.0;

/// Instruction counts of every row, recorded.
const RECORD: &str = "xtask/cores/instructions.toml";

/// The table of the page: a line for each core and precision.
pub(super) fn page(rows: &[Row]) -> String {
    let whats = ["inverse dynamics, exact", "inverse dynamics, regrouped", "six sines and cosines", "control tick"];
    let mut table =
        Table::new(&["core", "emulator", "scalar", "equal", "exact", "regrouped", "sines and cosines", "control tick"]);
    for core in CORES {
        for scalar in ["f32", "f64"] {
            let of: Vec<&Row> = rows.iter().filter(|row| row.core == core.name && row.scalar == scalar).collect();
            if of.is_empty() {
                continue;
            }
            let equal = of.iter().filter(|row| row.equal).count();
            let emulator = match &core.emulator {
                Emulator::Node => "Node.js",
                Emulator::Qemu { arguments, .. } => arguments.split(' ').nth(1).unwrap_or_default(),
            };
            let mut cells =
                vec![core.title.to_owned(), emulator.to_owned(), scalar.to_owned(), format!("{equal} of {}", of.len())];
            cells.extend(whats.iter().map(|what| {
                of.iter()
                    .find(|row| row.what == *what)
                    .and_then(|row| row.instructions)
                    .map_or("-".to_owned(), thousands)
            }));
            table.row(&cells);
        }
    }
    table.0
}

/// The table of the kernels in C against those in Rust.
pub(super) fn in_c(rows: &[Row]) -> String {
    let mut table = Table::new(&["core", "scalar", "kernel", "equal", "Rust", "C, gcc -O2", "ratio"]);
    for row in rows.iter().filter(|row| row.what.ends_with(IN_C)) {
        let of = rows.iter().find(|other| other.core == row.core && other.key() == row.key() && other.what != row.what);
        let (Some(c), Some(rust)) = (row.instructions, of.and_then(|row| row.instructions)) else { continue };
        let title = CORES.iter().find(|core| core.name == row.core).map_or(row.core, |core| core.title);
        let equal = if row.equal { "yes" } else { "no" };
        let ratio = format!("{:.2}", c as f64 / rust as f64);
        table.put(&[&title, &row.scalar, &row.key().1, &equal, &thousands(rust), &thousands(c), &ratio]);
    }
    table.0
}

/// The recorded counts: a table for each core.
type Record = BTreeMap<String, BTreeMap<String, u64>>;

pub(super) fn record(rows: &[Row]) -> Result<()> {
    let mut all = Record::new();
    for row in rows {
        if let Some(count) = row.instructions {
            all.entry(row.core.to_owned()).or_default().insert(format!("{} {}", row.scalar, row.what), count);
        }
    }
    let mut text = "# Instructions of one evaluation; written by `cargo xtask cores --write`.\n".to_owned();
    for (core, counts) in &all {
        text += &format!("\n[{core}]\n");
        counts.iter().for_each(|(name, count)| text += &format!("\"{name}\" = {count}\n"));
    }
    std::fs::write(root().join(RECORD), text)?;
    Ok(())
}

/// Fails if a count is not recorded, or differs by more than the tolerance.
pub(super) fn compare(rows: &[Row]) -> Result<()> {
    let path = root().join(RECORD);
    let recorded: Record =
        toml::from_str(&std::fs::read_to_string(&path).with_context(|| format!("{}", path.display()))?)?;
    let outside: Vec<String> = rows.iter().filter_map(|row| outside(row, &recorded)).collect();
    ensure!(
        outside.is_empty(),
        "instructions outside of {RECORD}; if that is meant, `cargo xtask cores --write`:\n{}",
        outside.join("\n")
    );
    Ok(())
}

fn outside(row: &Row, recorded: &Record) -> Option<String> {
    let found = row.instructions?;
    let name = format!("{} {}", row.scalar, row.what);
    match recorded.get(row.core).and_then(|counts| counts.get(&name)) {
        None => Some(format!("{} {name}: {found}, not recorded", row.core)),
        Some(&expected) => {
            let allowed = (expected as f64 * TOLERANCE / 100.0).max(1.0);
            (found.abs_diff(expected) as f64 > allowed)
                .then(|| format!("{} {name}: {found}, expected {expected} to within {TOLERANCE} %", row.core))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::row::rows;
    use super::{Record, Row, outside};

    fn row(count: u64) -> Row {
        rows("cortex-m4f", &format!("noise\nrow|f32|control tick|00ff|{count}\n")).unwrap().remove(0)
    }

    #[test]
    fn a_count_is_held_from_both_sides() {
        let recorded: Record = toml::from_str("[cortex-m4f]\n\"f32 control tick\" = 1000\n").unwrap();
        for (count, inside) in [(989, false), (990, true), (1000, true), (1010, true), (1011, false)] {
            assert_eq!(outside(&row(count), &recorded).is_none(), inside, "{count}");
        }
        assert!(outside(&row(1000), &Record::new()).unwrap().contains("not recorded"));
        // WebAssembly counts nothing.
        assert_eq!(outside(&row(0), &recorded), None);
        assert!(rows("desk", "row|f32|x").is_err());
    }
}
