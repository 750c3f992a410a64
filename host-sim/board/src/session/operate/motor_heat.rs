//! Heat of the motors, as the board computes it. It is requested every half second while a session runs, and kept for display.
//!
//! A motor's time constant is a second or more, so a value of half a second ago hardly differs. The values are parameters of the board
//! ([`session::parameters::HEAT`]) and therefore need no bytes in a status.

use super::heat::{Heat, joint_of};
use super::{Operator, Stop};
use link::{Frame, Value};
use session::parameters::HEAT;
use std::time::Duration;

/// Interval of the requests.
const EVERY: Duration = Duration::from_millis(500);

impl Operator {
    /// Requests the heat of the motors that the board observes, if the last request is old enough.
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

    /// Stores a heat. Returns true if the answer was not requested by a command.
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
