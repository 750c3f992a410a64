//! `firmware/budget.toml`: a range for each number of each firmware, and targets that `--bless` does not change.
//!
//! The ranges have lower bounds, too: a number that suddenly falls means that something is no longer measured or built.

use super::row::{BudgetRow, Field};
use super::targets::Targets;
use crate::process::root;
use anyhow::{Context as _, Result, bail};
use chip_image::costs::Late;
use clap::ValueEnum as _;
use firmware_image::{BadInput, Board};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// Path of the file, relative to the workspace.
const FILE: &str = "firmware/budget.toml";

/// Distance of the bounds from a blessed number in both directions, percent.
const SLACK: u64 = 2;

/// The same distance if another compiler built the programs.
const SLACK_OTHER_COMPILER: u64 = 10;

/// One firmware's ranges.
#[derive(Clone, Debug, PartialEq, serde::Deserialize)]
struct Bounds {
    scene: String,
    board: String,
    #[serde(flatten)]
    ranges: BTreeMap<String, (u64, u64)>,
}

/// The file.
#[derive(Clone, Debug, PartialEq, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Budget {
    /// The compiler of the ranges.
    rustc: String,
    target: Targets,
    #[serde(default)]
    row: Vec<Bounds>,
}

/// Selection of the fields that must have been measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fields {
    /// All fields in the file.
    All,
    /// Only the fields that were measured.
    Measured,
}

/// An error that lists the violations, or a message that there are none.
pub(crate) fn verdict(rows: usize, broken: &[String]) -> Result<()> {
    if broken.is_empty() {
        eprintln!("budget: {rows} firmwares are within {FILE}");
        return Ok(());
    }
    let list = broken.join("\n  ");
    Err(BadInput(format!("{FILE} is not kept:\n  {list}\nif that is meant, `cargo xtask budget --bless`, and say why"))
        .into())
}

impl Budget {
    pub(crate) fn load() -> Result<Self> {
        let path = path();
        let text = std::fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
        Self::parse(&text)
    }

    fn parse(text: &str) -> Result<Self> {
        let budget: Self = toml::from_str(text).with_context(|| FILE.to_owned())?;
        for row in &budget.row {
            let name = format!("{FILE}: {} on {}", row.scene, row.board);
            for (field, (low, high)) in &row.ranges {
                if Field::of(field).is_none() {
                    let known: Vec<_> = Field::value_variants().iter().map(|field| field.name()).collect();
                    bail!("{name}: field {field:?} is not known; expected one of {}", known.join(", "));
                }
                if low > high {
                    bail!("{name}: {field}: found [{low}, {high}]; expected the lesser number first");
                }
            }
        }
        Ok(budget)
    }

    /// True if the ranges belong to this compiler.
    pub(crate) fn is_of(&self, rustc: &str) -> bool {
        rustc == self.rustc
    }

    /// Makes these rows the bounds. If `all` were measured, removes the rows of other firmwares; otherwise keeps them.
    pub(crate) fn bless(&mut self, rows: &[BudgetRow], rustc: &str, all: bool) {
        rustc.clone_into(&mut self.rustc);
        let measured = |bounds: &Bounds| rows.iter().any(|row| row.scene == bounds.scene && row.board == bounds.board);
        self.row.retain(|bounds| !all && !measured(bounds));
        let new = rows
            .iter()
            .map(|row| Bounds {
                scene: row.scene.clone(),
                board: row.board.clone(),
                ranges: row.numbers.iter().map(|(of, value)| (of.name(), around(*of, *value))).collect(),
            })
            .collect::<Vec<_>>();
        self.row.extend(new);
    }

    pub(crate) fn save(&self) -> Result<()> {
        let path = path();
        std::fs::write(&path, self.print()).with_context(|| format!("cannot write {}", path.display()))
    }

    fn print(&self) -> String {
        let Targets {
            flash,
            ram_with_stack,
            ram_with_stack_of,
            masked,
            share_scene,
            share_rate_hz,
            share_clock_hz,
            share_percent,
        } = &self.target;
        let mut text = format!(
            "# What every firmware may take, from both sides. `cargo xtask budget` measures and holds; `cargo xtask budget --bless`\n\
             # writes the rows, {SLACK} % around what is measured, the controller's instructions exactly, and leaves the targets alone.\n\
             # Another compiler than this one may be {SLACK_OTHER_COMPILER} % off. What each field is: docs/performance.md. Cycles are estimated, never measured.\n\
             rustc = {:?}\n\n\
             [target]\nflash = {flash}\nram_with_stack = {ram_with_stack}\nmasked = {masked}\nshare_scene = {share_scene:?}\n\
             share_rate_hz = {share_rate_hz}\nshare_clock_hz = {share_clock_hz}\nshare_percent = {share_percent}\n",
            self.rustc
        );
        // Writing to a String cannot fail.
        if !ram_with_stack_of.is_empty() {
            text += "\n[target.ram_with_stack_of]\n";
        }
        for (board, most) in ram_with_stack_of {
            let _ = writeln!(text, "{board} = {most}");
        }
        for Bounds { scene, board, ranges } in &self.row {
            let _ = writeln!(text, "\n[[row]]\nscene = {scene:?}\nboard = {board:?}");
            for field in Field::value_variants() {
                if let Some((low, high)) = ranges.get(&field.name()) {
                    let _ = writeln!(text, "{} = [{low}, {high}]", field.name());
                }
            }
        }
        text
    }

