//! Outcome of a run.

use super::case::Case;
use super::judge::SafetyProperty;
use serde::Serialize;

/// Effect of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// The machine entered the fault state with this code.
    Fault(u8),
    /// The machine held, with this cause.
    Held(u8),
    /// The machine did what was requested.
    Asked,
    /// The machine continued.
    Unaffected,
}

/// A run with an unsafe command, and the data to reproduce and understand it.
#[derive(Clone, Debug, Serialize)]
pub struct Counterexample {
    /// Name of the scene.
    pub scene: String,
    /// Seed of the campaign.
    pub seed: u64,
    /// Number of the run.
    pub run: u64,
    /// Tick of the unsafe command.
    pub tick: u32,
    /// The fault and the state.
    pub case: Case,
    /// The violated property; `None` if chip and desk differ.
    pub law: Option<SafetyProperty>,
    /// Description of the violation.
    pub what: String,
    /// Inputs and outputs of the machine in that tick.
    pub inputs: String,
}

/// A finished run.
#[derive(Clone, Debug)]
pub struct Finished {
    /// The fault and the state.
    pub case: Case,
    /// Effect of the fault.
    pub outcome: Outcome,
    /// Number of ticks, all of them judged.
    pub ticks: u32,
    /// Motion of the joints, for runs with drives.
    pub motion: Motion,
    /// The unsafe command that ended the run.
    pub counterexample: Option<Counterexample>,
}

/// Motion of an arm on simulated drives in a run.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion {
    /// Largest distance of a joint from its position while torque must hold it, rad or m.
    pub worst: f64,
    /// Exemptions that occurred: one bit for each of [`Exemption::NAMES`].
    pub exempt: u8,
}

/// Motion that no program can prevent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exemption {
    /// An arm without brakes falls at a joint whose drive is off or has no power.
    NoDrive = 1,
    /// A drive that receives nothing continues its last torque until its own timeout.
    Unheard = 2,
    /// A drive is off while its torque is too small for its replies to show it. The arm may leave its position by its `reach`.
    Invisible = 4,
}

impl Exemption {
    /// All exemptions with their descriptions.
    pub const NAMES: [(Self, &'static str); 3] = [
        (Self::NoDrive, "an arm without brakes falls at a drive that is off"),
        (Self::Unheard, "a drive that hears nothing gives its last torque until its own timeout"),
        (Self::Invisible, "a drive is off below the torque that its replies can show"),
    ];
}

/// Identification of a run: campaign and number.
#[derive(Clone, Copy, Debug)]
pub struct Number {
    /// Seed of the campaign.
    pub seed: u64,
    /// Number of the run.
    pub run: u64,
}
