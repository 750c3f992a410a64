//! Kernels on the emulated chip: instructions, bytes, and stack traffic.

use super::baseline::BaselineCounts;
use crate::toolchain::{self, Toolchain};
use anyhow::{Context as _, Result, bail};
use chip_image::{Function, Program};
use firmware_image::emitted::written;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// A counted function.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct CountRow {
    /// Start address of the function.
    pub(crate) address: u32,
    /// Fewest instructions over all states.
    pub(crate) least: u64,
    /// Most instructions.
    pub(crate) most: u64,
    /// Multiplications, additions and subtractions of its program; zero for functions that are not kernels.
    pub(crate) operations: u64,
    /// Largest number of computed values that are alive at the same time.
    pub(crate) alive: u64,
    /// The function in the linked program.
    pub(crate) code: Function,
}

/// All counts by name, the program, and the compiler that built it.
#[derive(Debug)]
pub(crate) struct Counted {
    pub(crate) elf: PathBuf,
    pub(crate) program: Program,
    pub(crate) rows: BTreeMap<String, CountRow>,
    pub(crate) rustc: String,
}

impl Counted {
    /// A required row.
    pub(crate) fn row(&self, name: &str) -> Result<&CountRow> {
        self.rows.get(name).with_context(|| format!("the chip's program did not count {name}"))
    }

    /// The instructions, for the baseline.
    pub(crate) fn counts(&self) -> BaselineCounts {
        self.rows.iter().map(|(name, row)| (name.clone(), row.most)).collect()
    }
}

/// Builds the program, runs it in the emulator, and reads its output.
pub(crate) fn count() -> Result<Counted> {
    firmware_image::install::qemu()?;
    let toolchain = Toolchain::find_or_install()?;
    let folder = written("kernels", |folder| crate::bench::kernels::write(folder.to_owned()))?;
    let mut cargo = toolchain.cargo("build");
    cargo.args(["--quiet", "--locked", "--package", "probe", "--features", "kernels"]).env("NEWTAU_KERNELS", folder);
    let elf = toolchain::build(&mut cargo, toolchain::product("probe-kernels"))?;
    let said = crate::qemu::semihosted(&elf)?;
    let bytes = std::fs::read(&elf)?;
    let program = Program::parse(&bytes)?;
    let rows = said.lines().filter_map(|line| line.strip_prefix("count,")).map(|line| row(line, &program));
    let rows: BTreeMap<String, CountRow> = rows.collect::<Result<_>>()?;
    if rows.is_empty() {
        bail!("the counting program said nothing");
    }
    Ok(Counted { elf, program, rows, rustc: toolchain.rustc()? })
}

/// `name,address,least,most,operations,negations,live inputs,alive`
fn row(line: &str, program: &Program) -> Result<(String, CountRow)> {
    let mut fields = line.split(',');
    let name = fields.next().unwrap_or_default().to_owned();
    let numbers: Vec<u64> = fields.map(str::parse).collect::<Result<_, _>>().with_context(|| line.to_owned())?;
    let [address, least, most, operations, _, _, alive] = numbers[..] else { bail!("not seven numbers: {line}") };
    let address = u32::try_from(address & !1).with_context(|| line.to_owned())?;
    Ok((name, CountRow { address, least, most, operations, alive, code: program.function(address)? }))
}
