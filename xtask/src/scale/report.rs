//! `docs/measured/scale.md`: what was measured, and the plan that follows from it.

use super::measure::Cost;
use std::fmt::Write as _;

/// Everything that was measured.
pub(super) struct Figures {
    pub(super) runs: u64,
    pub(super) shards: u64,
    /// Of the table of all runs.
    pub(super) bytes: u64,
    pub(super) one: Cost,
    /// Seconds.
    pub(super) hyperqueue: f64,
    /// Seconds.
    pub(super) slurm: f64,
    pub(super) merge: Cost,
    /// Shards of the merge, and runs of each.
    pub(super) many: (u64, u64),
    /// Of the merged table.
    pub(super) merged_bytes: u64,
    pub(super) pick: Cost,
    /// Of the table of picks.
    pub(super) pick_bytes: u64,
    pub(super) picks: u64,
}

/// Runs of the plan.
const PLAN: f64 = 1e9;
/// Length of a shard of the plan, s: long beside an engine's share, short beside what a lost one costs.
const SHARD: f64 = 1800.0;
/// Target for a million picks, core minutes.
const TARGET: f64 = 70.0;

impl Figures {
    pub(super) fn markdown(&self) -> String {
        let Self { runs, shards, one, hyperqueue, slurm, merge, pick, .. } = self;
        let (many, each) = self.many;
        let mut text = String::from("| what | measured |\n|---|---|\n");
        let mut row = |what: String, value: String| {
            let _ = writeln!(text, "| {what} | {value} |");
        };
        row(
            format!("{runs} runs of two rods, one process"),
            format!("{:.1} s; {:.0} MiB at most", one.seconds, one.memory),
        );
        row(
            format!("the same on HyperQueue: {shards} shards, the cluster killed on the way"),
            format!("{hyperqueue:.1} s; same bytes"),
        );
        row(
            format!("the same on Slurm: {shards} shards, the node killed on the way"),
            format!("{slurm:.1} s; same bytes"),
        );
        row(
            format!("merge of {many} shards of {each} runs, with its results"),
            format!("{:.1} s; {:.0} MiB at most", merge.seconds, merge.memory),
        );
        row("a row of the table of two rods".to_owned(), format!("{:.0} bytes", self.bytes as f64 / *runs as f64));
        row(
            format!("a pick of 2.1 s at 1 kHz, in {} runs", self.picks),
            format!("{:.2} ms of a core", 1e3 * self.each()),
        );
        row("a row of the table of picks".to_owned(), format!("{:.0} bytes", self.row()));
        let million = 1e6 * self.each() / 60.0;
        row(
            format!("a million picks (target: {TARGET} core minutes)"),
            format!("{million:.0} core minutes; {} MiB at most", pick.memory.round()),
        );
        text + &self.plan()
    }

    /// Bytes of a pick's row.
    fn row(&self) -> f64 {
        self.pick_bytes as f64 / self.picks as f64
    }

    /// Processor time of a pick, s.
    fn each(&self) -> f64 {
        self.pick.processor / self.picks as f64
    }

    /// The plan on paper for a thousand million picks.
    fn plan(&self) -> String {
        let seconds = PLAN * self.each();
        let shards = (seconds / SHARD).ceil();
        // A merge reads and writes bytes, whatever they say.
        let merge = PLAN * self.row() * self.merge.seconds / self.merged_bytes as f64;
        let mut text =
            "\nA plan for 1e9 picks, from these figures (nobody has run it):\n\n| what | planned |\n|---|---|\n"
                .to_owned();
        let mut row = |what: &str, value: String| {
            let _ = writeln!(text, "| {what} | {value} |");
        };
        row("core hours", format!("{:.0}", seconds / 3600.0));
        row("on 1,000 cores", format!("{:.1} h", seconds / 3600.0 / 1000.0));
        row(
            "shards of half an hour, one core each",
            format!("{shards:.0}, each {:.0} runs and {:.0} MB", PLAN / shards, PLAN / shards * self.row() / 1e6),
        );
        row("the table", format!("{:.0} GB", PLAN * self.row() / 1e9));
        row("its merge, in one thread, one shard in memory", format!("{:.1} h", merge / 3600.0));
        row("a kill costs", "one block, about half a second".to_owned());
        row("what breaks first", "the merge, which is one thread and two passes over the table; then Slurm's MaxArraySize (1,001 unless raised)".to_owned());
        text
    }
}
