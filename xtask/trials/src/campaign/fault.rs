//! Temporary faults, their names and durations.

use super::target::Target;
use actuator_model::bus::{CommandFate, Fate};
use actuator_model::frame::Order;
use core::fmt::Debug;
use dynamics_core::Term;
use robot_compiler::SceneFile;
use serde::{Serialize, Serializer};

/// A temporary fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FaultKind {
    /// No fault: the behaviour of the undisturbed machine.
    Nothing,
    /// The emergency stop is pressed.
    EmergencyStop,
    /// Ticks do not finish in time.
    Overrun,
    /// A drive reports a failure.
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
    /// A position or encoder count does not change.
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
    /// A trajectory point is far from the previous one.
    PointJump,
    /// The trajectory leads to a position limit and beyond.
    ToLimit,
    /// The trajectory is faster than the joint's velocity limit.
    TooFast,
    /// Trajectory points contain NaN, infinite or huge values.
    PointNumbers,
    /// More points arrive than the buffer holds.
    Flood,
    /// The host repeats every request.
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
    /// A live payload has an absurd mass.
    Payload,
    /// A live wrench has an absurd size.
    Wrench,
    /// Live rotor inertias are negative or absurd.
    Rotor,
    /// A plausible live payload that the arm does not carry.
    Model,
    /// A force pushes at the tip.
    Push,
    /// Frames of this kind to a drive, or to all drives, have this fate.
    Command(
        #[serde(serialize_with = "in_small_letters")] Order,
        #[serde(serialize_with = "in_small_letters")] CommandFate,
    ),
    /// All frames to all drives are lost.
    Burst,
    /// The board's frames on a bus are not acknowledged.
    Unacknowledged,
    /// The board's controller has left a bus.
    BusOff,
    /// Replies of a drive have this fate; no reading gets older than `age_max`.
    Reply(#[serde(serialize_with = "in_small_letters")] Fate),
    /// Replies of a drive are lost for longer than `age_max`.
    ReplyGap,
    /// A drive has no power, for a time shorter or longer than its restart.
    Power(Span),
    /// No drive has power, for a time shorter or longer than their restart.
    PowerOfAll(Span),
    /// The emergency stop is pressed and cuts the power of all drives.
    PowerCut,
    /// A drive acknowledges its enable frame, and stays off.
    EnableIgnored,
    /// A drive switches off without reporting an error.
    Trip,
    /// A drive latches an error.
    Latched,
    /// Another program sets the zero of a drive.
    Zero,
    /// Two requests in one tick.
    RequestPair,
    /// The host stops for the rest of the run.
    HostGone,
}

/// Length of a loss of power.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Span {
    /// At most the shortest restart of a drive.
    Short,
    /// Longer than the shortest restart of a drive.
    Long,
}

fn in_small_letters<T: Debug, S: Serializer>(it: &T, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&format!("{it:?}").to_lowercase())
}

/// Names of one kind of frame with each of its fates.
macro_rules! commands {
    ($($order:ident $name:literal),*) => {
        [$(
            (FaultKind::Command(Order::$order, CommandFate::Lost), concat!($name, " lost")),
            (FaultKind::Command(Order::$order, CommandFate::Late), concat!($name, " late")),
            (FaultKind::Command(Order::$order, CommandFate::Refused), concat!($name, " refused by the transmitter")),
            (FaultKind::Command(Order::$order, CommandFate::Twice), concat!($name, " doubled")),
        )*]
    };
}

const COMMANDS: [(FaultKind, &str); 20] = commands![
    Enable "enable frame", Disable "disable frame", Clear "clear frame", Setting "timeout frame", Torque "torque frame"
];

