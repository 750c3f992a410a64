//! Actuators of ideal drives: transport delay, saturation, first-order lag and torque ripple. Each effect is computed only if the scene asks for it.

use dynamics_core::JointKind;
use robot_compiler::scene::Ripple;
use std::collections::VecDeque;
use std::f64::consts::TAU;

/// Effects of the actuators on a commanded torque, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct ActuatorSettings {
    /// Ticks between command and action.
    pub delay: usize,
    /// Clip at the joint's torque limit.
    pub saturation: bool,
    /// Time constant of the torque, s; `None` acts at once.
    pub lag: Option<f64>,
    /// Ripple of the torque over the joint's position.
    pub ripple: Option<Ripple>,
}

/// Torques after ripple, N m or N, at these joint positions.
#[must_use]
pub fn rippled<const N: usize>(ripple: Ripple, kinds: &[JointKind; N], torque: &[f64; N], q: &[f64; N]) -> [f64; N] {
    #[cfg(test)]
    super::calls::count(super::calls::Effect::Ripple);
    core::array::from_fn(|i| {
        let phase = match kinds[i] {
            JointKind::Revolute => ripple.cycles * q[i],
            JointKind::Prismatic => TAU * ripple.cycles * q[i],
        };
        torque[i] * (1.0 + ripple.share * libm::sin(phase))
    })
}

/// The actuators of an arm.
#[derive(Clone, Debug)]
pub(super) struct Actuators<const N: usize> {
    settings: ActuatorSettings,
    torque_max: [f64; N],
    /// Commands that are still delayed, oldest first.
    pipe: VecDeque<[f64; N]>,
    /// Torque curve since the last command, in the last tick's time.
    last: Drive<N>,
}

/// Torque from the instant `s` of a tick on: `goal + (start - goal) exp(-(t - s) / lag)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drive<const N: usize> {
    start: [f64; N],
    goal: [f64; N],
    lag: Option<f64>,
    since: f64,
}

impl<const N: usize> Actuators<N> {
    /// Actuators without torque until the first command has passed the delay.
    pub(super) fn new(settings: ActuatorSettings, torque_max: [f64; N]) -> Self {
        let pipe = core::iter::repeat_n([0.0; N], settings.delay).collect();
        let last = Drive { lag: settings.lag, ..Drive::none() };
        Self { settings, torque_max, pipe, last }
    }

    /// Discards all earlier commands, because the drives were off.
    pub(super) fn released(&mut self) {
        *self = Self::new(self.settings, self.torque_max);
    }

    /// Returns the torque curves of the next tick, of length `period` (s), before and after `since` (s into the tick), when the new command takes
    /// effect.
    pub(super) fn drive(&mut self, command: &[f64; N], period: f64, since: f64) -> (Drive<N>, Drive<N>) {
        let mut goal = if self.settings.delay > 0 {
            #[cfg(test)]
            super::calls::count(super::calls::Effect::ActuatorDelay);
            self.pipe.push_back(*command);
            self.pipe.pop_front().unwrap_or(*command)
        } else {
            *command
        };
        if self.settings.saturation {
            #[cfg(test)]
            super::calls::count(super::calls::Effect::Saturation);
            for i in 0..N {
                let most = self.torque_max[i];
                let above = if goal[i] < -most { -most } else { goal[i] };
                goal[i] = if above > most { most } else { above };
            }
        }
        let before = Drive { since: self.last.since - period, ..self.last };
        let drive = Drive { start: before.at(since), goal, lag: self.settings.lag, since };
        self.last = drive;
        (before, drive)
    }
}

impl<const N: usize> Drive<N> {
    /// No torque.
    pub(super) const fn none() -> Self {
        Self { start: [0.0; N], goal: [0.0; N], lag: None, since: 0.0 }
    }

    /// True if the torque is the same at all times.
    pub(super) const fn is_constant(&self) -> bool {
        self.lag.is_none()
    }

    /// Torque at time `t` (s) into the tick.
    pub(super) fn at(&self, t: f64) -> [f64; N] {
        match self.lag {
            None => self.goal,
            Some(lag) => {
                #[cfg(test)]
                super::calls::count(super::calls::Effect::Lag);
                let left = libm::exp(-(t - self.since) / lag);
                core::array::from_fn(|i| self.goal[i] + (self.start[i] - self.goal[i]) * left)
            }
        }
    }
}
