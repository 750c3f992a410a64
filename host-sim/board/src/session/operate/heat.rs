//! Heat of the motors, as the board last reported it.

use link::Frame;
use session::parameters::{ARM, HEAT};
use std::time::Duration;

/// Heat of a motor; 1 at its continuous limit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Heat {
    /// The robot file does not give the motor's rated torque or time constant, or the firmware does not send its heat.
    Unknown,
    /// The board has not answered yet.
    Pending,
    /// The last answer.
    Known(f32),
}

impl Heat {
    /// Converts the board's answer, which is NaN if the board does not know the motor.
    pub(super) fn of(answer: f32) -> Self {
        if answer.is_nan() { Self::Unknown } else { Self::Known(answer) }
    }
}

/// The last heat of each motor, and the state of the next request.
#[derive(Clone, Debug, Default)]
pub(super) struct MotorHeat {
    pub(super) joints: Vec<f32>,
    /// Time of the last question, on the device's clock.
    pub(super) asked: Option<Duration>,
    /// True if a command requests the heat itself, and takes the answers.
    pub(super) expected: bool,
    /// True if the firmware is too old for this parameter.
    pub(super) unsupported: bool,
}

impl MotorHeat {
    /// Notes which answers a command with these frames expects.
    pub(super) fn expect(&mut self, frames: &[Frame]) {
        self.expected = frames.iter().any(|frame| matches!(frame, Frame::Get(index) if joint_of(*index).is_some()));
    }

    pub(super) fn is_expected(&self) -> bool {
        self.expected
    }

    pub(super) fn unsupported(&mut self) {
        self.unsupported = true;
    }

    /// Resets everything for a new session, because the board may be another one.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }
}

/// Joint of a parameter, if the parameter is a heat.
pub(super) fn joint_of(index: u8) -> Option<usize> {
    (index < ARM && index % 16 == HEAT).then_some(usize::from(index / 16))
}
