//! `cargo xtask cores`: the same program on a dozen cores in emulators; every result equal to the desk's, every instruction count in its range.
//!
//! The program is the workspace `xtask/cores`. Targets and emulators that are missing are installed.

mod table;

use crate::process::{output, root, run as run_command, which};
use crate::table::{Table, thousands};
use crate::toolchain::Toolchain;
use crate::{measured, setup};
use anyhow::{Context as _, Result, bail, ensure};
use firmware_image::install;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use table::{CORES, Core, Emulator};

/// Allowed difference of an instruction count from the recorded one, in per cent, either way.
const TOLERANCE: f64 = 1.0;

/// Instruction counts of every row, recorded.
const RECORD: &str = "xtask/cores/instructions.toml";

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

/// One computation on one core.
#[derive(Clone, Debug, Serialize)]
struct Row {
    core: &'static str,
    scalar: String,
    what: String,
    equal: bool,
    /// Instructions of one evaluation; absent for WebAssembly, which has none.
    instructions: Option<u64>,
    #[serde(skip)]
    hash: String,
}

impl Row {
    /// Scalar and computation; that in C is the same as that in Rust.
    fn key(&self) -> (String, String) {
        (self.scalar.clone(), self.what.trim_end_matches(IN_C).to_owned())
    }
}

/// The end of the name of a computation in C.
const IN_C: &str = ", in C";

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
            emulated(program, arguments, &product.join("cores"))?
        }
    };
    rows(core.name, &said)
}

/// `CARGO_TARGET_THUMBV6M_NONE_EABI_RUSTFLAGS`: flags for the core alone, not for the build script.
fn flags_of(target: &str) -> String {
    format!("CARGO_TARGET_{}_RUSTFLAGS", target.to_uppercase().replace(['-', '.'], "_"))
}

