//! Received frames.
//!
//! A frame is converted before the session is locked, so that a tick only has to wait while its effect is applied.

use super::outcome::{Outcome, Reaction};
use super::requests::{Arrived, Requests};
use super::{Buffers, QUIET, Session};
use crate::parameters::{self, LiveBounds};
use crate::readings::Lines;
use crate::trajectory::{FinitePoint, NotTaken, Segment};
use core::borrow::BorrowMut;
use dynamics_core::control::{ArmBuild, Measurement, Reference};
use dynamics_core::safety::{self, SafetyConfiguration as _};
use dynamics_core::scene::Live;
use link::codec::Received;
use link::{DecodeError, Frame, Hello, NumberedRequest, Pacing, Refusal, Request, Verdict};

/// A received frame in the types of the control loop.
#[derive(Clone, Debug, PartialEq)]
pub struct Message<const N: usize> {
    missed: u32,
    said: FrameContent<N>,
}

/// Content of a frame, converted as far as possible.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "made and taken apart at once, where there is nothing to allocate from")]
enum FrameContent<const N: usize> {
    Undecodable(DecodeError),
    Measurement(u32, Result<Measurement<f32, N>, Refusal>),
    /// Live inputs within their bounds. Out of bounds until [`Message::check`].
    Live(Result<Live<f32, N>, Refusal>, Result<(), Refusal>),
    Reference(Result<Reference<f32, N>, Refusal>),
    /// The start of a trajectory.
    Start(Result<FinitePoint<N>, Refusal>),
    /// Ticks since the previous point, the point, and the segment to it.
    Point(u16, Result<Reference<f32, N>, Refusal>, Option<Segment<N>>),
    Request(NumberedRequest),
    Other(Frame),
}

impl<const N: usize> Message<N> {
    /// Converts a frame, or the error that came instead of one.
    #[must_use]
    pub fn new(received: Result<Received, DecodeError>) -> Self {
        let Received { frame, missed } = match received {
            Ok(received) => received,
            Err(error) => return Self { missed: 0, said: FrameContent::Undecodable(error) },
        };
        let said = match frame {
            Frame::Measurement(measurement) => {
                FrameContent::Measurement(measurement.tick, measurement.to_core().map_err(Refusal::from))
            }
            Frame::Live(live) => FrameContent::Live(
                live.to_core()
                    .map_err(Refusal::from)
                    .and_then(|values| if live.is_finite() { Ok(values) } else { Err(Refusal::NonFiniteLive) }),
                Err(Refusal::OutOfBounds),
            ),
            Frame::Reference(reference) => FrameContent::Reference(reference.to_core().map_err(Refusal::from)),
            Frame::Point(point) => {
                let (ticks, point) = (point.ticks, point.reference.to_core().map_err(Refusal::from));
                if ticks == 0 {
                    FrameContent::Start(point.and_then(|point| Ok(FinitePoint::new(point)?)))
                } else {
                    FrameContent::Point(ticks, point, None)
                }
            }
            Frame::Request(request) => FrameContent::Request(request),
            frame => FrameContent::Other(frame),
        };
        Self { missed, said }
    }

    /// True for a point that follows another: it needs the segment from there ([`Message::find_way`]).
    #[must_use]
    pub fn goes_on(&self) -> bool {
        matches!(self.said, FrameContent::Point(1.., Ok(_), _))
    }

    /// Checks live inputs, if that is what was received, against the bounds that [`Session::live_bounds`] returned. Live inputs without this check are
    /// refused as out of bounds.
    pub fn check(&mut self, bounds: &LiveBounds<N>) {
        if let FrameContent::Live(Ok(live), checked) = &mut self.said {
            *checked = parameters::check_live(live, bounds);
        }
    }

    /// Computes the segment to a point from the start that [`Session::way_from`] returned.
    pub fn find_way(&mut self, from: Option<(Reference<f32, N>, f32)>) {
        if let (FrameContent::Point(ticks, Ok(point), way), Some((last, period))) = (&mut self.said, from) {
            *way = Segment::new(&last, point, *ticks, period);
        }
    }
}

