//! Cost of the link's interrupts, for both of its modes: byte by byte, and by DMA.
//!
//! Both firmwares run the same supervised ticks in the emulator. The emulated chip has no DMA: a stand-in moves the bytes
//! (`firmware/src/boards/dma_stand_in.rs`), and its instructions are left out. The short interrupts that access DMA registers are taken from a
//! board's own program. All of their instructions are counted, on every branch, which gives an upper bound.

use crate::budget::Failure;
use crate::budget::interrupts::{BYTE, HALF_FILLED, SENT, SERVE};
use crate::budget::program;
use crate::budget::random_motion::Tick;
use crate::budget::traced::follow;
use chip_image::costs::{Cycles, LinkInterrupts, Runs, Ways};
use chip_image::cycles::steps::{self, Event, Step};
use chip_image::cycles::{Estimate, Estimator, Memory};
use chip_image::{Effect, Program};
use robot_compiler::SceneFile;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

/// Measures the firmware at `elf`, the one with the stand-in at `dma`, and the interrupts of a board's own program.
///
/// # Errors
/// A program cannot be read or lacks a handler, the chip is unusable, or the trace is incomplete.
pub fn measure<const N: usize>(
    scene: &SceneFile,
    elf: &Path,
    dma: &Path,
    board: &Path,
    motion: &[Tick<N>],
) -> Result<Ways, Failure> {
    let bytes = run(scene, elf, motion)?;
    let with_stand_in = run(scene, dma, motion)?;
    if with_stand_in.pieces == 0 || with_stand_in.way.half_filled.times == 0 {
        return Err(Failure::NotSeen("the interrupts of a DMA in the trace with its stand-in: it has none".into()));
    }
    let own = program::read(board)?;
    let once = |exception| {
        let why = || format!("expected a handler of exception {exception} that calls nothing: the link's by DMA");
        handler(&own, exception).ok_or_else(|| Failure::Program { path: board.to_owned(), why: why() })
    };
    let way = with_stand_in.way;
    let dma = LinkInterrupts {
        // Assumes that the line becomes idle after every packet.
        receive: times(once(BYTE)?, with_stand_in.packets),
        half_filled: times(once(HALF_FILLED)?, way.half_filled.times),
        // A packet is at most two pieces: up to the end of the buffer, and from its beginning. The stand-in sends it as one piece and at once, so it
        // has fewer interrupts.
        sent: times(once(SENT)?, 2 * with_stand_in.pieces),
        ..way
    };
    Ok(Ways { bytes: bytes.way, dma })
}

/// Traces one firmware.
fn run<const N: usize>(scene: &SceneFile, elf: &Path, motion: &[Tick<N>]) -> Result<LinkFindings, Failure> {
    let program = program::read(elf)?;
    let (mut found, carried) = follow(scene, elf, motion, move |log| {
        let mut watch = LinkWatch::new(&program);
        steps::read(log, |event| watch.event(event)).map(|()| watch.finish())
    })?;
    if found.way.receive.times != carried.to_chip {
        let (expected, times) = (carried.to_chip, found.way.receive.times);
        return Err(Failure::NotSeen(format!("{expected} received bytes in the trace: it has {times}")));
    }
    (found.way.to_chip, found.way.from_chip) = (carried.to_chip, carried.from_chip);
    found.packets = carried.packets_to_chip;
    Ok(found)
}

/// Findings of a trace.
#[derive(Clone, Copy, Debug, Default)]
struct LinkFindings {
    way: LinkInterrupts,
    /// Packets received.
    packets: u64,
    /// Pieces that the stand-in has sent.
    pieces: u64,
}

/// Follows a trace.
struct LinkWatch<'a> {
    estimator: Estimator<'a>,
    /// Address range of the stand-in's work, inside interrupts that otherwise belong to the link.
    left_out: Option<Range<u32>>,
    /// First instruction of each interrupt.
    starts: BTreeMap<u16, u32>,
    /// The exception of the previous instruction; true if that was the link's own code.
    before: (u16, bool),
    found: LinkFindings,
}

impl<'a> LinkWatch<'a> {
    fn new(program: &'a Program) -> Self {
        let stand_in = program.address_of(|name| name.contains("dma_stand_in") && name.contains("transmit"));
        let left_out = stand_in.and_then(|start| {
            let bytes = u32::try_from(program.function(start).ok()?.bytes).ok()?;
            Some(start..start + bytes)
        });
        let starts = [BYTE, HALF_FILLED, SERVE, SENT];
        let starts =
            starts.into_iter().filter_map(|exception| Some((exception, program.handler(usize::from(exception))?)));
        let estimator = Estimator::new(program, Memory::of(program));
        Self { estimator, left_out, starts: starts.collect(), before: (0, false), found: LinkFindings::default() }
    }

