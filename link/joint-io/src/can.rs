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
//! | none | counted as missing; the joint's measurement is a tick older, and at fault after [`MISSING_MAX`] of them |
//! | from one without an outstanding reply | counted as a duplicate and ignored |
//! | of an unknown identifier, of another length, remote | counted for the bus and ignored |
//!
//! A frame carries no number, so an actuator that always answers one tick late looks punctual after its first miss,
//! which is counted. Its delay is bounded by the bus: its reply must come before its next one.

use crate::frames::{Frames, Packet};
use crate::mit::{Reply, Setpoint};
use crate::{JointIo, MISSING_MAX, higher};
use core::marker::PhantomData;
use dynamics_core::control::{Sensed, Spring};
use dynamics_core::drive::MitDrive;
use dynamics_core::safety::SafeAction;
use embedded_can::nb::Can;
use embedded_can::{ErrorKind, Frame, Id};
use embedded_hal::digital::OutputPin;
use session::readings::{JointFaults, Readings};

/// Buses, at most.
pub const BUSES: usize = 3;

/// Frames taken from one bus in one tick, at most: [`crate::queued`] and its controller hold eleven, a bxCAN six, and
/// more arrive only while these are read.
const RECEIVED_MAX: u32 = 16;

/// Polls of a full transmitter before a command is given up.
const TRANSMIT_POLLS: u32 = 16;

/// Most outstanding replies: this tick's and the one before.
const OWED_MAX: u8 = 2;

/// Replies in which a drive that was switched on may say that it is off, before it is at fault: it may need some ms to switch on.
const OFF_MAX: u8 = 10;

/// Functions of a bus that the schedule needs, beside sending and receiving.
pub trait CanBus: Can {
    /// Whether the controller has left the bus after too many errors. Bringing it back is the board's work (a bxCAN does it
    /// by itself once told to).
    fn is_off(&mut self) -> bool;

    /// Abandon all unsent frames: a torque of the tick before must not go out after this tick's.
    fn abandon(&mut self);

    /// The controller's interrupt. Nothing to do where it holds all frames of a tick.
    fn interrupt(&mut self) {}
}

/// A bus that a board does not have: it takes no frame, and none comes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NoBus;

/// A frame that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoFrame {}

impl Frame for NoFrame {
    fn new(_: impl Into<Id>, _: &[u8]) -> Option<Self> {
        None
    }

    fn new_remote(_: impl Into<Id>, _: usize) -> Option<Self> {
        None
    }

    fn is_extended(&self) -> bool {
        match *self {}
    }

    fn is_remote_frame(&self) -> bool {
        match *self {}
    }

    fn id(&self) -> Id {
        match *self {}
    }

    fn dlc(&self) -> usize {
        match *self {}
    }

    fn data(&self) -> &[u8] {
        match *self {}
    }
}

impl Can for NoBus {
    type Frame = NoFrame;
    type Error = ErrorKind;

    fn transmit(&mut self, frame: &NoFrame) -> nb::Result<Option<NoFrame>, ErrorKind> {
        match *frame {}
    }

    fn receive(&mut self) -> nb::Result<NoFrame, ErrorKind> {
        Err(nb::Error::WouldBlock)
    }
}

impl CanBus for NoBus {
    fn is_off(&mut self) -> bool {
        false
    }

    fn abandon(&mut self) {}
}

/// Errors of a joint's frames; every count wraps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct JointCounts {
    /// Ticks in which a reply was due and none came.
    pub missing: u16,
    /// Replies that came a tick late.
    pub late: u16,
    /// Replies to no command.
    pub duplicate: u16,
    /// Torques that were NaN or infinite, and were sent as no torque.
    pub refused: u16,
    /// Commands that found no room in the transmitter, or were pushed out of it.
    pub unsent: u16,
}

/// Errors of a bus; every count wraps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BusCounts {
    /// Frames of identifiers that belong to no reply.
    pub foreign: u32,
    /// Replies of another length, from no actuator of ours, or remote requests.
    pub malformed: u32,
    /// Errors of the receiver, such as an overrun.
    pub receive_errors: u32,
    /// Errors of the transmitter.
    pub transmit_errors: u32,
    /// Ticks in which the bus was off.
    pub off: u32,
}

/// State of a joint.
#[derive(Clone, Copy, Debug)]
struct Joint {
    enabled: bool,
    /// Outstanding replies to commands, from the last two ticks.
    owed: u8,
    /// The older outstanding reply has been waited for through a tick that brought one.
    overdue: bool,
    /// Replies since the last [`JointIo::measure`].
    came: u8,
    position: f32,
    velocity: f32,
    torque: f32,
    /// In the last reply, degrees Celsius.
    temperature: Option<f32>,
    /// In the last reply: the drive's own error code.
    error: u8,
    /// Replies since it was switched on in which the drive says that it is off.
    off: u8,
    /// Ticks since the last reply; `u32::MAX` before the first.
    age_ticks: u32,
    /// Found in the last reply or command.
    faults: JointFaults,
    counts: JointCounts,
}

