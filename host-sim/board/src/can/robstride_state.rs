//! State of a RobStride motor, as its replies show it.

use super::frame::CanFrame;
use super::motors::with_id;
use dynamics_core::drive::{Protocol, RobStride};
use embedded_can::Frame as _;
use joint_io::frames::{Frames as _, error_text};

/// Kind of a reply's frame.
const REPLY: u32 = 2;

/// State of a motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// 0 off, 1 calibrating, 2 on.
    pub(super) code: u32,
    /// Error bits.
    pub(super) error: u8,
    /// Temperature, degrees Celsius.
    pub temperature: f64,
    /// True if the motor sends replies that this program did not ask for.
    pub is_in_use: bool,
}

impl State {
    /// The state in a reply of this motor to any program.
    pub(super) fn of(answer: &CanFrame, own: u8) -> Option<Self> {
        let id = answer.raw_id();
        if !answer.is_extended() || id >> 24 != REPLY || (id >> 8) as u8 != own {
            return None;
        }
        let reply = RobStride::reply(&with_id(own), answer.id(), answer.data())?;
        let &[.., high, low] = answer.data() else { return None };
        let temperature = f64::from(u16::from_be_bytes([high, low])) / 10.0;
        Some(Self { code: id >> 22 & 0b11, error: reply.error, temperature, is_in_use: false })
    }

    /// Text of the state and of its error.
    #[must_use]
    pub fn text(&self) -> String {
        let state = match self.code {
            0 => "off",
            1 => "calibrating",
            2 => "on",
            _ => "in a state that its manual does not name",
        };
        let error = if self.error == 0 { "" } else { error_text(Protocol::RobStride)(self.error) };
        let user = if self.is_in_use { "another program uses it, or it reports by itself" } else { "" };
        let parts: Vec<&str> = [state, error, user].into_iter().filter(|part| !part.is_empty()).collect();
        parts.join("; ")
    }
}
