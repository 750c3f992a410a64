//! `cargo xtask cores`: the same program on a dozen cores in emulators; every result equal to the desk's, every instruction count in its range.
//!
//! The program is the workspace `xtask/cores`. Targets and emulators that are missing are installed.

mod record;
mod row;
mod table;

use crate::process::{output, root, run as run_command, which};
use crate::toolchain::Toolchain;
use crate::{measured, qemu, setup};
use anyhow::{Context as _, Result, ensure};
use firmware_image::install;
use record::{compare, in_c, page, record};
use row::{Row, rows};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use table::{CORES, Core, Emulator};

const EXAMPLES: &str = "\
Examples:
  cargo xtask cores                     every core: results against the desk's, instructions against xtask/cores/instructions.toml
  cargo xtask cores --quick             three cores of different kinds
  cargo xtask cores --core cortex-m7 --json
  cargo xtask cores --write             record the counts, and write docs/measured/cores.md";

/// Options of `cores`.
#[derive(Clone, Debug, clap::Args)]
#[command(after_long_help = EXAMPLES)]
pub(crate) struct CoresOptions {
    /// Only these cores
    #[arg(long = "core", value_name = "NAME")]
    cores: Vec<String>,
    /// Only cores that compile quickly, one of each kind
    #[arg(long, conflicts_with = "cores")]
    quick: bool,
    /// Print the rows as JSON
    #[arg(long)]
    json: bool,
    /// Record the instruction counts, and write the page
    #[arg(long, conflicts_with_all = ["cores", "quick"])]
    write: bool,
}

/// Builds, runs and compares. Fails if a result differs from the desk's or a count is outside its range.
pub(crate) fn run(options: &CoresOptions) -> Result<()> {
    for name in &options.cores {
        if !CORES.iter().any(|core| core.name == name) {
            let known: Vec<_> = CORES.iter().map(|core| core.name).collect();
            return Err(firmware_image::BadInput(format!("--core {name}: expected one of {}", known.join(", "))).into());
        }
    }
    let asked = |core: &&Core| match (options.quick, options.cores.as_slice()) {
        (true, _) => core.quick,
        (false, []) => true,
        (false, names) => names.iter().any(|name| name == core.name),
    };
    let desk = hashes(&desk()?);
    let mut rows = Vec::new();
    for core in CORES.iter().filter(asked) {
        eprintln!("cores: {}", core.name);
        let found = on(core, &[], !options.quick).with_context(|| core.name)?;
        ensure!(!found.is_empty(), "{}: the program printed no row", core.name);
        rows.extend(found.into_iter().map(|row| {
            let equal = desk.get(&row.key()) == Some(&row.hash);
            Row { equal, ..row }
        }));
    }
    if options.json {
        println!("{}", serde_json::to_string_pretty(&serde_json::json!({ "rows": rows }))?);
    } else {
        print!("{}", page(&rows));
    }
    let wrong: Vec<_> =
        rows.iter().filter(|row| !row.equal).map(|row| format!("{} {} {}", row.core, row.scalar, row.what)).collect();
    ensure!(wrong.is_empty(), "results differ from the desk's: {}", wrong.join("; "));
    flushed_differs(&desk)?;
    if options.write {
        record(&rows)?;
        return measured::write_into("docs/measured/cores.md", &[("cores", page(&rows)), ("C", in_c(&rows))]);
    }
    compare(&rows)
}

/// The part that every test run does: three cores of different kinds.
pub(crate) fn quick() -> Result<()> {
    if !has_targets()? {
        return Ok(());
    }
    run(&CoresOptions { cores: Vec::new(), quick: true, json: false, write: false })
}

/// The comparison must see a core that flushes subnormal numbers to zero.
fn flushed_differs(desk: &BTreeMap<(String, String), String>) -> Result<()> {
    let core = CORES.iter().find(|core| core.name == "cortex-m4f").context("the table has a Cortex-M4F")?;
    let rows = on(core, &["flush-to-zero"], false)?;
    let differs = rows.iter().any(|row| desk.get(&row.key()) != Some(&row.hash));
    ensure!(differs, "with FPSCR.FZ set every result is equal: the states have no subnormal number");
    Ok(())
}

