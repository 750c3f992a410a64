//! Safety check of each command, written from `docs/safety.md` without using any code of the judged machine.
//!
//! After every tick the judge receives the machine's inputs, the requests that the host may have made, and the machine's output. It keeps its own
//! record of homing, latched faults, acting torque and silence. Limits, guards and times come from the scene. The judge computes in f64 and reports a
//! violation only if a bound is exceeded by more than the rounding of f32.
//!
//! A campaign and the fuzz target `session` share the judge, but provide different information. The campaign's readings come from a simulated arm
//! ([`Trust`]); the fuzz target knows every message that the machine accepted ([`Heard::exact`]).

mod fault;
mod law;
mod observation;
mod reference;
mod torque;
mod transition;

pub(super) use law::broken;
pub use law::{SafetyProperty, Unsafe};

use super::machine::{TickInputs, TickOutput};
use dynamics_core::ControllerConfig;
use dynamics_core::safety::Rules;
use link::Request;
use link::StateCode;
use observation::{Observation, torque};

/// Trust in readings and model; each level includes the previous one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Trust {
    /// Readings may be arbitrary: each is judged alone and against the previous one.
    Nothing,
    /// Readings come from a real motion: mean speeds from encoders are judged, too.
    Arm,
    /// Readings and model are correct, so holding must lead to rest.
    Loop,
}

/// Messages of the host since the previous tick.
#[derive(Clone, Copy, Debug)]
pub struct Heard<'a> {
    /// Requests that the machine may have accepted, in order.
    pub requests: &'a [Request],
    /// True if the machine may have received any message of the host.
    pub spoke: bool,
    /// True if the messages above are exactly those accepted. There is then at most one request, so that its answer can be checked.
    pub exact: bool,
}

/// Judge of one run.
#[derive(Clone, Debug)]
pub struct Judge<const N: usize> {
    config: ControllerConfig<f64, N>,
    rules: Rules<f64, N>,
    observation: Observation<N>,
    now: i64,
    /// State and cause of the previous tick.
    before: (StateCode, u8),
    homed: bool,
    /// Torque that acted in the previous tick, N m or N.
    torque: Option<[f64; N]>,
    /// Number of consecutive ticks with torque.
    acted: usize,
    /// Ticks since the machine may last have received a message of the host.
    silent: u32,
    /// Position of the arm when it was armed, rad or m.
    armed: [f64; N],
    /// Number of consecutive ticks of holding, and of disarming.
    held: u32,
    disarms: u32,
    /// True if disarming was not requested: the host is gone, or a motor is too hot.
    lost: bool,
    /// Ticks of holding after which the arm must be at rest.
    rest_after: u32,
    trust: Trust,
}

impl<const N: usize> Judge<N> {
    /// Creates the judge of a machine that has just started.
    #[must_use]
    pub fn new(config: &ControllerConfig<f64, N>, rules: &Rules<f64, N>, trust: Trust) -> Self {
        let stop = |i: usize| {
            let velocity = config.limits[i].velocity;
            let slowing = if velocity.is_finite() { velocity / rules.joints[i].deceleration } else { 1.0 };
            // Remaining position error: after five time constants 4 % of its speed.
            slowing + 5.0 / config.gains[i].position.sqrt() + 0.02
        };
        let rest = (0..N).map(stop).fold(0.0, f64::max);
        Self {
            config: *config,
            rules: *rules,
            observation: Observation::new(config),
            now: 0,
            before: (StateCode::Idle, 0),
            homed: false,
            torque: None,
            acted: 0,
            silent: u32::MAX,
            armed: [0.0; N],
            held: 0,
            disarms: 0,
            lost: false,
            rest_after: (rest / rules.period).ceil() as u32,
            trust,
        }
    }

    /// Starts again, as after a hello.
    pub fn reset(&mut self) {
        *self = Self::new(&self.config, &self.rules, self.trust);
    }

    /// Judges a tick.
    ///
    /// # Errors
    /// [`Unsafe`]: the first violated property.
    pub fn watch(&mut self, told: &TickInputs<N>, heard: &Heard<'_>, said: &TickOutput<N>) -> Result<(), Unsafe> {
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
        self.disarmed(heard, status)?;
        self.torque(said)?;
        self.faults(&board, &seen, heard, said)?;
        self.silence(heard, said)?;
        self.reference(&seen, status)?;
        self.rest(status)?;
        self.standing(&seen, status)?;

        self.before = (status.state, status.cause);
        self.torque = torque(&said.drives);
        self.acted = if self.torque.is_some() { self.acted + 1 } else { 0 };
        Ok(())
    }
}
