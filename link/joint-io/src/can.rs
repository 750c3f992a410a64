//! Actuators on up to three CAN buses.
//!
//! The schedule of a tick:
//!
//! ```text
//! tick k:    measure: empty the receivers, match replies | controller | drive: one command to each actuator
//! bus:                                                             | commands and replies ............ |  tick k+1
//! ```
//!
//! A reply answers the command of the previous tick: an actuator measures when a command arrives, and all replies have arrived before the next
//! tick begins ([`crate::bus_time`] computes the highest rate). On each bus the command with the **highest** identifier is queued first. The
//! reason is the bxCAN: while frames are pending, it takes another one only if its identifier is lower. In this order three commands fill three
//! mailboxes without waiting. If a bus has more actuators than its controller has mailboxes, [`crate::queued`] adds queues.
//!
//! Effect of the replies:
//!
//! | reply | what happens |
//! |---|---|
//! | from an actuator with an outstanding reply | accepted; its joint's measurement is fresh |
//! | two in one tick, after a tick without | both are accepted; the first one is late |
//! | none | the measurement ages by a tick; a fault after more than [`MISSING_MAX`](crate::MISSING_MAX) ticks |
//! | from one without an outstanding reply | ignored |
//! | with an unknown identifier or another length, or remote | ignored |
//! | about a setting that was not requested | ignored |
//! | a notice with an error, requested or not | the joint is at fault until a status without an error |
//!
//! ## On
//!
//! A drive counts as on ([`Readings::on`](session::readings::Readings::on)) when its replies have **confirmed** it, not when it was commanded on.
//! [`JointIo::enable`](crate::JointIo::enable) repeats the frame that enables it until then:
//!
//! | the kind's replies | confirmed by |
//! |---|---|
//! | carry the drive's state (`reports_state` of its [facts](dynamics_core::drive::DriveFacts)) | replies with state "on" in two ticks |
//! | carry no state | a reply to the frame, then a reply with the torque of a probe, a fiftieth of the frame's range |
//! | carry no state, and the frame gets a notice instead ([`Frames::NOTICES`]) | that notice, a status without an error, then the same probe |
//!
//! Two ticks are needed because a reply that arrives a tick late answers the previous frame. The brakes open only if every drive is on, has
//! replied in this tick, and gives the commanded torque.
//!
//! A drive no longer counts as on after a safe action, if the bus is off, after a silence in which it may have restarted
//! ([`MitDrive::restart_ticks`]), and from the tick in which a reply shows it off. A drive that has shown that it is on (also while it damps) and
//! then shows that it is off, without an error and without having been commanded off, has restarted. A drive of any kind also no longer counts as
//! on if its torque was less than half of the commanded torque in more than [`WEAK_MAX`] consecutive replies
//! ([`JointFaults::TORQUE`](session::readings::JointFaults::TORQUE)). Commanded torques below a fiftieth of the frame's range are not checked.
//!
//! Before a drive is enabled, its own communication timeout is read and set, if the protocol has one. If the drive does not confirm it within
//! [`TIMEOUT_TRIES`] frames, the joint is at fault.
//!
//! A drive that sends notices is switched off by [`Frames::exit`] until it confirms it. Then it gets commands without torque and gains, because only
//! a command gets a reply with its position.
//!
//! Frames are not numbered, so an actuator that always answers one tick late looks punctual after its first missing reply. The
//! bus bounds its delay: its reply must arrive before its next one.

mod bus;
mod joint;
mod joint_io;
mod limits;
mod notice;
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

pub use limits::{BUSES, TIMEOUT_TRIES, WEAK_MAX};

/// The joints on up to three buses, with drives that use the frames `F`. [`NoBus`](crate::can_bus::NoBus) stands for a bus that does not exist.
#[derive(Clone)]
pub struct CanJoints<F, A, B, C, P, const N: usize> {
    frames: PhantomData<F>,
    first: A,
    second: B,
    third: C,
    brake: P,
    drives: [MitDrive; N],
    /// Joints in the order in which their commands are queued: highest identifier first.
    order: [u8; N],
    joints: [CanJoint; N],
    brake_failed: bool,
    /// True if the last command to the brakes was to open.
    released: bool,
    /// Number of ticks in which errors are still to be cleared.
    clearing: u8,
    /// The joint with which the search for a drive's setting to read or write begins.
    next_setting: usize,
}

/// Shows the fields in which two drivers of one build may differ, without constants.
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
            .field("brake_failed", brake_failed)
            .field("released", released)
            .field("clearing", clearing)
            .field("next_setting", next_setting)
            .finish()
    }
}

impl<F: Frames, A: CanBus, B: CanBus, C: CanBus, P: OutputPin, const N: usize> CanJoints<F, A, B, C, P, N> {
    /// Creates a driver that has not sent any command. `brake` is the line that opens the brakes when high; it is driven low here.
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
            brake_failed: false,
            released: false,
            clearing: 0,
            next_setting: 0,
        };
        joints.engage_brakes();
        joints
    }

    /// Returns the buses, for a simulation at their other end.
    pub fn buses(&mut self) -> (&mut A, &mut B, &mut C) {
        (&mut self.first, &mut self.second, &mut self.third)
    }

    /// Returns the line to the brakes.
    pub fn brake(&self) -> &P {
        &self.brake
    }

    fn engage_brakes(&mut self) {
        (self.brake_failed, self.released) = (self.brake.set_low().is_err(), false);
    }

    fn release_brakes(&mut self) {
        (self.brake_failed, self.released) = (self.brake.set_high().is_err(), true);
    }

    /// Returns the communication timeouts that the drives reported, in units of [`dynamics_core::drive::TIMEOUT_UNIT_US`]; 0 if a drive has no
    /// timeout, `None` if it has not reported one.
    pub fn timeouts(&self) -> [Option<u32>; N] {
        self.joints.map(|joint| joint.timeout.value)
    }

    /// True if every drive has confirmed that it is on.
    fn all_on(&self) -> bool {
        self.joints.iter().all(|joint| joint.on)
    }
}
