//! Instructions of all contestants on the emulated chip, and their estimated cycles.

use super::build::{self, Job};
use super::contestants::{Computation, Family, GENERATORS, Ours, generated};
use super::desk::Torques;
use super::harness::{JOINTS, folder, source};
use super::install::CLANG;
use crate::process::{output, root};
use crate::qemu;
use anyhow::{Context as _, Result, bail, ensure};
use chip_image::Program;
use chip_image::cycles::{Estimate, Memory, Placement, Range, calls};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Estimated cycles: means over the states.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cycles {
    pub(super) low: f64,
    pub(super) likely: f64,
    pub(super) high: f64,
}

/// Instructions, estimated cycles, and bytes of a contestant.
#[derive(Clone, Debug)]
pub(super) struct Count {
    pub(super) family: Family,
    pub(super) task: Computation,
    /// Compiler and options, for the report.
    pub(super) build: String,
    /// Fewest over the states.
    pub(super) instructions_min: u32,
    /// Mean over the states.
    pub(super) instructions_mean: f64,
    /// Most over the states.
    pub(super) instructions_max: u32,
    /// Code in flash at 168 MHz, in calls after the first.
    pub(super) flash: Cycles,
    /// Code in SRAM.
    pub(super) sram: Cycles,
    /// Bytes of the function alone, without its callees.
    pub(super) code_bytes: u64,
    /// Largest difference from our recursion in f64, relative to the largest torque of the state.
    pub(super) error: f64,
}

/// A contestant before it is measured.
struct Entry {
    family: Family,
    task: Computation,
    build: String,
    symbol: String,
    /// Part of the symbol of the function with the arithmetic, for compilers that do not inline it.
    kernel: Option<String>,
}

/// Largest allowed difference of f32 torques from our recursion in f64, relative to the largest torque of the state.
const ERROR_MAX: f64 = 1e-5;

const MACHINE: &str = "-mcpu=cortex-m4 -mthumb -mfloat-abi=hard -mfpu=fpv4-sp-d16 -w";

/// The compilers, and their options in addition to [`MACHINE`]. Generated code has floating-point constants without a suffix, which are meant as
/// single precision.
const COMPILERS: [(&str, &str); 2] = [
    (GCC, "-fsingle-precision-constant"),
    (CLANG, "--target=thumbv7em-none-eabihf -Xclang -cl-single-precision-constant"),
];

const GCC: &str = "arm-none-eabi-gcc";

/// Sets of compiler options: name for reports, name for symbols, options. Contraction to fused multiply-add saves instructions but costs cycles, so
/// each set also exists without it.
const OPTIONS: [(&str, &str, &str); 8] = [
    ("-Os", "os", "-Os"),
    ("-O2", "o2", "-O2"),
    ("-O3", "o3", "-O3"),
    ("-O3, fast-math", "o3fast", "-O3 -ffast-math"),
    ("-Os, no FMA", "os_apart", "-Os -ffp-contract=off"),
    ("-O2, no FMA", "o2_apart", "-O2 -ffp-contract=off"),
    ("-O3, no FMA", "o3_apart", "-O3 -ffp-contract=off"),
    ("-O3, fast-math, no FMA", "o3fast_apart", "-O3 -ffast-math -ffp-contract=off"),
];

/// The function of `chip.c` that calls all contestants.
const COUNTER: &str = "counted_call";

/// Number of states in `chip.h`.
const STATES: usize = 64;

/// Tasks of generated C on the chip: the source file's name, and the switches for `generated_chip.c`.
const TASKS: [(Computation, &str, &str); 3] = [
    (Computation::Inverse, "inverse", ""),
    (Computation::Kernel, "kernel", "-DKERNEL"),
    (Computation::KernelAfterOurTrig, "kernel", "-DKERNEL -DOUR_TRIG"),
];

/// Builds for one arm, runs, checks against the reference's torques, and counts.
pub(super) fn measure(arm: &str, ours: &Ours, reference: &[Torques]) -> Result<Vec<Count>> {
    let (entries, elf) = build(arm, ours)?;
    let said = qemu::semihosted(&elf)?;
    let bytes = std::fs::read(&elf)?;
    let program = Program::parse(&bytes)?;
    let mut counts = Vec::new();
    let cycles = cycles(&elf, &program, &entries)?;
    for (entry, cycles) in entries.iter().zip(cycles) {
        let line = said.lines().find_map(|line| line.strip_prefix(&entry.symbol)?.strip_prefix(' '));
        let line = line.with_context(|| format!("the chip did not count {}", entry.symbol))?;
        let count = entry.read(line, cycles, &program, reference)?;
        // NaN counts as a difference too.
        if count.error.is_nan() || count.error > ERROR_MAX {
            bail!("{arm}: {} on the chip differs from ours by {:.1e} of the largest", entry.symbol, count.error);
        }
        counts.push(count);
    }
    Ok(counts)
}

/// Cycles of every contestant, from flash and from SRAM.
fn cycles(elf: &Path, program: &Program, entries: &[Entry]) -> Result<Vec<[Cycles; 2]>> {
    let start = |entry: &Entry| {
        program.address_of(|name| name == entry.symbol).with_context(|| format!("no symbol {}", entry.symbol))
    };
    let starts = entries.iter().map(start).collect::<Result<Vec<_>>>()?;
    let all = calls(elf, program, COUNTER, &starts, [Placement::Flash, Placement::Sram].map(Memory::new))?;
    let cycles = |(entry, calls): (&Entry, Vec<[Estimate; 2]>)| {
        ensure!(calls.len() == STATES, "{}: {} calls traced, not {STATES}", entry.symbol, calls.len());
        let unknown: u64 = calls.iter().flatten().map(|estimate| estimate.unknown).sum();
        ensure!(unknown == 0, "{}: {unknown} instructions that the decoder does not know", entry.symbol);
        Ok([0, 1].map(|memory| {
            // Leave out the first call, whose caches are empty.
            let later = || calls.iter().skip(1).map(move |call| call[memory].cycles);
            let mean = |of: fn(Range) -> u64| later().map(of).sum::<u64>() as f64 / later().count() as f64;
            Cycles { low: mean(|all| all.low), likely: mean(|all| all.likely), high: mean(|all| all.high) }
        }))
    };
    entries.iter().zip(all).map(cycles).collect()
}

