//! `cargo xtask bench --growth`: the growth of the simulator's computing time with joints, integration steps, runs and threads.
//!
//! Every case is timed once in each round, and its shortest time counts: load from other programs only makes a time longer.
//!
//! | module | holds |
//! |---|---|
//! | [`case`] | one timed run of the program: its files, its time, its peak memory |
//! | [`curve`] | times over sizes: exponent, tables, figures |

mod case;
mod curve;

use crate::machine::cores;
use crate::measured::write_into;
use crate::process::{cargo, root, run as run_command, target_directory};
use anyhow::{Context as _, Result};
use case::{Best, Case, Motion};
use curve::Curve;
use robot_compiler::emit::page::Page;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

const PAGE: &str = "docs/measured/growth.md";
const PICTURE: &str = "docs/figures/growth.svg";
const BLOCKS: [&str; 2] = ["growth", "growth, values"];

/// Options of `bench --growth`.
#[derive(Clone, Copy, Debug, Default, clap::Args)]
pub(crate) struct GrowthOptions {
    /// With --growth: also time a sweep of 100,000 runs
    #[arg(long, requires = "growth")]
    all: bool,
    /// With --growth: write docs/measured/growth.md and docs/figures/growth.svg
    #[arg(long, requires = "growth")]
    write: bool,
}

/// Largest number of runs, only with `--all`.
const RUNS_MAX: u32 = 100_000;

/// Sizes of one measurement.
struct Sizes {
    joints: Vec<usize>,
    /// Integration steps per control tick of 1 ms.
    steps: Vec<u32>,
    /// Integration steps per tick if the number of joints or threads varies.
    steps_fixed: u32,
    /// Run counts of two sweeps. Their difference in time is the cost of the additional runs, without start-up costs.
    pair: [u32; 2],
    /// Numbers of short runs.
    runs: Vec<u32>,
    threads: Vec<u32>,
    rounds: u32,
}

impl Sizes {
    fn full(all: bool) -> Self {
        let runs = [10, 100, 1_000, 10_000].into_iter().chain(all.then_some(RUNS_MAX)).collect();
        let threads = (0..16).map(|power| 1 << power).take_while(|threads| *threads as usize <= cores()).collect();
        let (joints, steps) = ((1..=case::JOINTS_MAX).collect(), vec![1, 2, 4, 8, 16]);
        Self { joints, steps, steps_fixed: 4, pair: [32, 160], runs, threads, rounds: 5 }
    }

    /// A run of the arm with this number of joints and of steps per tick.
    fn alone(joints: usize, steps: u32) -> Case {
        Case { joints, steps, motion: Motion::Whole, runs: None, threads: 1 }
    }

    fn of_joints(&self, joints: usize) -> Case {
        Self::alone(joints, self.steps_fixed)
    }

    fn of_steps(&self, steps: u32) -> Case {
        Self::alone(self.arm(), steps)
    }

    fn of_threads(&self, threads: u32) -> Case {
        Case { threads, ..self.of_joints(self.arm()) }
    }

    fn of_runs(&self, runs: u32) -> Case {
        Case { motion: Motion::Beginning, runs: Some(runs), ..self.of_joints(self.arm()) }
    }

    /// The two sweeps of a case.
    fn sweeps(&self, case: Case) -> [Case; 2] {
        self.pair.map(|runs| Case { runs: Some(runs), ..case })
    }

    /// Number of joints if another size varies.
    fn arm(&self) -> usize {
        self.joints.iter().copied().max().unwrap_or(case::JOINTS_MAX)
    }

    fn cases(&self) -> Vec<Case> {
        let joints = self.joints.iter().map(|joints| self.of_joints(*joints));
        let alone: Vec<Case> = joints.chain(self.steps.iter().map(|steps| self.of_steps(*steps))).collect();
        let threads = self.threads.iter().map(|threads| self.of_threads(*threads));
        let swept: Vec<Case> = alone.iter().copied().chain(threads).flat_map(|case| self.sweeps(case)).collect();
        alone.into_iter().chain(swept).chain(self.runs.iter().map(|runs| self.of_runs(*runs))).collect()
    }
}

/// Measures all, prints the tables, and with `--write` writes the page and its picture.
pub(super) fn run(options: GrowthOptions) -> Result<()> {
    if options.write {
        // A missing block is reported before the measurement.
        Page::read(root().join(PAGE), &BLOCKS)?;
    }
    run_command(&mut cargo(["build", "--quiet", "--locked", "--release", "--package", "host-sim", "--bin", "newtau"]))?;
    let program = target_directory().join("release/newtau");
    let folder = target_directory().join("growth");
    let curves = measure(&Sizes::full(options.all), &folder, &|| Ok(Command::new(&program)))?;
    let picture = if options.write { root().join(PICTURE) } else { folder.join("growth.svg") };
    std::fs::write(&picture, curve::drawing(&curves)).with_context(|| picture.display().to_string())?;
    let [growth, values] = [curve::growth(&curves).0, curve::values(&curves).0];
    if options.write {
        let shown = format!(
            "{growth}\n![Time over joints, steps, runs and threads, on logarithmic axes](../figures/growth.svg)\n"
        );
        return write_into(PAGE, &[(BLOCKS[0], shown), (BLOCKS[1], values)]);
    }
    println!("{growth}\n{values}\npicture: {}", picture.display());
    Ok(())
}

