//! Frames in.

use super::{Buffers, Session};
use crate::readings::Lines;
use crate::trajectory::NotTaken;
use core::borrow::BorrowMut;
use dynamics_core::control::{Configuration, Protection};
use dynamics_core::newton_euler::InverseDynamics;
use dynamics_core::safety;
use dynamics_core::trig::Trig;
use link::codec::Received;
use link::{DecodeError, Frame, Pacing, Refusal, Request};

/// Answer to a received frame.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "made and taken apart at once, where there is nothing to allocate from")]
pub enum Reaction {
    /// Nothing: it was taken.
    None,
    /// Send these, in order; ticks stop until the next agreed hello.
    Stop(Frame, Frame),
    /// Send this.
    Reply(Frame),
    /// Start pacing like this, and send this hello.
    Start(Pacing, Frame),
    /// Run one tick now.
    Tick,
}

impl<const N: usize, D, T, K, C, P, B> Session<N, D, T, K, C, P, B>
where
    B: BorrowMut<Buffers<N>>,
    D: InverseDynamics<f32, N> + Clone,
    T: Trig<f32> + Clone,
    K: safety::Configuration<f32, N> + Clone,
    C: Configuration<f32, N> + Clone,
    P: Protection<f32, N> + Clone,
{
    /// Take the link's received frame, or its error.
    pub fn receive(&mut self, received: Result<Received, DecodeError>) -> Reaction {
        let received = match received {
            Ok(received) => received,
            Err(error) => return refuse(Refusal::Undecodable(error)),
        };
        self.taken = self.taken.wrapping_add(1);
        // Even if packets were lost before it: a stop must not wait for the host to notice.
        let stops = matches!(received.frame, Frame::Request(Request::Hold));
        if received.missed > 0 && !stops {
            return refuse(Refusal::Lost { missed: received.missed });
        }
        if let Frame::Hello(theirs) = received.frame {
            return self.hello(theirs);
        }
        let Some(pacing) = self.pacing else { return refuse(Refusal::NoHello) };
        if pacing.is_supervised() {
            self.supervisor.heard();
        }
        let reaction = match received.frame {
            Frame::Measurement(measurement) => self.measured(pacing, &measurement),
            Frame::Live(live) => self.live(pacing, &live),
            frame if pacing.is_supervised() => self.supervised(pacing, &frame),
            Frame::Reference(reference) => reference.to_core().map_err(Refusal::from).map(|reference| {
                self.reference = Some(reference);
                Reaction::None
            }),
            _ => Err(Refusal::Unexpected),
        };
        reaction.unwrap_or_else(refuse)
    }

    /// A frame that has a meaning only under supervision.
    fn supervised(&mut self, pacing: Pacing, frame: &Frame) -> Result<Reaction, Refusal> {
        match frame {
            Frame::Alive => {}
            Frame::Request(request) => self.supervisor.request(request.to_core()),
            Frame::Point(point) => {
                let trajectory = &mut self.buffers.borrow_mut().trajectory;
                self.supervisor.point(trajectory, point.ticks, &point.reference.to_core()?)?;
            }
            Frame::Watch(watch) => (self.watch, self.until) = (*watch, 0),
            Frame::Dump => self.past = Some(0),
            Frame::Get(index) => return self.value(*index).map(Reaction::Reply),
            Frame::Set(setting) => return self.set(*setting),
            Frame::Lines(lines) if pacing == Pacing::Drill => {
                let link::Lines { emergency_stop, overrun, zeroed, drive_fault, supply, temperature } = *lines;
                self.supervisor.lines(&Lines { emergency_stop, supply, temperature });
                self.supervisor.drives_say(core::array::from_fn(|i| drive_fault >> i & 1 == 1), zeroed);
                if overrun {
                    self.supervisor.overrun();
                }
            }
            _ => return Err(Refusal::Unexpected),
        }
        Ok(Reaction::None)
    }

    fn measured(&mut self, pacing: Pacing, measurement: &link::Measurement) -> Result<Reaction, Refusal> {
        let values = measurement.to_core()?;
        (self.tick, self.fresh) = (measurement.tick, true);
        if pacing.is_supervised() {
            self.supervisor.measured(&values);
        }
        self.measurement = Some(values);
        Ok(match pacing {
            Pacing::Timer | Pacing::Live => Reaction::None,
            Pacing::LockStep if self.reference.is_none() => return Err(Refusal::NoReference),
            Pacing::LockStep | Pacing::Drill => Reaction::Tick,
        })
    }
}

fn refuse(refusal: Refusal) -> Reaction {
    Reaction::Reply(Frame::Refusal(refusal))
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