impl Joint {
    const NEW: Self = Self {
        enabled: false,
        owed: 0,
        overdue: false,
        came: 0,
        position: 0.0,
        velocity: 0.0,
        torque: 0.0,
        temperature: None,
        error: 0,
        off: 0,
        age_ticks: u32::MAX,
        faults: JointFaults::NONE,
        counts: JointCounts { missing: 0, late: 0, duplicate: 0, refused: 0, unsent: 0 },
    };
}

/// Order to a drive in a tick.
#[derive(Clone, Copy)]
enum Order {
    /// This torque of the joint, N m or N, and a spring about its last measurement; the drive is switched on first.
    Torque(f32, Option<Spring<f32>>),
    /// Damp, if the drive is on.
    Damp,
    /// Off.
    Off,
}

/// The joints behind up to three buses, whose drives understand the frames `F`. A bus that is not there is [`NoBus`].
#[derive(Clone, Debug)]
pub struct CanJoints<F, A, B, C, P, const N: usize> {
    frames: PhantomData<F>,
    first: A,
    second: B,
    third: C,
    brake: P,
    drives: [MitDrive; N],
    /// Joints in the order in which they are sent to: highest identifier first.
    order: [u8; N],
    joints: [Joint; N],
    buses: [BusCounts; BUSES],
    brake_failed: bool,
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
            joints: [Joint::NEW; N],
            buses: [BusCounts::default(); BUSES],
            brake_failed: false,
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
        self.brake_failed = self.brake.set_low().is_err();
    }

    fn release_brakes(&mut self) {
        self.brake_failed = self.brake.set_high().is_err();
    }

    /// The drives' own error codes, as their last replies have them; 0 without an error. [`Frames::words`] has them in words.
    pub fn drive_errors(&self) -> [u8; N] {
        self.joints.map(|joint| joint.error)
    }

    fn send_all(&mut self, order: impl Fn(usize) -> Order) {
        self.first.abandon();
        self.second.abandon();
        self.third.abandon();
        if !F::COMMAND_IN_IDENTIFIER {
            for i in self.order.map(usize::from) {
                let packet = self.packet(i, order(i));
                self.send(i, packet.as_ref());
            }
            return;
        }
        let mut packets: [(usize, Option<Packet>); N] = core::array::from_fn(|i| (i, self.packet(i, order(i))));
        packets.sort_unstable_by_key(|(_, packet)| core::cmp::Reverse(packet.map(|packet| rank(packet.id))));
        for (i, packet) in &packets {
            self.send(*i, packet.as_ref());
        }
    }

    /// The frame that carries out an order to a joint; `None` for a joint that is not there.
    fn packet(&mut self, i: usize, order: Order) -> Option<Packet> {
        Some(self.joints.get_mut(i)?.packet::<F>(self.drives.get(i)?, order))
    }

    fn send(&mut self, i: usize, packet: Option<&Packet>) {
        let (Some(drive), Some(joint), Some(packet)) = (self.drives.get(i), self.joints.get_mut(i), packet) else {
            return;
        };
        let sent = match drive.bus {
            0 => transmit(&mut self.first, packet, &mut self.buses[0]),
            1 => transmit(&mut self.second, packet, &mut self.buses[1]),
            _ => transmit(&mut self.third, packet, &mut self.buses[2]),
        };
        joint.sent(sent);
    }
}

impl Joint {
    /// The frame that carries out an order.
    fn packet<F: Frames>(&mut self, drive: &MitDrive, order: Order) -> Packet {
        self.faults = self.faults.without(JointFaults::NON_FINITE);
        let setpoint = match order {
            Order::Torque(torque, spring) => {
                let torque = drive.gearing.drive_torque(torque);
                let (torque, spring) = if torque.is_finite() {
                    (torque, spring)
                } else {
                    self.faults |= JointFaults::NON_FINITE;
                    self.counts.refused = self.counts.refused.wrapping_add(1);
                    (0.0, None)
                };
                if !self.enabled {
                    // An error is cleared first, in a tick of its own: only now does somebody want torque again.
                    if core::mem::take(&mut self.error) != 0
                        && let Some(clear) = F::clear(drive)
                    {
                        return clear;
                    }
                    (self.enabled, self.off) = (true, 0);
                    return F::enter(drive);
                }
                match spring {
                    None => Setpoint::torque(torque),
                    Some(spring) => self.sprung(drive, torque, &spring),
                }
            }
            Order::Damp if self.enabled => Setpoint::damped(drive.damping),
            Order::Damp | Order::Off => {
                self.enabled = false;
                return F::exit(drive);
            }
        };
        // A setpoint holds NaN here only if a range or a damping is NaN: then the drive is switched off.
        F::command(drive, &setpoint).unwrap_or_else(|| F::exit(drive))
    }

