//! A CAN bus with actuators on it, and the possible fates of a reply.

use crate::mit::Actuator;
use embedded_can::{ErrorKind, Id, StandardId};
use std::collections::VecDeque;

/// A data frame with a standard identifier.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// The identifier.
    pub id: u16,
    /// Up to eight bytes.
    pub data: Vec<u8>,
}

impl embedded_can::Frame for Frame {
    /// `None` for an extended identifier and for more than eight bytes.
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        match id.into() {
            Id::Standard(id) if data.len() <= 8 => Some(Self { id: id.as_raw(), data: data.to_vec() }),
            _ => None,
        }
    }

    fn new_remote(_: impl Into<Id>, _: usize) -> Option<Self> {
        None
    }

    fn is_extended(&self) -> bool {
        false
    }

    fn is_remote_frame(&self) -> bool {
        false
    }

    fn id(&self) -> Id {
        // An identifier of more than 11 bits is on no wire; as the lowest priority it is nobody's.
        StandardId::new(self.id).unwrap_or(StandardId::MAX).into()
    }

    fn dlc(&self) -> usize {
        self.data.len()
    }

    fn data(&self) -> &[u8] {
        &self.data
    }
}

/// Fate of a reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It arrives within the tick.
    Arrives,
    /// It is lost.
    Lost,
    /// It arrives in the tick after.
    Late,
    /// It arrives twice.
    Twice,
    /// Its last byte is missing.
    Short,
}

/// A bus: three mailboxes on the controller's side, served at once unless the bus is off.
#[derive(Clone, Debug, Default)]
pub struct Bus {
    /// The actuators on it.
    pub actuators: Vec<Actuator>,
    /// The controller has left the bus: nothing is sent or received.
    pub off: bool,
    /// Nobody acknowledges: mailboxes fill and stay full.
    pub stuck: bool,
    /// Fates of the next replies of an actuator, by identifier; empty: they arrive.
    pub fates: Vec<(u16, Fate)>,
    /// Actuators that hear nothing and say nothing, by identifier: their cable is broken.
    pub unplugged: Vec<u16>,
    /// Every frame that a controller sent, where they are kept.
    pub sent: Vec<Frame>,
    pending: Vec<Frame>,
    arrived: VecDeque<Frame>,
    later: Vec<Frame>,
    keeps_sent: bool,
}

/// Frames that wait to be sent, at most.
pub const MAILBOXES: usize = 3;

impl Bus {
    /// A bus with these actuators, which keeps what is sent.
    #[must_use]
    pub fn new(actuators: Vec<Actuator>) -> Self {
        Self { actuators, keeps_sent: true, ..Self::default() }
    }

    /// A bus with these actuators, for long runs: it keeps nothing of what is sent.
    #[must_use]
    pub fn forgetful(actuators: Vec<Actuator>) -> Self {
        Self { actuators, ..Self::default() }
    }

    /// Queue a frame; false when no mailbox takes it. As a bxCAN's driver does, one is taken beside others that wait only
    /// when its identifier is lower than all of theirs.
    pub fn send(&mut self, frame: Frame) -> bool {
        if self.pending.len() >= MAILBOXES || self.pending.iter().any(|waiting| waiting.id <= frame.id) {
            return false;
        }
        self.pending.push(frame);
        true
    }

    /// Abandon the waiting frames.
    pub fn abandon(&mut self) {
        self.pending.clear();
    }

    /// The next frame that has arrived.
    pub fn receive(&mut self) -> Option<Frame> {
        if self.off { None } else { self.arrived.pop_front() }
    }

    /// A frame from someone else.
    pub fn inject(&mut self, frame: Frame) {
        self.arrived.push_back(frame);
    }

    /// Let time pass: frames go to and fro, and free shafts move.
    pub fn step(&mut self, dt: f64) {
        self.serve();
        for actuator in &mut self.actuators {
            actuator.step(dt, 0.0);
        }
    }

    /// Send the waiting frames, lowest identifier first; the actuators answer at once.
    pub fn serve(&mut self) {
        self.arrived.extend(self.later.drain(..));
        if !self.off && !self.stuck {
            self.pending.sort_by_key(|frame| frame.id);
            for frame in std::mem::take(&mut self.pending) {
                self.deliver(&frame);
                if self.keeps_sent {
                    self.sent.push(frame);
                }
            }
        }
    }

    fn deliver(&mut self, frame: &Frame) {
        let addressed = |actuator: &&mut Actuator| actuator.electronics.id == frame.id;
        let Some(actuator) = self.actuators.iter_mut().find(addressed) else { return };
        if self.unplugged.contains(&frame.id) {
            return;
        }
        let Some(data) = actuator.receive(&frame.data) else { return };
        let mut reply = Frame { id: actuator.electronics.reply_id, data };
        let next = self.fates.iter().position(|(id, _)| *id == frame.id);
        match next.map_or(Fate::Arrives, |next| self.fates.remove(next).1) {
            Fate::Arrives => self.arrived.push_back(reply),
            Fate::Lost => {}
            Fate::Late => self.later.push(reply),
            Fate::Twice => self.arrived.extend([reply.clone(), reply]),
            Fate::Short => {
                reply.data.pop();
                self.arrived.push_back(reply);
            }
        }
    }
}

impl embedded_can::nb::Can for Bus {
    type Frame = Frame;
    type Error = ErrorKind;

    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, ErrorKind> {
        if self.send(frame.clone()) { Ok(None) } else { Err(nb::Error::WouldBlock) }
    }

    fn receive(&mut self) -> nb::Result<Frame, ErrorKind> {
        Self::receive(self).ok_or(nb::Error::WouldBlock)
    }
}
