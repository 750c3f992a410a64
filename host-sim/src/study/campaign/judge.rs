//! Whether a command was safe: from `docs/safety.md`, without a line of the machine that is judged.
//!
//! After every tick the judge is shown what the machine was told, what the host may have asked for, and what the machine did. It keeps
//! its own account of homing, latched faults, acting torque and silence. Numbers (limits, guards, times) are the scene's; arithmetic is
//! f64, and only what is beyond a bound by more than the rounding of f32 counts.
//!
//! A campaign and the fuzz target `session` share it. They differ in what they know: the campaign's readings come from a simulated arm
//! ([`Trust`]), the fuzz target knows each word that the machine took ([`Heard::exact`]).

mod fault;
mod law;
mod observation;
mod reference;
mod torque;
mod transition;

pub use law::{Law, Unsafe};

use super::machine::{Said, Told};
use crate::session::states::IDLE;
use dynamics_core::ControllerConfig;
use dynamics_core::safety::Rules;
use link::Request;
use observation::Observation;
use torque::torque;

/// Extent to which readings and model are believed, each more than the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Trust {
    /// Readings can be anything: each is judged by itself and against the one before.
    Nothing,
    /// Readings are those of an arm that moves as one: encoders' speeds are judged by their means, too.
    Arm,
    /// Readings are true, and so is the model, so that holding must lead to rest.
    Loop,
}

/// Words of the host since the tick before.
#[derive(Clone, Copy, Debug)]
pub struct Heard<'a> {
    /// Requests that may have been taken, the last one last.
    pub requests: &'a [Request],
    /// Something may have been taken for a word of the host.
    pub spoke: bool,
    /// That is exactly what was taken: at most one request, and what must be answered can be.
    pub exact: bool,
}

/// Judge of one run.
#[derive(Clone, Debug)]
pub struct Judge<const N: usize> {
    config: ControllerConfig<f64, N>,
    rules: Rules<f64, N>,
    observation: Observation<N>,
    now: i64,
    /// State and cause of the tick before.
    before: (u8, u8),
    homed: bool,
    /// The torque that acted in the tick before, N m or N.
    torque: Option<[f64; N]>,
    /// Ticks in a row that torque has acted.
    acted: usize,
    /// Ticks since the host may have been heard.
    silent: u32,
    /// Ticks in a row that the arm has held.
    held: u32,
    /// Ticks after which an arm that holds rests.
    rest_after: u32,
    trust: Trust,
}

impl<const N: usize> Judge<N> {
    /// Judge of a machine that has just been started.
    #[must_use]
    pub fn new(config: &ControllerConfig<f64, N>, rules: &Rules<f64, N>, trust: Trust) -> Self {
        let stop = |i: usize| {
            let velocity = config.limits[i].velocity;
            let slowing = if velocity.is_finite() { velocity / rules.joints[i].deceleration } else { 1.0 };
            // The error that is left of the way: at five time constants 4 % of its speed.
            slowing + 5.0 / config.gains[i].position.sqrt() + 0.02
        };
        let rest = (0..N).map(stop).fold(0.0, f64::max);
        Self {
            config: *config,
            rules: *rules,
            observation: Observation::new(config),
            now: 0,
            before: (IDLE, 0),
            homed: false,
            torque: None,
            acted: 0,
            silent: u32::MAX,
            held: 0,
            rest_after: (rest / rules.period).ceil() as u32,
            trust,
        }
    }

    /// Begin again, as after a hello.
    pub fn reset(&mut self) {
        *self = Self::new(&self.config, &self.rules, self.trust);
    }

    /// Judge a tick.
    ///
    /// # Errors
    /// [`Unsafe`]: the first law that is broken.
    pub fn watch(&mut self, told: &Told<N>, heard: &Heard<'_>, said: &Said<N>) -> Result<(), Unsafe> {
        self.now += 1;
        self.silent = if heard.spoke { 0 } else { self.silent.saturating_add(1) };
        let acted = if self.trust >= Trust::Arm { Some(self.acted) } else { None };
        let seen = self.observation.look(self.now, told, &self.config, &self.rules, acted);
        let board = self.board(told);
        let status = &said.status;
        if seen.faults.contains(&8) {
            self.homed = false;
        }

        self.reported(said)?;
        self.moved(told, heard, status)?;
        self.torque(said)?;
        self.faults(&board, &seen, said)?;
        self.silence(heard, said)?;
        self.reference(&seen, status)?;
        self.rest(status)?;

        self.before = (status.state, status.cause);
        self.torque = torque(&said.drives);
        self.acted = if self.torque.is_some() { self.acted + 1 } else { 0 };
        Ok(())
    }
}