    /// This torque of the drive where the joint was measured, and the spring's wherever it has gone since.
    ///
    /// `kp (position - p) + kd (velocity - v) + torque` with position and velocity of the last reply, which are codes: no rounding
    /// is between the drive's measurement and this. Of a spring or damper beyond the frame's range the drive renews what it can; the
    /// rest is in the torque.
    fn sprung(&self, drive: &MitDrive, torque: f32, spring: &Spring<f32>) -> Setpoint {
        let gearing = &drive.gearing;
        let Spring { stiffness, damping: kd } = gearing.drive_spring(spring);
        // The highest code of all may be part of a special frame.
        let kp = stiffness.min(0.999 * drive.ranges.kp.max);
        let (position, velocity) = (gearing.drive_position(self.position), gearing.drive_velocity(self.velocity));
        Setpoint { position, velocity, kp, kd, torque }
    }

    fn sent(&mut self, sent: bool) {
        if sent {
            self.owed = (self.owed + 1).min(OWED_MAX);
        } else {
            self.counts.unsent = self.counts.unsent.wrapping_add(1);
        }
    }

    fn take(&mut self, reply: &Reply, drive: &MitDrive) {
        if self.owed == 0 {
            self.counts.duplicate = self.counts.duplicate.wrapping_add(1);
            return;
        }
        if self.came > 0 {
            // Two replies were due, and this is the second: the one before answers the tick before.
            self.counts.late = self.counts.late.wrapping_add(1);
        }
        self.owed -= 1;
        self.came = self.came.saturating_add(1);
        self.position = drive.gearing.joint_position(reply.position);
        self.velocity = drive.gearing.joint_velocity(reply.velocity);
        self.torque = drive.gearing.joint_torque(reply.torque);
        (self.temperature, self.error) = (reply.temperature, reply.error);
        self.off = if self.enabled && reply.off { self.off.saturating_add(1) } else { 0 };
        let failed = reply.error != 0 || self.off > OFF_MAX;
        let found = JointFaults::RANGE.when(reply.saturated) | JointFaults::DRIVE.when(failed);
        self.faults = self.faults.without(JointFaults::RANGE | JointFaults::DRIVE) | found;
    }

    /// Begin a tick: count the replies that came, and age the measurements without one.
    fn begin_tick(&mut self) {
        if core::mem::take(&mut self.came) > 0 {
            self.age_ticks = 0;
            // One reply came and one more is outstanding: either this one was late, and two come next, or the other is
            // lost.
            self.overdue = self.owed > 0 && !self.overdue;
            if !self.overdue {
                self.owed = 0;
            }
        } else {
            self.age_ticks = self.age_ticks.saturating_add(1);
            if self.owed > 0 {
                self.counts.missing = self.counts.missing.wrapping_add(1);
            }
        }
    }
}

