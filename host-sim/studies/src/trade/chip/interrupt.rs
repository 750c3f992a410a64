//! Measurement of a whole tick interrupt with the safety state machine, as the firmware runs it in the emulated chip.

use super::task::run_interrupt;
use miette::IntoDiagnostic as _;
use serde::{Deserialize, Serialize};
use sim::failure::Failure;
use std::path::Path;

/// Longest interrupt of a firmware's supervised ticks. It includes readings, trajectory, safety state machine, controller, black box, outputs, and
/// the handler's entry and exit code, but not the core's automatic stacking of registers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Interrupt {
    /// Instructions.
    pub instructions: f64,
    /// Cycles from flash: an estimate.
    pub cycles: f64,
}

/// Measures the interrupt of a scene's firmware over a few ticks of a running arm. Installs missing tools.
///
/// # Errors
/// [`Failure::Target`], with the scene, if its firmware cannot be built or run.
pub fn measure(scene: &Path) -> Result<Interrupt, Failure> {
    let said = run_interrupt(scene).map_err(|error| Failure::Target(miette::Report::from_err(error)))?;
    let Traced { running: Running { instructions, cycles: Estimate { likely } } } =
        serde_json::from_str(&said).into_diagnostic().map_err(Failure::Target)?;
    Ok(Interrupt { instructions: instructions as f64, cycles: likely as f64 })
}

/// The answer of `cargo xtask firmware interrupt`.
#[derive(Deserialize)]
struct Traced {
    running: Running,
}

#[derive(Deserialize)]
struct Running {
    instructions: u64,
    cycles: Estimate,
}

#[derive(Deserialize)]
struct Estimate {
    likely: u64,
}
