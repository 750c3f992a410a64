//! Events, decoded from the bytes of an input.

use super::{Comparison, EVERYTHING, PAST};
use crate::fuzz::packets::frame;
use dynamics_core::Reference;
use dynamics_core::control::Sensed;
use link::{Frame, Hello, Pacing, Point, Request, Setting};
use session::readings::{JointFaults, Lines};

impl<const N: usize> Comparison<N> {
    pub(super) fn event(&mut self, kind: u8, bytes: &mut &[u8]) {
        let mut next = || bytes.split_off_first().copied().unwrap_or_default();
        match kind {
            0 => self.time(),
            1 => {
                for _ in 0..next() % 64 {
                    self.send(&Frame::Alive);
                    self.time();
                }
            }
            2 => {
                let all = [Request::Home, Request::Confirm, Request::Arm, Request::Disarm, Request::Run];
                let more = [Request::Hold, Request::Clear, Request::Stop, Request::FullRange, Request::Release];
                let asked = usize::from(next()) % 10;
                self.request = self.request.wrapping_add(1);
                let request = all.iter().chain(&more).copied().nth(asked).unwrap();
                self.send(&Frame::request(self.request, request));
                self.time();
            }
            3 => {
                let byte = next();
                let pacing = [Pacing::Live, Pacing::DryRun, Pacing::Timer, Pacing::LockStep][usize::from(byte % 4)];
                let robot = self.own.robot ^ u64::from(byte > 250);
                self.send(&Frame::Hello(Hello { pacing, robot, ..self.own }));
            }
            4 => {
                let any = frame(bytes);
                self.send(&any);
            }
            5 => {
                // From zero to 0.5 rad; most steps are small.
                let (ticks, step) = (next(), 0.5 * (f32::from(next().cast_signed()) / 127.0).powi(3));
                let from = if ticks == 0 { self.q } else { self.goal };
                self.goal = from.map(|q| q + step);
                let reference = link::Reference::new(&Reference::at_rest(self.goal));
                self.send(&Frame::Point(Point { ticks: u16::from(ticks), reference }));
            }
            6 => self.lines(next(), next()),
            7 => {
                let (joint, what) = (usize::from(next()) % N, next());
                let value = f32::from_le_bytes([next(), next(), next(), next()]);
                let (mut sensed, mut ages, mut faults) = (self.reading(), [0; N], [JointFaults::NONE; N]);
                match (&mut sensed, what % 4) {
                    (Sensed::State { q, .. }, 0) => q[joint] = value,
                    (Sensed::State { qd, .. }, 1) => qd[joint] = value,
                    (Sensed::Counts(counts), 0 | 1) => {
                        counts[joint] = counts[joint].wrapping_add(value.to_bits().cast_signed() >> (what >> 4));
                    }
                    (_, 2) => ages[joint] = u32::from(what >> 2),
                    _ => faults[joint] = JointFaults::NAMES[usize::from(what >> 2) % JointFaults::NAMES.len()].0,
                }
                self.odd = Some((sensed, ages, faults));
            }
            8 => {
                let back = self.sent.len().saturating_sub(1 + usize::from(next()) % PAST);
                let again: Vec<_> = self.sent.iter().skip(back).take(1 + usize::from(next() % 4)).cloned().collect();
                for (number, packet) in again {
                    self.push(&packet, Some(number));
                }
            }
            9 => {
                for _ in 0..next() {
                    self.encoder.encode(&Frame::Alive).unwrap();
                    self.number += 1;
                }
            }
            10 => {
                let (keep, ended) = (usize::from(next()), next() % 2 == 1);
                let packet = self.pack(&frame(bytes));
                self.push(&packet[..keep % packet.len()], None);
                if ended {
                    self.push(&[0], None);
                }
            }
            11 => {
                let bit = usize::from(u16::from_le_bytes([next(), next()]));
                let mut packet = self.pack(&frame(bytes));
                let at = bit / 8 % packet.len();
                packet[at] ^= 1 << (bit % 8);
                self.push(&packet, None);
            }
            12 => {
                let length = usize::from(next()).min(bytes.len());
                let noise = bytes.split_off(..length).unwrap_or_default();
                self.push(noise, None);
            }
            13 => {
                let (first, second) = (frame(bytes), frame(bytes));
                let (early, first) = (self.number, self.pack(&first));
                self.send(&second);
                self.push(&first, Some(early));
            }
            14 => self.send(&EVERYTHING),
            15 => {
                self.session.overrun();
                self.twin.overrun();
                self.told.overrun = true;
            }
            16 => self.blind = next() % 32,
            17 => self.counted = !self.counted,
            18 => {
                // A flood of packets without a tick between them.
                for _ in 0..next() {
                    self.send(&Frame::Alive);
                }
            }
            19 => self.send(&Frame::Dump),
            21 => {
                let mut live = dynamics_core::Live::<f32, N>::zero();
                (live.payload.mass, live.gravity.z) = (f32::from(next()) / 64.0, -9.81);
                self.send(&Frame::Live(link::Live::new(&live).unwrap()));
            }
            22 => {
                let (index, share) = (next(), f32::from(next()) / 64.0);
                let value = share * self.config.gains[usize::from(index / 16) % N].position;
                self.send(&Frame::Set(Setting { index, value }));
            }
            _ => {
                // Only noise and old packets arrive.
                for tick in 0..4 * u32::from(next()) {
                    match self.sent.last().cloned() {
                        Some((number, packet)) if tick % 2 == 0 => self.push(&packet, Some(number)),
                        _ => self.push(&[7, 0], None),
                    }
                    self.time();
                }
            }
        }
    }

    /// Sets the board's lines from now on; in a dry run the host sends them.
    fn lines(&mut self, bits: u8, drive_fault: u8) {
        let value = |choice: u8, inside: f32| [None, Some(inside), Some(-1e3), Some(f32::NAN)][usize::from(choice % 4)];
        let (emergency_stop, supply, temperature) = (bits & 1 == 1, value(bits >> 1, 24.0), value(bits >> 3, 20.0));
        self.lines = Lines { emergency_stop, supply, temperature };
        if self.pacing() == Some(Pacing::DryRun) {
            let (overrun, zeroed) = (bits & 32 != 0, bits & 64 == 0);
            let own = link::Lines { emergency_stop, overrun, zeroed, drive_fault, ..link::Lines::CALM };
            let lines = link::Lines { supply, temperature, ..own };
            self.send(&Frame::Lines(lines));
        }
    }
}
