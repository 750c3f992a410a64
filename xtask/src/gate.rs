//! Check that the control tick contains no f64 arithmetic, which this chip computes in software, and no panics.
//!
//! The tick alone is linked from a static library, and the linker removes unused sections. Everything that remains is reachable.

use crate::process::run;
use crate::toolchain::{self, Toolchain};
use anyhow::{Context as _, Result, bail};
use chip_image::Program;
use firmware_image::emitted;
use robot_compiler::emit::Choices;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Symbol at which the linker starts.
const ENTRY: &str = "newtau_gate_tick";

/// The tick inside the safety state machine, linked in addition.
const SAFETY: &str = "newtau_gate_safety";

/// Parts of forbidden names, and their meanings.
const FORBIDDEN: [(&str, &str); 12] = [
    ("__aeabi_d", "f64 arithmetic in software"),
    ("__aeabi_f2d", "f32 to f64 in software"),
    ("__aeabi_i2d", "integer to f64 in software"),
    ("__aeabi_ui2d", "integer to f64 in software"),
    ("__aeabi_l2d", "integer to f64 in software"),
    ("__aeabi_ul2d", "integer to f64 in software"),
    ("__aeabi_cd", "f64 comparison in software"),
    ("panicking", "a panic"),
    ("panic_bounds_check", "a panic on an index"),
    ("unwrap_failed", "a panic on unwrap or expect"),
    ("slice_index_fail", "a panic on a slice"),
    ("rust_begin_unwind", "the panic handler"),
];

/// Checks that the tick contains nothing forbidden, and that the check detects a tick that does.
pub(crate) fn check(scene: &Path) -> Result<()> {
    let scene = scene.canonicalize().with_context(|| format!("no scene file {}", scene.display()))?;
    let found = offences(&scene, None)?;
    if !found.is_empty() {
        bail!("reachable from the tick of {}:\n  {}", scene.display(), found.join("\n  "));
    }
    for (feature, what) in [("bad-panic", "panic"), ("bad-double", "f64")] {
        if !offences(&scene, Some(feature))?.iter().any(|line| line.contains(what)) {
            bail!("the gate is blind: it does not see the {what} in the tick built with `{feature}`");
        }
    }
    println!("gate: no soft double and no panic is reachable from the tick; it sees both in the ticks that have them");
    Ok(())
}

/// Forbidden symbols in the linked tick, each with its meaning.
fn offences(scene: &Path, feature: Option<&str>) -> Result<Vec<String>> {
    let linked = link(scene, feature)?;
    let bytes = std::fs::read(&linked)?;
    let program = Program::parse(&bytes)?;
    let names: Vec<&str> = program.symbols().map(|(name, _)| name).collect();
    if let Some(missing) = [ENTRY, SAFETY].into_iter().find(|entry| !names.contains(entry)) {
        bail!("{} has no {missing}: the gate would look at nothing", linked.display());
    }
    let mut found = Vec::new();
    for name in &names {
        if let Some((_, what)) = FORBIDDEN.iter().find(|(part, _)| name.contains(part)) {
            found.push(format!("{name}: {what}"));
        }
    }
    Ok(found)
}

fn link(scene: &Path, feature: Option<&str>) -> Result<PathBuf> {
    let toolchain = Toolchain::find_or_install()?;
    let mut cargo = toolchain.cargo("rustc");
    cargo.args(["--quiet", "--package", "arm", "--crate-type", "staticlib", "--features", feature.unwrap_or("gate")]);
    cargo.env("NEWTAU_ARM", emitted::arm(scene, Choices::default())?);
    let library = toolchain::build(&mut cargo, toolchain::product("libarm.a"))?;
    let linked = toolchain::product(&format!("tick-gate-{}.elf", feature.unwrap_or("tick")));
    let linker = toolchain.linker().context("no linker for the chip: `cargo xtask setup`")?;
    let mut command = Command::new(&linker);
    if linker.ends_with("rust-lld") {
        command.args(["-flavor", "gnu"]);
    }
    run(command.args(["--gc-sections", "--entry", ENTRY, "--undefined", SAFETY, "-o"]).arg(&linked).arg(library))?;
    Ok(linked)
}
