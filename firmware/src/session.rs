//! From frames to ticks to frames: the state machine between link and controller.
//!
//! ```text
//!            hello agrees                measurement (lock step) or timer
//! waiting ----------------> running --------------------------------------> command
//!    ^                         |  controller brakes, timer overruns
//!    |  hello (any state)      v
//!    +--------------------- fault: every tick answers with the fault; only a hello leaves it
//! ```
//!
//! A hello always starts afresh: the controller is reset, reference and measurement are forgotten, every live input is
//! zero. Live inputs come between ticks and hold from the next one on; they are answered only when they are refused.

use crate::joint_io::Readings;
use crate::meter::{Counter, Meter};
use dynamics_core::control::{
    Command, Configuration, Controller, ControllerConfig, Fault, Measurement, Protection, Reference, Unprotected,
};
use dynamics_core::newton_euler::InverseDynamics;
use dynamics_core::scene::Live;
use dynamics_core::trig::Trig;
use link::codec::Received;
use link::{DecodeError, Frame, Hello, JointCountMismatch, Pacing, Refusal};

/// What the session is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// No hello has agreed yet: the arm is braked and no tick runs.
    Waiting,
    /// Ticks run.
    Running(Pacing),
    /// The controller brakes; ticks run and answer with the fault.
    Fault(Fault, Pacing),
}

/// What a received frame asks for.
#[derive(Clone, Debug, PartialEq)]
pub enum Reaction {
    /// Nothing: it was taken.
    None,
    /// Send these, in order; ticks stop until the next agreed hello.
    Stop(Frame, Frame),
    /// Send this.
    Reply(Frame),
    /// Start pacing like this, and send this hello.
    Start(Pacing, Frame),
    /// Run one tick now.
    Tick,
}

/// The state machine.
pub struct Session<const N: usize, D, T, C = ControllerConfig<f32, N>, P = Unprotected> {
    own: Hello,
    state: State,
    controller: Controller<f32, N, D, T, C, P>,
    reference: Option<Reference<f32, N>>,
    measurement: Option<Measurement<f32, N>>,
    /// The number that the last measurement gave to its tick; the timer counts on from it.
    tick: u32,
    /// A measurement has come since the last tick.
    fresh: bool,
    driving: bool,
}