impl<F: Frames, A: CanBus, B: CanBus, C: CanBus, P: OutputPin, const N: usize> JointIo<N>
    for CanJoints<F, A, B, C, P, N>
{
    fn measure(&mut self) -> Option<Readings<N>> {
        let off = [
            collect::<F, A, N>(&mut self.first, 0, &self.drives, &mut self.joints, &mut self.buses[0]),
            collect::<F, B, N>(&mut self.second, 1, &self.drives, &mut self.joints, &mut self.buses[1]),
            collect::<F, C, N>(&mut self.third, 2, &self.drives, &mut self.joints, &mut self.buses[2]),
        ];
        let mut faults = [JointFaults::NONE; N];
        for ((joint, drive), faults) in self.joints.iter_mut().zip(&self.drives).zip(&mut faults) {
            joint.begin_tick();
            *faults = joint.faults
                | JointFaults::MISSING.when(joint.age_ticks > MISSING_MAX)
                | JointFaults::BUS.when(off[usize::from(drive.bus.min(2))])
                | JointFaults::OUTPUT.when(self.brake_failed);
        }
        let (q, qd) = (self.joints.map(|joint| joint.position), self.joints.map(|joint| joint.velocity));
        Some(Readings {
            sensed: Sensed::State { q, qd },
            torque: self.joints.map(|joint| joint.torque),
            age_ticks: self.joints.map(|joint| joint.age_ticks),
            faults,
            errors: self.drive_errors(),
            on: self.joints.map(|joint| joint.enabled && joint.off == 0),
            zero_lost: false,
        })
    }

    fn temperature(&self) -> Option<f32> {
        self.joints.iter().fold(None, |hottest, joint| higher(hottest, joint.temperature))
    }

    fn enable(&mut self, _: SafeAction) {
        self.send_all(|_| Order::Torque(0.0, None));
    }

    fn preload(&mut self, torque: &[f32; N]) {
        self.send_all(|i| torque.get(i).map_or(Order::Off, |&torque| Order::Torque(torque, None)));
    }

    fn drive(&mut self, torque: &[f32; N], springs: Option<&[Spring<f32>; N]>) {
        // Brakes open when every drive is on, in the tick that first gives torque.
        if self.joints.iter().all(|joint| joint.enabled && joint.off == 0) {
            self.release_brakes();
        }
        let spring = |i: usize| springs.and_then(|springs| springs.get(i).copied());
        self.send_all(|i| torque.get(i).map_or(Order::Off, |&torque| Order::Torque(torque, spring(i))));
    }

    fn safe(&mut self, action: SafeAction) {
        match action {
            SafeAction::Brake => {
                self.engage_brakes();
                self.send_all(|_| Order::Off);
            }
            SafeAction::DampedStop => self.send_all(|_| Order::Damp),
            SafeAction::Off => self.send_all(|_| Order::Off),
        }
    }

    fn interrupt(&mut self) {
        self.first.interrupt();
        self.second.interrupt();
        self.third.interrupt();
    }
}

/// Joints by falling identifier; of equal ones (on two buses) the first joint first. At most `N` exchanges a joint.
fn sending_order<const N: usize>(drives: &[MitDrive; N]) -> [u8; N] {
    let mut order: [u8; N] = core::array::from_fn(|i| i as u8);
    order.sort_unstable_by_key(|&i| (drives.get(usize::from(i)).map(|drive| core::cmp::Reverse(drive.id)), i));
    order
}

/// Rank of an identifier in arbitration: the lower one goes first. A standard one goes before the extended ones that begin as it does.
fn rank(id: Id) -> u32 {
    match id {
        Id::Standard(id) => u32::from(id.as_raw()) << 18,
        Id::Extended(id) => id.as_raw(),
    }
}

/// Queue one command; false when the transmitter has no room for it.
fn transmit<B: CanBus>(bus: &mut B, packet: &Packet, counts: &mut BusCounts) -> bool {
    // Eight bytes are always a frame.
    let Some(frame) = B::Frame::new(packet.id, &packet.data) else { return false };
    for _ in 0..TRANSMIT_POLLS {
        match bus.transmit(&frame) {
            // A command that was pushed out is noticed when its reply does not come.
            Ok(_) => return true,
            Err(nb::Error::WouldBlock) => {}
            Err(nb::Error::Other(_)) => {
                counts.transmit_errors = counts.transmit_errors.wrapping_add(1);
                return false;
            }
        }
    }
    false
}

/// Empty a bus's receiver; whether the bus is off.
fn collect<F: Frames, B: CanBus, const N: usize>(
    bus: &mut B,
    index: u8,
    drives: &[MitDrive; N],
    joints: &mut [Joint; N],
    counts: &mut BusCounts,
) -> bool {
    for _ in 0..RECEIVED_MAX {
        match bus.receive() {
            Ok(frame) => {
                if let Some(count) = take_frame::<F, B::Frame, N>(&frame, index, drives, joints, counts) {
                    *count = count.wrapping_add(1);
                }
            }
            Err(nb::Error::WouldBlock) => break,
            Err(nb::Error::Other(_)) => counts.receive_errors = counts.receive_errors.wrapping_add(1),
        }
    }
    let off = bus.is_off();
    counts.off = counts.off.wrapping_add(u32::from(off));
    off
}

/// Give a frame to its sender's joint; returns the error count to raise when no joint is the sender.
fn take_frame<'a, F: Frames, T: Frame, const N: usize>(
    frame: &T,
    index: u8,
    drives: &[MitDrive; N],
    joints: &mut [Joint; N],
    counts: &'a mut BusCounts,
) -> Option<&'a mut u32> {
    let id = frame.id();
    let mut ours = drives.iter().zip(joints).filter(|(drive, _)| drive.bus == index && F::answers(drive, id));
    let Some(first) = ours.next() else { return Some(&mut counts.foreign) };
    let data = if frame.is_data_frame() { frame.data() } else { &[] };
    for (drive, joint) in core::iter::once(first).chain(ours) {
        if let Some(reply) = F::reply(drive, id, data) {
            joint.take(&reply, drive);
            return None;
        }
    }
    Some(&mut counts.malformed)
}
