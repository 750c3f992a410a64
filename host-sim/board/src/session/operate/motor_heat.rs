//! Heat of the motors as the board follows it: asked for every half second while a session runs, and kept for the screen.
//!
//! A motor's time constant is a second or more, so that an older value would hardly differ. The values are parameters of the board
//! ([`session::parameters::HEAT`]), which costs no place in a status.

use super::{Operator, Stop};
use link::{Frame, Value};
use session::parameters::{ARM, HEAT};
use std::time::Duration;

/// Interval at which the heat is asked for.
const EVERY: Duration = Duration::from_millis(500);

/// Heat of a motor, 1 at its continuous limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Heat {
    /// The robot file does not know the motor's rated torque or time constant, or the firmware does not send its heat.
    Unknown,
    /// The board has not answered yet.
    Pending,
    /// The last answer.
    Known(f32),
}

impl Heat {
    /// The board's answer: not a number if it does not know the motor.
    pub(super) fn of(answer: f32) -> Self {
        if answer.is_nan() { Self::Unknown } else { Self::Known(answer) }
    }
}

/// The last heat of each motor, and the question for the next.
#[derive(Clone, Debug, Default)]
pub(super) struct MotorHeat {
    joints: Vec<f32>,
    /// Time of the last question, on the device's clock.
    asked: Option<Duration>,
    /// A command asks for the heat itself, and takes the answers.
    expected: bool,
    /// The firmware is older than this parameter.
    unsupported: bool,
}

impl MotorHeat {
    /// Expects answers to these frames of a command.
    pub(super) fn expect(&mut self, frames: &[Frame]) {
        self.expected = frames.iter().any(|frame| matches!(frame, Frame::Get(index) if joint_of(*index).is_some()));
    }

    pub(super) fn is_expected(&self) -> bool {
        self.expected
    }

    pub(super) fn unsupported(&mut self) {
        self.unsupported = true;
    }

    /// A new session: the board may be another one.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }
}

/// Joint of a parameter that is a heat.
fn joint_of(index: u8) -> Option<usize> {
    (index < ARM && index % 16 == HEAT).then_some(usize::from(index / 16))
}

impl Operator {
    /// Asks for the heat of the motors that the board follows, if the last answers are old.
    pub(super) fn ask_for_heat(&mut self) -> Result<(), Stop> {
        let due = self.heat.asked.is_none_or(|asked| self.silent_for(asked) >= EVERY);
        if !due || !self.agreed || self.heat.unsupported || !self.arm.has_heat.contains(&true) {
            return Ok(());
        }
        self.heat.asked = Some(self.device.now());
        let known = self.arm.has_heat.iter().enumerate().filter(|(_, known)| **known);
        let frames: Vec<Frame> = known.map(|(joint, _)| Frame::Get(16 * joint as u8 + HEAT)).collect();
        frames.iter().try_for_each(|frame| self.send(frame))
    }

    /// Takes note of a heat. Returns true if no command waits for it.
    pub(super) fn takes_heat(&mut self, value: &Value) -> bool {
        let Some(joint) = joint_of(value.index) else { return false };
        if self.heat.joints.len() <= joint {
            self.heat.joints.resize(joint + 1, f32::NAN);
        }
        if let Some(heat) = self.heat.joints.get_mut(joint) {
            *heat = value.value;
        }
        !self.heat.expected
    }

    /// Heat of a joint's motor, as last reported.
    pub(super) fn heat_of(&self, joint: usize) -> Heat {
        if self.heat.unsupported || !self.arm.has_heat.get(joint).is_some_and(|known| *known) {
            return Heat::Unknown;
        }
        match self.heat.joints.get(joint) {
            Some(heat) if !heat.is_nan() => Heat::Known(*heat),
            _ => Heat::Pending,
        }
    }
}
