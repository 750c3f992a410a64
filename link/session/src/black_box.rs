//! Inputs and outputs of the last ticks: telemetry of the current tick, and a record of the ticks around a fault.
//!
//! A tick only writes its inputs and output here. Frames are made from them later, at a lower priority than the tick's.

use crate::supervisor::silence;
use dynamics_core::safety::{Actuation, HoldCause, Inputs, Output, SafeAction, State};
use heapless::Vec;
use link::convert::joints;
use link::{Denial, DriveFaultReport, ExtraFields, Frame, Parts, SensedLines, StateCode, Status, TickCost};

/// Number of ticks that are remembered.
pub const TICKS: usize = 39;

/// Number of ticks remembered after a tick with a fault; the others are the ticks before it.
pub const TICKS_AFTER: u8 = 8;

/// Record of a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record<const N: usize> {
    /// Number of the tick.
    pub tick: u32,
    /// Number of frames received before it, including lost ones, modulo 65,536.
    pub taken: u16,
    /// Inputs of the safety state machine.
    pub inputs: Inputs<f32, N>,
    /// Outputs of the safety state machine.
    pub output: Output<f32, N>,
    /// Cost of the tick, if it can be counted exactly.
    pub cost: Option<TickCost>,
}

impl<const N: usize> Record<N> {
    /// The record of no tick.
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

    /// Record of an idle machine before its first tick; the drives perform the safe action.
    pub(crate) const fn safe(action: SafeAction) -> Self {
        let Self { output, .. } = Self::NONE;
        Self { output: Output { actuation: Actuation::Safe(action), ..output }, ..Self::NONE }
    }

    /// Creates the status frame with these parts; `beside` holds the fields that are not recorded.
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

/// Reason for the machine's state: the code of the fault or of the cause of holding, and the joint that caused it.
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

/// Status fields that are sampled when the status is sent, and are not recorded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiveContext<const N: usize> {
    /// True if the black box keeps a fault.
    pub kept: bool,
    /// Number of points that the trajectory buffer can still take.
    pub room: u8,
    /// Report of the first joint with a fault.
    pub drive_fault: Option<DriveFaultReport>,
    /// External torque or force on each joint, N m or N, if it is requested and estimated.
    pub external: Option<[f32; N]>,
}

impl<const N: usize> LiveContext<N> {
    /// All fields empty.
    pub(crate) const NONE: Self = Self { kept: false, room: 0, drive_fault: None, external: None };
}

/// A report to be sent. Copied from the session while the tick is locked out; [`Report::frame`] then makes the frame without the lock.
#[derive(Clone, Debug, PartialEq)]
// The tag is a word, and no record is optional: with a byte of the record as tag, the rest would be copied from an odd address.
#[repr(u32)]
#[allow(clippy::large_enum_variant, reason = "made and taken apart at once, where there is nothing to allocate from")]
pub enum Report<const N: usize> {
    /// A frame that is ready to be sent: the answer of a bench tick, a verdict, or the answer to a change.
    Answer(Frame),
    /// A tick, the parts of it to send, and the fields that are not recorded.
    Tick(Record<N>, Parts, LiveContext<N>),
    /// A tick of the black box.
    Past(Record<N>),
    /// The end of the black box.
    End,
}

impl<const N: usize> Report<N> {
    /// Creates the frame of this report. Not inlined, so that its temporaries have left the stack when the frame is packed.
    #[must_use]
    #[inline(never)]
    pub fn frame(self) -> Frame {
        match self {
            Self::Answer(frame) => frame,
            Self::Tick(record, parts, beside) => Frame::Status(record.status(parts, &beside)),
            Self::Past(record) => Frame::Past(Some(record.status(Parts::ALL, &LiveContext::NONE))),
            Self::End => Frame::Past(None),
        }
    }
}