fn folder() -> PathBuf {
    root().join("xtask/cores")
}

/// Cargo for the program.
fn cargo(subcommand: &str) -> Command {
    let mut command = firmware_image::process::cargo([subcommand]);
    command.current_dir(folder()).args(["--release", "--locked", "--quiet"]);
    for name in ["RUSTFLAGS", "CARGO_ENCODED_RUSTFLAGS"] {
        command.env_remove(name);
    }
    command
}

/// The rows on this computer.
fn desk() -> Result<Vec<Row>> {
    let said = cargo("run").output()?;
    ensure!(said.status.success(), "{}", String::from_utf8_lossy(&said.stderr));
    rows("desk", &String::from_utf8_lossy(&said.stdout))
}

/// The rows on a core.
fn on(core: &Core, features: &[&str], in_c: bool) -> Result<Vec<Row>> {
    target(core.target)?;
    let mut build = cargo("build");
    build.args(["--target", core.target]).env(flags_of(core.target), core.flags);
    let product = crate::process::target_directory().join(core.target).join("release");
    let said = match &core.emulator {
        Emulator::Node => {
            build = cargo("rustc");
            build.args(["--target", core.target, "--lib", "--crate-type", "cdylib"]);
            run_command(build.env(flags_of(core.target), core.flags))?;
            setup::npm()?;
            let said = output(Command::new("node").arg(folder().join("run.mjs")).arg(product.join("cores.wasm")));
            said.context("node cannot run the module")?
        }
        Emulator::Qemu { program, package, arguments, memory } => {
            let mut features = [&["bare"], features, core.features].concat();
            // In C as well, except when a test run has little time.
            if let (Some((compiler, package)), true) = (core.c, in_c) {
                if compiler.split(' ').next().is_some_and(|program| which(program).is_none()) {
                    install::apt(&[package])?;
                }
                features.push("c");
                build.env("NEWTAU_CC", compiler);
            }
            let features = features.join(",");
            run_command(build.args(["--bin", "cores", "--features", &features]).env("NEWTAU_MEMORY", memory))?;
            if which(program).is_none() {
                install::apt(&[package])?;
            }
            // A program that waits for ever uses no processor time.
            let mut emulator = Command::new("timeout");
            qemu::semihosted_by(emulator.args(["120", program]).args(arguments.split(' ')), &product.join("cores"))?
        }
    };
    rows(core.name, &said)
}

/// `CARGO_TARGET_THUMBV6M_NONE_EABI_RUSTFLAGS`: flags for the core alone, not for the build script.
fn flags_of(target: &str) -> String {
    format!("CARGO_TARGET_{}_RUSTFLAGS", target.to_uppercase().replace(['-', '.'], "_"))
}

/// False, with a message, on a machine where rustup cannot fetch targets: Debian's tool chain, which builds the firmware there, has that one alone.
pub(crate) fn has_targets() -> Result<bool> {
    let found = Toolchain::find_or_install()?;
    let rustup = matches!(found, Toolchain::Rustup);
    if !rustup {
        eprintln!("skipped: other targets come from rustup; here is {found}");
    }
    Ok(rustup)
}

/// Installs the compiler's target.
pub(crate) fn target(name: &str) -> Result<()> {
    let installed = output(Command::new("rustc").args(["--print", "sysroot"]))
        .is_some_and(|sysroot| Path::new(&sysroot).join("lib/rustlib").join(name).join("lib").is_dir());
    if !installed {
        eprintln!("setup: rustup target add {name}");
        run_command(Command::new("rustup").args(["target", "add", name]))?;
    }
    Ok(())
}

fn hashes(rows: &[Row]) -> BTreeMap<(String, String), String> {
    rows.iter().map(|row| (row.key(), row.hash.clone())).collect()
}
