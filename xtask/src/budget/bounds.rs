//! `firmware/budget.toml`: a range for each number of each firmware, and targets that `--bless` does not change.
//!
//! There are lower bounds too: a number that suddenly falls means that something was lost unnoticed.

use super::row::{BudgetRow, Field};
use crate::process::root;
use anyhow::{Context as _, Result, bail};
use chip_image::costs::Late;
use clap::ValueEnum as _;
use firmware_image::{BadInput, Board};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// The file, relative to the workspace.
const FILE: &str = "firmware/budget.toml";

/// Distance of the bounds from a blessed number, either way, in percent.
const SLACK: u64 = 2;

/// The same if the programs are built by another compiler than the blessed one.
const SLACK_OTHER_COMPILER: u64 = 10;

/// Targets that hold regardless of the blessed ranges.
#[derive(Clone, Debug, PartialEq, serde::Deserialize, serde::Serialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Targets {
    /// Most bytes of flash of any firmware.
    flash: u64,
    /// Most bytes of RAM of any firmware, its bounded stack included.
    ram_with_stack: u64,
    /// The same of a board that needs more, by its name.
    #[serde(default)]
    ram_with_stack_of: BTreeMap<String, u64>,
    /// Most instructions for which the tick's interrupt may be masked.
    masked: u64,
    /// The scene whose tick is limited to a share of the time.
    share_scene: String,
    /// Ticks in a second for that.
    share_rate_hz: u64,
    /// The core's clock for that.
    share_clock_hz: u64,
    /// Most estimated cycles of its tick, in percent of a period.
    share_percent: u64,
}

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

/// Fields of a row that must have been measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fields {
    /// All fields of the file.
    All,
    /// Only the measured ones.
    Measured,
}

/// An error that lists the violations, or a line that there are none.
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

    /// Makes these rows the bounds. Rows of other firmwares are removed if all were measured, and stay if only some were.
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

    /// The range of a firmware's number, if the file has it.
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

    /// Violations of the lateness: a tick may wait for the longest mask and for the bytes that arrive meanwhile, and some
    /// tick must have waited.
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

impl Targets {
    fn hold(&self, row: &BudgetRow) -> Vec<String> {
        let name = row.name();
        let mut lines = Vec::new();
        let mut below = |what: &str, found: Option<u64>, most: u64, unit: &str| {
            if let Some(found) = found.filter(|found| *found > most) {
                lines.push(format!("{name}: {what}: {found} {unit} found, expected at most {most}: a target"));
            }
        };
        below("flash", row.number(Field::Flash), self.flash, "bytes");
        let ram = row.number(Field::Ram).zip(row.number(Field::StackBound)).map(|(ram, stack)| ram + stack);
        let most = self.ram_with_stack_of.get(&row.board).copied().unwrap_or(self.ram_with_stack);
        below("ram with stack", ram, most, "bytes");
        below("masked", row.number(Field::Masked), self.masked, "instructions");
        if row.scene == self.share_scene {
            let most = self.share_clock_hz * self.share_percent / (100 * self.share_rate_hz.max(1));
            below("cycles_estimate", row.number(Field::CyclesEstimate), most, "cycles, estimated,");
        }
        lines
    }
}

fn path() -> PathBuf {
    root().join(FILE)
}

