//! RobStride motors on a bus, written from the maker's documents, for tests.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use super::super::adapter::Adapter;
use super::super::frame::CanFrame;
use super::super::motors::ANSWER;
use embedded_can::Frame as _;
use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::time::Instant;

/// Timeout of a new motor, in units of 50 us. A zero would not show that it was overwritten.
pub(crate) const OLD: u32 = 0x3039;

/// A RobStride motor: parameters, those in flash, and its state.
#[derive(Clone, Debug)]
pub(crate) struct Motor {
    pub(crate) id: u8,
    pub(crate) chip: [u8; 8],
    pub(crate) parameters: BTreeMap<u16, [u8; 4]>,
    pub(crate) flash: (u8, BTreeMap<u16, [u8; 4]>),
    pub(crate) state: u32,
    pub(crate) errors: u32,
    /// Old firmware has no frame that stores.
    pub(crate) is_old: bool,
    /// A motor that is broken takes no values.
    pub(crate) is_stubborn: bool,
    /// True if the position in its frames begins again at the other end of their range.
    pub(crate) wraps: bool,
}

impl Motor {
    pub(crate) fn new(id: u8) -> Self {
        let parameters: BTreeMap<u16, [u8; 4]> = [
            (0x7019, 1.25_f32.to_le_bytes()),
            (0x701B, 0.0_f32.to_le_bytes()),
            (0x701C, 48.0_f32.to_le_bytes()),
            (0x7028, OLD.to_le_bytes()),
            // The bytes after a value of one byte are not defined.
            (0x7005, [0, 7, 7, 7]),
            (0x700B, 60.0_f32.to_le_bytes()),
            (0x7018, 23.0_f32.to_le_bytes()),
        ]
        .into();
        let flash = (id, parameters.clone());
        Self {
            id,
            chip: [id; 8],
            flash,
            parameters,
            state: 0,
            errors: 0,
            is_old: false,
            is_stubborn: false,
            wraps: false,
        }
    }

    fn answer(&mut self, frame: &CanFrame) -> Option<CanFrame> {
        let (id, data): (u32, [u8; 8]) = (frame.raw_id(), frame.data().try_into().ok()?);
        if !frame.is_extended() || id as u8 != self.id {
            return None;
        }
        let (index, value) = (u16::from_le_bytes([data[0], data[1]]), [data[4], data[5], data[6], data[7]]);
        match id >> 24 {
            0 => return CanFrame::of(u32::from(self.id) << 8 | 0xFE, true, &self.chip),
            3 => self.state = 2,
            4 => {
                self.state = 0;
                if data[0] == 1 {
                    self.errors = 0;
                }
            }
            6 if data[0] == 1 && !self.is_stubborn => {
                self.parameters.insert(0x7019, 0.001_f32.to_le_bytes());
            }
            6 => {}
            7 => {
                if !self.is_stubborn {
                    self.id = (id >> 16) as u8;
                }
                return CanFrame::of(u32::from(self.id) << 8 | 0xFE, true, &self.chip);
            }
            17 => {
                let [low, high] = index.to_le_bytes();
                let (failed, [a, b, c, d]) = self.parameters.get(&index).map_or((1, [0; 4]), |value| (0, *value));
                let id = 17 << 24 | failed << 16 | u32::from(self.id) << 8 | id >> 8 & 0xFF;
                return CanFrame::of(id, true, &[low, high, 0, 0, a, b, c, d]);
            }
            18 if !self.is_stubborn => {
                self.parameters.insert(index, value);
            }
            18 => {}
            22 if !self.is_old && data == [1, 2, 3, 4, 5, 6, 7, 8] => self.flash = (self.id, self.parameters.clone()),
            _ => return None,
        }
        let id = 2 << 24 | self.state << 22 | self.errors << 16 | u32::from(self.id) << 8 | id >> 8 & 0xFF;
        let [high, low] = self.position_code().to_be_bytes();
        CanFrame::of(id, true, &[high, low, 0x80, 0, 0x80, 0, 0, 0xFB])
    }

    /// Code of the position in a frame; past the end of its range that of the end, if it does not wrap.
    fn position_code(&self) -> u16 {
        let mut position = self.parameters.get(&0x7019).map_or(0.0, |bytes| f32::from_le_bytes(*bytes));
        if self.wraps {
            position = (position + 12.57).rem_euclid(25.14) - 12.57;
        }
        // The cast saturates.
        ((position / 12.57 + 1.0) / 2.0 * 65535.0).round() as u16
    }

    /// Turns the shaft to this position, rad.
    pub(crate) fn turn_to(&mut self, position: f32) {
        self.parameters.insert(0x7019, position.to_le_bytes());
    }
}

/// A bus with such motors.
pub(crate) struct Bus {
    pub(crate) motors: Vec<Motor>,
    pub(crate) answers: VecDeque<CanFrame>,
    pub(crate) sent: Vec<CanFrame>,
    /// Kinds of frames whose next answer is lost.
    pub(crate) lost: Vec<u32>,
    /// Kinds of frames whose next answer comes after the time for it.
    pub(crate) late: Vec<u32>,
    pub(crate) delayed: Option<(Instant, CanFrame)>,
    /// Frames of another program and the replies to it, again and again.
    pub(crate) others: Vec<CanFrame>,
    pub(crate) turn: usize,
}

impl Adapter for Bus {
    fn begin_tick(&mut self) {}

    fn send(&mut self, frame: &CanFrame) -> io::Result<()> {
        self.sent.push(*frame);
        let kind = frame.raw_id() >> 24;
        for answer in self.motors.iter_mut().filter_map(|motor| motor.answer(frame)) {
            if let Some(place) = self.lost.iter().position(|lost| *lost == kind) {
                self.lost.remove(place);
            } else if let Some(place) = self.late.iter().position(|late| *late == kind) {
                self.late.remove(place);
                self.delayed = Some((Instant::now() + ANSWER + ANSWER / 5, answer));
            } else {
                self.answers.push_back(answer);
            }
        }
        Ok(())
    }

    fn receive(&mut self) -> io::Result<Option<CanFrame>> {
        if let Some((_, late)) = self.delayed.take_if(|(at, _)| *at <= Instant::now()) {
            return Ok(Some(late));
        }
        self.turn += 1;
        let other = self.others.get(self.turn % (self.others.len() + 1)).copied();
        Ok(self.answers.pop_front().or(other))
    }

    fn is_off(&mut self) -> bool {
        false
    }
}

pub(crate) fn bus(ids: &[u8]) -> Bus {
    let motors = ids.iter().copied().map(Motor::new).collect();
    let (answers, sent, lost, late, others) = (VecDeque::new(), Vec::new(), Vec::new(), Vec::new(), Vec::new());
    Bus { motors, answers, sent, lost, late, delayed: None, others, turn: 0 }
}

/// Kinds of the frames that were sent, each once.
pub(crate) fn kinds(bus: &Bus) -> Vec<u32> {
    let mut kinds: Vec<u32> =
        bus.sent.iter().filter(|frame| frame.is_extended()).map(|frame| frame.raw_id() >> 24).collect();
    kinds.sort_unstable();
    kinds.dedup();
    kinds
}
