//! Comparison of compiler settings for the same firmware.

use super::image::Image;
use super::measure::supervised_trace;
use super::row::EMULATED;
use crate::table::{Table, thousands};
use anyhow::{Context as _, Result};
use firmware_image::Build;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Cargo's environment variables that change the build of the chip's programs.
const OPT_LEVEL: &str = "CARGO_PROFILE_FIRMWARE_OPT_LEVEL";
const RUSTFLAGS: &str = "CARGO_TARGET_THUMBV7EM_NONE_EABIHF_RUSTFLAGS";

/// A build with its changed settings.
struct Tuning {
    name: &'static str,
    environment: &'static [(&'static str, &'static str)],
}

const TUNINGS: [Tuning; 4] = [
    Tuning { name: "as shipped: for the Cortex-M4, opt-level 3", environment: &[] },
    // An empty variable would count as unset.
    Tuning { name: "for any Armv7E-M with a float unit", environment: &[(RUSTFLAGS, "-Ctarget-cpu=generic")] },
    Tuning { name: "opt-level 2", environment: &[(OPT_LEVEL, "2")] },
    Tuning { name: "opt-level s", environment: &[(OPT_LEVEL, "s")] },
];

/// The table of a scene's builds.
pub(super) fn table(scene: &Path) -> Result<String> {
    let mut table = Table::new(&[
        "build",
        "flash",
        "RAM",
        "instructions of the controller",
        "instructions of the tick's interrupt",
        "its cycles, estimated (low to high)",
    ]);
    for tuning in TUNINGS {
        eprintln!("tuning: {}", tuning.name);
        let elf = build(scene, &tuning)?;
        let image = Image::measure(&elf)?;
        let said = supervised_trace(scene, &elf)?;
        let number = |at: &str| said.pointer(at).and_then(Value::as_u64).with_context(|| format!("no {at}"));
        let cycles = |what: &str| number(&format!("/traced/running/cycles/{what}"));
        let (low, likely, high) = (cycles("low")?, cycles("likely")?, cycles("high")?);
        let [flash, ram] = [image.flash, image.ram].map(thousands);
        let controller = thousands(number("/ticks/max")?);
        let interrupt = thousands(number("/traced/running/instructions")?);
        let range = format!("{} ({} to {})", thousands(likely), thousands(low), thousands(high));
        table.row(&[tuning.name.into(), flash, ram, controller, interrupt, range]);
    }
    Ok(table.0)
}

/// Builds with the tuning's changes of the environment.
fn build(scene: &Path, tuning: &Tuning) -> Result<PathBuf> {
    let build = Build { environment: tuning.environment, ..Build::of(scene, EMULATED) };
    build.run().with_context(|| tuning.name.to_owned())
}