/// Percent by which a blessed range is widened for this compiler or another one.
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
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

    use super::{BadInput, Board, Budget, Fields, Late, around, verdict};
    use crate::budget::row::{BudgetRow, Field};

    const TARGETS: &str = "rustc = \"rustc 1.95.0\"\n[target]\nflash = 65536\nram_with_stack = 24576\nmasked = 100\n\
        share_scene = \"hard\"\nshare_rate_hz = 4000\nshare_clock_hz = 168000000\nshare_percent = 25\n";

    fn row(scene: &str, numbers: &[(Field, u64)]) -> BudgetRow {
        BudgetRow { scene: scene.into(), board: "netduinoplus2".into(), numbers: numbers.iter().copied().collect() }
    }

    fn blessed(rows: &[BudgetRow]) -> Budget {
        let mut budget = Budget::parse(TARGETS).unwrap();
        budget.bless(rows, "rustc 1.95.0", true);
        budget
    }

    fn held(budget: &Budget, rows: &[BudgetRow]) -> Vec<String> {
        budget.hold(rows, "rustc 1.95.0", Fields::All)
    }

    #[test]
    fn what_is_blessed_is_kept_and_reads_back() {
        let rows =
            [row("pick", &[(Field::Flash, 40_000), (Field::Instructions, 1322)]), row("easy", &[(Field::Ram, 0)])];
        let budget = blessed(&rows);
        assert_eq!(held(&budget, &rows), [""; 0]);
        assert_eq!(Budget::parse(&budget.print()).unwrap(), budget);
    }

    #[test]
    fn a_number_that_leaves_its_range_either_way_is_told_with_row_field_found_and_expected() {
        let budget = blessed(&[row("pick", &[(Field::Flash, 40_000)])]);
        for passes in [39_200, 40_000, 40_800] {
            assert_eq!(held(&budget, &[row("pick", &[(Field::Flash, passes)])]), [""; 0], "{passes}");
        }
        for fails in [39_199, 40_801, 28_000] {
            let expected = format!("pick on netduinoplus2: flash: {fails} bytes found, expected 39200 to 40800");
            assert_eq!(held(&budget, &[row("pick", &[(Field::Flash, fails)])]), [expected]);
        }
    }

    #[test]
    fn another_compiler_may_be_ten_percent_off_and_no_more() {
        let budget = blessed(&[row("pick", &[(Field::Flash, 40_000)])]);
        let held = |flash| budget.hold(&[row("pick", &[(Field::Flash, flash)])], "rustc 1.96.0", Fields::All);
        assert_eq!((held(37_000).len(), held(43_900).len()), (0, 0));
        assert_eq!((held(36_000).len(), held(44_100).len()), (1, 1));
    }

    #[test]
    fn ticks_that_were_alike_must_stay_alike() {
        assert_eq!((around(Field::Ram, 0), around(Field::Ram, 100)), ((0, 0), (98, 102)));
        let budget = blessed(&[row("pick", &[(Field::InstructionsSpread, 0), (Field::Instructions, 1_353)])]);
        let one = |field, value| held(&budget, &[row("pick", &[(Field::InstructionsSpread, 0), (field, value)])]).len();
        assert_eq!([1_352, 1_353, 1_354].map(|value| one(Field::Instructions, value)), [1, 0, 1]);
        let spread = row("pick", &[(Field::InstructionsSpread, 1), (Field::Instructions, 1_353)]);
        assert_eq!(held(&budget, &[spread]).len(), 1);
    }

    #[test]
    fn rows_and_fields_that_are_missing_or_new_are_told() {
        let budget = blessed(&[row("pick", &[(Field::Flash, 1)]), row("gone", &[(Field::Flash, 1)])]);
        let now = [row("pick", &[(Field::Ram, 5)]), row("new", &[])];
        assert_eq!(
            held(&budget, &now),
            [
                "pick on netduinoplus2: flash: nothing found, expected 0 to 2",
                "pick on netduinoplus2: ram: 5 found, expected a range in the file",
                "new on netduinoplus2: found a firmware, expected a [[row]] of it",
                "gone on netduinoplus2: found no such firmware, expected one",
            ]
        );
        let some = budget.hold(&[row("pick", &[])], "rustc 1.95.0", Fields::Measured);
        assert_eq!(some, [""; 0], "the cheap part does not measure everything");
    }

    #[test]
    fn the_fewest_instructions_leave_room_for_another_compiler_and_for_unlike_ticks() {
        let fewest = |numbers: &[(Field, u64)]| {
            blessed(&[row("pick", numbers)]).fewest_instructions("pick", Board::Netduinoplus2)
        };
        // Less 10 %.
        assert_eq!(fewest(&[(Field::Instructions, 1_000), (Field::InstructionsSpread, 0)]), Some(900));
        assert_eq!(fewest(&[(Field::Instructions, 1_000), (Field::InstructionsSpread, 500)]), Some(400));
        assert_eq!(fewest(&[(Field::Instructions, 1_000)]), None);
        let budget = blessed(&[row("pick", &[(Field::Instructions, 1_000)])]);
        assert_eq!(budget.range("pick", Board::Netduinoplus2, Field::Instructions), Some((1_000, 1_000)));
        assert_eq!(budget.range("pick", Board::F405Can, Field::Instructions), None);
    }

    #[test]
    fn a_board_may_have_a_target_of_its_own_which_is_kept() {
        let own = format!("{TARGETS}[target.ram_with_stack_of]\nnetduinoplus2 = 100\n");
        let mut budget = Budget::parse(&own).unwrap();
        let mut row = row("pick", &[(Field::Ram, 60), (Field::StackBound, 41)]);
        budget.bless(std::slice::from_ref(&row), "rustc 1.95.0", true);
        assert_eq!(Budget::parse(&budget.print()).unwrap(), budget);
        let expected = "pick on netduinoplus2: ram with stack: 101 bytes found, expected at most 100: a target";
        assert_eq!(held(&budget, std::slice::from_ref(&row)), [expected]);
        // Other boards keep to the one of all.
        row.board = "odrive-v3".into();
        budget.bless(std::slice::from_ref(&row), "rustc 1.95.0", true);
        assert_eq!(held(&budget, &[row]), [""; 0]);
    }

    #[test]
    fn no_blessing_moves_a_target() {
        let rows = [row(
            "hard",
            &[
                (Field::Flash, 65_537),
                (Field::Ram, 20_000),
                (Field::StackBound, 4_577),
                (Field::Masked, 101),
                (Field::CyclesEstimate, 10_501),
            ],
        )];
        let told = held(&blessed(&rows), &rows);
        assert_eq!(told.len(), 4, "{told:?}");
        assert_eq!(
            told[3],
            "hard on netduinoplus2: cycles_estimate: 10501 cycles, estimated, found, expected at most 10500: a target"
        );
        let within = [row("hard", &[(Field::Flash, 65_536), (Field::Masked, 100), (Field::CyclesEstimate, 10_500)])];
        assert_eq!(held(&blessed(&within), &within), [""; 0]);
    }

    #[test]
    fn a_tick_that_is_later_than_the_mask_is_told_and_so_is_a_flood_that_met_none() {
        let budget = Budget::parse(TARGETS).unwrap();
        let late = |most| Late { ticks: 1, delayed: 1, most, bytes_to_chip: 1, bytes_from_chip: 1 };
        assert_eq!((budget.hold_late(&late(100)).len(), budget.hold_late(&late(1)).len()), (0, 0));
        assert_eq!((budget.hold_late(&late(101)).len(), budget.hold_late(&late(0)).len()), (1, 1));
    }

    #[test]
    fn a_file_that_cannot_be_is_refused_with_row_and_field() {
        let row = |line: &str| format!("{TARGETS}[[row]]\nscene = \"a\"\nboard = \"b\"\n{line}\n");
        let why = |text: &str| format!("{:#}", Budget::parse(text).unwrap_err());
        assert!(why(&row("flsh = [1, 2]")).starts_with("firmware/budget.toml: a on b: field \"flsh\" is not known"));
        let expected = "firmware/budget.toml: a on b: flash: found [2, 1]; expected the lesser number first";
        assert_eq!(why(&row("flash = [2, 1]")), expected);
        assert!(why(&row("flash = 5")).contains("firmware/budget.toml"));
        assert!(why(&TARGETS.replace("masked", "maskd")).contains("maskd"));
    }

    #[test]
    fn the_verdict_is_an_error_of_its_own_kind_when_anything_is_broken() {
        assert!(verdict(1, &[]).is_ok());
        let why = verdict(1, &["a: b".into()]).unwrap_err();
        assert!(why.downcast_ref::<BadInput>().is_some() && why.to_string().contains("a: b"));
    }
}
