//! Instructions of all contestants on the emulated chip.

use super::build::{self, Job};
use super::contestants::{Family, GENERATORS, Ours, Task, generated};
use super::desk::Torques;
use super::{folder, source};
use crate::process::root;
use crate::qemu;
use anyhow::{Context as _, Result, bail};
use chip_image::Program;
use std::path::PathBuf;

/// Instructions and bytes of a contestant.
#[derive(Clone, Debug, serde::Serialize)]
pub(super) struct Count {
    pub(super) family: Family,
    pub(super) task: Task,
    /// Compiler and options, in words.
    pub(super) build: &'static str,
    /// Fewest over the states.
    pub(super) instructions_min: u32,
    /// Mean over the states.
    pub(super) instructions_mean: f64,
    /// Most over the states.
    pub(super) instructions_max: u32,
    /// Bytes of the function alone, without its callees.
    pub(super) code_bytes: u64,
    /// Largest difference from our recursion in f64, relative to the largest torque of the state.
    pub(super) error: f64,
}

/// A contestant before it is measured.
struct Entry {
    family: Family,
    task: Task,
    build: &'static str,
    symbol: String,
    /// Part of the name of the function with the arithmetic, for compilers that do not inline it.
    kernel: Option<String>,
}

/// Largest difference of f32 torques from our recursion in f64, relative to the largest of the state.
const ERROR_MAX: f64 = 1e-5;

const MACHINE: &str = "-mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16 -w";

/// Name of a build, in words and in a symbol; options.
const OPTIONS: [(&str, &str, &str); 3] =
    [("gcc -O2", "o2", "-O2"), ("gcc -O3", "o3", "-O3"), ("gcc -O3, fast-math", "o3fast", "-O3 -ffast-math")];

/// Tasks of generated C on the chip; the file of their source; the switches of `generated_chip.c`.
const TASKS: [(Task, &str, &str); 3] = [
    (Task::Inverse, "inverse", ""),
    (Task::Kernel, "kernel", "-DKERNEL"),
    (Task::KernelAfterOurTrig, "kernel", "-DKERNEL -DOUR_TRIG"),
];

/// Builds for one arm, runs, checks against the reference's torques, and counts.
pub(super) fn measure(arm: &str, ours: &Ours, reference: &[Torques]) -> Result<Vec<Count>> {
    let (entries, elf) = build(arm, ours)?;
    let said = qemu::semihosted(&elf)?;
    let bytes = std::fs::read(&elf)?;
    let program = Program::parse(&bytes)?;
    let mut counts = Vec::new();
    for entry in entries {
        let line = said.lines().find_map(|line| line.strip_prefix(&entry.symbol)?.strip_prefix(' '));
        let line = line.with_context(|| format!("the chip did not count {}", entry.symbol))?;
        let count = entry.read(line, &program, reference)?;
        // NaN counts as a difference too.
        if count.error.is_nan() || count.error > ERROR_MAX {
            bail!("{arm}: {} on the chip differs from ours by {:.1e} of the largest", entry.symbol, count.error);
        }
        counts.push(count);
    }
    Ok(counts)
}

impl Entry {
    /// `INSTRUCTIONS... / TORQUES...`
    fn read(&self, line: &str, program: &Program, reference: &[Torques]) -> Result<Count> {
        let (instructions, torques) = line.split_once(" / ").with_context(|| format!("no torques: {line}"))?;
        let instructions: Vec<u32> = instructions.split(' ').map(str::parse).collect::<Result<_, _>>()?;
        let torques: Vec<f64> = torques
            .split(' ')
            .map(|bits| u32::from_str_radix(bits, 16).map(|bits| f64::from(f32::from_bits(bits))))
            .collect::<Result<_, _>>()?;
        Ok(Count {
            family: self.family,
            task: self.task,
            build: self.build,
            instructions_min: instructions.iter().copied().min().unwrap_or_default(),
            instructions_mean: instructions.iter().map(|&n| f64::from(n)).sum::<f64>() / instructions.len() as f64,
            instructions_max: instructions.iter().copied().max().unwrap_or_default(),
            code_bytes: self.code_bytes(program)?,
            error: error(&torques, reference),
        })
    }
}

