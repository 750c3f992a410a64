//! Case of a run: a fault in a state.

use super::fault::FaultKind;
use super::target::Target;
use dynamics_core::safety::SafeAction;
use link::StateCode;
use robot_compiler::SceneFile;
use serde::Serialize;

/// State of the machine when the fault begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Situation {
    /// Idle, not homed.
    Idle,
    /// Homing.
    Homing,
    /// Idle, homed.
    Homed,
    /// The drives are being enabled. Only with simulated drives; otherwise drives are on at once.
    Arming,
    /// Armed.
    Armed,
    /// Following the scene's motion.
    Running,
    /// Decelerating to rest, or at rest.
    Holding,
    /// Moving to the rest pose, without a host. Only with simulated drives, and arms that have such a pose.
    Lowering,
    /// Held by torque until the brakes have engaged. Only with simulated drives, and arms with brakes.
    Disarming,
    /// In the fault state; the cause is no longer present.
    Fault,
}

impl Situation {
    /// All situations with their display names.
    pub const NAMES: [(Self, &'static str); 10] = [
        (Self::Idle, "idle"),
        (Self::Homing, "homing"),
        (Self::Homed, "homed"),
        (Self::Arming, "arming"),
        (Self::Armed, "armed"),
        (Self::Running, "running"),
        (Self::Holding, "holding"),
        (Self::Lowering, "lowering"),
        (Self::Disarming, "disarming"),
        (Self::Fault, "fault"),
    ];

    /// The situations of a target with their display names.
    pub fn names(target: Target) -> impl Iterator<Item = (Self, &'static str)> {
        let of = move |situation| {
            target == Target::Drives || !matches!(situation, Self::Arming | Self::Lowering | Self::Disarming)
        };
        Self::NAMES.into_iter().filter(move |(situation, _)| of(*situation))
    }

    /// Display name.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(situation, _)| *situation == self).map_or("", |(_, name)| name)
    }

    /// Number of the machine's state.
    #[must_use]
    pub const fn state(self) -> StateCode {
        match self {
            Self::Idle | Self::Homed => StateCode::Idle,
            Self::Homing => StateCode::Homing,
            Self::Arming => StateCode::Arming,
            Self::Armed => StateCode::Armed,
            Self::Running => StateCode::Running,
            Self::Holding => StateCode::Holding,
            Self::Lowering => StateCode::Lowering,
            Self::Disarming => StateCode::Disarming,
            Self::Fault => StateCode::Fault,
        }
    }

    /// True if an arm can reach this state. An arm with brakes is never lowered, because its brakes hold it when the host is lost.
    fn is_possible(self, scene: &SceneFile) -> bool {
        let brakes = scene.safety.safe_action == SafeAction::Brake;
        match self {
            Self::Lowering => scene.safety.rest.is_some() && !brakes,
            Self::Disarming => brakes && scene.safety.brake_delay > 0.0,
            _ => true,
        }
    }
}

/// Number of requests from which a pair is drawn.
pub(super) const REQUESTS: u64 = link::Request::OF_THE_MACHINE.len() as u64;

/// A fault in a state of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Case {
    /// The fault.
    pub fault: FaultKind,
    /// State of the machine when the fault begins.
    pub situation: Situation,
}

impl Case {
    /// All cases that are possible in a scene. Each has the number of its first request, if the fault is a pair of requests.
    pub(super) fn of(scene: &SceneFile, target: Target) -> Vec<(Self, u64)> {
        let faults = FaultKind::names(target).map(|(fault, _)| fault).filter(|f| f.is_possible(scene, target));
        let situations: Vec<_> =
            Situation::names(target).map(|(it, _)| it).filter(|it| it.is_possible(scene)).collect();
        let mut cases = Vec::new();
        for fault in faults {
            for first in 0..if fault == FaultKind::RequestPair { REQUESTS } else { 1 } {
                cases.extend(situations.iter().map(|&situation| (Self { fault, situation }, first)));
            }
        }
        cases
    }
}
