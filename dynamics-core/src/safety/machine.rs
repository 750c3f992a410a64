//! The safety state machine.

use super::measured::JudgedInput;
use super::memory::{Action, Decision, MachineMemory, Now};
use super::ordinary::{goes_on, is_quiet};
use super::{Actuation, Inputs, Output, Rules, SafetyConfiguration, State};
use crate::control::{Command, Fault, LimitFlags, Observed, Reference, TorqueRequest};
use crate::scalar::Real;

/// The state machine around a controller. See the [module](super) for its states and `docs/safety.md` for its rules.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Safety<S, const N: usize, C> {
    config: C,
    /// The machine's own observer, which runs in every state.
    observed: Observed<S, N>,
    memory: MachineMemory<S, N>,
}

impl<S: Real, const N: usize, C: SafetyConfiguration<S, N>> Safety<S, N, C> {
    /// A machine that idles, not homed.
    #[must_use]
    pub fn new(config: C) -> Self {
        Self { config, observed: Observed::new(), memory: MachineMemory::new() }
    }

    /// State of the machine.
    #[inline]
    #[must_use]
    pub fn state(&self) -> State {
        self.memory.state
    }

    /// The rules.
    #[must_use]
    pub fn rules(&self) -> &Rules<S, N> {
        self.config.rules()
    }

    /// True if the arm comes to rest along its path: the next reference should be on the path, slower.
    #[must_use]
    pub fn stops_along(&self) -> bool {
        self.memory.along
    }

    /// Resets everything but the heat of the motors: no host can cool them.
    pub fn reset(&mut self, config: C) {
        let heats = self.memory.heats;
        *self = Self::new(config);
        self.memory.heats = heats;
    }

    /// Heat of each motor, 1 at its continuous limit; 0 if it is not known ([`super::heat`]).
    #[must_use]
    pub fn heat(&self) -> &[S; N] {
        &self.memory.heats.heat
    }

    /// True if the joints' zeros have been confirmed.
    #[must_use]
    pub fn homed(&self) -> bool {
        self.memory.homed
    }

