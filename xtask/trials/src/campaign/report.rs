//! Report of a campaign: a table of faults and states.

use super::case::Situation;
use super::fault::FaultKind;
use super::outcome::{Counterexample, Exemption, Finished, Outcome};
use super::target::Target;
use dynamics_core::control::Fault;
use dynamics_core::safety::HoldCause;
use report::{Block, Page, Table, Tone};
use serde::Serialize;
use sim::table::table;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::time::Duration;

/// Results of the runs with one fault in one state.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Cell {
    /// Number of runs.
    pub runs: u64,
    /// Number of runs for each outcome, the most frequent first.
    pub outcomes: Vec<(Outcome, u64)>,
}

/// Results of the runs with one fault.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The fault.
    pub fault: FaultKind,
    /// One cell per state, in the order of [`Situation::NAMES`].
    pub cells: Vec<Cell>,
    /// Number of runs.
    pub runs: u64,
    /// Number of judged ticks.
    pub ticks: u64,
    /// Number of runs that ended with an unsafe command, or an unsafe motion.
    pub unsafe_commands: u64,
    /// With drives: the number of exempt runs, in which something happened that no program can prevent; and the largest distance of a joint from its
    /// position while torque must hold it, rad or m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<(u64, f64)>,
}

/// Results of a campaign.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The scenes.
    pub scenes: Vec<String>,
    /// `desk`, `drives` or `qemu`.
    pub target: &'static str,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Number of runs.
    pub runs: u64,
    /// Number of judged ticks.
    pub ticks: u64,
    /// Wall-clock time, s.
    pub seconds: f64,
    /// Exemptions, which no program can prevent: description, and number of runs in which each occurred.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub exempt: Vec<(&'static str, u64)>,
    /// The states, in the order of the cells of each row.
    #[serde(skip)]
    pub(super) states: Vec<Situation>,
    /// One row per fault.
    pub rows: Vec<Row>,
    /// Every unsafe command, and every tick in which chip and desk differ.
    pub counterexamples: Vec<Counterexample>,
}

impl Report {
    /// Summarises finished runs.
    pub(super) fn new(
        scenes: Vec<String>,
        (target, seed): (Target, u64),
        finished: Vec<Finished>,
        time: Duration,
    ) -> Self {
        let states: Vec<_> = Situation::names(target).map(|(situation, _)| situation).collect();
        let rows = FaultKind::names(target).map(|(fault, _)| Row::of(fault, target, &finished));
        let exempt = |exemption: Exemption| {
            finished.iter().filter(|run| run.motion.exempt & exemption as u8 != 0).count() as u64
        };
        let exempt = Exemption::NAMES.map(|(exemption, words)| (words, exempt(exemption)));
        Self {
            scenes,
            target: target.name(),
            exempt: exempt.into_iter().filter(|(_, runs)| *runs > 0).collect(),
            states,
            seed,
            runs: finished.len() as u64,
            ticks: finished.iter().map(|run| u64::from(run.ticks)).sum(),
            seconds: time.as_secs_f64(),
            rows: rows.filter(|row| row.runs > 0).collect(),
            counterexamples: finished.into_iter().filter_map(|run| run.counterexample).collect(),
        }
    }

    /// Counts as a sentence.
    #[must_use]
    pub fn count(&self) -> String {
        let Self { runs, ticks, seconds, seed, .. } = self;
        let found = self.counterexamples.len();
        let what = if self.target == Target::Drives.name() { "motions" } else { "commands" };
        let parity = if self.target == "qemu" { ", each compared with the desk's to the last bit" } else { "" };
        format!(
            "{runs} runs on `{}` (seed {seed}; {}): {ticks} ticks judged{parity}; {found} unsafe {what}; {seconds:.0} s",
            self.target,
            self.scenes.join(", "),
        )
    }

    /// Text for the terminal.
    #[must_use]
    pub fn table(&self) -> String {
        let mut table = table(self.header(), usize::MAX);
        for row in &self.rows {
            table.add_row(row.texts());
        }
        let mut text = format!("{table}\n{}\n{LEGEND}\n", self.count());
        if !self.exempt.is_empty() {
            let _ = writeln!(text, "{}", self.exemptions());
        }
        for found in &self.counterexamples {
            let Counterexample { scene, seed, run, tick, case, what, inputs, .. } = found;
            let (fault, state) = (case.fault.name(), case.situation.name());
            let _ = writeln!(
                text,
                "\nunsafe: {scene}, --seed {seed} --run {run}, tick {tick} ({fault}, {state}): {what}\n{inputs}"
            );
        }
        text
    }

    /// Markdown for the documentation.
    #[must_use]
    pub fn markdown(&self) -> String {
        let header = self.header();
        let mut text = format!("{}.\n\n| {} |\n|{}\n", self.count(), header.join(" | "), "---|".repeat(header.len()));
        for row in &self.rows {
            let _ = writeln!(text, "| {} |", row.texts().join(" | "));
        }
        if !self.exempt.is_empty() {
            let _ = writeln!(text, "\n{}.", self.exemptions());
        }
        text
    }

