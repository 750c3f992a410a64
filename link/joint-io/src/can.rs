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
//! | about a setting that was not asked for | counted for the bus and ignored |
//!
//! ## On
//!
//! A drive is on when it has **shown** it ([`Readings::on`]), not when it was told to be. [`JointIo::enable`] repeats the frame that enables it
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
//! replies that follow each other ([`JointFaults::TORQUE`]); below a fiftieth of the frame's range nothing is seen.
//!
//! Before a drive is enabled, its own communication timeout is read and set where the protocol has one. It is a fault of the joint if the drive
//! does not confirm it in [`TIMEOUT_TRIES`] frames.
//!
//! A frame carries no number, so an actuator that always answers one tick late looks punctual after its first miss,
//! which is counted. Its delay is bounded by the bus: its reply must come before its next one.

use crate::can_bus::CanBus;
use crate::frames::{Frames, Packet, Setting};
use crate::mit::{Reply, Setpoint};
use crate::queued::OUT;
use crate::{JointIo, MISSING_MAX, higher};
use core::fmt::Debug;
use core::marker::PhantomData;
use dynamics_core::control::{Sensed, Spring};
use dynamics_core::drive::{MitDrive, Range};
use dynamics_core::safety::SafeAction;
use embedded_can::{Frame, Id};
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

/// Replies in which a drive may give less than half of the torque that it was told, one after the other.
pub const WEAK_MAX: u8 = 5;

/// Torque below which nothing is concluded from a drive's torque, as a share of the range of its frames. Also the torque of a probe.
const PROBE_SHARE: f32 = 0.02;

/// Probes of a drive before it is enabled anew.
const PROBES: u8 = 4;

/// Replies, each of another tick, that have to show that a drive is on.
const SHOWN: u8 = 2;

/// Frames about its communication timeout that a drive may leave without a confirmation.
pub const TIMEOUT_TRIES: u8 = 12;

/// Ticks in which errors of drives are cleared after [`JointIo::clear`].
const CLEARING: u8 = 8;

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
struct CanJoint {
    /// The drive has shown that it is on, since it was last commanded off.
    on: bool,
    /// It takes damping: the last reply shows that it is on, or nothing shows that it is off.
    powered: bool,
    /// Progress of enabling it: 0 before the first frame, then 1; of a drive whose replies carry no state, one more with every probe.
    asked: u8,
    /// Replies that have shown it on, each of another tick.
    shown: u8,
    /// Replies, each of another tick, that may still be followed by one that shows it off because it was commanded off. 0: it was commanded on
    /// since, or did not hear the command.
    off_due: u8,
    /// Setting of its communication timeout.
    timeout: Timeout,
    /// Its zero may be lost since the last [`JointIo::measure`].
    zero_lost: bool,
    /// The last two commands, in the drive's units, the newer one first.
    told: [Setpoint; 2],
    /// Replies, one after the other, with less than half of the torque that was commanded.
    weak: u8,
    /// There were too many of them since the last safe action.
    torque_lost: bool,
    /// A reply has come since the start.
    heard: bool,
    /// A frame was sent since the start.
    greeted: bool,
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
    /// Ticks since the last reply; `u32::MAX` before the first.
    age_ticks: u32,
    /// Found in the last reply or command.
    faults: JointFaults,
    counts: JointCounts,
}

/// A drive's communication timeout, as far as it is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Timeout {
    /// In the drive's last answer.
    value: Option<u32>,
    /// It was written since that answer.
    written: bool,
    /// Frames without a confirmation.
    tries: u8,
    /// Ticks in which an answer is still expected.
    due: u8,
}

impl Timeout {
    /// True if the drive has confirmed it, or needs not.
    fn is_settled(self, drive: &MitDrive) -> bool {
        drive.timeout == 0 || (self.value == Some(drive.timeout) && !self.written)
    }
}

impl CanJoint {
    const NEW: Self = Self {
        on: false,
        powered: false,
        asked: 0,
        shown: 0,
        off_due: 0,
        timeout: Timeout { value: None, written: false, tries: 0, due: 0 },
        zero_lost: false,
        told: [Setpoint::torque(0.0); 2],
        weak: 0,
        torque_lost: false,
        heard: false,
        greeted: false,
        owed: 0,
        overdue: false,
        came: 0,
        position: 0.0,
        velocity: 0.0,
        torque: 0.0,
        temperature: None,
        error: 0,
        age_ticks: u32::MAX,
        faults: JointFaults::NONE,
        counts: JointCounts { missing: 0, late: 0, duplicate: 0, refused: 0, unsent: 0 },
    };
}

