//! Costs on the chip: of a controller, of the whole interrupt around it, and the share of the processor.
//!
//! In the interrupt of a tick the firmware runs more than the controller: readings, trajectory, safety state machine, black box, outputs. This part
//! is the same for every choice of a scene. It is measured once, and added to the controller of each:
//!
//! ```text
//! interrupt(choice) = controller(choice) + [interrupt(firmware) - controller(firmware)]
//! share(choice)     = interrupt(choice) rate / clock
//! ```
//!
//! `host-sim/tests/chip/interrupt.rs` compares the sum with the interrupt of the choice's own firmware. The firmware computes in `f32`, so for an
//! `f64` choice the sum cannot be checked against a firmware.

pub mod cost;
pub mod interrupt;
mod task;

pub use cost::Cost;
use cost::MeasuredCost;
use indicatif::ProgressBar;
use interrupt::Interrupt;
use serde::{Deserialize, Serialize};
use sim::failure::Failure;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// Clock of the chip, Hz.
pub const CLOCK: f64 = 168e6;

/// Cost of the interrupt of a tick on the chip, and its share of the processor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Load {
    /// Mean number of cycles per tick: an estimate.
    pub cycles: f64,
    /// Greatest number of cycles per tick: an estimate.
    pub cycles_max: f64,
    /// Share of the processor at [`CLOCK`] and the choice's rate, for the mean tick.
    pub cpu_share: f64,
    /// Share of the processor for the longest tick.
    pub cpu_share_max: f64,
}

/// Cost of the interrupt around the controller.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct InterruptCost {
    /// Number of instructions.
    pub instructions: f64,
    /// Number of cycles, estimated.
    pub cycles: f64,
}

impl InterruptCost {
    /// Measures the interrupt of a scene's firmware and subtracts its controller; `controller` is the cost of the latter if it is known.
    ///
    /// # Errors
    /// Those of the methods of [`Chip`].
    pub fn measure(
        scene: &Path,
        controller: Option<&Cost>,
        chip: &dyn Chip,
        stop: &AtomicBool,
    ) -> Result<Self, Failure> {
        let missing = || Failure::Target(miette::miette!("{}: its controller was not measured", scene.display()));
        let controller = match controller {
            Some(known) => *known,
            None => *chip.controllers(&[scene.to_owned()], stop)?.first().ok_or_else(missing)?,
        };
        let Interrupt { instructions, cycles } = chip.interrupt(scene, stop)?;
        Ok(Self {
            instructions: instructions - controller.instructions_max as f64,
            cycles: cycles - controller.cycles_max,
        })
    }

    /// Cost of the interrupt with this controller, at this rate (Hz).
    #[must_use]
    pub fn around(&self, controller: &Cost, rate: f64) -> Load {
        let [cycles, cycles_max] = [controller.cycles, controller.cycles_max].map(|cycles| cycles + self.cycles);
        let [cpu_share, cpu_share_max] = [cycles, cycles_max].map(|cycles| cycles * rate / CLOCK);
        Load { cycles, cycles_max, cpu_share, cpu_share_max }
    }
}

/// Chip on which costs are measured.
pub trait Chip {
    /// Costs of the controllers of scene files, in their order.
    ///
    /// # Errors
    /// A controller cannot be built or run, or its result is not valid.
    fn controllers(&self, scenes: &[PathBuf], stop: &AtomicBool) -> Result<Vec<Cost>, Failure>;

    /// Longest interrupt of a tick of the firmware of a scene file.
    ///
    /// # Errors
    /// The firmware cannot be built or run.
    fn interrupt(&self, scene: &Path, stop: &AtomicBool) -> Result<Interrupt, Failure>;
}

/// The emulated chip. Its first use installs the tools that it needs.
#[derive(Clone, Copy, Debug)]
pub struct EmulatedChip;

impl Chip for EmulatedChip {
    /// Same as [`cost::measure`], but a tick that brakes, or a torque that differs from the desk's in any bit, is an error: the cost of such a tick
    /// would be meaningless.
    fn controllers(&self, scenes: &[PathBuf], stop: &AtomicBool) -> Result<Vec<Cost>, Failure> {
        let costs = cost::measure(scenes, stop, &ProgressBar::hidden())?;
        for (path, MeasuredCost { cost, fault, .. }) in scenes.iter().zip(&costs) {
            if let Some(braked) = fault {
                let fault = braked.fault().map_or_else(|| format!("fault {}", braked.code), |fault| fault.to_string());
                return Err(Failure::Target(miette::miette!(
                    "{}: tick {} braked: {fault}",
                    path.display(),
                    braked.tick
                )));
            }
            if !cost.matches_desk {
                return Err(Failure::Target(miette::miette!(
                    "{}: the chip's torques are not the desk's",
                    path.display()
                )));
            }
        }
        Ok(costs.into_iter().map(|found| found.cost).collect())
    }

    fn interrupt(&self, scene: &Path, stop: &AtomicBool) -> Result<Interrupt, Failure> {
        // Ctrl-C also stops the compiler and the emulator.
        interrupt::measure(scene)
            .map_err(|failure| if stop.load(Ordering::Relaxed) { Failure::Interrupted } else { failure })
    }
}
