//! The operator: a function from what the board reports to the next request.

use crate::scene::{MOTION_TICKS, TOP};
use dynamics_core::safety::State;
use link::{Frame, Point, Reference, Request};

/// Presence of the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presence {
    /// It sends in every period.
    Here,
    /// It is silent for so many more periods.
    Away(u8),
    /// It is silent until it says hello again.
    Gone,
}

/// The operator's memory.
#[derive(Clone, Copy, Debug)]
pub struct Host<const N: usize> {
    /// Presence.
    pub presence: Presence,
    /// Frames of the next batch that go before the one that is lost.
    pub lose: Option<u8>,
    /// Packets lost since the last that arrived.
    pub owed: u8,
    /// Periods until the next request.
    pub pause: u8,
    /// Joint positions that the board reported last, rad.
    pub seen: [f32; N],
}

impl<const N: usize> Host<N> {
    /// A host that is there.
    #[must_use]
    pub const fn new() -> Self {
        Self { presence: Presence::Here, lose: None, owed: 0, pause: 0, seen: [0.0; N] }
    }

    /// The frames before the next period.
    ///
    /// | state | frames |
    /// |---|---|
    /// | idle | `Home`, or `Arm` where the arm is homed |
    /// | homing | `Confirm` |
    /// | armed, or holding above the table | a new trajectory, and `Run` |
    /// | running | `Hold` when the trajectory has ended |
    /// | holding at the table | `Disarm` |
    /// | fault | `Clear` |
    pub fn frames(&mut self, state: State, homed: bool) -> Vec<Frame> {
        match self.presence {
            Presence::Here => {}
            Presence::Away(left) => {
                self.presence = if left <= 1 { Presence::Here } else { Presence::Away(left - 1) };
                return Vec::new();
            }
            Presence::Gone => return Vec::new(),
        }
        if self.pause > 0 {
            self.pause -= 1;
            return vec![Frame::Alive];
        }
        self.pause = 1;
        let up = self.seen[0] > 0.5 * TOP;
        match state {
            State::Idle if homed => vec![Frame::Request(Request::Arm)],
            State::Idle => vec![Frame::Request(Request::Home)],
            State::Homing => vec![Frame::Request(Request::Confirm)],
            State::Holding(_) if !up => vec![Frame::Request(Request::Disarm)],
            State::Armed | State::Holding(_) => {
                self.pause = MOTION_TICKS as u8 + 3;
                let point = |ticks, q| {
                    let reference = dynamics_core::Reference::at_rest(q);
                    Frame::Point(Point { ticks, reference: Reference::new(&reference) })
                };
                let target = if up { 0.0 } else { TOP };
                vec![point(0, self.seen), point(MOTION_TICKS, [target; N]), Frame::Request(Request::Run)]
            }
            State::Running => vec![Frame::Request(Request::Hold)],
            State::Fault(_) => {
                self.pause = 3;
                vec![Frame::Request(Request::Clear)]
            }
        }
    }
}

impl<const N: usize> Default for Host<N> {
    fn default() -> Self {
        Self::new()
    }
}