/// Order to a drive in a tick.
#[derive(Clone, Copy)]
enum Order {
    /// This torque of the joint, N m or N, and a spring about its last measurement; the drive is enabled first.
    Torque(f32, Option<Spring<f32>>),
    /// Enable the drive; one that is on damps, or gives no torque.
    Enable { damped: bool },
    /// Damp, if the drive is on.
    Damp,
    /// Off.
    Off,
}

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

    /// The joint whose drive gets a frame about its communication timeout in this tick: one of all, because all such frames of a bus can have one
    /// identifier. Its drive has answered in this tick, is off, and has not confirmed its timeout.
    fn next_setting(&mut self, order: &impl Fn(usize) -> Order) -> Option<usize> {
        let needs = |i: usize| {
            let (Some(joint), Some(drive)) = (self.joints.get(i), self.drives.get(i)) else { return false };
            let idle = match order(i) {
                Order::Damp => !joint.powered,
                _ => !joint.on,
            };
            joint.age_ticks == 0 && idle && joint.error == 0 && !joint.timeout.is_settled(drive)
        };
        let found = (self.next_setting..N).chain(0..self.next_setting).find(|&i| needs(i))?;
        self.next_setting = if found + 1 < N { found + 1 } else { 0 };
        Some(found)
    }

    fn send_torque(&mut self, torque: &[f32; N], springs: Option<&[Spring<f32>; N]>) {
        let spring = |i: usize| springs.and_then(|springs| springs.get(i).copied());
        self.send_all(|i| torque.get(i).map_or(Order::Off, |&torque| Order::Torque(torque, spring(i))));
    }

    fn send_all(&mut self, order: impl Fn(usize) -> Order) {
        self.first.abandon();
        self.second.abandon();
        self.third.abandon();
        let setting = if self.all_on() { None } else { self.next_setting(&order) };
        let clears = self.clearing > 0;
        self.clearing = self.clearing.saturating_sub(1);
        if !F::COMMAND_IN_IDENTIFIER {
            // Its identifier is the highest of all.
            if let Some(i) = setting {
                let packet = self.setting_packet(i);
                self.send(i, packet.as_ref());
            }
            for i in self.order.map(usize::from) {
                if setting != Some(i) {
                    let packet = self.packet(i, order(i), clears);
                    self.send(i, packet.as_ref());
                }
            }
            return;
        }
        let mut packets: [(usize, Option<Packet>); N] = core::array::from_fn(|i| {
            (i, if setting == Some(i) { self.setting_packet(i) } else { self.packet(i, order(i), clears) })
        });
        packets.sort_unstable_by_key(|(_, packet)| core::cmp::Reverse(packet.map(|packet| rank(packet.id))));
        for (i, packet) in &packets {
            self.send(*i, packet.as_ref());
        }
    }

    /// The frame that carries out an order to a joint; `None` for a joint that is not there.
    fn packet(&mut self, i: usize, order: Order, clears: bool) -> Option<Packet> {
        Some(self.joints.get_mut(i)?.packet::<F>(self.drives.get(i)?, order, clears))
    }

    /// The frame that reads or writes the communication timeout of a joint's drive.
    #[cold]
    #[inline(never)]
    fn setting_packet(&mut self, i: usize) -> Option<Packet> {
        self.joints.get_mut(i)?.setting_packet::<F>(self.drives.get(i)?)
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
        joint.sent(sent != Sent::Refused);
        if let Sent::InPlaceOf(id) = sent {
            let bus = drive.bus;
            drop_frame(id, bus, &self.drives, &mut self.joints);
        }
    }
}