/// Times every case, in rounds, and returns the curves. `program` returns the command of `newtau`, without arguments.
fn measure(sizes: &Sizes, folder: &Path, program: &dyn Fn() -> Result<Command>) -> Result<Vec<Curve>> {
    let mut best: BTreeMap<Case, Best> = sizes.cases().into_iter().map(|case| (case, Best::default())).collect();
    for case in best.keys() {
        case.write(folder)?;
    }
    for round in 1..=sizes.rounds {
        eprintln!("growth: round {round} of {}", sizes.rounds);
        for (case, best) in &mut best {
            best.improve(&case.once(folder, program()?)?);
        }
    }
    curves(sizes, &best)
}

fn curves(sizes: &Sizes, best: &BTreeMap<Case, Best>) -> Result<Vec<Curve>> {
    let of = |case: Case| best.get(&case).with_context(|| format!("{case:?} was not measured"));
    let seconds = |case: Case| Ok(of(case)?.seconds);
    // Milliseconds per simulated second.
    let alone = |case: Case| Ok(1e3 * seconds(case)? / case.motion.seconds());
    let together = |case: Case| -> Result<f64> {
        let [few, many] = sizes.sweeps(case);
        let [from, to] = sizes.pair;
        Ok(1e3 * (seconds(many)? - seconds(few)?) / f64::from(to - from) / case.motion.seconds())
    };
    let joints = || sizes.joints.iter().map(|joints| (*joints as f64, sizes.of_joints(*joints)));
    let steps = || sizes.steps.iter().map(|steps| (f64::from(*steps), sizes.of_steps(*steps)));
    let runs = || sizes.runs.iter().map(|runs| (f64::from(*runs), sizes.of_runs(*runs)));
    let threads = sizes.threads.iter().map(|threads| (f64::from(*threads), sizes.of_threads(*threads)));
    let one_thread = together(sizes.of_threads(1))?;
    let mut all = vec![
        Curve::of(curve::JOINTS, "time of one run alone", curve::PACE, joints(), alone)?,
        Curve::of(curve::JOINTS, "time of a run side by side", curve::PACE, joints(), together)?,
        Curve::of(curve::STEPS, "time of one run alone", curve::PACE, steps(), alone)?,
        Curve::of(curve::STEPS, "time of a run side by side", curve::PACE, steps(), together)?,
        Curve::of(curve::RUNS, "time of a whole sweep", "s", runs(), seconds)?,
        Curve::of(curve::RUNS, "time of a run of a sweep", "ms", runs(), |case| {
            Ok(1e3 * seconds(case)? / f64::from(case.runs.unwrap_or(1)))
        })?,
    ];
    // Only Linux reports the peak memory of a program.
    if best.values().any(|best| best.peak.is_some()) {
        let peak = |case| Ok(of(case)?.peak.unwrap_or(f64::NAN));
        all.push(Curve::of(curve::RUNS, "peak memory of a sweep", "MB", runs(), peak)?);
    }
    all.push(Curve::of(curve::THREADS, "speed of many runs", "times", threads, |case| {
        Ok(one_thread / together(case)?)
    })?);
    Ok(all)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::{Sizes, curve, measure};
    use crate::process::target_directory;
    use std::collections::BTreeSet;

    #[test]
    fn the_whole_measurement_runs_with_tiny_sizes() {
        let sizes = Sizes {
            joints: vec![1, 2],
            steps: vec![1, 2],
            steps_fixed: 1,
            pair: [1, 2],
            runs: vec![1, 2],
            threads: vec![1, 2],
            rounds: 1,
        };
        let folder = target_directory().join("growth-test");
        let curves = measure(&sizes, &folder, &|| crate::measured::program("newtau")).unwrap();
        assert!(curves.len() >= 7, "{}", curves.len());
        assert!(curves.iter().all(|curve| curve.points.len() == 2));
        let (growth, values) = (curve::growth(&curves).0, curve::values(&curves).0);
        assert_eq!((growth.lines().count(), values.lines().count()), (2 + curves.len(), 2 + 2 * curves.len()));
        assert_eq!(curve::drawing(&curves).matches("class=\"title\"").count(), 4);
    }

    #[test]
    fn all_adds_the_longest_sweep_and_every_case_has_files_of_its_own() {
        let (some, all) = (Sizes::full(false), Sizes::full(true));
        assert_eq!(some.runs.last(), Some(&10_000));
        assert_eq!(all.runs.last(), Some(&100_000));
        assert_eq!(all.threads[0], 1);
        let cases: BTreeSet<_> = all.cases().into_iter().collect();
        let names: BTreeSet<_> = cases.iter().map(|case| case.name()).collect();
        assert_eq!(cases.len(), names.len());
    }
}