impl<const N: usize, A: ArmBuild<f32, N>, B: BorrowMut<Buffers<N>>> Session<N, A, B> {
    /// Takes a received frame, or its error, in one call. For single-threaded callers, which need no lock.
    pub fn receive(&mut self, received: Result<Received, DecodeError>) -> Reaction {
        let mut message = Message::new(received);
        if message.goes_on() {
            message.find_way(self.way_from());
        }
        message.check(&self.live_bounds());
        let outcome = match self.take(&message) {
            Outcome::Hello(theirs) => {
                self.forget_controller();
                self.forget_arm();
                self.begin(&theirs)
            }
            outcome => outcome,
        };
        outcome.reaction()
    }

    /// Returns the start of the next segment of the trajectory, and the control period, s; `None` if there is no start.
    pub fn way_from(&self) -> Option<(Reference<f32, N>, f32)> {
        self.buffers.borrow().trajectory.last().map(|last| (*last, self.supervisor.period()))
    }

    /// Returns the bounds of the live inputs, which never change.
    pub fn live_bounds(&self) -> LiveBounds<N> {
        LiveBounds::new(self.safety.rules())
    }

    /// Takes a message. If a tick has ended the trajectory since [`Session::way_from`], the point is refused; a tick can change nothing else that
    /// matters to the segment.
    pub fn take(&mut self, message: &Message<N>) -> Outcome {
        let Message { missed, said } = message;
        if let FrameContent::Undecodable(error) = said {
            return Outcome::Refused(Refusal::Undecodable(*error));
        }
        // Lost packets count too: the host has sent them.
        self.taken = self.taken.wrapping_add(1).wrapping_add(*missed as u16);
        // A stop is accepted even after lost packets: it must not wait until the host notices the loss.
        let stops =
            matches!(said, FrameContent::Request(NumberedRequest { request: Request::Hold | Request::Stop, .. }));
        if *missed > 0 && !stops {
            return Outcome::Refused(Refusal::Lost { missed: u8::try_from(*missed).unwrap_or(u8::MAX) });
        }
        if let FrameContent::Other(Frame::Hello(theirs)) = said {
            return self.greeted(*theirs);
        }
        let agreed = self.pacing.filter(|_| !self.shut_out || stops);
        let Some(pacing) = agreed else { return Outcome::Refused(Refusal::NoHello) };
        if pacing.is_supervised() && !self.shut_out {
            self.supervisor.heard();
        }
        let outcome = match said {
            FrameContent::Measurement(tick, measurement) => {
                measurement.as_ref().map_err(Refusal::clone).and_then(|values| self.measured(pacing, *tick, values))
            }
            FrameContent::Live(live, checked) => {
                live.as_ref().map_err(Refusal::clone).and_then(|live| (*checked).and_then(|()| self.live(pacing, live)))
            }
            FrameContent::Start(point) if pacing.is_supervised() => {
                point.as_ref().map_err(Refusal::clone).and_then(|point| self.start(point))
            }
            FrameContent::Point(_, point, way) if pacing.is_supervised() => {
                point.as_ref().map_err(Refusal::clone).and_then(|point| self.point(point, way.as_ref()))
            }
            FrameContent::Reference(reference) if !pacing.is_supervised() => {
                reference.as_ref().map_err(Refusal::clone).map(|reference| {
                    self.reference = Some(*reference);
                    Outcome::None
                })
            }
            FrameContent::Request(request) if pacing.is_supervised() => Ok(self.request(*request)),
            FrameContent::Other(frame) if pacing.is_supervised() => self.supervised(pacing, frame),
            _ => Err(Refusal::Unexpected),
        };
        outcome.unwrap_or_else(Outcome::Refused)
    }

    /// Takes a host's hello. While the arm is driven, only the hello that began the session is accepted, and it continues the session: an arm
    /// that is held or lowered must not fall because its host has reconnected.
    #[cold]
    #[inline(never)]
    fn greeted(&mut self, theirs: Hello) -> Outcome {
        self.shut_out = false;
        let state = self.supervisor.state();
        if self.is_live() && state.has_or_awaits_torque() {
            if theirs != (Hello { pacing: Pacing::Live, ..self.own }) {
                self.shut_out = true;
                return Outcome::Refused(Refusal::Driven);
            }
            self.resume();
            return Outcome::Resume(theirs);
        }
        self.left_live = self.is_live();
        self.pacing = None;
        Outcome::Hello(theirs)
    }