impl CanJoint {
    /// The frame that carries out an order.
    fn packet<F: Frames>(&mut self, drive: &MitDrive, order: Order, clears: bool) -> Packet {
        self.faults = self.faults.without(JointFaults::NON_FINITE);
        let first = !core::mem::replace(&mut self.greeted, true);
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
                match spring {
                    _ if !self.on => return self.enable::<F>(drive, false),
                    None => Setpoint::torque(torque),
                    Some(spring) => self.sprung(drive, torque, &spring),
                }
            }
            Order::Enable { damped } if !self.on => return self.enable::<F>(drive, damped),
            Order::Enable { damped: true } => Setpoint::damped(drive.damping),
            Order::Enable { damped: false } => Setpoint::torque(0.0),
            // A drive that a board before its reset has left on is damped too: nothing is known of it yet.
            Order::Damp if self.powered || first => Setpoint::damped(drive.damping),
            Order::Damp | Order::Off => {
                (self.powered, self.off_due) = (false, OWED_MAX);
                if clears
                    && self.error != 0
                    && let Some(clear) = F::clear(drive)
                {
                    return clear;
                }
                return F::exit(drive);
            }
        };
        self.command::<F>(drive, &setpoint)
    }

    /// The frame that makes a drive give this. A setpoint holds NaN only if a range or a damping is NaN: then the drive is switched off.
    fn command<F: Frames>(&mut self, drive: &MitDrive, setpoint: &Setpoint) -> Packet {
        self.told = [*setpoint, self.told[0]];
        F::command(drive, setpoint).unwrap_or_else(|| F::exit(drive))
    }

    /// The next frame to a drive that has not shown that it is on.
    #[cold]
    #[inline(never)]
    fn enable<F: Frames>(&mut self, drive: &MitDrive, damped: bool) -> Packet {
        if self.error != 0
            && let Some(clear) = F::clear(drive)
        {
            self.off_due = OWED_MAX;
            return clear;
        }
        let answered = self.age_ticks == 0 && self.asked > 0;
        let held = if damped { Setpoint::damped(drive.damping) } else { Setpoint::torque(0.0) };
        if F::FACTS.reports_state && answered && self.powered {
            return self.command::<F>(drive, &held);
        }
        if !F::FACTS.reports_state && answered && self.asked <= PROBES {
            self.asked += 1;
            return self.command::<F>(drive, &Setpoint { torque: probe(drive), ..held });
        }
        // Replies keep the order of the frames: at most one is still due that answers a frame from before this one.
        (self.asked, self.shown, self.off_due) = (1, 0, self.off_due.min(1));
        self.told = [Setpoint::torque(0.0); 2];
        F::enter(drive)
    }

    /// The frame that reads or writes the drive's communication timeout.
    fn setting_packet<F: Frames>(&mut self, drive: &MitDrive) -> Option<Packet> {
        let it = &mut self.timeout;
        let differs = it.value.is_some_and(|value| value != drive.timeout);
        (it.tries, it.due) = (it.tries.saturating_add(1), OWED_MAX);
        // What was written is read back.
        let writes = differs && !it.written;
        it.written = writes;
        if writes { F::write_timeout(drive) } else { F::read_timeout(drive) }
    }

    /// Forgets that the drive is on: it is commanded off or to damp, or it cannot be reached.
    fn forget(&mut self) {
        (self.on, self.asked, self.shown, self.weak) = (false, 0, 0, 0);
        self.told = [Setpoint::torque(0.0); 2];
    }

    /// The drive may have restarted: its settings and its zero are what they are after a start.
    ///
    /// It is not known to be off: one that was only not heard still damps, and a frame that switches it off would let an arm without
    /// brakes fall. One that is off takes no notice of damping.
    #[cold]
    fn restarted(&mut self, drive: &MitDrive) {
        self.forget();
        self.timeout = Timeout::default();
        self.zero_lost |= !drive.absolute;
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

    /// A frame that was counted as sent was not: no reply is due for it.
    fn dropped(&mut self) {
        self.owed = self.owed.saturating_sub(1);
        self.counts.unsent = self.counts.unsent.wrapping_add(1);
    }

    fn take<F: Frames>(&mut self, reply: &Reply, drive: &MitDrive) {
        if self.owed == 0 {
            self.counts.duplicate = self.counts.duplicate.wrapping_add(1);
            return;
        }
        if self.came > 0 {
            // Two replies were due, and this is the second: the one before answers the tick before.
            self.counts.late = self.counts.late.wrapping_add(1);
        }
        self.owed -= 1;
        let first = self.came == 0;
        self.came = self.came.saturating_add(1);
        self.position = drive.gearing.joint_position(reply.position);
        self.velocity = drive.gearing.joint_velocity(reply.velocity);
        self.torque = drive.gearing.joint_torque(reply.torque);
        (self.temperature, self.error) = (reply.temperature, reply.error);
        let found = JointFaults::RANGE.when(reply.saturated) | JointFaults::DRIVE.when(reply.error != 0);
        self.faults = self.faults.without(JointFaults::RANGE | JointFaults::DRIVE) | found;
        if F::FACTS.reports_state {
            self.take_state(reply, drive, first);
        } else {
            self.take_torque(reply, drive);
        }
    }

    /// Takes the state in a reply. `first`: the first reply of this tick.
    fn take_state(&mut self, reply: &Reply, drive: &MitDrive, first: bool) {
        let shows_on = !reply.off && reply.error == 0;
        let was_powered = core::mem::replace(&mut self.powered, shows_on);
        if shows_on {
            if self.on {
                // One that is on and gives no torque has not restarted.
                self.weigh(reply, drive);
            } else if first {
                self.off_due = self.off_due.saturating_sub(1);
                if self.asked > 0 {
                    self.shown = self.shown.saturating_add(1);
                    self.on = self.shown >= SHOWN && self.timeout.is_settled(drive);
                }
            }
        } else if reply.error == 0 && (self.on || (was_powered && self.off_due == 0)) {
            // It was not commanded off, whether it gave torque, damped, or was about to.
            self.restarted(drive);
        } else {
            (self.on, self.shown) = (false, 0);
        }
    }

    /// Takes the torque in a reply of a protocol whose replies carry no state.
    fn take_torque(&mut self, reply: &Reply, drive: &MitDrive) {
        let floor = probe(drive);
        if reply.error != 0 {
            (self.on, self.powered) = (false, false);
        } else if !self.on {
            self.powered |= self.asked > 0;
            if self.asked > 1 && (reply.torque - floor).abs() <= 0.5 * floor {
                self.on = true;
            }
        } else {
            if self.weigh(reply, drive) {
                self.restarted(drive);
            }
        }
    }

    /// Counts the replies, one after the other, in which the drive gives less than half of its torque. After too many of them it no longer
    /// counts as on, whatever state it reports: true then.
    fn weigh(&mut self, reply: &Reply, drive: &MitDrive) -> bool {
        let floor = probe(drive);
        // It answers the last command or, as a drive measures before it acts, the one before.
        let [new, old] = self.told.map(|told| {
            let Setpoint { position, velocity, kp, kd, torque } = told;
            kp * (position - reply.position) + kd * (velocity - reply.velocity) + torque
        });
        let (low, high) = if new < old { (new, old) } else { (old, new) };
        let Range { min, max } = drive.ranges.torque;
        let weak = (low > floor && reply.torque < 0.5 * if low < max { low } else { max })
            || (high < -floor && reply.torque > 0.5 * if high > min { high } else { min });
        self.weak = if weak { self.weak.saturating_add(1) } else { 0 };
        let lost = self.weak > WEAK_MAX;
        if lost {
            self.forget();
            self.torque_lost = true;
        }
        lost
    }

    /// Takes a drive's answer about a setting; false when none was asked for.
    #[cold]
    #[inline(never)]
    fn take_setting(&mut self, setting: Setting) -> bool {
        let asked = self.timeout.due > 0 && self.owed > 0;
        if asked {
            (self.timeout.due, self.owed) = (0, self.owed - 1);
            if let Setting::Timeout(value) = setting {
                (self.timeout.value, self.timeout.written) = (Some(value), false);
            }
        }
        asked
    }

    /// Greatest age of the reading, ticks. While a second reply is outstanding, the one that came may be late: it shows the drive as it was a tick
    /// ago, and brakes must not open on it. Once they are open a late reading counts as fresh.
    fn age(&self, released: bool) -> u32 {
        self.age_ticks.max(u32::from(self.overdue && !released))
    }

    /// Begin a tick: count the replies that came, and age the measurements without one.
    fn begin_tick(&mut self, drive: &MitDrive) {
        let dark = self.age_ticks;
        self.timeout.due = self.timeout.due.saturating_sub(1);
        if core::mem::take(&mut self.came) > 0 {
            self.age_ticks = 0;
            if dark > drive.restart_ticks && core::mem::replace(&mut self.heard, true) {
                self.restarted(drive);
            }
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
            if self.heard && self.age_ticks == drive.restart_ticks.saturating_add(1) {
                self.restarted(drive);
            }
        }
    }
}

