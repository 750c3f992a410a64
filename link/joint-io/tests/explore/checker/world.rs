//! The board's environment: bus, drives, power, brakes and joints.

use super::scene::{self, INERTIA, PERIOD, Setup, TURN, WEIGHT};
use actuator_model::frame::Frame;
use actuator_model::mit::{Electronics, Language, Memory, Shaft};
use embedded_can::ErrorKind;
use embedded_can::nb::Can;
use embedded_hal::digital::{ErrorType, OutputPin};
use joint_io::can_bus::CanBus;
use joint_io::mit::EXIT;
use std::collections::VecDeque;
use std::convert::Infallible;

/// Fate of a joint's command in this period.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum CommandFate {
    /// It arrives.
    #[default]
    Arrives,
    /// The transmitter is full.
    Refused,
    /// It is sent, but the drive does not receive it.
    Lost,
    /// It arrives at the end of the period.
    Late,
    /// It arrives twice.
    Twice,
}

/// Fate of a joint's reply in this period.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ReplyFate {
    /// It arrives.
    #[default]
    Arrives,
    /// It is lost.
    Lost,
    /// It arrives a period late.
    Late,
    /// It arrives twice.
    Twice,
}

/// A CAN controller with three mailboxes, and the frames that arrive at it. Frames to send stay in the mailboxes until [`World::step`].
#[derive(Clone, Debug, Default)]
pub struct Wire {
    pending: Vec<Frame>,
    arrived: VecDeque<Frame>,
    later: Vec<Frame>,
    /// True if the controller has left the bus.
    pub off: bool,
    /// Identifiers of the drives to which no command can be queued in this period, as bits.
    pub refused: u8,
}

/// Number of mailboxes of a controller.
const MAILBOXES: usize = 3;

fn rank(frame: &Frame) -> u32 {
    if frame.extended { frame.id } else { frame.id << 18 }
}

impl Wire {
    /// Identifier of the drive that a command is for.
    fn addressee(frame: &Frame) -> u32 {
        // A Damiao's requests about settings share an identifier, and name the drive in their first byte.
        match frame.id {
            0x7ff if !frame.extended => frame.data.first().map_or(0, |id| u32::from(*id)),
            // The requests of a MyActuator drive; its commands have the identifier 0x400 higher than its own.
            0x141..=0x160 if !frame.extended => frame.id - 0x140,
            id => id & 0xff,
        }
    }
}

impl Can for Wire {
    type Frame = Frame;
    type Error = ErrorKind;

    fn transmit(&mut self, frame: &Frame) -> nb::Result<Option<Frame>, ErrorKind> {
        let full = self.pending.len() >= MAILBOXES || self.pending.iter().any(|waiting| rank(waiting) <= rank(frame));
        if full || self.refused >> Self::addressee(frame) & 1 == 1 {
            return Err(nb::Error::WouldBlock);
        }
        self.pending.push(frame.clone());
        Ok(None)
    }

    fn receive(&mut self) -> nb::Result<Frame, ErrorKind> {
        if self.off {
            return Err(nb::Error::WouldBlock);
        }
        self.arrived.pop_front().ok_or(nb::Error::WouldBlock)
    }
}

impl CanBus for Wire {
    fn is_off(&mut self) -> bool {
        self.off
    }

    fn abandon(&mut self) {
        self.pending.clear();
    }
}

/// The line to the brakes; true opens them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Brake(pub bool);

impl ErrorType for Brake {
    type Error = Infallible;
}

impl OutputPin for Brake {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.0 = false;
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.0 = true;
        Ok(())
    }
}

/// A drive and its joint.
#[derive(Clone, Debug)]
pub struct Drive {
    /// The drive's electronics.
    pub electronics: Electronics,
    /// Periods until it has power again; 0 with power.
    pub dark: u8,
    /// Error of its zero, turns of the motor.
    pub turns: u8,
    /// Joint position, rad, on a grid.
    pub q: f64,
    /// Joint velocity, rad/s, on a grid.
    pub qd: f64,
    /// Fate of its command in this period.
    pub command: CommandFate,
    /// Fate of its reply in this period.
    pub reply: ReplyFate,
    /// Torque at the end of the last period, N m.
    pub torque: f64,
}

