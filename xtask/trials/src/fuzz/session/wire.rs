//! Packets on the link, and their effects on each session.

use super::ticks::said;
use super::{Comparison, EVERYTHING, PAST, nothing};
use crate::campaign::TickInputs;
use crate::fuzz::packets::{all_bits, begins};
use link::{Actuation, DecodeError, Frame, Hello, NumberedRequest, Pacing, Packet, Received, Refusal, Request};
use session::{Reaction, State};

impl<const N: usize> Comparison<N> {
    /// Encodes a packet to send later.
    pub(super) fn pack(&mut self, frame: &Frame) -> Packet {
        let packet = self.encoder.encode(frame).unwrap();
        if self.sent.len() == PAST {
            self.sent.remove(0);
        }
        self.sent.push((self.number, packet.clone()));
        self.number += 1;
        packet
    }

    pub(super) fn send(&mut self, frame: &Frame) {
        let (number, packet) = (self.number, self.pack(frame));
        self.push(&packet, Some(number));
    }

    /// Puts bytes on the link; `number` is the packet's number if they are a whole packet.
    pub(super) fn push(&mut self, bytes: &[u8], number: Option<u64>) {
        self.wire.extend_from_slice(bytes);
        for &byte in bytes {
            if let Some(result) = self.decoder.push(byte) {
                self.results.push(result.clone());
                self.hear(result, number);
            }
        }
    }

    /// Passes a received result to the session, and to the twin if it must be accepted.
    fn hear(&mut self, result: Result<Received, DecodeError>, number: Option<u64>) {
        let before = self.session.state();
        let reaction = self.session.receive(result.clone());
        let Received { frame, missed } = match result {
            Ok(received) => received,
            Err(error) => return self.is_refused(&reaction, Refusal::Undecodable(error), before),
        };
        self.taken = self.taken.wrapping_add(1).wrapping_add(missed as u16);
        let last = core::mem::replace(&mut self.last, number);
        if let Frame::Hello(theirs) = &frame {
            return self.greeted(*theirs, &reaction, before);
        }
        let stops = matches!(frame, Frame::Request(NumberedRequest { request: Request::Hold | Request::Stop, .. }));
        if let (Some(number), Some(last)) = (number, last)
            && number <= last
            && !begins(&frame)
            && last - number < 255
        {
            assert!(missed > 0, "packet {number} was taken behind {last}");
        }
        if missed > 0 && !stops {
            let missed = u8::try_from(missed).unwrap_or(u8::MAX);
            return self.is_refused(&reaction, Refusal::Lost { missed }, before);
        }

        // The twin keeps its own watch.
        let heard = if matches!(frame, Frame::Watch(_)) { Frame::Alive } else { frame.clone() };
        let other = self.twin.receive(Ok(Received { frame: heard, missed: 0 }));
        assert_eq!(bits(&reaction), bits(&other), "{reaction:?} and {other:?}");
        assert_eq!((self.session.state(), self.twin.state()), (before, before), "a frame did what a tick does");
        if let Some(pacing) = before.pacing().filter(|pacing| pacing.is_supervised()) {
            self.tell(pacing, &frame, &reaction);
            let taken = reaction == Reaction::None && matches!(frame, Frame::Live(_) | Frame::Set(_));
            assert!(!(taken && self.changes), "two changes wait for one tick: {frame:?}");
            self.changes |= taken && matches!(before, State::Supervised(_, state) if state.has_torque());
        }
        match (&reaction, before.pacing()) {
            (Reaction::Tick, Some(Pacing::LockStep | Pacing::DryRun)) => self.tick(),
            (Reaction::None | Reaction::Reply(_), Some(_)) => {}
            (Reaction::Reply(Frame::Refusal(Refusal::NoHello)), None) => {}
            other => panic!("{frame:?} led to {other:?}"),
        }
    }

    /// Records the effect of a frame on the machine's inputs.
    fn tell(&mut self, pacing: Pacing, frame: &Frame, reaction: &Reaction) {
        self.spoke = true;
        if matches!(reaction, Reaction::Reply(Frame::Refusal(_))) {
            return;
        }
        match frame {
            // A request that is answered at once does not reach the machine.
            Frame::Request(request) if *reaction == Reaction::None => self.asked = Some(request.request),
            Frame::Measurement(measurement) => {
                self.told.sensed = measurement.sensed.to_core().unwrap();
                self.told.age_ticks = [measurement.age_ticks; N];
            }
            Frame::Lines(lines) => {
                assert!(pacing == Pacing::DryRun, "the board's own lines count");
                self.told.emergency_stop = lines.emergency_stop;
                self.told.overrun |= lines.overrun;
                self.told.zeroed = lines.zeroed;
                self.told.drive_fault = core::array::from_fn(|i| lines.drive_fault >> i & 1 == 1);
                (self.told.supply, self.told.temperature) = (lines.supply, lines.temperature);
            }
            _ => {}
        }
    }

