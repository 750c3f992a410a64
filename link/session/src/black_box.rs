//! Inputs and outputs of the last ticks: telemetry of this one, and a memory of those around a fault.
//!
//! A tick only copies its inputs and its output here. Frames are made of them below the priority of the tick.

use crate::supervisor::silence;
use dynamics_core::safety::{Actuation, HoldCause, Inputs, Output, SafeAction, State};
use heapless::Vec;
use link::convert::joints;
use link::{Denial, DriveFaultReport, ExtraFields, Frame, Parts, SensedLines, StateCode, Status, TickCost};

/// Ticks that are remembered.
pub const TICKS: usize = 39;

/// Ticks remembered after a tick with a fault; the others are the ticks before it.
pub const TICKS_AFTER: u8 = 8;

/// A tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record<const N: usize> {
    /// Its number.
    pub tick: u32,
    /// Frames that had been taken before it, modulo 65,536.
    pub taken: u16,
    /// Inputs of the machine.
    pub inputs: Inputs<f32, N>,
    /// Outputs of the machine.
    pub output: Output<f32, N>,
    /// Its cost.
    pub cost: Option<TickCost>,
}

impl<const N: usize> Record<N> {
    /// No tick.
    const NONE: Self = Self {
        tick: 0,
        taken: 0,
        inputs: silence(),
        output: Output {
            actuation: Actuation::Safe(SafeAction::Brake),
            state: State::Idle,
            homed: false,
            refused: None,
        },
        cost: None,
    };

    /// An idle machine before its first tick, whose drives do the safe action.
    pub(crate) const fn safe(action: SafeAction) -> Self {
        let Self { output, .. } = Self::NONE;
        Self { output: Output { actuation: Actuation::Safe(action), ..output }, ..Self::NONE }
    }

    /// Status frame with these parts, and what stands beside the record.
    #[must_use]
    pub fn status(&self, parts: Parts, beside: &LiveContext<N>) -> Status {
        let Output { actuation, state, homed, refused } = &self.output;
        let (cause, joint) = cause(*state);
        let asked = |part| parts.contains(part);
        Status {
            tick: self.tick,
            taken: self.taken,
            state: StateCode::new(*state),
            cause,
            joint,
            homed: *homed,
            refused: refused.map(Denial::new),
            kept: beside.kept,
            room: beside.room,
            actuation: asked(Parts::TORQUE).then(|| link::Actuation::new(actuation)),
            sensed: asked(Parts::SENSED).then(|| sensed(&self.inputs)),
            extra: self.extra(parts, beside),
            cost: self.cost.filter(|_| asked(Parts::COST)),
        }
    }

    fn extra(&self, parts: Parts, beside: &LiveContext<N>) -> ExtraFields {
        let asked = |part| parts.contains(part);
        match (beside.drive_fault, &beside.external, &self.inputs.reference) {
            (Some(drive_fault), ..) if asked(Parts::SENSED) => ExtraFields::DriveFault(drive_fault),
            (_, Some(external), _) => ExtraFields::External(joints(external)),
            (.., Some(reference)) if asked(Parts::REFERENCE) => ExtraFields::Reference(link::Reference::new(reference)),
            _ => ExtraFields::Nothing,
        }
    }
}

/// Reason for the machine's state: the number of the fault or of the cause to hold, and the joint that caused it.
fn cause(state: State) -> (u8, Option<u8>) {
    match state {
        State::Fault(fault) => (fault.code(), fault.joint()),
        State::Holding(cause) => match cause {
            HoldCause::NoRoom { joint } | HoldCause::OutOfReach { joint } | HoldCause::FirstMotion { joint } => {
                (cause.code(), Some(joint))
            }
            HoldCause::Requested | HoldCause::HeartbeatLost | HoldCause::NoReference | HoldCause::StaleInput => {
                (cause.code(), None)
            }
        },
        State::Idle
        | State::Homing
        | State::Armed
        | State::Running
        | State::Arming
        | State::Lowering
        | State::Disarming => (0, None),
    }
}

/// Readings and lines of a board.
fn sensed<const N: usize>(inputs: &Inputs<f32, N>) -> SensedLines {
    let bits = |joints: &[bool; N]| joints.iter().rev().fold(0, |bits, &joint| bits << 1 | u8::from(joint));
    SensedLines {
        sensed: link::Sensed::new(&inputs.sensed),
        age_ticks: joints(&inputs.age_ticks.map(|age| u16::try_from(age).unwrap_or(u16::MAX))),
        lines: link::Lines {
            emergency_stop: inputs.emergency_stop,
            overrun: inputs.overrun,
            zeroed: inputs.zeroed,
            drive_fault: bits(&inputs.drive_fault),
            on: bits(&inputs.on),
            zero_lost: inputs.zero_lost,
            supply: inputs.supply,
            temperature: inputs.temperature,
        },
    }
}

/// Parts of a status that are of now, and of no record.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiveContext<const N: usize> {
    /// The black box holds a fault.
    pub kept: bool,
    /// Points that the trajectory has room for.
    pub room: u8,
    /// Report of the first joint with a fault.
    pub drive_fault: Option<DriveFaultReport>,
    /// Torque from outside on each joint, N m or N, where it is asked for and estimated.
    pub external: Option<[f32; N]>,
}

impl<const N: usize> LiveContext<N> {
    /// Nothing.
    pub(crate) const NONE: Self = Self { kept: false, room: 0, drive_fault: None, external: None };
}