    /// Violations of a range or a target, one line each.
    pub(crate) fn hold(&self, rows: &[BudgetRow], rustc: &str, fields: Fields) -> Vec<String> {
        let mut lines = Vec::new();
        for row in rows {
            let name = row.name();
            match self.row.iter().find(|bounds| bounds.scene == row.scene && bounds.board == row.board) {
                Some(bounds) => lines.extend(bounds.hold(row, self.is_of(rustc), fields)),
                None => lines.push(format!("{name}: found a firmware, expected a [[row]] of it")),
            }
            lines.extend(self.target.hold(row));
        }
        if fields == Fields::All && rows.len() > 1 {
            let measured =
                |bounds: &&Bounds| rows.iter().any(|row| (&row.scene, &row.board) == (&bounds.scene, &bounds.board));
            let gone = self.row.iter().filter(|bounds| !measured(bounds));
            lines.extend(
                gone.map(|gone| format!("{} on {}: found no such firmware, expected one", gone.scene, gone.board)),
            );
        }
        lines
    }

    /// Range of a firmware's number; `None` if the file has none.
    pub(crate) fn range(&self, scene: &str, board: Board, field: Field) -> Option<(u64, u64)> {
        let row = self.row.iter().find(|bounds| bounds.scene == scene && bounds.board == board.name())?;
        row.ranges.get(&field.name()).copied()
    }

    /// Fewest instructions that a tick of the controller may take, with any compiler.
    pub(crate) fn fewest_instructions(&self, scene: &str, board: Board) -> Option<u64> {
        let (low, high) = self.range(scene, board, Field::Instructions)?;
        let (_, spread) = self.range(scene, board, Field::InstructionsSpread)?;
        Some(widened(low..=high, slack(Field::Instructions, false)).start().saturating_sub(spread))
    }

    /// Violations of the lateness limit. A tick may wait for the longest mask and for bytes that arrive in that time. At least one tick must have
    /// waited.
    pub(crate) fn hold_late(&self, late: &Late) -> Vec<String> {
        let most = self.target.masked;
        let kept = (1..=most).contains(&late.most);
        (!kept)
            .then(|| format!("flood: tick start: {} instructions late found, expected 1 to {most}", late.most))
            .into_iter()
            .collect()
    }
}

impl Bounds {
    fn hold(&self, row: &BudgetRow, same_compiler: bool, fields: Fields) -> Vec<String> {
        let name = row.name();
        let mut lines = Vec::new();
        for (field, (low, high)) in &self.ranges {
            let Some(field) = Field::of(field) else { continue };
            let expected = widened(*low..=*high, slack(field, same_compiler));
            match row.number(field) {
                Some(found) if expected.contains(&found) => {}
                Some(found) => lines.push(format!(
                    "{name}: {}: {found} {} found, expected {} to {}",
                    field.name(),
                    field.unit(),
                    expected.start(),
                    expected.end()
                )),
                None if fields == Fields::All => {
                    lines.push(format!("{name}: {}: nothing found, expected {low} to {high}", field.name()));
                }
                None => {}
            }
        }
        for (field, found) in &row.numbers {
            if !self.ranges.contains_key(&field.name()) {
                lines.push(format!("{name}: {}: {found} found, expected a range in the file", field.name()));
            }
        }
        lines
    }
}

fn path() -> PathBuf {
    root().join(FILE)
}

/// Percent by which a blessed range is widened for this compiler or for another one.
const fn slack(field: Field, same_compiler: bool) -> u64 {
    match (same_compiler, field.repeats()) {
        (true, _) => 0,
        (false, true) => SLACK_OTHER_COMPILER,
        (false, false) => SLACK_OTHER_COMPILER - SLACK,
    }
}

/// The blessed range of a measured number.
fn around(field: Field, value: u64) -> (u64, u64) {
    if field.repeats() {
        return (value, value);
    }
    let slack = (value * SLACK).div_ceil(100);
    (value - slack.min(value), value + slack)
}

fn widened(range: RangeInclusive<u64>, percent: u64) -> RangeInclusive<u64> {
    let by = |value: u64| (value * percent).div_ceil(100);
    range.start() - by(*range.start()).min(*range.start())..=range.end() + by(*range.end())
}

#[cfg(test)]
mod tests;
