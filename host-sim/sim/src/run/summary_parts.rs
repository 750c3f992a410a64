//! Parts of a run's summary: its setting, its limits and its faults.

use crate::run::record::Record;
use dynamics_core::control::LimitFlags;
use serde::Serialize;

/// Scene, robot, target and settings of a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Setting {
    /// The scene's name.
    pub scene: String,
    /// The robot's name.
    pub robot: String,
    /// Target that computed the torques: `desk` or `qemu`.
    pub target: String,
    /// `f32` or `f64`.
    pub scalar: String,
    /// The control law.
    pub law: String,
    /// Method for sine and cosine.
    pub trig: String,
    /// Interval of the ticks in which the model is evaluated; `None` if it is evaluated in all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model: Option<ModelTicks>,
    /// Control period, s.
    pub period: f64,
    /// Simulated drives; `None` if they are ideal.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drives: Option<SimulatedDrives>,
}

/// Drives that a run simulates.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SimulatedDrives {
    /// Their kind, as in the robot file.
    pub kind: &'static str,
    /// Rate of their own loop, Hz.
    pub loop_rate: f64,
    /// Their action after a fault.
    #[serde(skip)]
    pub after_fault: &'static str,
}

/// The ticks in which a model is evaluated.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModelTicks {
    /// Number of ticks from one evaluation to the next.
    pub every: u32,
    /// Model torque in the ticks between: `hold` or `extrapolate`.
    pub between: String,
}

/// Ticks in which each limit acted on a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Serialize)]
pub struct LimitCounts {
    /// The reference was held at a position limit.
    pub position: u64,
    /// The reference was held at the velocity limit.
    pub velocity: u64,
    /// The torque was held at its limit.
    pub torque: u64,
    /// The change of torque was held at its limit.
    pub torque_rate: u64,
    /// The reference was not followed, because of a collision that this joint detected.
    #[serde(skip_serializing_if = "is_zero")]
    pub collision: u64,
}

/// True if the count is zero and may be left out.
pub(super) fn is_zero(count: &u64) -> bool {
    *count == 0
}

impl LimitCounts {
    pub(super) fn describe(&self) -> String {
        let named = [
            ("position", self.position),
            ("velocity", self.velocity),
            ("torque", self.torque),
            ("torque rate", self.torque_rate),
            ("collision", self.collision),
        ];
        let acted: Vec<String> = named.iter().filter(|(_, n)| *n > 0).map(|(name, n)| format!("{name} {n}")).collect();
        if acted.is_empty() { "none".to_owned() } else { acted.join(", ") }
    }
}

pub(super) fn count_limits(record: &Record, joint: usize) -> LimitCounts {
    let count = |flag| record.joint(joint).filter(|s| s.limits.contains(flag)).count() as u64;
    LimitCounts {
        position: count(LimitFlags::POSITION),
        velocity: count(LimitFlags::VELOCITY),
        torque: count(LimitFlags::TORQUE),
        torque_rate: count(LimitFlags::TORQUE_RATE),
        collision: count(LimitFlags::COLLISION),
    }
}

/// A fault and the tick in which it occurred.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FaultEvent {
    /// Tick, counted from 0.
    pub tick: usize,
    /// The fault's stable number.
    pub code: u8,
    /// Joint, counted from 1, if the fault belongs to one joint.
    pub joint: Option<u8>,
    /// Description of the fault.
    pub message: String,
}

/// Each tick in which a new fault occurred.
pub(super) fn fault_events(record: &Record) -> Vec<FaultEvent> {
    let mut last = None;
    let mut events = Vec::new();
    for (tick, fault) in record.faults().iter().enumerate() {
        if let Some(new) = fault.filter(|_| *fault != last) {
            let joint = new.joint().map(|joint| joint + 1);
            events.push(FaultEvent { tick, code: new.code(), joint, message: new.to_string() });
        }
        last = *fault;
    }
    events
}

/// Fewest and most instructions in a tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Instructions {
    /// Fewest.
    pub min: u64,
    /// Most.
    pub max: u64,
}
