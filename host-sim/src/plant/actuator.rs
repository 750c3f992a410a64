//! Actuators: transport delay, saturation, first-order lag; each only when asked for.

use std::collections::VecDeque;

/// What the actuators do to a commanded torque, in this order.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct ActuatorSettings {
    /// Ticks between command and action.
    pub delay: usize,
    /// Clip at the joint's torque limit.
    pub saturation: bool,
    /// Time constant of the torque, s; `None` acts at once.
    pub lag: Option<f64>,
}

/// The actuators of an arm.
#[derive(Clone, Debug)]
pub(super) struct Actuators<const N: usize> {
    settings: ActuatorSettings,
    torque_max: [f64; N],
    /// Commands on their way, oldest first.
    pipe: VecDeque<[f64; N]>,
    /// Torque at the end of the last tick.
    torque: [f64; N],
}

/// Torque over one tick: `goal + (start - goal) exp(-t / lag)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drive<const N: usize> {
    start: [f64; N],
    goal: [f64; N],
    lag: Option<f64>,
}

impl<const N: usize> Actuators<N> {
    /// Actuators that give no torque until the first command has come through.
    pub(super) fn new(settings: ActuatorSettings, torque_max: [f64; N]) -> Self {
        let pipe = core::iter::repeat_n([0.0; N], settings.delay).collect();
        Self { settings, torque_max, pipe, torque: [0.0; N] }
    }

    /// The torque over the next tick, of length `period` (s), for a new command.
    pub(super) fn drive(&mut self, command: &[f64; N], period: f64) -> Drive<N> {
        let mut goal = if self.settings.delay > 0 {
            self.pipe.push_back(*command);
            self.pipe.pop_front().unwrap_or(*command)
        } else {
            *command
        };
        if self.settings.saturation {
            for i in 0..N {
                goal[i] = goal[i].clamp(-self.torque_max[i], self.torque_max[i]);
            }
        }
        let drive = Drive { start: self.torque, goal, lag: self.settings.lag };
        self.torque = drive.at(period);
        drive
    }
}

impl<const N: usize> Drive<N> {
    /// Torque at time `t` (s) into the tick.
    pub(super) fn at(&self, t: f64) -> [f64; N] {
        match self.lag {
            None => self.goal,
            Some(lag) => {
                let left = libm::exp(-t / lag);
                core::array::from_fn(|i| self.goal[i] + (self.start[i] - self.goal[i]) * left)
            }
        }
    }
}
