//! Results of the emulator's trace of a few ticks under the safety state machine, in lock step: the tick's interrupt and
//! its estimated cycles, the time for which it is masked, and the cost of a byte of the link.

use crate::budget::interrupts::{BYTE, Mask, SERVE, TICK};
use crate::budget::random_motion::Tick;
use crate::budget::report::{Interrupt, Traced};
use crate::budget::supervised::TICKS_BEFORE;
use crate::budget::ticks::{PATIENCE, QEMU, hello};
use crate::budget::{Failure, program, supervised};
use ::board::chip::{Carried, Chip, Emulator};
use ::board::session::dry_run::OnChip;
use chip_image::Program;
use chip_image::costs::Cycles;
use chip_image::cycles::steps::{self, Detail, Event, Step};
use chip_image::cycles::{Estimate, Estimator, Memory};
use robot_compiler::SceneFile;
use std::collections::BTreeMap;
use std::io::BufReader;
use std::path::Path;
use std::process::ChildStderr;

/// Homes, arms and runs a chip along a motion, and traces it.
///
/// # Errors
/// The program cannot be read, the chip is unusable, or the trace is incomplete.
pub fn trace<const N: usize>(scene: &SceneFile, elf: &Path, motion: &[Tick<N>]) -> Result<Traced, Failure> {
    let program = program::read(elf)?;
    let stack = program.stack().map_err(|error| Failure::Program { path: elf.to_owned(), why: error.to_string() })?;
    let open = stack.open;
    let (found, carried) = follow(scene, elf, motion, move |log| {
        let mut watch = TraceWatch::new(&program);
        steps::read(log, |event| watch.event(event)).map(|()| watch.found)
    })?;
    if u64::from(found.below_interrupts) > open {
        let deep = found.below_interrupts;
        return Err(Failure::NotSeen(format!(
            "at most {open} bytes of stack below unmasked interrupts: it has {deep}"
        )));
    }
    found.sum_up(carried.to_chip, carried.from_chip, (supervised::TICKS_BEFORE + motion.len()) as u64)
}

/// The emulator's log.
pub(crate) type Log = BufReader<ChildStderr>;

/// Homes, arms and runs a chip along a motion while `read` reads its log. Returns the result of `read`, and the bytes that the link carried.
pub(crate) fn follow<const N: usize, R: Send + 'static>(
    scene: &SceneFile,
    elf: &Path,
    motion: &[Tick<N>],
    read: impl FnOnce(Log) -> Result<R, chip_image::cycles::emulator::Error> + Send + 'static,
) -> Result<(R, Carried), Failure> {
    let arguments: Vec<_> = steps::arguments(Detail::Registers)?.into_iter().map(Into::into).collect();
    let mut emulator = Emulator::start_with(QEMU.as_ref(), elf, PATIENCE, &arguments)?;
    let log = emulator.take_log().ok_or_else(|| Failure::NotSeen("the emulator's log: it has none".into()))?;
    let reader = std::thread::spawn(move || read(BufReader::with_capacity(1 << 16, log)));
    let expect = hello::<N>(scene)?;
    let mut chip = OnChip::start(Chip::over(emulator, expect)?, expect)?;
    supervised::drive(&mut chip, scene, motion, |_| ())?;
    let carried = chip.chip().carried();
    // The log ends when the emulator ends.
    drop(chip);
    let found = reader.join().map_err(|_| Failure::NotSeen("the log: its reader stopped".into()))??;
    Ok((found, carried))
}

/// Instructions executed in one exception handler.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Served {
    /// Its first instruction.
    start: u32,
    /// Instructions since its last start.
    now: u64,
    /// Number of starts.
    times: u64,
    /// Instructions of all runs together.
    total: u64,
    /// Most instructions in one run.
    most: u64,
}

impl Served {
    fn step(&mut self, step: &Step) {
        if self.times == 0 {
            self.start = step.address;
        }
        // No instruction of a handler jumps back to its first, so this is a new start.
        if step.address == self.start {
            self.now = 0;
            self.times += 1;
        }
        self.now += 1;
        self.total += 1;
        self.most = self.most.max(self.now);
    }
}

/// Findings of a trace.
#[derive(Clone, Debug, Default)]
struct TraceFindings {
    byte: Served,
    tick: Served,
    serve: Served,
    masked: u64,
    /// Largest stack depth, in bytes, outside of interrupts while these are not masked. [`chip_image::Stack::open`] bounds it.
    below_interrupts: u32,
    /// Estimates of the completed ticks.
    estimates: Vec<Estimate>,
}