impl<const N: usize, D, T, C, P> Session<N, D, T, C, P>
where
    D: InverseDynamics<f32, N>,
    T: Trig<f32>,
    C: Configuration<f32, N>,
    P: Protection<f32, N>,
{
    /// A session that waits for a hello like `own`.
    pub fn new(own: Hello, controller: Controller<f32, N, D, T, C, P>) -> Self {
        Self {
            own,
            state: State::Waiting,
            controller,
            reference: None,
            measurement: None,
            tick: 0,
            fresh: false,
            driving: false,
        }
    }

    /// What the session is doing.
    pub fn state(&self) -> State {
        self.state
    }

    /// Take what the link received.
    pub fn receive(&mut self, received: Result<Received, DecodeError>) -> Reaction {
        let received = match received {
            Ok(received) => received,
            Err(error) => return refuse(Refusal::Undecodable(error)),
        };
        if received.missed > 0 {
            return refuse(Refusal::Lost { missed: received.missed });
        }
        match received.frame {
            Frame::Hello(theirs) => self.hello(theirs),
            Frame::Reference(reference) => self.when_agreed(|session| {
                session.reference = Some(reference.to_core()?);
                Ok(Reaction::None)
            }),
            Frame::Measurement(measurement) => self.when_agreed(|session| {
                session.measurement = Some(measurement.to_core()?);
                session.tick = measurement.tick;
                session.fresh = true;
                Ok(session.after_measurement())
            }),
            Frame::Live(live) => self.when_agreed(|session| {
                let values = live.to_core()?;
                if !live.is_finite() {
                    return Ok(refuse(Refusal::NonFiniteLive));
                }
                *session.controller.live_mut() = values;
                Ok(Reaction::None)
            }),
            Frame::Command(_) | Frame::Fault(_) | Frame::Refusal(_) => refuse(Refusal::Unexpected),
        }
    }

    /// One tick, and what it cost: the controller alone, not the link.
    ///
    /// Nothing comes back while the session waits, or while the timer already runs but reference or measurement has not
    /// come yet.
    #[inline]
    pub fn tick<K: Counter>(&mut self, meter: &Meter<K>) -> Option<Frame> {
        let pacing = match self.state {
            State::Waiting => return None,
            State::Running(pacing) | State::Fault(_, pacing) => pacing,
        };
        let reference = self.reference.as_ref()?;
        let measurement = self.measurement.as_mut()?;
        if !core::mem::take(&mut self.fresh) {
            measurement.age_ticks = measurement.age_ticks.saturating_add(1);
            self.tick = self.tick.wrapping_add(1);
        }
        let controller = &mut self.controller;
        let (command, cost) = meter.measure(|| controller.tick(reference, measurement));
        self.driving = matches!(command, Command::Drive { .. });
        if let Command::Brake(fault) = command {
            self.state = State::Fault(fault, pacing);
        }
        Some(Frame::answer(self.tick, &command, cost))
    }

    /// The tick had not ended when the next was due: the next answer is the fault.
    pub fn overrun(&mut self) {
        self.controller.overrun();
    }

    /// Whether the last tick drove the joints and nothing has happened since that must stop them.
    pub fn drives(&self) -> bool {
        self.driving && self.controller.fault().is_none()
    }

    /// The torques or forces of the tick that gave this answer, N m or N; `None` when the joints must stop.
    #[inline]
    pub fn torque(&self, answer: &Frame) -> Option<[f32; N]> {
        match answer {
            Frame::Command(command) if self.drives() => command.torque.as_slice().try_into().ok(),
            _ => None,
        }
    }

    /// Take what the board's own joints say, in place of a measurement from the link. Call it at the start of a tick.
    ///
    /// A joint at fault stops the arm as a measurement that is lost does.
    pub fn sense(&mut self, readings: &Readings<N>) {
        if self.state == State::Waiting {
            return;
        }
        self.measurement = Some(readings.measurement());
        self.tick = self.tick.wrapping_add(1);
        self.fresh = true;
        if readings.is_faulty() {
            self.controller.measurement_lost();
        }
    }

    fn hello(&mut self, theirs: Hello) -> Reaction {
        self.controller.reset();
        *self.controller.live_mut() = Live::zero();
        self.reference = None;
        self.measurement = None;
        self.fresh = false;
        self.driving = false;
        let answer = Frame::Hello(Hello { pacing: theirs.pacing, ..self.own });
        if (Hello { pacing: self.own.pacing, ..theirs }) != self.own {
            self.state = State::Waiting;
            return Reaction::Stop(answer, Frame::Refusal(Refusal::OtherRobot));
        }
        self.state = State::Running(theirs.pacing);
        Reaction::Start(theirs.pacing, answer)
    }

    fn when_agreed(&mut self, take: impl FnOnce(&mut Self) -> Result<Reaction, JointCountMismatch>) -> Reaction {
        if self.state == State::Waiting {
            return refuse(Refusal::NoHello);
        }
        take(self).unwrap_or_else(|mismatch| {
            refuse(Refusal::JointCount { expected: mismatch.expected as u8, found: mismatch.found as u8 })
        })
    }

    fn after_measurement(&self) -> Reaction {
        match self.state {
            State::Running(Pacing::Timer) | State::Fault(_, Pacing::Timer) | State::Waiting => Reaction::None,
            State::Running(Pacing::LockStep) | State::Fault(_, Pacing::LockStep) if self.reference.is_none() => {
                refuse(Refusal::NoReference)
            }
            State::Running(Pacing::LockStep) | State::Fault(_, Pacing::LockStep) => Reaction::Tick,
        }
    }
}

fn refuse(refusal: Refusal) -> Reaction {
    Reaction::Reply(Frame::Refusal(refusal))
}
