//! When torque acts, and the safe action otherwise: the state machine around the controller.
//!
//! ```text
//!         home            confirm               arm           drives on, weight carried            run
//! Idle ----------> Homing -------> Idle, homed -----> Arming ----------------------> Armed ----------> Running
//!   ^                                   ^               |                             | ^                |  hold, heartbeat lost,
//!   |                                   |  disarm, hold | drive not on: Fault  disarm | |                |  no reference, stale input,
//!   | clear                             +---------------+-----------------------------+ |                |  no room to stop, out of reach
//!   |                                   +--------------------------------------------------- Holding <---+
//! Fault <------- a fault, in any state      disarm                      +-- heartbeat lost ---^  +--run--> Running
//!   ^                                                                                         |
//!   +------------------ at the rest pose ------------------ Lowering <--- no host for too long, where there is a rest pose
//! ```
//!
//! An arm whose brakes need time to engage ([`Rules::brake_delay`]) passes through `Disarming` before `Idle`, and also before the fault that is
//! raised when the host is gone.
//!
//! Torque acts in `Armed`, `Running`, `Holding` and `Lowering`, and with engaged brakes in `Disarming` and the second part of `Arming`. In
//! all other states, and already in the tick in which a fault is raised, the drives do the robot's [`SafeAction`]. This module contains no
//! hardware: the readings of a board or a simulator come in as [`Inputs`], and the commands to the drives go out as [`Output`]. The control law
//! in between is a function: [`Safety::tick`] calls it at most once, when torque may act.
//!
//! ```
//! # use dynamics_core::control::{ArmBuild, Controller};
//! # use dynamics_core::safety::{Inputs, Output, Safety};
//! # fn tick<A: ArmBuild<f32, 6>>(
//! #     safety: &mut Safety<f32, 6, A::Settings>, controller: &mut Controller<f32, 6, A>, inputs: &Inputs<f32, 6>,
//! # ) -> Output<f32, 6> {
//! safety.tick(inputs, |ask| ask.of(controller))
//! # }
//! ```
//!
//! Every rule has a number and a test; `docs/safety.md` lists them.

mod arming;
mod decision;
pub mod heat;
mod lowering;
mod machine;
mod measured;
mod memory;
mod ordinary;
mod rules;
mod stop;
mod texts;

pub use crate::control::TorqueRequest;
pub use machine::Safety;
pub use rules::{JointRules, LiveInput, Protected, Rules, SafeAction, SafetyConfiguration};

use crate::control::{Fault, LimitFlags, Reference, Sensed};

/// Request to the machine. At most one a tick; the machine accepts it, or rejects it with a reason.
///
/// From a reset to motion: `Clear` if the emergency stop was pressed, which is a fault; then `Home`, `Confirm`, `Arm`, and `Run` when the state is
/// `Armed`. In its first motion after homing the arm accepts only slow references ([`Rules::first_motion`]), until `FullRange`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Request {
    /// Any state `-> Fault`: emergency stop over the link, [`Fault::EmergencyStop`]. Always accepted.
    Stop,
    /// `Idle -> Homing`: forget the joints' zeros.
    Home,
    /// `Homing -> Idle`, homed: the joints know their zeros, and an operator has checked them.
    Confirm,
    /// `Idle -> Arming -> Armed`: switch the drives on, then hold the arm by torque where it is.
    Arm,
    /// `Armed, Holding -> Idle`, at rest only, through `Disarming` if there is a [`Rules::brake_delay`]; `Homing, Arming -> Idle`.
    Disarm,
    /// `Armed, Holding -> Running`: follow the reference, which must be where the arm is.
    Run,
    /// `Running -> Holding`: stop along the path, and stay there. `Lowering -> Holding`. `Arming -> Idle`.
    Hold,
    /// `Fault -> Idle`, if the cause of the fault is gone.
    Clear,
    /// Lifts the limits of the first motion after homing ([`Rules::first_motion`]). In `Idle`, once homed; in
    /// `Armed` and `Holding`, at rest and while no joint's torque is at its limit.
    FullRange,
}

impl Request {
    /// Rank of the request among several of one tick: the highest wins, and the first of equal ones. Stop 3, hold 2, disarm 1, all
    /// others 0.
    #[must_use]
    pub const fn rank(self) -> u8 {
        match self {
            Self::Stop => 3,
            Self::Hold => 2,
            Self::Disarm => 1,
            Self::Home | Self::Confirm | Self::Arm | Self::Run | Self::Clear | Self::FullRange => 0,
        }
    }
}

