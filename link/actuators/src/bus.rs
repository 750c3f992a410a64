//! A CAN bus with actuators, on which commands and replies can be disturbed.

use crate::frame::{Frame, Order};
use crate::mit::Actuator;
use embedded_can::ErrorKind;
use std::collections::VecDeque;

/// Fate of a reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Fate {
    /// It arrives within the tick.
    Arrives,
    /// It is lost.
    Lost,
    /// It arrives in the next tick.
    Late,
    /// It arrives twice.
    Twice,
    /// Its last byte is missing.
    Short,
}

/// Fate of a disturbed command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum CommandFate {
    /// It is sent, but the actuator does not receive it.
    Lost,
    /// It arrives in the next tick, before that tick's own commands.
    Late,
    /// The transmitter is full.
    Refused,
    /// It arrives twice.
    Twice,
}

/// Commands that share a fate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Disturbance {
    /// Identifier of the actuator; `None` for all.
    pub id: Option<u16>,
    /// Kind of command; `None` for all kinds.
    pub order: Option<Order>,
    /// Their fate.
    pub fate: CommandFate,
}

/// A bus: three mailboxes on the controller's side, served at once unless the bus is off.
#[derive(Clone, Debug, Default)]
pub struct Bus {
    /// The actuators on it.
    pub actuators: Vec<Actuator>,
    /// True if the controller has left the bus: nothing is sent or received.
    pub off: bool,
    /// True if no device acknowledges: mailboxes fill and stay full.
    pub stuck: bool,
    /// Fates of the next replies, with the identifier of the actuator. Replies without an entry arrive.
    pub fates: Vec<(u16, Fate)>,
    /// Identifiers of actuators with a broken cable: they receive and send nothing.
    pub unplugged: Vec<u16>,
    /// Disturbance of commands, until it is changed.
    pub disturbance: Option<Disturbance>,
    /// Every frame that a controller sent, if the bus records them.
    pub sent: Vec<Frame>,
    pending: Vec<Frame>,
    arrived: VecDeque<Frame>,
    later: Vec<Frame>,
    /// Commands that arrive in the next tick.
    delayed: Vec<Frame>,
    keeps_sent: bool,
}

/// Largest number of frames that wait to be sent.
pub const MAILBOXES: usize = 3;

impl Bus {
    /// Creates a bus with these actuators that records all sent frames.
    #[must_use]
    pub fn new(actuators: Vec<Actuator>) -> Self {
        Self { actuators, keeps_sent: true, ..Self::default() }
    }

    /// Creates a bus with these actuators that records nothing, for long runs.
    #[must_use]
    pub fn forgetful(actuators: Vec<Actuator>) -> Self {
        Self { actuators, ..Self::default() }
    }

    /// Queues a frame; returns false if no mailbox takes it. As in a bxCAN's driver, a frame is accepted while others wait only if its identifier
    /// is lower than all of theirs.
    pub fn send(&mut self, frame: Frame) -> bool {
        if self.pending.len() >= MAILBOXES || self.pending.iter().any(|waiting| waiting.rank() <= frame.rank()) {
            return false;
        }
        if self.fate(&frame) == Some(CommandFate::Refused) {
            return false;
        }
        self.pending.push(frame);
        true
    }

    /// Drops the waiting frames.
    pub fn abandon(&mut self) {
        self.pending.clear();
    }

    /// Returns the next frame that has arrived.
    pub fn receive(&mut self) -> Option<Frame> {
        if self.off { None } else { self.arrived.pop_front() }
    }

    /// Adds a received frame from another device.
    pub fn inject(&mut self, frame: Frame) {
        self.arrived.push_back(frame);
    }

    /// Simulates `dt` seconds: exchanges frames and moves free shafts.
    pub fn step(&mut self, dt: f64) {
        self.serve();
        for actuator in &mut self.actuators {
            actuator.step(dt, 0.0);
        }
    }

    /// Delivers the delayed frames of the previous tick, calls [`Bus::exchange`], and takes the frames that actuators send by themselves.
    pub fn serve(&mut self) {
        self.arrived.extend(self.later.drain(..));
        for frame in std::mem::take(&mut self.delayed) {
            self.deliver(&frame);
        }
        self.exchange();
        if !self.off && !self.stuck {
            let heard = self.actuators.iter_mut().filter(|it| !self.unplugged.contains(&it.electronics.id));
            self.arrived.extend(heard.filter_map(|it| it.electronics.unasked()));
        }
    }

    /// Fate of a command.
    fn fate(&self, frame: &Frame) -> Option<CommandFate> {
        let Disturbance { id, order, fate } = self.disturbance?;
        let electronics = self.actuators.iter().map(|it| &it.electronics).find(|it| it.hears(frame))?;
        let meant = id.is_none_or(|id| id == electronics.id);
        (meant && order.is_none_or(|order| order == electronics.order(frame))).then_some(fate)
    }

    /// Sends the waiting frames, lowest identifier first; the actuators answer at once.
    pub fn exchange(&mut self) {
        if !self.off && !self.stuck {
            self.pending.sort_by_key(Frame::rank);
            for frame in std::mem::take(&mut self.pending) {
                match self.fate(&frame) {
                    None | Some(CommandFate::Refused) => self.deliver(&frame),
                    Some(CommandFate::Lost) => {}
                    Some(CommandFate::Late) => self.delayed.push(frame.clone()),
                    Some(CommandFate::Twice) => (0..2).for_each(|_| self.deliver(&frame)),
                }
                if self.keeps_sent {
                    self.sent.push(frame);
                }
            }
        }
    }

    fn deliver(&mut self, frame: &Frame) {
        let Some(actuator) = self.actuators.iter_mut().find(|actuator| actuator.electronics.hears(frame)) else {
            return;
        };
        let own = actuator.electronics.id;
        if self.unplugged.contains(&own) {
            return;
        }
        let Some(mut reply) = actuator.answer(frame) else { return };
        let next = self.fates.iter().position(|(id, _)| *id == own);
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
