//! A campaign as a page.

use super::Target;
use super::outcome::{Counterexample, Outcome};
use super::report::{Cell, LEGEND, Report};
use report::{Block, Figure, Page, Point, Scale, Series, Table};
use sim::run::files::shell_word;
use std::path::PathBuf;

/// A way in which a run ends: its name, and whether an outcome is of it.
type End = (&'static str, fn(&Outcome) -> bool);

const ENDS: [End; 4] = [
    ("fault", |outcome| matches!(outcome, Outcome::Fault(_))),
    ("held", |outcome| matches!(outcome, Outcome::Held(_))),
    ("went where it was asked to", |outcome| matches!(outcome, Outcome::Asked)),
    ("went on", |outcome| matches!(outcome, Outcome::Unaffected)),
];

impl Report {
    /// The page; an unsafe command comes first, with the command that repeats it from these scene files.
    #[must_use]
    pub fn page(&self, files: &[PathBuf]) -> Page {
        let files: Vec<String> = files.iter().map(|file| shell_word(file)).collect();
        let mut table = Table::new("Faults in states, and how runs ended", &self.header());
        for row in &self.rows {
            let cells = row.texts().into_iter().map(report::Cell::from);
            let mut cells: Vec<report::Cell> = cells.collect();
            // After the fault, its states, runs and ticks.
            if let Some(last) = cells.get_mut(row.cells.len() + 3) {
                last.warns = row.unsafe_commands > 0;
            }
            table.row(cells);
        }
        let mut lead = vec![format!("{}.", self.count().replace('`', ""))];
        let drives = self.target == Target::Drives.name();
        let safe = if drives { "No motion was unsafe." } else { "No command was unsafe." };
        lead.extend(self.counterexamples.is_empty().then(|| safe.to_owned()));
        lead.extend((!self.exempt.is_empty()).then(|| format!("{}.", self.exemptions())));
        let mut blocks = Vec::new();
        if !self.counterexamples.is_empty() {
            blocks.push(Block::Heading(if drives { "Unsafe motions" } else { "Unsafe commands" }.to_owned()));
        }
        let mut commands =
            Table::new("Runs that failed, and the command that repeats each", &["run", "scene", "command"]);
        for found in &self.counterexamples {
            let Counterexample { scene, seed, run, tick, case, what, inputs, .. } = found;
            let repeat =
                format!("newtau campaign {} --target {} --seed {seed} --run {run}", files.join(" "), self.target);
            let told = report::Cell::from(repeat.clone()).told(repeat.clone());
            commands.row(vec![run.to_string().into(), scene.clone().into(), told]);
            let (fault, state) = (case.fault.name(), case.situation.name());
            blocks.push(Block::Words(format!("{scene}, tick {tick} ({fault}, {state}): {what}")));
            blocks.push(Block::Terminal(format!("{repeat}\n{inputs}")));
        }
        blocks.extend((!self.counterexamples.is_empty()).then_some(Block::Table(commands)));
        blocks.extend([Block::Figure(self.figure()), Block::Table(table), Block::Words(LEGEND.to_owned())]);
        Page { title: format!("campaign on {}", self.target), lead, blocks }
    }

    /// Runs in each state by how they ended.
    fn figure(&self) -> Figure {
        let states: Vec<_> = self.states.iter().map(|situation| situation.name().to_owned()).collect();
        let count = |state: usize, ends: fn(&Outcome) -> bool| -> u64 {
            let cells = self.rows.iter().filter_map(|row| row.cells.get(state));
            cells
                .flat_map(|cell: &Cell| &cell.outcomes)
                .filter(|(outcome, _)| ends(outcome))
                .map(|(_, runs)| runs)
                .sum()
        };
        let series = |(name, ends): End| {
            let bar = |(state, label): (usize, &String)| {
                let runs = count(state, ends);
                Point::at(state as f64, runs as f64).named(format!("{label}, {name}: {runs} runs"))
            };
            Series::bars(name, states.iter().enumerate().map(bar).collect())
        };
        let all = ENDS.into_iter().map(series).collect::<Vec<_>>();
        let figure = Figure::new("Runs by state and end", "state when the fault came", "runs");
        all.into_iter().fold(figure.scaled(Scale::Names(states.clone()), Scale::Linear), Figure::with)
    }
}