/// State of the machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// No torque: the safe action holds the arm.
    Idle,
    /// The joints find their zeros, by hand or by their own means; no torque.
    Homing,
    /// Torque holds the arm where it was armed.
    Armed,
    /// The arm follows the reference.
    Running,
    /// The arm comes to rest from the last reference, and stays there.
    Holding(HoldCause),
    /// The safe action, until the fault is cleared.
    Fault(Fault),
    /// The drives are switched on, then they take up the arm's weight, with engaged brakes.
    Arming,
    /// Without a host the arm moves to its rest pose, slowly.
    Lowering,
    /// The brakes engage, and torque holds the arm until they have.
    Disarming,
}

impl State {
    /// The stable number: idle 0, homing 1, armed 2, running 3, holding 4, fault 5, arming 6, lowering 7, disarming 8.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::Idle => 0,
            Self::Homing => 1,
            Self::Armed => 2,
            Self::Running => 3,
            Self::Holding(_) => 4,
            Self::Fault(_) => 5,
            Self::Arming => 6,
            Self::Lowering => 7,
            Self::Disarming => 8,
        }
    }

    /// True if torque acts with open brakes.
    #[must_use]
    pub const fn drives(self) -> bool {
        matches!(self, Self::Armed | Self::Running | Self::Holding(_) | Self::Lowering)
    }

    /// True if torque acts from the first tick of this state to the last, on open or on engaged brakes.
    #[must_use]
    pub const fn has_torque(self) -> bool {
        self.drives() || matches!(self, Self::Disarming)
    }

    /// True if torque acts or is about to: the arm is held by its drives, or the drives are switching on.
    #[must_use]
    pub const fn has_or_awaits_torque(self) -> bool {
        self.has_torque() || matches!(self, Self::Arming)
    }
}

/// Reason why the arm holds instead of following the reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HoldCause {
    /// On request.
    Requested,
    /// The host fell silent.
    HeartbeatLost,
    /// There was no reference for this tick.
    NoReference,
    /// This tick was the last in which the reference, or the arm, could stop before this joint's limit.
    NoRoom {
        /// Joint, counted from 0.
        joint: u8,
    },
    /// The reference was farther from this joint than allowed.
    OutOfReach {
        /// Joint, counted from 0.
        joint: u8,
    },
    /// The live inputs are older than [`Rules::live_max`].
    StaleInput,
    /// The reference of this joint was faster than allowed in the first motion after homing ([`Rules::first_motion`]).
    FirstMotion {
        /// Joint, counted from 0.
        joint: u8,
    },
}

impl HoldCause {
    /// The stable number.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::Requested => 1,
            Self::HeartbeatLost => 2,
            Self::NoReference => 3,
            Self::NoRoom { .. } => 4,
            Self::OutOfReach { .. } => 5,
            Self::StaleInput => 6,
            Self::FirstMotion { .. } => 7,
        }
    }

    /// The cause with this number, on this joint if it concerns one joint. The inverse of [`HoldCause::code`].
    #[must_use]
    pub const fn from_code(code: u8, joint: u8) -> Option<Self> {
        Some(match code {
            1 => Self::Requested,
            2 => Self::HeartbeatLost,
            3 => Self::NoReference,
            4 => Self::NoRoom { joint },
            5 => Self::OutOfReach { joint },
            6 => Self::StaleInput,
            7 => Self::FirstMotion { joint },
            _ => return None,
        })
    }
}

/// Reason for which a request is rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The request is not possible in this state.
    WrongState,
    /// A fault is in force, or was raised in this tick; for [`Request::Clear`], the fault that still has a cause.
    Fault(Fault),
    /// The arm has not been homed.
    NotHomed,
    /// A joint does not know its zero yet.
    NotZeroed,
    /// The measurement has this fault, or the first reference is NaN or infinite.
    Implausible(Fault),
    /// A joint moves faster than rest.
    NotAtRest,
    /// The host is silent.
    HeartbeatLost,
    /// There is no reference to follow.
    NoReference,
    /// The first reference, or the arm, could not stop before this joint's limit.
    NoRoom {
        /// Joint, counted from 0.
        joint: u8,
    },
    /// The first reference is not at this joint's position, or does not have its speed.
    OutOfReach {
        /// Joint, counted from 0.
        joint: u8,
    },
    /// A change of live inputs or parameters waits for this tick; the session checks it first.
    ChangePending,
    /// The scene needs this live input, and none has come since the hello.
    MissingInput(LiveInput),
    /// This live input is older than [`Rules::live_max`].
    StaleInput(LiveInput),
    /// The black box has not been read since the fault that it holds.
    Unread,
    /// The first reference of this joint is faster than allowed in the first motion after homing ([`Rules::first_motion`]).
    FirstMotion {
        /// Joint, counted from 0.
        joint: u8,
    },
}