    /// One tick. Total: every input gives torques inside their limits or the safe action.
    ///
    /// `control` is called once if torque may act, with the reference to follow, and not at all otherwise.
    pub fn tick(
        &mut self,
        inputs: &Inputs<S, N>,
        control: impl FnOnce(TorqueRequest<'_, S, N>) -> Command<S, N>,
    ) -> Output<S, N> {
        let mut output = Output::silent(self.config.rules().safe_action);
        let hand_guided = self.config.get().law.is_hand_guided();
        self.tick_into(&mut output, inputs, hand_guided, |ask, torque, limits| match control(*ask) {
            Command::Drive { torque: given, limits: acted } => {
                (*torque, *limits) = (given, acted);
                Ok(())
            }
            Command::Brake(fault) => Err(fault),
        });
        output
    }

    /// As [`Safety::tick`], but writes the output to `output`. `control` writes its torques and the limits that acted on the reference to
    /// buffers of the machine; before the call they are zero and none. `hand_guided` is true if the controller's law
    /// [is hand-guided](crate::control::ControlLaw::is_hand_guided) now; the reference is then the arm's own position.
    ///
    /// Cost in addition to the controller's: `O(N)`, no division, no root. An ordinary tick makes the same comparisons for any
    /// numbers: the arm runs, there is no request, every joint answers.
    #[inline]
    pub fn tick_into(
        &mut self,
        output: &mut Output<S, N>,
        inputs: &Inputs<S, N>,
        hand_guided: bool,
        control: impl FnOnce(&TorqueRequest<'_, S, N>, &mut [S; N], &mut [LimitFlags; N]) -> Result<(), Fault>,
    ) {
        let Self { config: source, observed, memory } = self;
        let (config, rules) = (source.get(), source.rules());
        // After a compliant tick the reference acceleration is unknown; zero is used.
        let still = [S::zero(); N];
        let acceleration = if memory.gave_way { &still } else { &memory.reference.qdd };
        let mut read = still;
        let mut ages = 0;
        for age in &inputs.age_ticks {
            ages |= *age;
        }
        let fresh = ages == 0;
        let aged = (fresh, &inputs.age_ticks);
        let (read, q, qd) = observed.update(config, acceleration, &inputs.sensed, aged, &mut read);
        let seen = JudgedInput { read, q, qd };
        let silent = inputs.heartbeat_age > rules.heartbeat_max;
        let drove = memory.state.has_torque();

        let here;
        let reference = match &inputs.reference {
            Some(_) if hand_guided => {
                here = where_it_is(q);
                Some(&here)
            }
            reference => reference.as_ref(),
        };

        let ordinary = match reference {
            Some(reference)
                if memory.state == State::Running
                    && memory.sensors.fresh
                    && fresh
                    && memory.beyond_weight(rules).is_none()
                    && is_quiet(inputs, rules) =>
            {
                let goes_on = goes_on(&seen, &memory.sensors.last, reference, config, rules);
                if goes_on {
                    memory.go_on(read, reference);
                }
                goes_on
            }
            _ => false,
        };
        let mut decision = match ordinary {
            true => Decision::of(Action::Drive),
            false => memory.decide(&Now { inputs, reference, seen: &seen, silent, hand_guided }, config, rules),
        };
        // One call for all of them: a second call would put a second copy of the controller into the program.
        if decision.action.asks() {
            let drives = decision.action.drives();
            let (mut torque, mut limits) = (still, [LimitFlags::NONE; N]);
            let MachineMemory { reference, torque: last, limits: acted, .. } = &*memory;
            // On engaged brakes, the torque is that of the weight, at rest at the memory's reference. It contains no sensor noise, so its rise
            // comes to an end. In the first tick of arming it is computed but not driven: if the arm cannot be held, its drives are not switched on.
            // While the arm is disarmed, it is held as before until its brakes have engaged.
            let measured = drives || memory.state == State::Disarming;
            let (q, qd) = if measured { (q, qd) } else { (&reference.q, &still) };
            let ask = TorqueRequest {
                start: !drove,
                at_once: decision.action == Action::DriveAtOnce,
                reference,
                ordinary,
                beyond_weight: memory.beyond_weight(rules),
                is_running: memory.state == State::Running,
                q,
                qd,
                torque: last,
                limits: acted,
            };
            // Limits that the controller applies itself start with its first torque: it does not know the torque before.
            match control(&ask, &mut torque, &mut limits).and_then(|()| ask.hold(config, &mut torque, &mut limits)) {
                Err(fault) => decision = memory.fail(fault, inputs.request),
                Ok(()) if drives => {
                    if let Some(held) = &memory.held {
                        flag(&mut limits, held);
                    }
                    (memory.torque, memory.limits) = (torque, limits);
                    memory.gave_way = LimitFlags::any(&limits) && gives_way(&limits);
                    if memory.is_warm(rules) {
                        memory.flag_warm(&mut limits);
                    }
                    output.actuation = Actuation::Drive { torque, limits };
                }
                Ok(()) if decision.action == Action::Preload => {
                    memory.carry(&torque, &mut limits, rules);
                    output.actuation = Actuation::Preload { torque, limits };
                }
                Ok(()) => {}
            }
        }
        if decision.action > Action::Preload {
            memory.rest();
            output.actuation = match decision.action {
                Action::Safe => Actuation::Safe(rules.safe_action),
                _ => Actuation::Enable(rules.safe_action),
            };
        }
        if let Some(heat) = &rules.heat {
            memory.heats.update(heat, &memory.torque);
        }
        output.refused = decision.refused;
        (output.state, output.homed) = (memory.state, memory.homed);
    }
}

impl<S: Real, const N: usize> MachineMemory<S, N> {
    /// Torque acts on engaged brakes. Counts the ticks in which it carries the whole weight, or the ticks of disarming.
    #[cold]
    fn carry(&mut self, torque: &[S; N], limits: &mut [LimitFlags; N], rules: &Rules<S, N>) {
        (self.torque, self.limits) = (*torque, *limits);
        if self.state == State::Disarming {
            self.arming.ticks += 1;
            self.gave_way = gives_way(limits);
        }
        if let Some(held) = &self.held {
            flag(limits, held);
        }
        if self.is_warm(rules) {
            self.flag_warm(limits);
        }
        let rises = limits.iter().any(|flags| flags.contains(LimitFlags::TORQUE_RATE));
        self.arming.carried = if rises { 0 } else { self.arming.carried.saturating_add(1) };
    }
}

/// True if the controller was compliant because of a collision.
#[cold]
fn gives_way<const N: usize>(limits: &[LimitFlags; N]) -> bool {
    limits.iter().any(|flags| flags.contains(LimitFlags::COLLISION))
}

/// Adds limits that the machine has applied.
#[cold]
fn flag<const N: usize>(limits: &mut [LimitFlags; N], held: &[LimitFlags; N]) {
    for i in 0..N {
        limits[i] |= held[i];
    }
}

/// The reference of a hand-guided arm: at rest at its position, also beyond a position limit. So the arm is not pushed back when the hand lets go.
#[inline]
fn where_it_is<S: Real, const N: usize>(q: &[S; N]) -> Reference<S, N> {
    Reference::at_rest(*q)
}
