//! Lateness of a tick while the chip's timer paces it and the link is saturated.
//!
//! Whenever the chip has read the bytes sent so far, live inputs, reference and measurement follow at once: as much as its queue holds, faster than
//! any wire. The chip answers every tick. The emulator's own log gives the number of instructions from the timer's interrupt becoming pending to the
//! first instruction of its handler. Instructions of a tick that is still running are not counted: that is an overrun, and no mask delayed the
//! interrupt.

use crate::budget::Failure;
use crate::budget::interrupts::TICK;
use crate::budget::program;
use crate::budget::random_motion::Tick;
use crate::budget::ticks::{PATIENCE, QEMU, hello, tell_live};
use ::board::chip::{Chip, Emulator};
use chip_image::costs::Late;
use chip_image::cycles::steps::{self, Detail, Event, Step};
use dynamics_core::Command;
use robot_compiler::SceneFile;
use sim::run::simulate;
use std::io::BufReader;
use std::path::Path;

/// Runs `ticks` timer-paced ticks of a chip that holds still, under a flood.
///
/// # Errors
/// The program cannot be read, the chip is unusable or brakes, or the log has no delays.
pub fn flood<const N: usize>(scene: &SceneFile, elf: &Path, ticks: u64, still: &Tick<N>) -> Result<Late, Failure> {
    let start = tick_handler(elf)?;
    let arguments: Vec<_> = steps::arguments(Detail::Registers)?.into_iter().map(Into::into).collect();
    let mut emulator = Emulator::start_with(QEMU.as_ref(), elf, PATIENCE, &arguments)?;
    let log = emulator.take_log().ok_or_else(|| Failure::NotSeen("the emulator's log: it has none".into()))?;
    let reader = std::thread::spawn(move || {
        let mut delays = Delays::new(start);
        steps::read(BufReader::with_capacity(1 << 16, log), |event| delays.event(event)).map(|()| delays.late)
    });
    let expect = hello::<N>(scene)?;
    let mut chip = Chip::over(emulator, expect)?;
    tell_live::<N>(&mut chip, scene)?;
    chip.start_timer(expect, &still.0, &still.1)?;
    let before = chip.carried();
    let model = scene.robot.model::<N>().map_err(|error| Failure::Scene(error.to_string()))?;
    let live = simulate::live_inputs::<f32, N>(scene, &model);
    let mut pushed = 0;
    for _ in 0..ticks {
        let (tick, reply) = chip.next_timed::<N>()?;
        if let Command::Brake(fault) = reply.command {
            return Err(Failure::NotSeen(format!("a torque in tick {tick} of the flood: the chip brakes, {fault}")));
        }
        if tick >= pushed {
            pushed = chip.push(&live, &still.0, &still.1)?;
        }
    }
    let carried = chip.carried();
    drop(chip);
    let late = reader.join().map_err(|_| Failure::NotSeen("the log: its reader stopped".into()))??;
    if late.ticks < ticks || late.delayed == 0 {
        return Err(Failure::NotSeen(format!(
            "{ticks} ticks of which some had to wait: {} began, {} late; a flood that meets no tick shows nothing",
            late.ticks, late.delayed
        )));
    }
    Ok(Late {
        bytes_to_chip: carried.to_chip - before.to_chip,
        bytes_from_chip: carried.from_chip - before.from_chip,
        ..late
    })
}

/// Start address of the tick's interrupt handler.
fn tick_handler(elf: &Path) -> Result<u32, Failure> {
    let found = program::read(elf)?.handler(usize::from(TICK));
    let why = || format!("its vector table has no handler of exception {TICK}, the control timer's");
    found.ok_or_else(|| Failure::Program { path: elf.to_owned(), why: why() })
}

/// Counts the instructions from the interrupt to its handler.
struct Delays {
    start: u32,
    /// Instructions since the interrupt became pending.
    waiting: Option<u64>,
    late: Late,
}

impl Delays {
    fn new(start: u32) -> Self {
        Self { start, waiting: None, late: Late::default() }
    }

    fn event(&mut self, event: Event) {
        match event {
            // If it becomes pending again before the handler starts, that is the same wait.
            Event::Pending { exception: TICK } => drop(self.waiting.get_or_insert(0)),
            Event::Step(step) if step.address == self.start => {
                if let Some(waited) = self.waiting.take() {
                    self.late.ticks += 1;
                    self.late.delayed += u64::from(waited > 0);
                    self.late.most = self.late.most.max(waited);
                }
            }
            Event::Step(Step { exception: TICK, .. }) => {}
            Event::Step(_) => self.waiting = self.waiting.map(|waited| waited + 1),
            Event::Pending { .. } | Event::Priority { .. } => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Delays, TICK};
    use chip_image::cycles::steps::{Event, Step};

    #[test]
    fn a_delay_counts_from_pending_to_the_handlers_first_instruction() {
        let step = |address| Event::Step(Step { address, ..Step::default() });
        let own = |address| Event::Step(Step { address, exception: TICK, ..Step::default() });
        let pending = |exception| Event::Pending { exception };
        let mut delays = Delays::new(100);
        let log = [
            // A handler that starts at once; its own instructions do not count as a wait.
            [step(2), pending(TICK), step(100), step(102)].to_vec(),
            // A handler that waits for three instructions and is pended twice.
            [pending(54), step(4), pending(TICK), step(6), pending(TICK), step(8), step(10), step(100)].to_vec(),
            // An interrupt that becomes pending while the previous tick still runs, and then waits for one instruction.
            [own(100), pending(TICK), own(102), own(104), step(12), own(100)].to_vec(),
            // A handler that was never pended does not count.
            [step(100)].to_vec(),
        ];
        log.concat().into_iter().for_each(|event| delays.event(event));
        assert_eq!((delays.late.ticks, delays.late.delayed, delays.late.most), (3, 2, 3));
    }
}
