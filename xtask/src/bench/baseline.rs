//! Comparison of instruction counts with a baseline. An increase is a regression; a decrease means that the baseline is outdated.

use anyhow::{Context as _, Result, bail};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::PathBuf;

/// Counts by name.
pub(crate) type BaselineCounts = BTreeMap<String, u64>;

/// Largest difference of a count from the baseline in both directions, percent.
const TOLERANCE_PERCENT: u64 = 3;

/// The baselines, one for each machine and compiler: `desk, rustc 1.95.0`.
type Baselines = BTreeMap<String, BaselineCounts>;

fn path() -> PathBuf {
    crate::process::root().join("bench/baseline.toml")
}

/// Compares counts with the baseline of this name. With `bless`, makes them the baseline.
///
/// If this compiler has no baseline, a message says so, and that is no failure. Counts differ between compilers, so a new compiler needs a new
/// baseline.
pub(crate) fn hold(name: &str, counts: &BaselineCounts, bless: bool) -> Result<()> {
    let path = path();
    let text = std::fs::read_to_string(&path).unwrap_or_default();
    let mut baselines: Baselines = toml::from_str(&text).with_context(|| path.display().to_string())?;
    if bless {
        baselines.insert(name.to_owned(), counts.clone());
        std::fs::write(&path, print(&baselines))?;
        println!("baseline: {} counts of {name} written to {}", counts.len(), path.display());
        return Ok(());
    }
    let Some(baseline) = baselines.get(name) else {
        let known: Vec<&str> = baselines.keys().map(String::as_str).collect();
        println!("baseline: none for {name} (there is: {}); `cargo xtask bench --bless` writes it", known.join("; "));
        return Ok(());
    };
    let differences = differences(baseline, counts);
    if !differences.is_empty() {
        bail!(
            "instruction counts of {name} left the baseline by more than {TOLERANCE_PERCENT} %:\n  {}\nif that is meant, \
             `cargo xtask bench --bless`, and say why",
            differences.join("\n  ")
        );
    }
    println!("baseline: {} counts of {name} are within {TOLERANCE_PERCENT} %", counts.len());
    Ok(())
}

/// Missing, new and deviating counts, one line each.
fn differences(baseline: &BaselineCounts, counts: &BaselineCounts) -> Vec<String> {
    let mut lines = Vec::new();
    for (name, &was) in baseline {
        match counts.get(name) {
            None => lines.push(format!("{name}: {was} in the baseline, not counted now")),
            Some(&is) if is.abs_diff(was) * 100 > was * TOLERANCE_PERCENT => {
                let percent = 100.0 * (is as f64 / was as f64 - 1.0);
                lines.push(format!("{name}: {was} in the baseline, {is} now ({percent:+.1} %)"));
            }
            Some(_) => {}
        }
    }
    let new = counts.iter().filter(|(name, _)| !baseline.contains_key(*name));
    lines.extend(new.map(|(name, is)| format!("{name}: {is} now, not in the baseline")));
    lines
}

fn print(baselines: &Baselines) -> String {
    let mut text = String::from(
        "# Instructions that `cargo xtask bench` holds the code to, within 3 % either way; `cargo xtask bench --bless` writes\n\
         # them. Desk: 64 states under callgrind. Chip: one state, the most of 200, in QEMU.\n",
    );
    for (name, counts) in baselines {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "\n[{name:?}]");
        for (name, count) in counts {
            let _ = writeln!(text, "{name} = {count}");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{BaselineCounts, Baselines, differences, print};

    fn counts(all: &[(&str, u64)]) -> BaselineCounts {
        all.iter().map(|(name, count)| ((*name).to_owned(), *count)).collect()
    }

    #[test]
    fn three_percent_pass_and_what_is_more_fails_either_way() {
        let baseline = counts(&[("a", 1000)]);
        for passes in [1000, 1030, 970] {
            assert_eq!(differences(&baseline, &counts(&[("a", passes)])), [""; 0], "{passes}");
        }
        for fails in [1031, 969] {
            assert_eq!(differences(&baseline, &counts(&[("a", fails)])).len(), 1, "{fails}");
        }
        assert_eq!(differences(&baseline, &counts(&[("a", 1031)])), ["a: 1000 in the baseline, 1031 now (+3.1 %)"],);
    }

    #[test]
    fn what_is_missing_or_new_fails() {
        assert_eq!(
            differences(&counts(&[("gone", 5)]), &counts(&[("new", 7)])),
            ["gone: 5 in the baseline, not counted now", "new: 7 now, not in the baseline"]
        );
    }

    #[test]
    fn what_is_written_reads_back() {
        let one = counts(&[("ur5_exact", 440), ("trig", 275)]);
        let baselines: Baselines = [("chip, rustc 1.95.0".to_owned(), one)].into();
        assert_eq!(toml::from_str::<Baselines>(&print(&baselines)).ok(), Some(baselines));
    }
}