const ON_BUSES: [(FaultKind, &str); 19] = [
    (FaultKind::Burst, "all frames lost"),
    (FaultKind::Unacknowledged, "bus without acknowledgement"),
    (FaultKind::BusOff, "bus off"),
    (FaultKind::Reply(Fate::Lost), "replies lost, up to `age_max`"),
    (FaultKind::ReplyGap, "replies lost, beyond `age_max`"),
    (FaultKind::Reply(Fate::Late), "replies late"),
    (FaultKind::Reply(Fate::Twice), "replies doubled"),
    (FaultKind::Power(Span::Short), "a drive without power, briefly"),
    (FaultKind::Power(Span::Long), "a drive without power"),
    (FaultKind::PowerOfAll(Span::Short), "all drives without power, briefly"),
    (FaultKind::PowerOfAll(Span::Long), "all drives without power"),
    (FaultKind::PowerCut, "emergency stop that cuts the power"),
    (FaultKind::EnableIgnored, "a drive ignores its enable frame"),
    (FaultKind::Trip, "a drive goes off by itself"),
    (FaultKind::Latched, "a drive latches an error"),
    (FaultKind::Zero, "a drive's zero set by a stranger"),
    (FaultKind::RequestPair, "two requests in a tick"),
    (FaultKind::HostSilent, "host silent for a while"),
    (FaultKind::HostGone, "host gone for good"),
];

const UNDISTURBED: [(FaultKind, &str); 3] =
    [(FaultKind::Nothing, "nothing"), (FaultKind::EmergencyStop, "emergency stop"), (FaultKind::Overrun, "overrun")];

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

    /// All faults of a target with their display names.
    pub fn names(target: Target) -> impl Iterator<Item = (Self, &'static str)> {
        let (plain, on_buses): (&[_], [&[_]; 3]) = match target {
            Target::Drives => (&[], [&UNDISTURBED, &COMMANDS, &ON_BUSES]),
            Target::Desk | Target::Qemu => (&Self::NAMES, [&[]; 3]),
        };
        plain.iter().chain(on_buses.into_iter().flatten()).copied()
    }

    /// Display name.
    #[must_use]
    pub fn name(self) -> &'static str {
        let mut all = Self::NAMES.iter().chain(&COMMANDS).chain(&ON_BUSES);
        all.find(|(kind, _)| *kind == self).map_or("", |(_, name)| name)
    }

    /// True if the fault is possible in this scene. In a dry run the host is never silent, because each measurement
    /// counts as one of its messages.
    pub(super) fn is_possible(self, scene: &SceneFile, target: Target) -> bool {
        let dry_run = target == Target::Qemu;
        match self {
            Self::Position | Self::Velocity => !scene.sensors.encoder,
            Self::HostSilent => !dry_run,
            Self::Payload | Self::Model => matches!(scene.model.payload, Term::Live),
            Self::Wrench => matches!(scene.model.tip_wrench, Term::Live),
            Self::Rotor => matches!(scene.model.rotor, Term::Live),
            _ => true,
        }
    }

    /// True if the fault affects packets on the link.
    pub(super) const fn is_of_the_link(self) -> bool {
        matches!(self, Self::Damaged | Self::Lost | Self::Doubled | Self::Swapped | Self::Garbage)
    }

    /// True if the machine's measurements and model stay correct during the fault. Only then must a holding arm come to
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
            // Longer than the machine holds without its host. The limits of the scene are added.
            Self::HostSilent => (1, 400),
            // Longer than the points that were sent in advance last.
            Self::Underrun => (20, 80),
            Self::Runaway | Self::Stuck | Self::ToLimit => (1, 300),
            // Longer than the drives' own timeouts.
            Self::Burst
            | Self::Unacknowledged
            | Self::BusOff
            | Self::PowerCut
            | Self::Command(..)
            | Self::EnableIgnored => (1, 150),
            Self::Power(Span::Short) | Self::PowerOfAll(Span::Short) => (1, 9),
            Self::Power(Span::Long) | Self::PowerOfAll(Span::Long) => (11, 400),
            _ => (1, 60),
        }
    }
}