impl Refusal {
    /// The stable number.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::WrongState => 1,
            Self::Fault(_) => 2,
            Self::NotHomed => 3,
            Self::NotZeroed => 4,
            Self::Implausible(_) => 5,
            Self::NotAtRest => 6,
            Self::HeartbeatLost => 7,
            Self::NoReference => 8,
            Self::NoRoom { .. } => 9,
            Self::OutOfReach { .. } => 10,
            Self::ChangePending => 11,
            Self::MissingInput(_) => 12,
            Self::StaleInput(_) => 13,
            Self::Unread => 14,
            Self::FirstMotion { .. } => 15,
        }
    }
}

/// Inputs of the machine in one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Inputs<S, const N: usize> {
    /// Request of this tick, if there is one.
    pub request: Option<Request>,
    /// True if the emergency stop is pressed, or its wire is broken.
    pub emergency_stop: bool,
    /// True if the tick before had not ended when this one was due, or if a watchdog reports so.
    pub overrun: bool,
    /// Ticks since the host was last heard.
    pub heartbeat_age: u32,
    /// True if every joint knows its zero; always true for absolute encoders.
    pub zeroed: bool,
    /// The sensors' reading.
    pub sensed: Sensed<S, N>,
    /// Ticks since each joint's reading was taken; 0 is fresh.
    pub age_ticks: [u32; N],
    /// True for each joint whose drive reports a fault.
    pub drive_fault: [bool; N],
    /// True for each joint whose drive has shown, after its enable frame, that it is on.
    pub on: [bool; N],
    /// True if a drive may have lost its zero since the tick before: the arm must be homed again.
    pub zero_lost: bool,
    /// Ticks since the live inputs came; `u32::MAX` if none have come since the hello.
    pub live_age: u32,
    /// Supply voltage, V, if the board measures it.
    pub supply: Option<S>,
    /// Highest temperature, degrees Celsius, if the board measures it.
    pub temperature: Option<S>,
    /// Reference of this tick; `None` when the host has not sent one.
    pub reference: Option<Reference<S, N>>,
}

impl<S: crate::Real, const N: usize> Inputs<S, N> {
    /// Nothing is known, and every field is the worst case: the emergency stop is pressed, the host is silent, no drive is on. Start from it, and replace
    /// each field that your board measures; a field that was forgotten then stops the arm. A board
    /// that does not measure them sets `supply` and `temperature` to `None`; `overrun` is set in every tick.
    #[must_use]
    pub fn unknown() -> Self {
        let unknown = S::literal(f64::NAN);
        Self {
            request: None,
            emergency_stop: true,
            overrun: true,
            heartbeat_age: u32::MAX,
            zeroed: false,
            sensed: Sensed::State { q: [unknown; N], qd: [unknown; N] },
            age_ticks: [u32::MAX; N],
            drive_fault: [true; N],
            on: [false; N],
            zero_lost: true,
            live_age: u32::MAX,
            supply: Some(unknown),
            temperature: Some(unknown),
            reference: None,
        }
    }
}

/// Action of the drives in one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
// The tag is a word. With a byte tag, copies of the rest start at odd addresses and need three times the instructions.
#[repr(u32)]
pub enum Actuation<S, const N: usize> {
    /// Drive these torques, brakes released.
    Drive {
        /// Actuator torque or force, N m or N: finite, inside its limit, and within the torque rate of the last one.
        torque: [S; N],
        /// Which limits acted on each joint.
        limits: [LimitFlags; N],
    },
    /// No torque.
    Safe(SafeAction),
    /// Switch the drives on, without torque, brakes engaged. The action is what a drive that is already on does meanwhile.
    Enable(SafeAction),
    /// Drive these torques, brakes engaged: the drives take up the arm's weight.
    Preload {
        /// As those of [`Actuation::Drive`].
        torque: [S; N],
        /// Which limits acted on each joint.
        limits: [LimitFlags; N],
    },
}

/// Outputs of the machine in one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output<S, const N: usize> {
    /// Action of the drives.
    pub actuation: Actuation<S, N>,
    /// State of the machine, with its reason.
    pub state: State,
    /// True if the joints' zeros have been confirmed and no jump has occurred since.
    pub homed: bool,
    /// Reason why the request of this tick was rejected; `None` if it was accepted or there was none.
    pub refused: Option<Refusal>,
}

impl<S, const N: usize> Output<S, N> {
    /// The output of an idle machine, not homed: before the first tick.
    #[must_use]
    pub const fn silent(action: SafeAction) -> Self {
        Self { actuation: Actuation::Safe(action), state: State::Idle, homed: false, refused: None }
    }
}
