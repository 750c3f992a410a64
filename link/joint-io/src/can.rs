//! Actuators on up to three CAN buses.
//!
//! The schedule of a tick:
//!
//! ```text
//! tick k:    measure: empty the receivers, match replies | controller | drive: one command to each actuator
//! bus:                                                             | commands and replies ............ |  tick k+1
//! ```
//!
//! A reply answers the command of the tick before: an actuator measures when a command arrives, and everything is in
//! before the next tick begins ([`crate::bus_time`] computes the highest rate). On each bus the command with the
//! **highest** identifier is queued first: a bxCAN takes a frame into a free mailbox beside pending ones only when the
//! new one has the lower identifier, so in this order three commands fill three mailboxes without waiting. Where a bus has
//! more actuators than its controller has room for, [`crate::queued`] stands between them.
//!
//! Effect of the replies:
//!
//! | reply | what happens |
//! |---|---|
//! | from an actuator with an outstanding reply | taken; its joint's measurement is fresh |
//! | two in one tick, after a tick without | the first is counted as late, the second taken |
//! | none | counted as missing; the joint's measurement is a tick older, and at fault after [`MISSING_MAX`](crate::MISSING_MAX) of them |
//! | from one without an outstanding reply | counted as a duplicate and ignored |
//! | of an unknown identifier, of another length, remote | counted for the bus and ignored |
//! | about a setting that was not asked for | counted for the bus and ignored |
//!
//! ## On
//!
//! A drive is on when it has **shown** it ([`Readings::on`](session::readings::Readings::on)), not when it was told to be. [`JointIo::enable`](crate::JointIo::enable) repeats the frame that enables it
//! until then:
//!
//! | the kind's replies | shown by |
//! |---|---|
//! | carry the drive's state (`reports_state` of its [facts](dynamics_core::drive::DriveFacts)) | replies of two ticks after the frame whose state is on |
//! | carry none | a reply to the frame, then a reply whose torque follows a probe of a fiftieth of the frame's range |
//!
//! Two ticks, because a reply that comes a tick late answers the frame before. The brakes open only if every drive is on, has replied in this
//! tick, and gives the torque that it was told. Every safe action, a
//! bus that is off and a silence in which the drive may have restarted ([`MitDrive::restart_ticks`]) forget it, and so does a reply that shows the drive off, in its own tick. A drive
//! that has shown that it is on, also while it damps, and then shows that it is off, without an error and without having been commanded off, has restarted. A drive
//! of any kind no longer counts as on when its torque was less than half of what it was told to give, in more than [`WEAK_MAX`]
//! replies that follow each other ([`JointFaults::TORQUE`](session::readings::JointFaults::TORQUE)); below a fiftieth of the frame's range nothing is seen.
//!
//! Before a drive is enabled, its own communication timeout is read and set where the protocol has one. It is a fault of the joint if the drive
//! does not confirm it in [`TIMEOUT_TRIES`] frames.
//!
//! A frame carries no number, so an actuator that always answers one tick late looks punctual after its first miss,
//! which is counted. Its delay is bounded by the bus: its reply must come before its next one.

mod bus;
mod joint;
mod joint_io;
mod limits;
mod reply;
mod send;

use crate::can_bus::CanBus;
use crate::frames::Frames;
use bus::sending_order;
use core::fmt::Debug;
use core::marker::PhantomData;
use dynamics_core::drive::MitDrive;
use embedded_hal::digital::OutputPin;
use joint::CanJoint;

pub use limits::{BUSES, BusCounts, JointCounts, TIMEOUT_TRIES, WEAK_MAX};

/// The joints behind up to three buses, whose drives understand the frames `F`. A bus that is not there is [`NoBus`](crate::can_bus::NoBus).
#[derive(Clone)]
pub struct CanJoints<F, A, B, C, P, const N: usize> {
    frames: PhantomData<F>,
    first: A,
    second: B,
    third: C,
    brake: P,
    drives: [MitDrive; N],
    /// Joints in the order in which they are sent to: highest identifier first.
    order: [u8; N],
    joints: [CanJoint; N],
    buses: [BusCounts; BUSES],
    brake_failed: bool,
    /// The last command to the brakes was to open.
    released: bool,
    /// Ticks in which errors are still to be cleared.
    clearing: u8,
    /// The joint that is looked at first when a drive's setting is to be read or written.
    next_setting: usize,
}

/// Prints the fields in which two drivers of one build may differ, without constants.
impl<F, A: Debug, B: Debug, C: Debug, P: Debug, const N: usize> Debug for CanJoints<F, A, B, C, P, N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self {
            frames: _,
            first,
            second,
            third,
            brake,
            drives: _,
            order: _,
            joints,
            buses,
            brake_failed,
            released,
            clearing,
            next_setting,
        } = self;
        f.debug_struct("CanJoints")
            .field("first", first)
            .field("second", second)
            .field("third", third)
            .field("brake", brake)
            .field("joints", joints)
            .field("buses", buses)
            .field("brake_failed", brake_failed)
            .field("released", released)
            .field("clearing", clearing)
            .field("next_setting", next_setting)
            .finish()
    }
}

impl<F: Frames, A: CanBus, B: CanBus, C: CanBus, P: OutputPin, const N: usize> CanJoints<F, A, B, C, P, N> {
    /// Actuators without any command so far. `brake` is a line that is high to open the brakes; it is driven low here.
    pub fn new((first, second, third): (A, B, C), brake: P, drives: [MitDrive; N]) -> Self {
        let mut joints = Self {
            frames: PhantomData,
            first,
            second,
            third,
            brake,
            drives,
            order: sending_order(&drives),
            joints: [CanJoint::NEW; N],
            buses: [BusCounts::default(); BUSES],
            brake_failed: false,
            released: false,
            clearing: 0,
            next_setting: 0,
        };
        joints.engage_brakes();
        joints
    }

    /// The buses, for a simulation at their other end.
    pub fn buses(&mut self) -> (&mut A, &mut B, &mut C) {
        (&mut self.first, &mut self.second, &mut self.third)
    }

    /// The line to the brakes.
    pub fn brake(&self) -> &P {
        &self.brake
    }

    /// Errors of each joint's frames.
    pub fn joint_counts(&self) -> [JointCounts; N] {
        self.joints.map(|joint| joint.counts)
    }

    /// Errors of each bus.
    pub fn bus_counts(&self) -> [BusCounts; BUSES] {
        self.buses
    }

    fn engage_brakes(&mut self) {
        (self.brake_failed, self.released) = (self.brake.set_low().is_err(), false);
    }

    fn release_brakes(&mut self) {
        (self.brake_failed, self.released) = (self.brake.set_high().is_err(), true);
    }

    /// The drives' own error codes, as their last replies have them; 0 without an error. [`Frames::error_text`] has their text.
    pub fn drive_errors(&self) -> [u8; N] {
        self.joints.map(|joint| joint.error)
    }

    /// The drives' own communication timeouts, as they answered, in units of [`dynamics_core::drive::TIMEOUT_UNIT_US`]; 0 where a drive has none,
    /// `None` where it is not known.
    pub fn timeouts(&self) -> [Option<u32>; N] {
        self.joints.map(|joint| joint.timeout.value)
    }

    /// True if every drive has shown that it is on.
    fn all_on(&self) -> bool {
        self.joints.iter().all(|joint| joint.on)
    }
}