fn emulated(program: &str, arguments: &str, elf: &Path) -> Result<String> {
    let mut command = Command::new("timeout");
    command.arg("120").arg(program).args(arguments.split(' '));
    command.args(["-icount", "shift=0", "-display", "none", "-monitor", "none", "-serial", "null"]);
    command.args(["-semihosting-config", "enable=on,target=native", "-kernel"]).arg(elf);
    let said =
        command.stdin(std::process::Stdio::null()).output().with_context(|| format!("cannot start {program}"))?;
    let text = String::from_utf8_lossy(&said.stdout).into_owned() + &String::from_utf8_lossy(&said.stderr);
    ensure!(said.status.success(), "{program} {arguments}: {}\n{text}", said.status);
    Ok(text)
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

/// The lines `row|SCALAR|WHAT|HASH|INSTRUCTIONS` of a program's output.
fn rows(core: &'static str, said: &str) -> Result<Vec<Row>> {
    let rows = said.lines().filter_map(|line| line.trim().strip_prefix("row|"));
    rows.map(|line| {
        let [scalar, what, hash, count] = line.split('|').collect::<Vec<_>>()[..] else { bail!("{core}: row {line}") };
        let instructions = Some(count.parse::<u64>()?).filter(|count| *count > 0);
        Ok(Row {
            core,
            scalar: scalar.to_owned(),
            what: what.to_owned(),
            equal: true,
            instructions,
            hash: hash.to_owned(),
        })
    })
    .collect()
}

fn hashes(rows: &[Row]) -> BTreeMap<(String, String), String> {
    rows.iter().map(|row| (row.key(), row.hash.clone())).collect()
}

/// The table of the page: a line for each core and precision.
fn page(rows: &[Row]) -> String {
    let whats = ["inverse dynamics, exact", "inverse dynamics, regrouped", "six sines and cosines", "control tick"];
    let mut table =
        Table::new(&["core", "emulator", "scalar", "equal", "exact", "regrouped", "sines and cosines", "control tick"]);
    for core in CORES {
        for scalar in ["f32", "f64"] {
            let of: Vec<&Row> = rows.iter().filter(|row| row.core == core.name && row.scalar == scalar).collect();
            if of.is_empty() {
                continue;
            }
            let equal = of.iter().filter(|row| row.equal).count();
            let emulator = match &core.emulator {
                Emulator::Node => "Node.js",
                Emulator::Qemu { arguments, .. } => arguments.split(' ').nth(1).unwrap_or_default(),
            };
            let mut cells =
                vec![core.title.to_owned(), emulator.to_owned(), scalar.to_owned(), format!("{equal} of {}", of.len())];
            cells.extend(whats.iter().map(|what| {
                of.iter()
                    .find(|row| row.what == *what)
                    .and_then(|row| row.instructions)
                    .map_or("-".to_owned(), thousands)
            }));
            table.row(&cells);
        }
    }
    table.0
}

/// The table of the kernels in C against those in Rust.
fn in_c(rows: &[Row]) -> String {
    let mut table = Table::new(&["core", "scalar", "kernel", "equal", "Rust", "C, gcc -O2", "ratio"]);
    for row in rows.iter().filter(|row| row.what.ends_with(IN_C)) {
        let of = rows.iter().find(|other| other.core == row.core && other.key() == row.key() && other.what != row.what);
        let (Some(c), Some(rust)) = (row.instructions, of.and_then(|row| row.instructions)) else { continue };
        let title = CORES.iter().find(|core| core.name == row.core).map_or(row.core, |core| core.title);
        let equal = if row.equal { "yes" } else { "no" };
        let ratio = format!("{:.2}", c as f64 / rust as f64);
        table.put(&[&title, &row.scalar, &row.key().1, &equal, &thousands(rust), &thousands(c), &ratio]);
    }
    table.0
}

/// The recorded counts: a table for each core.
type Record = BTreeMap<String, BTreeMap<String, u64>>;

fn record(rows: &[Row]) -> Result<()> {
    let mut all = Record::new();
    for row in rows {
        if let Some(count) = row.instructions {
            all.entry(row.core.to_owned()).or_default().insert(format!("{} {}", row.scalar, row.what), count);
        }
    }
    let mut text = "# Instructions of one evaluation; written by `cargo xtask cores --write`.\n".to_owned();
    for (core, counts) in &all {
        text += &format!("\n[{core}]\n");
        counts.iter().for_each(|(name, count)| text += &format!("\"{name}\" = {count}\n"));
    }
    std::fs::write(root().join(RECORD), text)?;
    Ok(())
}

/// Fails if a count is not recorded, or differs by more than the tolerance.
fn compare(rows: &[Row]) -> Result<()> {
    let path = root().join(RECORD);
    let recorded: Record =
        toml::from_str(&std::fs::read_to_string(&path).with_context(|| format!("{}", path.display()))?)?;
    let outside: Vec<String> = rows.iter().filter_map(|row| outside(row, &recorded)).collect();
    ensure!(
        outside.is_empty(),
        "instructions outside of {RECORD}; if that is meant, `cargo xtask cores --write`:\n{}",
        outside.join("\n")
    );
    Ok(())
}

fn outside(row: &Row, recorded: &Record) -> Option<String> {
    let found = row.instructions?;
    let name = format!("{} {}", row.scalar, row.what);
    match recorded.get(row.core).and_then(|counts| counts.get(&name)) {
        None => Some(format!("{} {name}: {found}, not recorded", row.core)),
        Some(&expected) => {
            let allowed = (expected as f64 * TOLERANCE / 100.0).max(1.0);
            (found.abs_diff(expected) as f64 > allowed)
                .then(|| format!("{} {name}: {found}, expected {expected} to within {TOLERANCE} %", row.core))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Record, Row, outside, rows};

    fn row(count: u64) -> Row {
        rows("cortex-m4f", &format!("noise\nrow|f32|control tick|00ff|{count}\n")).unwrap().remove(0)
    }

    #[test]
    fn a_count_is_held_from_both_sides() {
        let recorded: Record = toml::from_str("[cortex-m4f]\n\"f32 control tick\" = 1000\n").unwrap();
        for (count, inside) in [(989, false), (990, true), (1000, true), (1010, true), (1011, false)] {
            assert_eq!(outside(&row(count), &recorded).is_none(), inside, "{count}");
        }
        assert!(outside(&row(1000), &Record::new()).unwrap().contains("not recorded"));
        // WebAssembly counts nothing.
        assert_eq!(outside(&row(0), &recorded), None);
        assert!(rows("desk", "row|f32|x").is_err());
    }
}
