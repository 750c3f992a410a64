//! One direction of a simulated link. Frames can be lost, corrupted, delayed or cut off, as on a real cable.

use link::{DecodeError, Frame, Received};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::collections::VecDeque;

/// Disturbances of a simulated link and of simulated drives' buses.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Disturbance {
    /// Probability that a frame is lost, 0 to 1.
    pub drop: f64,
    /// Probability that a frame arrives corrupted, 0 to 1: the receiver discards it.
    pub corrupt: f64,
    /// Delay of the host link in each direction, s.
    pub delay: f64,
    /// Seed of the random numbers.
    pub seed: u64,
}

/// Random numbers that are the same on every machine.
#[derive(Clone, Debug)]
pub(super) struct Chance(ChaCha8Rng);

impl Chance {
    pub(super) fn new(seed: u64, stream: u64) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(stream);
        Self(generator)
    }

    /// True with this probability.
    pub(super) fn happens(&mut self, probability: f64) -> bool {
        ((self.0.next_u64() >> 11) as f64 * (f64::EPSILON / 2.0)) < probability
    }
}

/// One direction of the link.
#[derive(Clone, Debug)]
pub(super) struct Wire {
    disturbance: Disturbance,
    chance: Chance,
    /// Number of the next frame to be sent.
    number: u64,
    /// Number of the next frame to arrive.
    expected: u64,
    /// Time of arrival, s, number, and the frame; `None` if it is corrupted.
    under_way: VecDeque<(f64, u64, Option<Frame>)>,
    /// True if the cable is cut.
    pub(super) cut: bool,
    /// Frames that did not arrive.
    pub(super) lost: u64,
}

impl Wire {
    pub(super) fn new(disturbance: Disturbance, stream: u64) -> Self {
        let chance = Chance::new(disturbance.seed, stream);
        Self { disturbance, chance, number: 0, expected: 0, under_way: VecDeque::new(), cut: false, lost: 0 }
    }

    /// Sends a frame at this time, s.
    pub(super) fn send(&mut self, now: f64, frame: Frame) {
        let number = self.number;
        self.number += 1;
        // Both random numbers are drawn for every frame, so that changing one probability does not change which frames the other one affects.
        let (dropped, corrupted) =
            (self.chance.happens(self.disturbance.drop), self.chance.happens(self.disturbance.corrupt));
        if self.cut || dropped {
            self.lost += 1;
            return;
        }
        if corrupted {
            self.lost += 1;
        }
        self.under_way.push_back((now + self.disturbance.delay, number, (!corrupted).then_some(frame)));
    }

    /// The next frame that has arrived by this time, s, with the number of frames lost before it.
    pub(super) fn receive(&mut self, now: f64) -> Option<Result<Received, DecodeError>> {
        // The tolerance prevents a rounding error from delaying a frame by a tick.
        self.under_way.front().filter(|(due, ..)| *due <= now + 1e-9)?;
        let (_, number, frame) = self.under_way.pop_front()?;
        let Some(frame) = frame else { return Some(Err(DecodeError::BadCrc)) };
        let missed = (number - self.expected) as u32;
        self.expected = number + 1;
        Some(Ok(Received { frame, missed }))
    }
}

#[cfg(test)]
mod tests {
    use super::{Disturbance, Wire};
    use link::Frame;

    fn sent(disturbance: Disturbance, frames: u32) -> (Wire, usize, u32) {
        let mut wire = Wire::new(disturbance, 0);
        let (mut arrived, mut missed) = (0, 0);
        for frame in 0..frames {
            wire.send(f64::from(frame) * 1e-3, Frame::Alive);
            while let Some(received) = wire.receive(f64::from(frame) * 1e-3) {
                arrived += usize::from(received.is_ok());
                missed += received.map_or(0, |received| received.missed);
            }
        }
        (wire, arrived, missed)
    }

    #[test]
    fn frames_are_lost_as_often_as_said_and_counted_by_the_receiver() {
        let (wire, arrived, missed) = sent(Disturbance { drop: 0.1, corrupt: 0.1, ..Disturbance::default() }, 10_000);
        assert!((7900..8300).contains(&arrived), "{arrived}");
        assert_eq!(wire.lost, 10_000 - arrived as u64);
        // Losses after the last frame that arrived have not been noticed yet.
        assert!(u64::from(missed) <= wire.lost && u64::from(missed) + 20 > wire.lost, "{missed} of {}", wire.lost);
        let (again, ..) = sent(Disturbance { drop: 0.1, corrupt: 0.1, ..Disturbance::default() }, 10_000);
        assert_eq!(again.lost, wire.lost);
    }

    #[test]
    fn frames_are_late_and_a_cut_cable_carries_none() {
        let mut wire = Wire::new(Disturbance { delay: 0.01, ..Disturbance::default() }, 0);
        wire.send(0.0, Frame::Alive);
        assert!(wire.receive(0.009).is_none() && wire.receive(0.01).is_some());
        wire.cut = true;
        wire.send(0.02, Frame::Alive);
        wire.cut = false;
        wire.send(0.02, Frame::Dump);
        assert_eq!(wire.receive(0.04).unwrap().unwrap().missed, 1);
    }
}