impl TraceFindings {
    /// Checks the counts against both ends of the link, and summarises them.
    fn sum_up(self, to_chip: u64, from_chip: u64, ticks: u64) -> Result<Traced, Failure> {
        fn missing<T>(what: String) -> Result<T, Failure> {
            Err(Failure::NotSeen(what))
        }
        if self.tick.times != ticks {
            return missing(format!("{ticks} ticks in the trace: it has {}", self.tick.times));
        }
        // Each interrupt of the receiver takes one byte.
        if self.byte.times != to_chip {
            return missing(format!("{to_chip} received bytes in the trace: it has {}", self.byte.times));
        }
        // The first tick has empty caches, which do not occur in operation.
        let after = |first: usize| {
            let longest = self.estimates.iter().skip(first).max_by_key(|estimate| estimate.cycles.likely);
            let Some(longest) = longest else { return missing(format!("a tick behind {first} others in the trace")) };
            if longest.unknown > 0 {
                return missing(format!("{} instructions that the decoder knows", longest.unknown));
            }
            let chip_image::cycles::Range { low, likely, high } = longest.cycles;
            Ok(Interrupt { instructions: longest.instructions, cycles: Cycles { low, likely, high } })
        };
        Ok(Traced {
            ticks,
            running: after(TICKS_BEFORE + 1)?,
            longest: after(1)?,
            masked: self.masked,
            byte_interrupt: self.byte.most,
            link_byte: (self.byte.total + self.serve.total).div_ceil((to_chip + from_chip).max(1)),
        })
    }
}

/// Follows a trace.
struct TraceWatch<'a> {
    program: &'a Program,
    estimator: Estimator<'a>,
    mask: Mask,
    priorities: BTreeMap<u16, u8>,
    /// Initial stack pointer.
    top: u32,
    /// Instructions since the tick's interrupt was masked.
    masked: u64,
    /// Exception of the previous instruction.
    before: u16,
    /// Estimate of the current tick so far; another interrupt may split it.
    tick: Option<Estimate>,
    found: TraceFindings,
}

impl<'a> TraceWatch<'a> {
    fn new(program: &'a Program) -> Self {
        Self {
            program,
            top: program.stack_top().unwrap_or_default(),
            estimator: Estimator::new(program, Memory::of(program)),
            mask: Mask::default(),
            priorities: BTreeMap::new(),
            masked: 0,
            before: 0,
            tick: None,
            found: TraceFindings::default(),
        }
    }

    fn event(&mut self, event: Event) {
        match event {
            Event::Priority { exception, priority } => drop(self.priorities.insert(exception, priority)),
            Event::Pending { .. } => {}
            Event::Step(step) => self.step(&step),
        }
    }

    fn step(&mut self, step: &Step) {
        match step.exception {
            BYTE => self.found.byte.step(step),
            TICK => self.found.tick.step(step),
            SERVE => self.found.serve.step(step),
            _ => {}
        }
        self.estimate(step);
        self.measure_stack(step);
        self.hold_off(step);
        self.before = step.exception;
    }

    /// Updates the estimate. Caches and pipeline follow all executed code; the estimate is cut at the start and end of the tick.
    fn estimate(&mut self, step: &Step) {
        let begins = step.exception == TICK && step.address == self.found.tick.start;
        if step.exception != self.before || begins {
            let lap = self.estimator.finish();
            if self.before == TICK {
                add(self.tick.get_or_insert_default(), lap);
            }
            let ends = begins || !matches!(step.exception, TICK | BYTE);
            if ends {
                self.found.estimates.extend(self.tick.take());
            }
        }
        self.estimator.execute_with(step.address, &step.registers);
    }

    /// Measures the stack outside of interrupts. Nothing counts before priorities are set, because no interrupt can occur until then. The lowest
    /// priority is blocked only by PRIMASK.
    fn measure_stack(&mut self, step: &Step) {
        const SP: usize = 13;
        // A step without registers in the log has zeros.
        let known = step.registers[SP] != 0 && !self.priorities.is_empty();
        if step.exception == 0 && known && !self.mask.holds_off(u8::MAX) {
            let used = self.top.saturating_sub(step.registers[SP]);
            self.found.below_interrupts = self.found.below_interrupts.max(used);
        }
    }

    /// Counts the instructions for which a mask delays the tick. Not counted are instructions of the tick itself, those of more urgent interrupts,
    /// which are counted separately, and those before the first interrupt, when no timer runs.
    fn hold_off(&mut self, step: &Step) {
        let priority = |exception| self.priorities.get(&exception).copied();
        let held_off = |mask: Mask| priority(TICK).is_some_and(|own| mask.holds_off(own));
        if priority(step.exception) > priority(TICK) && held_off(self.mask) {
            self.masked += 1;
            self.found.masked = self.found.masked.max(self.masked);
        }
        if let Some(instruction) = self.program.decode(step.address) {
            self.mask = self.mask.after(&instruction, &step.registers);
        }
        if !held_off(self.mask) {
            self.masked = 0;
        }
    }
}

fn add(sum: &mut Estimate, part: Estimate) {
    sum.instructions += part.instructions;
    sum.unknown += part.unknown;
    sum.cycles.low += part.cycles.low;
    sum.cycles.likely += part.cycles.likely;
    sum.cycles.high += part.cycles.high;
}

#[cfg(test)]
mod tests;