/// Torque of a probe, N m of the drive.
fn probe(drive: &MitDrive) -> f32 {
    PROBE_SHARE * drive.ranges.torque.max
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
        let (mut faults, mut zero_lost) = ([JointFaults::NONE; N], false);
        for ((joint, drive), faults) in self.joints.iter_mut().zip(&self.drives).zip(&mut faults) {
            joint.begin_tick(drive);
            let off = off[usize::from(drive.bus.min(2))];
            if off {
                joint.forget();
            }
            zero_lost |= core::mem::take(&mut joint.zero_lost);
            let unset = joint.timeout.tries > TIMEOUT_TRIES && !joint.timeout.is_settled(drive);
            *faults = joint.faults
                | JointFaults::TIMEOUT.when(unset)
                | JointFaults::TORQUE.when(joint.torque_lost)
                | JointFaults::MISSING.when(joint.age_ticks > MISSING_MAX)
                | JointFaults::BUS.when(off)
                | JointFaults::OUTPUT.when(self.brake_failed);
        }
        let (q, qd) = (self.joints.map(|joint| joint.position), self.joints.map(|joint| joint.velocity));
        Some(Readings {
            sensed: Sensed::State { q, qd },
            torque: self.joints.map(|joint| joint.torque),
            age_ticks: self.joints.map(|joint| joint.age(self.released)),
            faults,
            errors: self.drive_errors(),
            on: self.joints.map(|joint| joint.on),
            zero_lost,
        })
    }

    fn temperature(&self) -> Option<f32> {
        self.joints.iter().fold(None, |hottest, joint| higher(hottest, joint.temperature))
    }

    fn enable(&mut self, action: SafeAction) {
        self.engage_brakes();
        self.send_all(|_| Order::Enable { damped: action == SafeAction::DampedStop });
    }

    fn preload(&mut self, torque: &[f32; N], springs: Option<&[Spring<f32>; N]>) {
        self.engage_brakes();
        self.send_torque(torque, springs);
    }

    fn drive(&mut self, torque: &[f32; N], springs: Option<&[Spring<f32>; N]>) {
        // They open only on replies of this tick, none of which lacks its torque; then they stay open while every drive is on.
        let shown = |joint: &CanJoint| joint.age(false) == 0 && joint.weak == 0;
        if self.all_on() && (self.released || self.joints.iter().all(shown)) {
            self.release_brakes();
        } else {
            self.engage_brakes();
        }
        self.send_torque(torque, springs);
    }

    fn safe(&mut self, action: SafeAction) {
        for joint in &mut self.joints {
            joint.forget();
            joint.torque_lost = false;
        }
        match action {
            SafeAction::Brake => {
                self.engage_brakes();
                self.send_all(|_| Order::Off);
            }
            SafeAction::DampedStop => self.send_all(|_| Order::Damp),
            SafeAction::Off => self.send_all(|_| Order::Off),
        }
    }

    fn clear(&mut self) {
        self.clearing = CLEARING;
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

/// Fate of a frame that was given to a bus.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Sent {
    /// It waits to be sent.
    Queued,
    /// It waits, and has pushed out the frame with this identifier.
    InPlaceOf(Id),
    /// There is no room for it, or the transmitter has an error.
    Refused,
}

