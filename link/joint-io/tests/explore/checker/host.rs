//! The operator: a function from what the board reports to the next request.

use super::scene::{MOTION_TICKS, TOP};
use dynamics_core::safety::State;
use link::{Frame, Point, Reference, Request};

/// Presence of the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Presence {
    /// It sends in every period.
    Here,
    /// It is silent for this many more periods.
    Away(u8),
    /// It is silent until it sends another hello.
    Gone,
}

/// The operator's memory.
#[derive(Clone, Copy, Debug)]
pub struct Host<const N: usize> {
    /// Presence.
    pub presence: Presence,
    /// Index of the frame of the next batch that is lost.
    pub lose: Option<u8>,
    /// Number of packets lost since the last one that arrived.
    pub owed: u8,
    /// Periods until the next request.
    pub pause: u8,
    /// Number of the last request. It counts up; every number in the board's memory is one of the last eight.
    pub number: u8,
    /// The last request.
    pub last: Option<Request>,
    /// True if the last request has arrived.
    pub arrived: bool,
    /// Joint positions that the board reported last, rad.
    pub seen: [f32; N],
}

impl<const N: usize> Host<N> {
    /// Creates a host that is present.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            presence: Presence::Here,
            lose: None,
            owed: 0,
            pause: 0,
            number: 0,
            last: None,
            arrived: false,
            seen: [0.0; N],
        }
    }

    /// Returns the frames that the host sends before the next period.
    ///
    /// | state | frames |
    /// |---|---|
    /// | idle | `Home`, or `Arm` if the arm is homed |
    /// | homing | `Confirm` |
    /// | armed, or holding above the table | a new trajectory, and `Run` |
    /// | running | `Hold` when the trajectory has ended |
    /// | arming, disarming | only heartbeats |
    /// | lowering | `Hold` |
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
        let request = match state {
            State::Idle if homed => Request::Arm,
            State::Idle => Request::Home,
            State::Homing => Request::Confirm,
            State::Arming | State::Disarming => return vec![Frame::Alive],
            State::Holding(_) if !up => Request::Disarm,
            State::Armed | State::Holding(_) => {
                self.pause = MOTION_TICKS as u8 + 3;
                let point = |ticks, q| {
                    let reference = dynamics_core::Reference::at_rest(q);
                    Frame::Point(Point { ticks, reference: Reference::new(&reference) })
                };
                let target = if up { 0.0 } else { TOP };
                return vec![point(0, self.seen), point(MOTION_TICKS, [target; N]), self.request(Request::Run)];
            }
            State::Running | State::Lowering => Request::Hold,
            State::Fault(_) => {
                self.pause = 3;
                Request::Clear
            }
        };
        vec![self.request(request)]
    }

    /// A new request.
    pub fn request(&mut self, request: Request) -> Frame {
        self.number = self.number.wrapping_add(1);
        (self.last, self.arrived) = (Some(request), false);
        Frame::request(self.number, request)
    }

    /// Returns the last request again, with the same number.
    #[must_use]
    pub fn again(&self) -> Option<Frame> {
        self.last.map(|request| Frame::request(self.number, request))
    }
}

impl<const N: usize> Default for Host<N> {
    fn default() -> Self {
        Self::new()
    }
}