    /// Page for a browser: the same table with words and colours.
    #[must_use]
    pub fn page(&self) -> Page {
        let header = self.header();
        let mut table = Table::new("Outcomes by fault and state, number of runs", &header);
        for row in &self.rows {
            let numbers = row.texts().into_iter().skip(1 + row.cells.len());
            let cells = row.cells.iter().map(|cell| report::Cell::coloured(cell.parts()));
            let numbers = header.iter().skip(1 + row.cells.len()).zip(numbers).map(|(name, number)| {
                let unsafe_runs = *name == "unsafe" && row.unsafe_commands > 0;
                report::Cell::from(number).warning(unsafe_runs)
            });
            table.row(core::iter::once(row.fault.name().into()).chain(cells).chain(numbers).collect());
        }
        let holds: Vec<_> = HoldCause::ALL.iter().map(|cause| format!("{} {}", cause.code(), cause.text())).collect();
        let faults: Vec<_> = Fault::ALL.iter().map(|fault| format!("{} {}", fault.code(), fault.text())).collect();
        let mut blocks = vec![
            Block::Facts(vec![
                ("goes on".into(), "the fault has no effect on the state".into()),
                ("obeys".into(), "the machine goes to the state that was requested".into()),
                (
                    "hold".into(),
                    format!("the arm stops and holds, with this cause: {}", holds.join("; ").replace('`', "")),
                ),
                (
                    "fault".into(),
                    format!("the safe action, for this fault, the first one of a run: {}", faults.join("; ")),
                ),
                ("unsafe".into(), "runs with a command or a motion that the judge calls unsafe".into()),
            ]),
            Block::Table(table),
        ];
        let found = |found: &Counterexample| {
            let Counterexample { scene, seed, run, tick, case, what, .. } = found;
            format!(
                "{scene}, --seed {seed} --run {run}, tick {tick} ({}, {}): {what}",
                case.fault.name(),
                case.situation.name()
            )
        };
        if !self.counterexamples.is_empty() {
            blocks.push(Block::Heading("Unsafe".into()));
            blocks.push(Block::List(self.counterexamples.iter().map(found).collect()));
        }
        let exempt = (!self.exempt.is_empty()).then(|| format!("{}.", self.exemptions()));
        let lead = core::iter::once(format!("{}.", self.count().replace('`', ""))).chain(exempt).collect();
        Page { title: format!("fault injection: {}", self.target), lead, blocks }
    }

    pub(super) fn header(&self) -> Vec<&'static str> {
        let states = self.states.iter().map(|situation| situation.name());
        let numbers = ["runs", "ticks", "unsafe", "exempt", "farthest, mrad"];
        let count = if self.target == Target::Drives.name() { 5 } else { 3 };
        core::iter::once("fault").chain(states).chain(numbers.into_iter().take(count)).collect()
    }

    /// Exemptions, and the number of runs in which each occurred.
    pub(super) fn exemptions(&self) -> String {
        let one = |(words, runs): &(&str, u64)| format!("{words}: {runs} runs");
        format!(
            "Exempt, because no program can prevent it. {}",
            self.exempt.iter().map(one).collect::<Vec<_>>().join("; ")
        )
    }
}

/// Legend of the table's cells.
pub(super) const LEGEND: &str = "F9 50: fault 9 in 50 runs; H2: held, cause 2; asked: went where it was asked to; -: went on (docs/operate/faults.md and docs/safety/state-machine.md have the numbers)";

impl Row {
    fn of(fault: FaultKind, target: Target, finished: &[Finished]) -> Self {
        let runs = || finished.iter().filter(|run| run.case.fault == fault);
        let cell = |situation| Cell::of(runs().filter(|run| run.case.situation == situation));
        Self {
            fault,
            cells: Situation::names(target).map(|(situation, _)| cell(situation)).collect(),
            runs: runs().count() as u64,
            ticks: runs().map(|run| u64::from(run.ticks)).sum(),
            unsafe_commands: runs().filter(|run| run.counterexample.is_some()).count() as u64,
            motion: (target == Target::Drives).then(|| {
                let exempt = runs().filter(|run| run.motion.exempt != 0).count() as u64;
                (exempt, runs().map(|run| run.motion.worst).fold(0.0, f64::max))
            }),
        }
    }

    pub(super) fn texts(&self) -> Vec<String> {
        let cells = self.cells.iter().map(Cell::text);
        let numbers = [self.runs, self.ticks, self.unsafe_commands].map(|number| number.to_string());
        let motion = self.motion.map(|(exempt, worst)| [exempt.to_string(), format!("{:.1}", 1e3 * worst)]);
        let name = core::iter::once(self.fault.name().to_owned());
        name.chain(cells).chain(numbers).chain(motion.into_iter().flatten()).collect()
    }
}

impl Cell {
    fn of<'a>(runs: impl Iterator<Item = &'a Finished>) -> Self {
        let mut counts = BTreeMap::new();
        for run in runs {
            *counts.entry(run.outcome).or_insert(0) += 1;
        }
        let mut outcomes: Vec<(Outcome, u64)> = counts.into_iter().collect();
        // The sort is stable: equally frequent outcomes keep their order.
        outcomes.sort_by_key(|(_, count)| core::cmp::Reverse(*count));
        Self { runs: outcomes.iter().map(|(_, count)| count).sum(), outcomes }
    }

    /// Each outcome in words, with its colour.
    fn parts(&self) -> Vec<(Tone, String)> {
        let one = |(outcome, count): &(Outcome, u64)| {
            let (tone, words) = match outcome {
                Outcome::Fault(code) => (Tone::Stop, format!("fault {code}")),
                Outcome::Held(cause) => (Tone::Caution, format!("hold {cause}")),
                Outcome::Asked => (Tone::Good, "obeys".to_owned()),
                Outcome::Unaffected => (Tone::Quiet, "goes on".to_owned()),
            };
            (tone, format!("{words}: {count}"))
        };
        self.outcomes.iter().map(one).collect()
    }

    fn text(&self) -> String {
        let one = |(outcome, count): &(Outcome, u64)| match outcome {
            Outcome::Fault(code) => format!("F{code} {count}"),
            Outcome::Held(cause) => format!("H{cause} {count}"),
            Outcome::Asked => format!("asked {count}"),
            Outcome::Unaffected => format!("- {count}"),
        };
        self.outcomes.iter().map(one).collect::<Vec<_>>().join(", ")
    }
}
