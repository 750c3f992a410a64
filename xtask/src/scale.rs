//! `cargo xtask scale`: a study on the engines that `newtau sweep --submit` writes for, killed on the way, compared byte for byte with
//! one process; a merge of many shards; and the plan for very many runs that the figures give.
//!
//! | module | holds |
//! |---|---|
//! | `work` | the study that every engine does |
//! | `engines` | HyperQueue and Slurm on this machine |
//! | `slurm` | a Slurm of one node: its daemons, their configuration |
//! | `measure` | time, memory and processor time of a process |
//! | `report` | `docs/measured/scale.md` |

mod engines;
mod measure;
mod report;
mod slurm;
mod work;

use crate::process::{cargo, root, run, target_directory};
use anyhow::Result;
use measure::{Cost, measured};
use report::Figures;
use robot_compiler::emit::page::Page;
use std::path::Path;
use std::process::Command;
use work::Work;

/// Options of the task.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// Runs of the study on every engine
    #[arg(long, default_value_t = 100_000)]
    runs: u64,
    /// Shards of it
    #[arg(long, default_value_t = 50)]
    shards: u64,
    /// Write the tables of docs/measured/scale.md
    #[arg(long)]
    write: bool,
}

/// Where the tables go.
const PLACE: &str = "scale";

/// The page with the figures.
const DOCUMENT: &str = "docs/measured/scale.md";

/// Shards of the merge whose memory is measured, and runs of each.
const MANY: (u64, u64) = (1_000, 100);

/// Runs of the pick from which a run's processor time is taken.
const PICKS: u64 = 1_000;

/// Installs the engines, runs, compares, and reports.
pub(crate) fn run_all(options: &Options) -> Result<()> {
    let mut page = Page::read(root().join(DOCUMENT), &[PLACE])?;
    let python = engines::install()?;
    slurm::install()?;
    run(&mut cargo(["build", "--release", "--locked", "--package", "host-sim"]))?;
    let program = target_directory().join("release/newtau");
    let folder = target_directory().join("scale");
    if folder.exists() {
        std::fs::remove_dir_all(&folder)?;
    }
    std::fs::create_dir_all(&folder)?;
    let work = Work { program, folder, python, runs: options.runs, shards: options.shards };
    let whole = work.folder.join("whole");
    eprintln!("scale: {} runs in one process", work.runs);
    let one = measured(&work.python, work.sweep().arg("--out").arg(&whole))?;
    eprintln!("scale: {} shards on HyperQueue", work.shards);
    let hyperqueue = engines::hyperqueue(&work)?;
    work.same("hyperqueue")?;
    eprintln!("scale: {} shards on Slurm", work.shards);
    let slurm = slurm::run(&work)?;
    work.same("slurm")?;
    let merge = many_shards(&work)?;
    let pick = pick(&work)?;
    let bytes = |folder: &Path| anyhow::Ok(std::fs::metadata(folder.join("runs.csv"))?.len());
    let figures = Figures {
        runs: work.runs,
        shards: work.shards,
        bytes: bytes(&whole)?,
        one,
        hyperqueue,
        slurm,
        merge,
        many: MANY,
        merged_bytes: bytes(&work.folder.join("many/whole"))?,
        pick,
        pick_bytes: bytes(&work.folder.join("pick"))?,
        picks: PICKS,
    };
    print!("{}", figures.markdown());
    if options.write {
        crate::measured::fill(&mut page, DOCUMENT, &[(PLACE, figures.markdown())])?;
        page.write()?;
    }
    Ok(())
}

/// The merge of very many shards.
fn many_shards(work: &Work) -> Result<Cost> {
    let (shards, runs) = MANY;
    eprintln!("scale: a merge of {shards} shards");
    let all = work.folder.join("many");
    let mut merge = Command::new(&work.program);
    merge.args(["sweep", "merge", "--quiet", "--out"]).arg(all.join("whole"));
    for number in 1..=shards {
        let folder = all.join(format!("shards/{number}"));
        let mut sweep = Command::new(&work.program);
        sweep.arg("sweep").arg(root().join("bench/scale/study.toml"));
        sweep.args(["--quiet", "--jobs", "1", "--runs", &(shards * runs).to_string()]);
        run(sweep.args(["--shard", &format!("{number}/{shards}"), "--out"]).arg(&folder))?;
    }
    merge.arg(all.join("shards"));
    measured(&work.python, &mut merge)
}

/// The pick in one thread.
fn pick(work: &Work) -> Result<Cost> {
    eprintln!("scale: {PICKS} picks");
    let mut sweep = Command::new(&work.program);
    sweep.arg("sweep").arg(root().join("scenes/studies/pick_payload_friction.toml"));
    sweep.args(["--quiet", "--jobs", "1", "--runs", &PICKS.to_string(), "--out"]).arg(work.folder.join("pick"));
    measured(&work.python, &mut sweep)
}