    fn event(&mut self, event: Event) {
        if let Event::Step(step) = event {
            self.step(&step);
        }
    }

    fn step(&mut self, step: &Step) {
        let own = !self.left_out.as_ref().is_some_and(|range| range.contains(&step.address));
        if self.before != (step.exception, own) {
            self.cut();
        }
        self.before = (step.exception, own);
        self.found.pieces += u64::from(self.left_out.as_ref().is_some_and(|range| range.start == step.address));
        if self.starts.get(&step.exception) == Some(&step.address)
            && let Some(runs) = of(&mut self.found.way, step.exception)
        {
            runs.times += 1;
        }
        self.estimator.execute_with(step.address, &step.registers);
    }

    /// Adds the estimate since the last cut to its interrupt.
    fn cut(&mut self) {
        let lap = self.estimator.finish();
        let (exception, own) = self.before;
        if let (true, Some(runs)) = (own, of(&mut self.found.way, exception)) {
            add(runs, &lap);
        }
    }

    fn finish(mut self) -> LinkFindings {
        self.cut();
        self.found
    }
}

/// Counts of an interrupt, if it belongs to the link.
const fn of(way: &mut LinkInterrupts, exception: u16) -> Option<&mut Runs> {
    match exception {
        BYTE => Some(&mut way.receive),
        HALF_FILLED => Some(&mut way.half_filled),
        SERVE => Some(&mut way.serve),
        SENT => Some(&mut way.sent),
        _ => None,
    }
}

fn add(runs: &mut Runs, estimate: &Estimate) {
    runs.instructions += estimate.instructions;
    runs.cycles.low += estimate.cycles.low;
    runs.cycles.likely += estimate.cycles.likely;
    runs.cycles.high += estimate.cycles.high;
}

/// `times` runs that are equal to `one`.
const fn times(one: Runs, times: u64) -> Runs {
    let Cycles { low, likely, high } = one.cycles;
    let cycles = Cycles { low: low * times, likely: likely * times, high: high * times };
    Runs { times, instructions: one.instructions * times, cycles }
}

/// One run of a handler that calls no function, with each of its instructions executed once.
fn handler(program: &Program, exception: u16) -> Option<Runs> {
    let start = program.handler(usize::from(exception))?;
    let range = start..start + u32::try_from(program.function(start).ok()?.bytes).ok()?;
    let mut estimator = Estimator::new(program, Memory::of(program));
    let mut at = start;
    while let Some(instruction) = range.contains(&at).then(|| program.decode(at)).flatten() {
        if matches!(instruction.effect, Effect::Jump(goal) if !range.contains(&goal)) {
            return None;
        }
        estimator.execute(at);
        at += instruction.width;
    }
    let mut runs = Runs { times: 1, ..Runs::default() };
    add(&mut runs, &estimator.finish());
    Some(runs)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

    use super::{BYTE, LinkFindings, LinkWatch, SENT, SERVE, Step, of};
    use chip_image::Program;
    use chip_image::cycles::steps::Event;

    fn watched(events: &[(u16, u32)]) -> LinkFindings {
        let program = Program::from_halves(0, &[0xbf00; 16]);
        let mut watch = LinkWatch::new(&program);
        watch.starts = [(BYTE, 0), (SERVE, 8), (SENT, 16)].into();
        watch.left_out = Some(12..16);
        for (exception, address) in events {
            watch.event(Event::Step(Step { address: *address, exception: *exception, ..Step::default() }));
        }
        watch.finish()
    }

    #[test]
    fn each_interrupt_has_its_own_instructions_and_the_stand_in_none() {
        let found =
            watched(&[(0, 30), (BYTE, 0), (BYTE, 2), (SERVE, 8), (SERVE, 10), (BYTE, 0), (SERVE, 12), (SENT, 14)]);
        let mut way = found.way;
        let mut seen = |exception| of(&mut way, exception).map(|runs| (runs.times, runs.instructions)).unwrap();
        assert_eq!([BYTE, SERVE, SENT].map(&mut seen), [(2, 3), (1, 2), (0, 0)]);
        assert_eq!(found.pieces, 1);
    }
}