    /// Deletes the state of the previous host, and none of the arm's.
    fn resume(&mut self) {
        (self.taken, self.requests, self.foreign) = (0, Requests::NONE, 0);
        (self.change, self.past, self.watch, self.until, self.unsaid) = (None, None, QUIET, 0, false);
        self.changed.clear();
        self.supervisor.change_host(&mut self.buffers.borrow_mut().trajectory);
    }

    fn start(&mut self, point: &FinitePoint<N>) -> Result<Outcome, Refusal> {
        self.supervisor.start(&mut self.buffers.borrow_mut().trajectory, point)?;
        Ok(Outcome::None)
    }

    fn point(&mut self, point: &Reference<f32, N>, way: Option<&Segment<N>>) -> Result<Outcome, Refusal> {
        self.buffers.borrow_mut().trajectory.add(way, point)?;
        Ok(Outcome::None)
    }

    /// Takes a frame that is valid only under supervision.
    fn supervised(&mut self, pacing: Pacing, frame: &Frame) -> Result<Outcome, Refusal> {
        match frame {
            Frame::Alive => {}
            Frame::Watch(watch) => (self.watch, self.until) = (*watch, 0),
            Frame::Dump => self.past = Some(0),
            Frame::Get(index) => return self.value(*index).map(Outcome::Value),
            Frame::Set(setting) => return self.set(*setting),
            Frame::Lines(lines) if pacing == Pacing::DryRun => {
                let link::Lines { emergency_stop, overrun, zeroed, drive_fault, on, zero_lost, supply, temperature } =
                    *lines;
                self.supervisor.lines(&Lines { emergency_stop, supply, temperature });
                let joints = |bits: u8| core::array::from_fn(|i| bits >> i & 1 == 1);
                self.supervisor.drives_say(joints(drive_fault), joints(on), zeroed, zero_lost);
                if overrun {
                    self.supervisor.overrun();
                }
            }
            _ => return Err(Refusal::Unexpected),
        }
        Ok(Outcome::None)
    }

    /// Queues a request for the next tick, or answers it at once.
    fn request(&mut self, request: NumberedRequest) -> Outcome {
        // After a change of host the supervisor may hold a request that stops the arm and is not in `requests`.
        let stronger = |asked: safety::Request| {
            let waiting = self.supervisor.inputs().request.filter(|_| !self.requests.is_waiting());
            waiting.is_some_and(|waiting| waiting.rank() >= asked.rank())
        };
        let arrived = match request.request.to_core() {
            Some(asked) if stronger(asked) => self.requests.judge(request, || Verdict::Superseded),
            Some(asked) => {
                let arrived = self.requests.take(request);
                if matches!(arrived, Arrived::New) {
                    self.supervisor.request(asked);
                }
                arrived
            }
            None => {
                let black_box = &mut self.buffers.borrow_mut().black_box;
                self.requests.judge(request, || match black_box.release() {
                    true => Verdict::Accepted,
                    false => Verdict::Rejected(link::Denial::new(safety::Refusal::Unread)),
                })
            }
        };
        match arrived {
            Arrived::Answered(answer) => Outcome::Answer(answer),
            Arrived::Waits | Arrived::New => Outcome::None,
        }
    }

    fn measured(&mut self, pacing: Pacing, tick: u32, values: &Measurement<f32, N>) -> Result<Outcome, Refusal> {
        if pacing == Pacing::Live {
            self.foreign = self.foreign.saturating_add(1);
            return Err(Refusal::OwnMeasurements { count: self.foreign });
        }
        (self.tick, self.fresh) = (tick, true);
        if pacing.is_supervised() {
            self.supervisor.measured(values);
        } else {
            self.measurement = Some(*values);
        }
        Ok(match pacing {
            Pacing::Timer | Pacing::Live => Outcome::None,
            Pacing::LockStep if self.reference.is_none() => return Err(Refusal::NoReference),
            Pacing::LockStep | Pacing::DryRun => Outcome::Tick,
        })
    }
}

impl From<NotTaken> for Refusal {
    fn from(not_taken: NotTaken) -> Self {
        match not_taken {
            NotTaken::NonFinite => Self::NonFinitePoint,
            NotTaken::Full => Self::TrajectoryFull,
            NotTaken::NoStart => Self::NoStart,
            NotTaken::Running => Self::Running,
        }
    }
}