/// Report of ticks. Made under the lock of the tick by copying; [`Report::frame`] does the rest.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "made and taken apart at once, where there is nothing to allocate from")]
pub enum Report<const N: usize> {
    /// The answer of a bench tick.
    Answer(Frame),
    /// A tick, these parts of it, and what stands beside its record.
    Tick(Record<N>, Parts, LiveContext<N>),
    /// A tick of the black box; `None` behind the last.
    Past(Option<Record<N>>),
}

impl<const N: usize> Report<N> {
    /// Frame of this report. A function of its own on a chip: what it moves is off the stack when the frame is packed.
    #[must_use]
    #[inline(never)]
    pub fn frame(self) -> Frame {
        match self {
            Self::Answer(frame) => frame,
            Self::Tick(record, parts, beside) => Frame::Status(record.status(parts, &beside)),
            Self::Past(record) => Frame::Past(record.map(|record| record.status(Parts::ALL, &LiveContext::NONE))),
        }
    }
}

/// A ring of the last ticks. It stops a few ticks after a fault, and holds these until the host has read and released them: by
/// [`link::Request::Release`], or by clearing the fault after a complete reading. A hello changes nothing about it.
#[derive(Clone, Debug)]
pub struct BlackBox<const N: usize> {
    /// One place more than the remembered ticks: the current tick is written there while the others are frozen.
    ring: Vec<Record<N>, { TICKS + 1 }>,
    /// Place of the current tick.
    now: usize,
    /// Number of records, the current one included.
    length: usize,
    /// Ticks still to be remembered after a fault; `None` where no fault is held.
    left: Option<u8>,
    /// All of a held fault has been read.
    read: bool,
    /// A reading has begun after the ring had stopped.
    reads: bool,
    /// The fault in force has been released already.
    known: bool,
}

impl<const N: usize> BlackBox<N> {
    /// Empty.
    #[must_use]
    pub const fn new() -> Self {
        Self { ring: Vec::new(), now: 0, length: 0, left: None, read: false, reads: false, known: false }
    }

    /// Fill the ring with ticks that never were, once, at the start: no tick does it then.
    pub fn prepare(&mut self) {
        while self.ring.push(Record::NONE).is_ok() {}
    }

    /// A new session: forget everything, but for a fault that is held, or will be: that of the last tick, which the next would have found,
    /// and one that the next tick raises though it comes from before, which is `pending`.
    pub fn restart(&mut self, pending: bool) {
        self.reads = false;
        let failed = self.length > 0 && !self.known && matches!(self.now().output.state, State::Fault(_));
        match &mut self.left {
            // The last tick before the hello stays; one more is written after it.
            Some(left) => *left = (*left).min(2),
            None if failed => self.left = Some(2),
            None if pending => {}
            None => (self.now, self.length) = (0, 0),
        }
        self.known = false;
    }

    /// True if a fault is held: no new ticks are remembered until [`BlackBox::release`].
    #[must_use]
    pub fn keeps(&self) -> bool {
        self.left.is_some()
    }

    /// True if all of a held fault has been read.
    #[must_use]
    pub fn is_read(&self) -> bool {
        self.read
    }

    /// Go on recording. Returns false, and changes nothing, if a fault is held that has not been read completely.
    pub fn release(&mut self) -> bool {
        if self.keeps() && !self.read {
            return false;
        }
        self.known = self.keeps();
        (self.left, self.read, self.reads) = (None, false, false);
        true
    }

    /// Note that the tick at this place has been read, or that there are no more.
    pub fn read(&mut self, place: usize, end: bool) {
        if place == 0 {
            self.reads = self.left == Some(0);
        }
        self.read |= self.reads && end;
    }

    /// The current tick; call [`BlackBox::begin`] first.
    #[inline]
    #[must_use]
    pub fn now(&self) -> &Record<N> {
        match self.ring.get(self.now) {
            Some(record) => record,
            None => const { &Record::NONE },
        }
    }

    /// Room for the current tick, behind one that ended in this state; `None` before [`BlackBox::prepare`]. The one before is remembered,
    /// unless the ring is frozen.
    #[inline]
    pub fn begin(&mut self, before: State) -> Option<&mut Record<N>> {
        let fails = matches!(before, State::Fault(_));
        // In nearly every tick there is no fault to remember.
        let still = if fails || self.known || self.left.is_some() { self.holds(fails) } else { false };
        if !still {
            self.now = if self.length > 0 && self.now < TICKS { self.now + 1 } else { 0 };
            self.length = (self.length + 1).min(TICKS + 1);
        }
        self.ring.get_mut(self.now)
    }

    /// Counts the ticks after a fault. True if the ring is frozen. `fails`: the tick before ended in a fault.
    #[cold]
    #[inline(never)]
    fn holds(&mut self, fails: bool) -> bool {
        let still = match &mut self.left {
            Some(0) => true,
            Some(left) => {
                *left -= 1;
                *left == 0
            }
            left if fails && !self.known => {
                *left = Some(TICKS_AFTER + 1);
                false
            }
            _ => false,
        };
        self.known &= fails;
        still
    }

    /// The remembered tick at this place, the oldest at 0, without the current one; `None` behind the last.
    #[must_use]
    pub fn get(&self, place: usize) -> Option<&Record<N>> {
        let remembered = self.length.checked_sub(1)?;
        if place >= remembered {
            return None;
        }
        self.ring.get((self.now + TICKS + 1 - remembered + place) % (TICKS + 1))
    }
}

impl<const N: usize> Default for BlackBox<N> {
    fn default() -> Self {
        Self::new()
    }
}
