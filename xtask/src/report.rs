//! `cargo xtask report`: bundles the scripts of the report page, takes its picture for the README, and measures its cost.

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
    /// Bundle the scripts again, with npm, into host-sim/report/assets
    #[arg(long)]
    bundle: bool,
    /// Compare the scripts there with newly bundled ones; exit code 1 if they differ
    #[arg(long)]
    check: bool,
    /// Take docs/report.png: run a scene, and open its report in a headless Chromium
    #[arg(long)]
    picture: bool,
    /// Time one minute of motion with and without its report, and write docs/measured/report.md
    #[arg(long)]
    time: bool,
}

/// Files that bundling creates; the style sheet in the same folder is written by hand.
const MADE: [&str; 4] = ["viewer.js", "points.js", "uplot.css", "LICENCES.txt"];

/// Scene of the picture, and the time and joint that it shows.
const SCENE: &str = "scenes/puma560_collision.toml";
const MOMENT: &str = "t=0.412&joint=2";
/// Width and height of the picture, pixels.
const SIZE: &str = "1280,880";
/// Largest allowed file size, bytes.
const BYTES_MAX: u64 = 200_000;

/// Runs the task.
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

/// True if the scripts are to be compared with their sources: if npm and node are installed, or if nothing may be skipped.
pub(crate) fn checks() -> bool {
    crate::setup::required() || which("npm").is_some() && which("node").is_some()
}

/// Installs the packages of `package-lock.json` and bundles into a folder. The result has the same bytes on every machine, because versions are fixed
/// and checked.
fn bundle(into: &Path) -> Result<()> {
    let web = root().join("host-sim/report/web");
    crate::setup::npm()?;
    run(Command::new("npm").current_dir(&web).args(["ci", "--no-audit", "--no-fund", "--loglevel=error"]))?;
    run(Command::new("node").current_dir(&web).arg("build.mjs").arg(into))
}

/// Compares the committed files with newly bundled ones.
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
        // The run ends with a collision fault and a non-zero exit code; its report still exists.
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