/// Queue one command.
fn transmit<B: CanBus>(bus: &mut B, packet: &Packet, counts: &mut BusCounts) -> Sent {
    // Eight bytes are always a frame.
    let Some(frame) = B::Frame::new(packet.id, &packet.data) else { return Sent::Refused };
    for _ in 0..TRANSMIT_POLLS {
        match bus.transmit(&frame) {
            Ok(None) => return Sent::Queued,
            Ok(Some(other)) => return Sent::InPlaceOf(other.id()),
            Err(nb::Error::WouldBlock) => {}
            Err(nb::Error::Other(_)) => {
                counts.transmit_errors = counts.transmit_errors.wrapping_add(1);
                return Sent::Refused;
            }
        }
    }
    Sent::Refused
}

/// Note for the joint that a frame with this identifier was for that it was not sent. A frame about a setting names no joint.
fn drop_frame<const N: usize>(id: Id, bus: u8, drives: &[MitDrive; N], joints: &mut [CanJoint; N]) {
    let to = match id {
        Id::Standard(id) => u32::from(id.as_raw()),
        Id::Extended(id) => id.as_raw() & 0xff,
    };
    let mut ours = drives.iter().zip(joints).filter(|(drive, _)| drive.bus == bus && u32::from(drive.id) == to);
    if let Some((_, joint)) = ours.next() {
        joint.dropped();
    }
}

/// Empty a bus's receiver; whether the bus is off.
fn collect<F: Frames, B: CanBus, const N: usize>(
    bus: &mut B,
    index: u8,
    drives: &[MitDrive; N],
    joints: &mut [CanJoint; N],
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
    for _ in 0..OUT {
        let Some(id) = bus.dropped() else { break };
        drop_frame(id, index, drives, joints);
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
    joints: &mut [CanJoint; N],
    counts: &'a mut BusCounts,
) -> Option<&'a mut u32> {
    let id = frame.id();
    let mut ours = drives.iter().zip(joints).filter(|(drive, _)| drive.bus == index && F::answers(drive, id));
    let Some(first) = ours.next() else { return Some(&mut counts.foreign) };
    let data = if frame.is_data_frame() { frame.data() } else { &[] };
    for (drive, joint) in core::iter::once(first).chain(ours) {
        if let Some(setting) = F::setting(drive, id, data) {
            if joint.take_setting(setting) {
                return None;
            }
        } else if let Some(reply) = F::reply(drive, id, data) {
            joint.take::<F>(&reply, drive);
            return None;
        }
    }
    Some(&mut counts.malformed)
}