/// A ring buffer of the last ticks. It stops a few ticks after a fault and keeps the ticks around it until the host has read and released them:
/// by [`link::Request::Release`], or by clearing the fault after a complete reading. A hello does not release them.
#[derive(Clone, Debug)]
pub struct BlackBox<const N: usize> {
    /// One entry more than the remembered ticks: the current tick is written there while the others are frozen.
    ring: Vec<Record<N>, { TICKS + 1 }>,
    /// Index of the current tick.
    now: usize,
    /// Number of records, the current one included.
    length: usize,
    /// Number of ticks still to be remembered after a fault; `None` if no fault is kept.
    left: Option<u8>,
    /// True if all ticks around a kept fault have been read.
    read: bool,
    /// True if a reading has begun after the ring stopped.
    reads: bool,
    /// True if the fault in force has been released already.
    known: bool,
}

impl<const N: usize> BlackBox<N> {
    /// Creates an empty black box.
    #[must_use]
    pub const fn new() -> Self {
        Self { ring: Vec::new(), now: 0, length: 0, left: None, read: false, reads: false, known: false }
    }

    /// Fills the ring with empty records. Call it once at the start, so that no tick has to.
    pub fn prepare(&mut self) {
        while self.ring.push(Record::NONE).is_ok() {}
    }

    /// Starts a new session. Deletes everything, unless a fault is kept or is about to be. That is a fault of the last tick, which the next tick
    /// would have found, or a fault from before that the next tick will raise (`pending`).
    pub fn restart(&mut self, pending: bool) {
        self.reads = false;
        let failed = self.length > 0 && !self.known && matches!(self.now().output.state, State::Fault(_));
        match &mut self.left {
            // The last tick before the hello is kept; one more is written after it.
            Some(left) => *left = (*left).min(2),
            None if failed => self.left = Some(2),
            None if pending => {}
            None => (self.now, self.length) = (0, 0),
        }
        self.known = false;
    }

    /// True if a fault is kept: after [`TICKS_AFTER`] more ticks, none is remembered until [`BlackBox::release`].
    #[must_use]
    pub fn keeps(&self) -> bool {
        self.left.is_some()
    }

    /// True if all ticks around a kept fault have been read.
    #[must_use]
    pub fn is_read(&self) -> bool {
        self.read
    }

    /// Resumes recording. Returns false and changes nothing if a fault is kept that has not been read completely.
    pub fn release(&mut self) -> bool {
        if self.keeps() && !self.read {
            return false;
        }
        self.known = self.keeps();
        (self.left, self.read, self.reads) = (None, false, false);
        true
    }

    /// Records that the tick at index `place` has been read, or, with `end`, that there are no more.
    pub fn read(&mut self, place: usize, end: bool) {
        if place == 0 {
            self.reads = self.left == Some(0);
        }
        self.read |= self.reads && end;
    }

    /// Returns the current tick. Call [`BlackBox::begin`] first.
    #[inline]
    #[must_use]
    pub fn now(&self) -> &Record<N> {
        match self.ring.get(self.now) {
            Some(record) => record,
            None => const { &Record::NONE },
        }
    }

    /// Returns the record to write the current tick to; `None` before [`BlackBox::prepare`]. `before` is the state in which the previous tick
    /// ended. The previous tick is remembered, unless the ring is frozen.
    #[inline]
    pub fn begin(&mut self, before: State) -> Option<&mut Record<N>> {
        let fails = matches!(before, State::Fault(_));
        // In nearly every tick there is no fault to keep.
        let still = if fails || self.known || self.left.is_some() { self.holds(fails) } else { false };
        if !still {
            self.now = if self.length > 0 && self.now < TICKS { self.now + 1 } else { 0 };
            self.length = (self.length + 1).min(TICKS + 1);
        }
        self.ring.get_mut(self.now)
    }

    /// Counts the ticks after a fault. Returns true if the ring is frozen. `fails`: the previous tick ended in a fault.
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

    /// Returns the remembered tick at index `place`; the oldest is 0. The current tick does not count. `None` after the last.
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
