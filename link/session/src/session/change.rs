//! Changes of live inputs and parameters. While no torque acts, they are made between ticks; otherwise by the tick that has computed their
//! effect.

use super::waiting::Change;
use super::{Buffers, Outcome, Session};
use crate::parameters;
use core::borrow::BorrowMut;
use dynamics_core::control::{ArmBuild, Configuration, ControllerConfig, Fault, LimitFlags, TorqueRequest};
use dynamics_core::safety::SafetyConfiguration as _;
use dynamics_core::scene::Live;
use link::{Pacing, Refusal, Setting, Value};

/// Largest permitted jump of a joint's torque as a share of its torque limit, if no torque rate is given.
pub const JUMP: f32 = 0.02;

impl<const N: usize, A: ArmBuild<f32, N>, B: BorrowMut<Buffers<N>>> Session<N, A, B> {
    pub(super) fn live(&mut self, pacing: Pacing, live: &Live<f32, N>) -> Result<Outcome, Refusal> {
        let change = Change::Live(*live);
        if pacing.is_supervised() {
            self.change(change)?;
        } else {
            change.make(&mut self.controller);
        }
        Ok(Outcome::None)
    }

    /// Makes a change at once if no torque acts, otherwise in the next tick. Returns true if it is made already.
    fn change(&mut self, change: Change<N>) -> Result<bool, Refusal> {
        // While arming, torque may act on engaged brakes, and the brakes are about to open.
        let state = self.supervisor.state();
        if !state.has_or_awaits_torque() {
            self.make(&change);
            return Ok(true);
        }
        if self.change.is_some() || self.changed.is_full() {
            return Err(Refusal::Busy);
        }
        self.change = Some(change);
        Ok(false)
    }

    fn make(&mut self, change: &Change<N>) {
        change.make(&mut self.controller);
        if matches!(change, Change::Live(_)) {
            self.supervisor.live_came();
        }
    }

    pub(super) fn value(&mut self, index: u8) -> Result<Value, Refusal> {
        let tunable = self.is_tunable();
        let (built_in, payload) = (self.safety.get(), &self.safety.rules().payload);
        let (config, live) = (self.controller.config(), self.controller.live());
        let mut value = parameters::read(index, config, built_in, live, payload, tunable)?;
        if index < parameters::ARM && index % 16 == parameters::HEAT {
            value.value = self.supervisor.heat(usize::from(index / 16));
        }
        Ok(value)
    }

    pub(super) fn set(&mut self, setting: Setting) -> Result<Outcome, Refusal> {
        let tunable = self.is_tunable();
        let payload = &self.safety.rules().payload;
        parameters::check(setting, self.safety.get(), self.controller.live(), payload, tunable)?;
        // A hand-guided arm's reference is its own position, that of any other arm comes from the trajectory: no switching during a motion.
        if setting.index == parameters::LAW && self.supervisor.runs_or_stops() {
            return Err(Refusal::Running);
        }
        Ok(match self.change(Change::Parameter(setting))? {
            true => Outcome::Value(self.value(setting.index)?),
            // The tick that makes the change answers it.
            false => Outcome::None,
        })
    }

    fn is_tunable(&mut self) -> bool {
        self.tunable && self.controller.config_mut().is_some()
    }

    /// Makes a change that has waited, or refuses it if the torque of joint `jumps` would jump.
    #[cold]
    pub(super) fn settle(&mut self, change: &Change<N>, jumps: Option<u8>) {
        let changed = match jumps {
            Some(joint) => Some(Err(Refusal::WouldJump { joint })),
            None => {
                self.make(change);
                match change {
                    Change::Live(_) => None,
                    Change::Parameter(setting) => self.value(setting.index).ok().map(Ok),
                }
            }
        };
        if let Some(changed) = changed {
            // There is capacity: otherwise the change would not have been accepted.
            self.changed.push_back(changed).ok();
        }
    }
}

/// Torques, and the limits that acted.
pub(super) type Torques<const N: usize> = ([f32; N], [LimitFlags; N]);

/// Returns the first joint for which a change would make the torque jump by more than permitted, if there is one. It also counts as a jump if a
/// limit acts on only one of both answers, because the limited torque hides the true difference.
#[cold]
pub(super) fn jump<const N: usize>(
    ask: &TorqueRequest<'_, f32, N>,
    config: &ControllerConfig<f32, N>,
    now: Result<Torques<N>, Fault>,
    then: Result<Torques<N>, Fault>,
) -> Option<u8> {
    let held = |answer: Result<Torques<N>, Fault>| {
        let (mut torque, mut limits) = answer?;
        ask.hold(config, &mut torque, &mut limits).map(|()| (torque, limits))
    };
    let (Ok((torque, limits)), Ok((other, others))) = (held(now), held(then)) else { return Some(0) };
    let held = LimitFlags::TORQUE | LimitFlags::TORQUE_RATE;
    let jumps = |i: usize| {
        let share = JUMP * config.limits[i].torque;
        let most = if config.torque_step[i].is_finite() { config.torque_step[i] } else { share };
        let near = (torque[i] - other[i]).abs() <= most;
        !near || limits[i].bits() & held.bits() != others[i].bits() & held.bits()
    };
    (0..N).find(|&i| jumps(i)).map(|joint| joint as u8)
}
