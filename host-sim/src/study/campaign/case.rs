//! What a run is about: which fault in which state.

use dynamics_core::Term;
use robot_compiler::SceneFile;
use serde::Serialize;

/// What is wrong, for a while.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FaultKind {
    /// Nothing: what a machine does that nothing is done to.
    Nothing,
    /// The emergency stop is pressed.
    EmergencyStop,
    /// Ticks do not end in time.
    Overrun,
    /// A drive says that it has failed.
    Drive,
    /// The supply voltage is low, high, NaN or infinite.
    Supply,
    /// The temperature is low, high, NaN or infinite.
    Temperature,
    /// A position is NaN or infinite.
    Position,
    /// A velocity is NaN, infinite, or beyond the guard.
    Velocity,
    /// A position or encoder is somewhere else at once.
    Jump,
    /// A position or encoder stands still.
    Stuck,
    /// A position or encoder runs away, slower than a jump.
    Runaway,
    /// Readings are some ticks old.
    Stale,
    /// No reading comes any more.
    Missing,
    /// The host says nothing.
    HostSilent,
    /// Points come too late.
    Underrun,
    /// A point is far from the one before.
    PointJump,
    /// The trajectory leads to a position limit and beyond.
    ToLimit,
    /// The trajectory is faster than the joint may be.
    TooFast,
    /// Points hold NaN, infinities, huge numbers.
    PointNumbers,
    /// More points than the buffer holds.
    Flood,
    /// Every request, again and again.
    Requests,
    /// Bits flip on the link.
    Damaged,
    /// Packets are lost.
    Lost,
    /// Packets come twice.
    Doubled,
    /// Packets come in another order.
    Swapped,
    /// Bytes that are no packets, and cut ones.
    Garbage,
    /// A live input is NaN or infinite.
    LiveNumbers,
    /// A live payload of absurd mass.
    Payload,
    /// Something pushes at the tip.
    Push,
}

impl FaultKind {
    /// Each with what a person calls it.
    pub const NAMES: [(Self, &'static str); 29] = [
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
        (Self::Push, "collision"),
    ];

    /// What a person calls it.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(kind, _)| *kind == self).map_or("", |(_, name)| name)
    }

    /// Whether it can happen in this scene: on the drill's link the host is never silent, as each measurement is a word of it.
    pub(super) fn is_possible(self, scene: &SceneFile, drill: bool) -> bool {
        match self {
            Self::Position | Self::Velocity => !scene.sensors.encoder,
            Self::HostSilent => !drill,
            Self::Payload => matches!(scene.model.payload, Term::Live),
            _ => true,
        }
    }

    /// Whether packets suffer on the link.
    pub(super) const fn is_of_the_link(self) -> bool {
        matches!(self, Self::Damaged | Self::Lost | Self::Doubled | Self::Swapped | Self::Garbage)
    }

    /// Whether it leaves true what the machine measures and knows of its arm: only then must the arm stand where it holds.
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
                | Self::Push
        )
    }

    /// How many ticks it lasts, least and most.
    pub(super) const fn ticks(self) -> (u32, u32) {
        match self {
            // Longer than the machine holds without its host; those of a scene are added.
            Self::HostSilent => (1, 400),
            // Longer than the points last that the host is ahead.
            Self::Underrun => (20, 80),
            Self::Runaway | Self::Stuck | Self::ToLimit => (1, 300),
            _ => (1, 60),
        }
    }
}

/// What the machine is doing when the fault comes.
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
    /// On its way along the scene's motion.
    Running,
    /// Coming to rest, or at rest.
    Holding,
    /// In a fault, what raised it gone.
    Fault,
}

impl Situation {
    /// Each with what a person calls it.
    pub const NAMES: [(Self, &'static str); 7] = [
        (Self::Idle, "idle"),
        (Self::Homing, "homing"),
        (Self::Homed, "homed"),
        (Self::Armed, "armed"),
        (Self::Running, "running"),
        (Self::Holding, "holding"),
        (Self::Fault, "fault"),
    ];

    /// What a person calls it.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(situation, _)| *situation == self).map_or("", |(_, name)| name)
    }

    /// The number of the machine's state.
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

/// A fault in a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
pub struct Case {
    /// What is wrong.
    pub fault: FaultKind,
    /// When.
    pub situation: Situation,
}

impl Case {
    /// All that are possible in a scene.
    pub(super) fn of(scene: &SceneFile, drill: bool) -> Vec<Self> {
        let faults = FaultKind::NAMES.into_iter().map(|(fault, _)| fault).filter(|f| f.is_possible(scene, drill));
        faults.flat_map(|fault| Situation::NAMES.map(|(situation, _)| Self { fault, situation })).collect()
    }
}