    /// Checks that a reaction is this refusal and that nothing has changed.
    fn is_refused(&self, reaction: &Reaction, refusal: Refusal, before: State) {
        assert_eq!(*reaction, Reaction::Reply(Frame::Refusal(refusal)));
        assert_eq!(self.session.state(), before);
    }

    /// Checks the reaction to a hello: a restart for the session's own robot, a stop for any other.
    fn greeted(&mut self, theirs: Hello, reaction: &Reaction, before: State) {
        let own = Hello { pacing: theirs.pacing, ..self.own };
        let answer = Frame::Hello(own);
        if let State::Supervised(Pacing::Live, state) = before
            && state.has_or_awaits_torque()
        {
            return self.greeted_while_driven(theirs, reaction, state);
        }
        let state = if own != theirs {
            assert_eq!(*reaction, Reaction::Stop(answer, Frame::Refusal(Refusal::OtherRobot)));
            State::Waiting
        } else {
            assert_eq!(*reaction, Reaction::Start(theirs.pacing, answer));
            match theirs.pacing {
                pacing if pacing.is_supervised() => State::Supervised(pacing, dynamics_core::safety::State::Idle),
                pacing => State::Bench(pacing, None),
            }
        };
        assert_eq!(self.session.state(), state);
        let other = self.twin.receive(Ok(Received { frame: Frame::Hello(theirs), missed: 0 }));
        assert_eq!(*reaction, other);
        // A status reports that the drives of a live session do the safe action from now on.
        let is_live = |state: State| state.pacing() == Some(Pacing::Live);
        let (said, same) = (said(&mut self.session), said(&mut self.twin));
        assert!(said.iter().map(all_bits).eq(same.iter().map(all_bits)), "{said:?} and {same:?}");
        match &said[..] {
            [] => assert!(!is_live(before) || is_live(state), "nothing is said of a live session that has ended"),
            [Frame::Status(status)] => {
                assert!(
                    is_live(before)
                        && !is_live(state)
                        && matches!(status.actuation, Some(Actuation::Brake | Actuation::DampedStop | Actuation::Off)),
                    "{status:?}"
                );
            }
            other => panic!("{other:?}"),
        }
        self.judge.reset();
        // If a hello ends a live session, a late tick is reported by the next session.
        let overrun = self.told.overrun && is_live(before);
        (self.told, self.asked, self.spoke) = (TickInputs { overrun, ..nothing() }, None, false);
        (self.taken, self.changes) = (0, false);
        if own == theirs && theirs.pacing.is_supervised() {
            self.twin.receive(Ok(Received { frame: EVERYTHING, missed: 0 }));
        }
    }
}

impl<const N: usize> Comparison<N> {
    /// Checks the reaction to a hello while the arm is driven: the same session continues, and any other hello is refused.
    fn greeted_while_driven(&mut self, theirs: Hello, reaction: &Reaction, state: dynamics_core::safety::State) {
        let other = self.twin.receive(Ok(Received { frame: Frame::Hello(theirs), missed: 0 }));
        assert_eq!(*reaction, other);
        let before = State::Supervised(Pacing::Live, state);
        if theirs != (Hello { pacing: Pacing::Live, ..self.own }) {
            return self.is_refused(reaction, Refusal::Driven, before);
        }
        assert_eq!(*reaction, Reaction::Resume(Frame::Hello(theirs)));
        assert_eq!((self.session.state(), self.twin.state()), (before, before), "a hello did what a tick does");
        if !matches!(self.asked, Some(Request::Stop | Request::Hold)) {
            let stops = matches!(state, dynamics_core::safety::State::Running | dynamics_core::safety::State::Arming);
            self.asked = stops.then_some(Request::Hold);
        }
        (self.taken, self.changes, self.spoke) = (0, false, true);
        self.twin.receive(Ok(Received { frame: EVERYTHING, missed: 0 }));
    }
}

/// A reaction as bytes, because `==` fails for NaN.
fn bits(reaction: &Reaction) -> Vec<u8> {
    match reaction {
        Reaction::None => vec![0],
        Reaction::Tick => vec![1],
        Reaction::Reply(frame) | Reaction::Resume(frame) => all_bits(frame),
        Reaction::Stop(first, second) => [all_bits(first), all_bits(second)].concat(),
        Reaction::Start(_, frame) => all_bits(frame),
    }
}