/// Grid points per rad of positions in motion and at rest, and per rad/s of speeds. A joint that comes to rest settles on the coarse grid, so that
/// there are few states of rest.
const MOVING: f64 = 8192.0;
const RESTING: f64 = 1024.0;
const SPEEDS: f64 = 256.0;

/// Steps of the plant in a period.
const STEPS: u32 = 5;

/// Friction, N m. It also stops a joint that is nearly at rest, so that the grid has states of rest.
const FRICTION: f64 = 0.5;

impl Drive {
    fn shaft(&self) -> Shaft {
        Shaft { position: self.q + f64::from(self.turns) * TURN, velocity: self.qd }
    }

    /// True if it has power, is switched on, has no error and follows commands.
    #[must_use]
    pub fn is_on(&self) -> bool {
        self.dark == 0 && self.electronics.is_enabled() && self.electronics.error == 0
    }

    /// Simulates a control period of the joint. `free`: no brake holds it.
    fn step(&mut self, free: bool) {
        let dt = PERIOD / f64::from(STEPS);
        for _ in 0..STEPS {
            let shaft = self.shaft();
            if self.dark == 0 {
                self.electronics.pass(dt);
                self.torque = self.electronics.drive(&shaft);
            } else {
                self.torque = 0.0;
            }
            let push = self.torque - WEIGHT;
            let stuck = self.qd == 0.0 && (push.abs() <= FRICTION || (self.q <= 0.0 && push < 0.0));
            if !free || stuck {
                self.qd = 0.0;
                continue;
            }
            let direction = if self.qd == 0.0 { push.signum() } else { self.qd.signum() };
            let next = self.qd + dt * (push - FRICTION * direction) / INERTIA;
            // Friction stops the joint; it does not reverse it.
            self.qd = if self.qd != 0.0 && next * self.qd < 0.0 && push.abs() <= FRICTION { 0.0 } else { next };
            self.q += dt * self.qd;
            if self.q <= 0.0 {
                // The joint rests on the table.
                (self.q, self.qd) = (0.0, self.qd.max(0.0));
            }
        }
        // Adding 0.0 removes a negative zero.
        self.qd = (self.qd * SPEEDS).round() / SPEEDS + 0.0;
        let grid = if self.qd == 0.0 { RESTING } else { MOVING };
        self.q = (self.q * grid).round() / grid;
    }
}

/// Drives and joints, and the emergency stop.
#[derive(Clone, Debug)]
pub struct World<const N: usize> {
    /// Drives and joints.
    pub axes: [Drive; N],
    /// Number of periods for which the emergency stop is still pressed.
    pub stop: u8,
    /// Number of periods for which the bus is still off.
    pub bus_off: u8,
    /// True if this period ends late.
    pub late: bool,
}

impl<const N: usize> World<N> {
    /// Creates drives that were just switched on, with joints on the table.
    #[must_use]
    pub fn new(setup: &Setup) -> Self {
        let drive = |joint: usize| Drive {
            electronics: scene::electronics(setup, joint as u8),
            dark: 0,
            turns: 0,
            q: 0.0,
            qd: 0.0,
            command: CommandFate::Arrives,
            reply: ReplyFate::Arrives,
            torque: 0.0,
        };
        Self { axes: core::array::from_fn(drive), stop: 0, bus_off: 0, late: false }
    }

    /// Prepares the CAN controller for the frames of this period.
    pub fn prepare(&self, wire: &mut Wire) {
        wire.off = self.bus_off > 0;
        wire.refused = 0;
        for (i, drive) in self.axes.iter().enumerate() {
            if drive.command == CommandFate::Refused {
                wire.refused |= 1 << (i + 1);
            }
        }
    }

