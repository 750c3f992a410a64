//! `cargo xtask report`: the scripts of the report page from their sources, its picture in the README, and what it costs.

mod time;

use crate::process::{cargo_run, root, run, target_directory, which};
use anyhow::{Context as _, Result, bail};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Tasks for the report page.
#[derive(clap::Args)]
#[group(required = true, multiple = true)]
pub(crate) struct ReportOptions {
    /// Bundle the scripts anew, with npm, into host-sim/report/assets
    #[arg(long)]
    bundle: bool,
    /// Compare the scripts there with newly bundled ones; code 1 if they differ
    #[arg(long)]
    check: bool,
    /// Take docs/report.png: a run, in a headless Chromium
    #[arg(long)]
    picture: bool,
    /// Time a minute of motion with and without its report, and write docs/measured/report.md
    #[arg(long)]
    time: bool,
}

/// Files that bundling makes; the style sheet beside them is written by hand.
const MADE: [&str; 4] = ["viewer.js", "points.js", "uplot.css", "LICENCES.txt"];

/// Scene of the picture, and the moment and the joint that it shows.
const SCENE: &str = "scenes/puma560_collision.toml";
const MOMENT: &str = "t=0.412&joint=2";
/// Size of the picture, pixels.
const SIZE: &str = "1280,880";
/// Largest file, bytes.
const BYTES_MAX: u64 = 200_000;

/// Run the task.
pub(crate) fn run_task(options: &ReportOptions) -> Result<()> {
    if options.bundle {
        bundle(&assets())?;
    }
    if options.check {
        check()?;
    }
    if options.picture {
        picture()?;
    }
    if options.time {
        time::run()?;
    }
    Ok(())
}

fn assets() -> PathBuf {
    root().join("host-sim/report/assets")
}

/// True if the scripts are compared with their sources: if npm is there, or if nothing may be skipped.
pub(crate) fn checks() -> bool {
    crate::setup::required() || which("npm").is_some() && which("node").is_some()
}

/// Installs the packages of `package-lock.json` and bundles into a folder. The same bytes everywhere: versions are fixed and checked.
fn bundle(into: &Path) -> Result<()> {
    let web = root().join("host-sim/report/web");
    crate::setup::npm()?;
    run(Command::new("npm").current_dir(&web).args(["ci", "--no-audit", "--no-fund", "--loglevel=error"]))?;
    run(Command::new("node").current_dir(&web).arg("build.mjs").arg(into))
}

/// Compares what is committed with what its sources give.
pub(crate) fn check() -> Result<()> {
    let fresh = target_directory().join("report");
    fs::create_dir_all(&fresh).with_context(|| fresh.display().to_string())?;
    bundle(&fresh)?;
    for name in MADE {
        let read = |folder: &Path| fs::read(folder.join(name)).with_context(|| folder.join(name).display().to_string());
        if read(&assets())? != read(&fresh)? {
            bail!("host-sim/report/assets/{name} is not what its sources give: cargo xtask report --bundle");
        }
    }
    println!("report: the scripts are what their sources give");
    Ok(())
}

/// Runs a scene and takes a picture of its report.
fn picture() -> Result<()> {
    crate::setup::chromium()?;
    let folder = target_directory().join("report");
    run(cargo_run("host-sim").args(["run", SCENE, "--quiet", "--force", "--out"]).arg(&folder)).or_else(|error| {
        // A collision is a fault: the run's exit code says so, and its report is there.
        if folder.join("report.html").is_file() { Ok(()) } else { Err(error) }
    })?;
    let path = root().join("docs/report.png");
    let profile = folder.join("profile");
    run(Command::new("chromium")
        .args([
            "--headless=new",
            "--no-sandbox",
            "--use-gl=angle",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
        ])
        .args(["--disable-background-networking", "--disable-component-update", "--disable-sync", "--no-first-run"])
        .args(["--hide-scrollbars", "--virtual-time-budget=8000", "--log-level=3"])
        .arg(format!("--window-size={SIZE}"))
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg(format!("--screenshot={}", path.display()))
        .arg(format!("file://{}#{MOMENT}", folder.join("report.html").display())))?;
    let size = fs::metadata(&path).with_context(|| path.display().to_string())?.len();
    if size > BYTES_MAX {
        bail!("{} has {size} bytes; expected at most {BYTES_MAX}", path.display());
    }
    println!("report: {} has {size} bytes", path.display());
    Ok(())
}