impl Entry {
    /// Bytes of the function, and of the kernel if that is a separate function.
    fn code_bytes(&self, program: &Program) -> Result<u64> {
        let size = |is_it: &dyn Fn(&str) -> bool| program.symbols().find(|(name, _)| is_it(name)).map(|(_, size)| size);
        let own = size(&|name| name == self.symbol).with_context(|| format!("no symbol {}", self.symbol))?;
        let kernel = size(&|name| self.kernel.as_ref().is_some_and(|kernel| name.contains(kernel)));
        Ok(u64::from(own) + u64::from(kernel.unwrap_or_default()))
    }
}

/// The largest difference, relative to the largest torque of its state; infinite if a torque is missing or NaN.
fn error(found: &[f64], wanted: &[Torques]) -> f64 {
    let mut error: f64 = if found.is_empty() { f64::INFINITY } else { 0.0 };
    for (found, wanted) in found.chunks(super::JOINTS).zip(wanted) {
        let size = wanted.iter().fold(0.0, |size: f64, torque| size.max(torque.abs()));
        let differences = found.iter().zip(wanted).map(|(found, wanted)| (found - wanted).abs() / size);
        let number = |difference: f64| if difference.is_nan() { f64::INFINITY } else { difference };
        error = differences.fold(error, |error, difference| error.max(number(difference)));
    }
    error
}

/// The program with all contestants.
fn build(arm: &str, ours: &Ours) -> Result<(Vec<Entry>, PathBuf)> {
    let mut entries = Vec::new();
    let mut jobs = Vec::new();
    let mut objects = Vec::new();
    for (family, name) in [(Family::Regrouped, "regrouped"), (Family::Exact, "exact")] {
        for (task, end) in [(Task::Inverse, ""), (Task::Kernel, "_kernel")] {
            let kernel = Some(format!("{arm}_inverse_dynamics_{name}_f32"));
            entries.push(Entry { family, task, build: "rustc", symbol: format!("chip_{arm}_{name}{end}"), kernel });
        }
    }
    for (family, generator, switch) in GENERATORS {
        for (task, function, switches) in TASKS {
            for (build, short, options) in OPTIONS {
                let after = if task == Task::KernelAfterOurTrig { "_after_our_trig" } else { "" };
                let symbol = format!("{generator}_{function}{after}_{short}");
                let text = generated(arm, generator, function, "f32");
                let object = folder().join(arm).join(format!("{symbol}.o"));
                // The generators write their numbers without a suffix; they are meant as single precision.
                let job = Job::new("arm-none-eabi-gcc", object.clone()).words(MACHINE).words(options).words(switches);
                let job = job.words("-c -fsingle-precision-constant").with(format!("-D{switch}"));
                let job = job.with(format!("-DENTRY={symbol}")).depends_on(&text);
                let job = job.with(format!("-DSOURCE={:?}", text.display().to_string()));
                jobs.push(job.from(&source("generated_chip.c")).output());
                entries.push(Entry { family, task, build, symbol, kernel: None });
                objects.push(object);
            }
        }
    }
    build::all("contestants for the chip", jobs)?;

    let list: String = entries.iter().map(|entry| format!("X({})", entry.symbol)).collect();
    let elf = folder().join(arm).join("chip.elf");
    let mut job =
        Job::new("arm-none-eabi-gcc", elf.clone()).words(MACHINE).words("-O2 -nostartfiles -Wl,--gc-sections");
    job = job.with(format!("-DCONTESTANTS={list}")).with("-L").with(root()).with("-T").from(&source("chip.ld"));
    job = job.from(&source("chip.c"));
    for object in &objects {
        job = job.from(object);
    }
    build::all("the chip's program", vec![job.words("-lm").from(&ours.chip).output().words("-lc -lgcc")])?;
    Ok((entries, elf))
}