impl Entry {
    /// `INSTRUCTIONS... / TORQUES...`
    fn read(&self, line: &str, [flash, sram]: [Cycles; 2], program: &Program, reference: &[Torques]) -> Result<Count> {
        let (instructions, torques) = line.split_once(" / ").with_context(|| format!("no torques: {line}"))?;
        let instructions: Vec<u32> = instructions.split(' ').map(str::parse).collect::<Result<_, _>>()?;
        let torques: Vec<f64> = torques
            .split(' ')
            .map(|bits| u32::from_str_radix(bits, 16).map(|bits| f64::from(f32::from_bits(bits))))
            .collect::<Result<_, _>>()?;
        Ok(Count {
            family: self.family,
            task: self.task,
            build: self.build.clone(),
            instructions_min: instructions.iter().copied().min().unwrap_or_default(),
            instructions_mean: instructions.iter().map(|&n| f64::from(n)).sum::<f64>() / instructions.len() as f64,
            instructions_max: instructions.iter().copied().max().unwrap_or_default(),
            flash,
            sram,
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

/// Largest difference, relative to the largest torque of its state; infinite if a torque is missing, or if one is NaN.
fn error(found: &[f64], wanted: &[Torques]) -> f64 {
    let complete = !found.is_empty() && found.len() == wanted.len() * JOINTS;
    let mut error: f64 = if complete { 0.0 } else { f64::INFINITY };
    for (found, wanted) in found.chunks(JOINTS).zip(wanted) {
        let size = wanted.iter().fold(0.0, |size: f64, torque| size.max(torque.abs()));
        let differences = found.iter().zip(wanted).map(|(found, wanted)| (found - wanted).abs() / size);
        let number = |difference: f64| if difference.is_nan() { f64::INFINITY } else { difference };
        error = differences.fold(error, |error, difference| error.max(number(difference)));
    }
    error
}

/// Builds the program with all contestants.
fn build(arm: &str, ours: &Ours) -> Result<(Vec<Entry>, PathBuf)> {
    let mut entries = Vec::new();
    let mut jobs = Vec::new();
    let mut objects = Vec::new();
    for (family, name) in [(Family::Regrouped, "regrouped"), (Family::Exact, "exact")] {
        for (task, end) in [(Computation::Inverse, ""), (Computation::Kernel, "_kernel")] {
            let kernel = Some(format!("{arm}_inverse_dynamics_{name}_f32"));
            entries.push(Entry {
                family,
                task,
                build: "rustc".to_owned(),
                symbol: format!("chip_{arm}_{name}{end}"),
                kernel,
            });
        }
    }
    let headers = headers()?;
    for (family, generator, switch) in GENERATORS {
        for (task, function, switches) in TASKS {
            let text = generated(arm, generator, function, "f32");
            let after = if task == Computation::KernelAfterOurTrig { "_after_our_trig" } else { "" };
            for (number, (compiler, own)) in COMPILERS.into_iter().enumerate() {
                for (name, short, options) in OPTIONS {
                    let symbol = format!("{generator}_{function}{after}_{number}_{short}");
                    let object = folder().join(arm).join(format!("{symbol}.o"));
                    let job =
                        Job::new(compiler, object.clone()).words(own).words(MACHINE).words(options).words(switches);
                    let job = job.words("-c").with("-isystem").with(&headers).with(format!("-D{switch}"));
                    let job = job.with(format!("-DENTRY={symbol}"));
                    let job = job.with(format!("-DSOURCE={:?}", text.display().to_string()));
                    jobs.push(job.with(source("generated_chip.c")).output());
                    let build = format!("{} {name}", if compiler == GCC { "gcc" } else { compiler });
                    entries.push(Entry { family, task, build, symbol, kernel: None });
                    objects.push(object);
                }
            }
        }
    }
    build::all("contestants for the chip", jobs)?;

    let list: String = entries.iter().map(|entry| format!("X({})", entry.symbol)).collect();
    let elf = folder().join(arm).join("chip.elf");
    let mut job = Job::new(GCC, elf.clone()).words(MACHINE).words("-O2 -nostartfiles -Wl,--gc-sections");
    job = job
        .with(format!("-DCONTESTANTS={list}"))
        .with("-L")
        .with(root())
        .with("-L")
        .with(root().join("firmware/memory/stm32f405"))
        .with("-T")
        .with(source("chip.ld"));
    job = job.with(source("chip.c"));
    for object in &objects {
        job = job.with(object);
    }
    build::all("the chip's program", vec![job.words("-lm").with(&ours.chip).output().words("-lc -lgcc")])?;
    Ok((entries, elf))
}

/// Folder of newlib's headers, for clang, which has no C library of its own.
fn headers() -> Result<PathBuf> {
    let said = output(Command::new(GCC).args(["-M", "-x", "c", "-include", "math.h", "/dev/null"]));
    let said = said.with_context(|| format!("{GCC} does not find math.h"))?;
    let header = said.split_whitespace().find(|word| word.ends_with("/math.h")).map(Path::new);
    Ok(header.and_then(Path::parent).with_context(|| format!("no math.h: {said}"))?.to_owned())
}
