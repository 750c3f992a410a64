//! Case of a run: a fault in a state.

use dynamics_core::Term;
use robot_compiler::SceneFile;
use serde::Serialize;

/// A temporary fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FaultKind {
    /// No fault: the behaviour of the undisturbed machine.
    Nothing,
    /// The emergency stop is pressed.
    EmergencyStop,
    /// Ticks do not end in time.
    Overrun,
    /// A drive says that it has failed.
    Drive,
    /// The supply voltage is too low, too high, NaN or infinite.
    Supply,
    /// The temperature is too low, too high, NaN or infinite.
    Temperature,
    /// A position is NaN or infinite.
    Position,
    /// A velocity is NaN, infinite, or beyond the guard.
    Velocity,
    /// A position or encoder count jumps.
    Jump,
    /// A position or encoder count stands still.
    Stuck,
    /// A position or encoder count drifts away, slower than a jump.
    Runaway,
    /// Readings are some ticks old.
    Stale,
    /// No new reading arrives.
    Missing,
    /// The host sends nothing.
    HostSilent,
    /// Trajectory points arrive too late.
    Underrun,
    /// A trajectory point is far from the one before.
    PointJump,
    /// The trajectory leads to a position limit and beyond.
    ToLimit,
    /// The trajectory is faster than the joint's velocity limit.
    TooFast,
    /// Trajectory points hold NaN, infinite or huge values.
    PointNumbers,
    /// More points arrive than the buffer holds.
    Flood,
    /// The host sends every request again and again.
    Requests,
    /// Bits are flipped on the link.
    Damaged,
    /// Packets are lost.
    Lost,
    /// Packets arrive twice.
    Doubled,
    /// Packets arrive in another order.
    Swapped,
    /// Garbage bytes arrive, and truncated packets.
    Garbage,
    /// A live input is NaN or infinite.
    LiveNumbers,
    /// A live payload of absurd mass.
    Payload,
    /// A live wrench of absurd size.
    Wrench,
    /// Live rotor inertias that are negative or absurd.
    Rotor,
    /// A live payload that could be, and is not there.
    Model,
    /// A force pushes at the tip.
    Push,
}

impl FaultKind {
    /// All faults with their display names.
    pub const NAMES: [(Self, &'static str); 32] = [
        (Self::Nothing, "nothing"),
        (Self::EmergencyStop, "emergency stop"),
        (Self::Overrun, "overrun"),
        (Self::Drive, "drive fault"),
        (Self::Supply, "supply low, high, NaN"),
        (Self::Temperature, "temperature low, high, NaN"),
        (Self::Position, "position NaN, infinite"),
        (Self::Velocity, "velocity NaN, infinite, too high"),
        (Self::Jump, "position jumps"),
        (Self::Stuck, "position stuck"),
        (Self::Runaway, "position runs away"),
        (Self::Stale, "readings old"),
        (Self::Missing, "no readings"),
        (Self::HostSilent, "host silent"),
        (Self::Underrun, "points too late"),
        (Self::PointJump, "trajectory jumps"),
        (Self::ToLimit, "trajectory to a limit"),
        (Self::TooFast, "trajectory too fast"),
        (Self::PointNumbers, "points NaN, infinite, huge"),
        (Self::Flood, "too many points"),
        (Self::Requests, "storm of requests"),
        (Self::Damaged, "link: bits flipped"),
        (Self::Lost, "link: packets lost"),
        (Self::Doubled, "link: packets doubled"),
        (Self::Swapped, "link: packets swapped"),
        (Self::Garbage, "link: garbage"),
        (Self::LiveNumbers, "live input NaN, infinite"),
        (Self::Payload, "payload of absurd mass"),
        (Self::Wrench, "wrench of absurd size"),
        (Self::Rotor, "rotors negative, absurd"),
        (Self::Model, "payload told wrongly"),
        (Self::Push, "collision"),
    ];

    /// Display name.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(kind, _)| *kind == self).map_or("", |(_, name)| name)
    }

    /// Whether the fault is possible in this scene. In a drill the host is never silent, because each measurement
    /// counts as one of its messages.
    pub(super) fn is_possible(self, scene: &SceneFile, drill: bool) -> bool {
        match self {
            Self::Position | Self::Velocity => !scene.sensors.encoder,
            Self::HostSilent => !drill,
            Self::Payload | Self::Model => matches!(scene.model.payload, Term::Live),
            Self::Wrench => matches!(scene.model.tip_wrench, Term::Live),
            Self::Rotor => matches!(scene.model.rotor, Term::Live),
            _ => true,
        }
    }

    /// Whether the fault affects packets on the link.
    pub(super) const fn is_of_the_link(self) -> bool {
        matches!(self, Self::Damaged | Self::Lost | Self::Doubled | Self::Swapped | Self::Garbage)
    }

    /// Whether the machine's measurements and model stay correct during the fault. Only then must a holding arm come to
    /// rest.
    pub(super) const fn leaves_the_loop_intact(self) -> bool {
        !matches!(
            self,
            Self::Jump
                | Self::Stuck
                | Self::Runaway
                | Self::Stale
                | Self::Missing
                | Self::Velocity
                | Self::Payload
                | Self::Wrench
                | Self::Rotor
                | Self::Model
                | Self::Push
        )
    }

    /// Shortest and longest duration, ticks.
    pub(super) const fn ticks(self) -> (u32, u32) {
        match self {
            // Longer than the machine holds without its host; the limits of the scene are added.
            Self::HostSilent => (1, 400),
            // Longer than the points sent ahead of time last.
            Self::Underrun => (20, 80),
            Self::Runaway | Self::Stuck | Self::ToLimit => (1, 300),
            _ => (1, 60),
        }
    }
}

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
    /// Armed.
    Armed,
    /// Following the scene's motion.
    Running,
    /// Braking to rest, or at rest.
    Holding,
    /// In the fault state; the cause has gone.
    Fault,
}

impl Situation {
    /// All situations with their display names.
    pub const NAMES: [(Self, &'static str); 7] = [
        (Self::Idle, "idle"),
        (Self::Homing, "homing"),
        (Self::Homed, "homed"),
        (Self::Armed, "armed"),
        (Self::Running, "running"),
        (Self::Holding, "holding"),
        (Self::Fault, "fault"),
    ];

    /// Display name.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(situation, _)| *situation == self).map_or("", |(_, name)| name)
    }

    /// Number of the machine's state.
    #[must_use]
    pub const fn state(self) -> u8 {
        match self {
            Self::Idle | Self::Homed => 0,
            Self::Homing => 1,
            Self::Armed => 2,
            Self::Running => 3,
            Self::Holding => 4,
            Self::Fault => 5,
        }
    }
}

/// A fault in a state of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Case {
    /// The fault.
    pub fault: FaultKind,
    /// State of the machine when the fault begins.
    pub situation: Situation,
}

impl Case {
    /// All cases that are possible in a scene.
    pub(super) fn of(scene: &SceneFile, drill: bool) -> Vec<Self> {
        let faults = FaultKind::NAMES.into_iter().map(|(fault, _)| fault).filter(|f| f.is_possible(scene, drill));
        faults.flat_map(|fault| Situation::NAMES.map(|(situation, _)| Self { fault, situation })).collect()
    }
}