    /// Simulates a control period after the board's commands: frames, power, motion. `free`: no brake holds the arm. Returns true if every drive was on while
    /// it moved.
    pub fn step(&mut self, wire: &mut Wire, free: bool) -> bool {
        let late = self.serve(wire);
        for drive in &mut self.axes {
            drive.step(free);
        }
        let all_on = self.axes.iter().all(Drive::is_on);
        for frame in late {
            self.deliver(wire, &frame, ReplyFate::Late);
        }
        all_on
    }

    /// Sends the waiting frames and returns those that arrive late.
    fn serve(&mut self, wire: &mut Wire) -> Vec<Frame> {
        let mut late = Vec::new();
        let later = core::mem::take(&mut wire.later);
        wire.arrived.extend(later);
        if wire.off {
            return late;
        }
        let mut pending = core::mem::take(&mut wire.pending);
        pending.sort_by_key(rank);
        for frame in pending {
            let Some(drive) = self.axes.iter().find(|drive| drive.electronics.hears(&frame)) else { continue };
            let reply = drive.reply;
            match drive.command {
                CommandFate::Arrives | CommandFate::Refused => self.deliver(wire, &frame, reply),
                CommandFate::Lost => {}
                CommandFate::Late => late.push(frame),
                CommandFate::Twice => {
                    self.deliver(wire, &frame, reply);
                    self.deliver(wire, &frame, reply);
                }
            }
        }
        let hears = self.axes.iter_mut().filter(|drive| drive.dark == 0);
        wire.arrived.extend(hears.filter_map(|drive| drive.electronics.unasked()));
        late
    }

    fn deliver(&mut self, wire: &mut Wire, frame: &Frame, fate: ReplyFate) {
        let Some(drive) = self.axes.iter_mut().find(|drive| drive.electronics.hears(frame)) else { return };
        if drive.dark > 0 {
            return;
        }
        let shaft = drive.shaft();
        let Some(reply) = drive.electronics.answer(frame, &shaft) else { return };
        match fate {
            ReplyFate::Arrives => wire.arrived.push_back(reply),
            ReplyFate::Lost => {}
            ReplyFate::Late => wire.later.push(reply),
            ReplyFate::Twice => wire.arrived.extend([reply.clone(), reply]),
        }
    }

    /// Positions that the drives measure, rad.
    #[must_use]
    pub fn shown(&self) -> [f64; N] {
        core::array::from_fn(|i| self.axes[i].shaft().position)
    }

    /// The operator sets the zeros of all drives that have power.
    pub fn set_zeros(&mut self) {
        for drive in &mut self.axes {
            if drive.dark == 0 {
                drive.turns = 0;
            }
        }
    }

    /// Ends a period: resets the fates, and restores power.
    pub fn end(&mut self, setup: &Setup) {
        self.stop = self.stop.saturating_sub(1);
        self.bus_off = self.bus_off.saturating_sub(1);
        self.late = false;
        for drive in &mut self.axes {
            (drive.command, drive.reply) = (CommandFate::Arrives, ReplyFate::Arrives);
            if drive.dark == 1 {
                drive.restart(setup);
            }
            drive.dark = drive.dark.saturating_sub(1);
        }
    }
}

impl Drive {
    /// Switches the drive off without an error.
    pub fn trip(&mut self) {
        let Electronics { language, id, .. } = self.electronics;
        let shaft = self.shaft();
        let frame = match language {
            Language::MyActuator => Frame::standard(0x140 + id, vec![0x80, 0, 0, 0, 0, 0, 0, 0]),
            Language::RobStride => Frame { id: 4 << 24 | 0xfd << 8 | u32::from(id), extended: true, data: vec![0; 8] },
            Language::MiniCheetah | Language::Damiao => Frame::standard(id, EXIT.to_vec()),
        };
        // The answer is discarded.
        let _ = self.electronics.answer(&frame, &shaft);
    }

    /// Restarts the drive: off, without errors. If it knows its position only within a turn of its motor and has moved further, its zero is
    /// wrong.
    fn restart(&mut self, setup: &Setup) {
        let shaft = self.shaft();
        self.electronics.memory = Memory::Absolute;
        self.electronics.restart(&shaft);
        if !setup.absolute {
            self.turns = (self.turns + 1) % 3;
        }
    }
}
