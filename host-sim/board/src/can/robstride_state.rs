//! State of a RobStride motor, as its replies show it.

use super::adapter::Adapter;
use super::frame::CanFrame;
use super::motors::{listen, with_id};
use dynamics_core::drive::{Protocol, RobStride};
use embedded_can::Frame as _;
use joint_io::frames::{Frames as _, error_text};
use std::io;

/// Kinds of frames.
const COMMAND: u32 = 1;
const REPLY: u32 = 2;
const ON: u32 = 3;
pub(super) const OFF: u32 = 4;
pub(super) const WRITE: u32 = 18;

/// State of a motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// 0 off, 1 calibrating, 2 on.
    pub(super) code: u32,
    /// Error bits.
    pub(super) error: u8,
    /// Position in the frame, as a share of its range, -1 to 1; `None` at the ends of the range, where the frame cannot say more.
    pub(super) share: Option<f64>,
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
        let share = (!reply.saturated).then_some(reply.position.into());
        Some(Self { code: id >> 22 & 0b11, error: reply.error, share, temperature, is_in_use: false })
    }

    /// True if the motor is off. A motor that calibrates turns.
    pub(super) fn is_off(&self) -> bool {
        self.code == 0
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

/// Listens to the bus. Returns the first of these motors that replies to another program, and its state.
///
/// # Errors
/// The adapter is gone; another program sends frames to one of them, and none replies.
pub(super) fn state_for_others(adapter: &mut dyn Adapter, motors: &[u8]) -> io::Result<Option<(u8, State)>> {
    let mut used = None;
    let replied = listen(adapter, |frame| {
        let (kind, to) = (frame.raw_id() >> 24, frame.raw_id() as u8);
        if frame.is_extended() && matches!(kind, COMMAND | ON | OFF | WRITE) && motors.contains(&to) {
            used = Some(to);
        }
        motors.iter().find_map(|&own| Some((own, State { is_in_use: true, ..State::of(frame, own)? })))
    })?;
    match (replied, used) {
        (None, Some(own)) => Err(io::Error::other(format!(
            "motor {own}: another program sends frames to it, and no reply was seen: nothing was changed"
        ))),
        (replied, _) => Ok(replied),
    }
}
