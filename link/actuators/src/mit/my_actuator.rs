//! Frames of MyActuator's RMD drives, after "Servo Motor Control Protocol (applicable driver V3)" V4.2, sections 2 and 5, and what was observed on
//! drives where the document is silent.
//!
//! | from a document or a drive | here |
//! |---|---|
//! | there is no frame that enables it; a motion command works on a drive that was never switched on (axol, yukunlin1124) | a motion command switches it on |
//! | "cut off the output" after the timeout of 0xB3; the first command after that is swallowed (2b-t/myactuator_rmd_ros, pull request 4) | it is answered, and not carried out |
//! | the time of 0xB3 is in ROM | it is the one after a start, too |
//! | with function 3 of 0x20 it sends its status every 100 ms while it has an error (V4.2, 2.34.4) | whether it keeps the setting without power is not stated; here it does not |
//! | what a motion command does on a drive with an error is not stated | it is answered, and there is no torque |
//! | the answer to the release of a holding brake comes after 50 to 150 ms (axol) | after [`Electronics::release_time`] |
//! | a holding brake | there is none |

use super::{Electronics, Language, Setpoint, Shaft, error, to_code, to_float};
use crate::frame::{Frame, Order};

/// Identifiers minus the drive's own (sections 1.1 and 5).
const SINGLE: u32 = 0x140;
const ANSWER: u32 = 0x240;
const MOTION: u32 = 0x400;
const MOTION_REPLY: u16 = 0x500;

/// Interval of the status of a drive with an error, and of the frames after an expired timeout, s.
const STATUS_EVERY: f64 = 0.1;
const EXPIRED_EVERY: f64 = 1.0;

impl Electronics {
    pub(super) fn hears_as_my_actuator(&self, frame: &Frame) -> bool {
        let own = u32::from(self.id);
        !frame.extended && [SINGLE + own, MOTION + own].contains(&frame.id)
    }

    pub(super) fn order_of_my_actuator(&self, frame: &Frame) -> Order {
        match frame.data.first() {
            Some(_) if frame.id >= MOTION => Order::Torque,
            Some(0x77) => Order::Enable,
            Some(0x80) => Order::Disable,
            _ => Order::Setting,
        }
    }

    pub(super) fn answer_as_my_actuator(&mut self, frame: &Frame, shaft: &Shaft) -> Option<Frame> {
        let data = <[u8; 8]>::try_from(frame.data.as_slice()).ok()?;
        let swallows = self.is_silent();
        self.silent_for = 0.0;
        if frame.id == MOTION + u32::from(self.id) {
            if !swallows {
                (self.told, self.enabled, self.told_off) = (self.motion(data), true, false);
            }
            self.drive(shaft);
            return Some(self.motion_reply(shaft));
        }
        match data {
            [0x77, ..] if self.ignores_enable => return None,
            // It releases a holding brake.
            [0x77, ..] if self.release_time > 0.0 => {
                self.releasing.push_back(self.release_time);
                return None;
            }
            [0x77, ..] => {}
            [0x80, ..] if swallows => {}
            [0x80, ..] => self.exit(),
            [0x9a, ..] => return Some(self.status()),
            [0xb3, _, _, _, a, b, c, d] => {
                self.timeout = f64::from(u32::from_le_bytes([a, b, c, d])) * 1e-3;
                self.first_timeout = self.timeout;
            }
            [0x20, 3, _, _, value, ..] => self.reports_errors = value == 1,
            _ => return None,
        }
        Some(self.answer_with(data))
    }

    /// Section 5.1: p_des 16 bits, v_des 12, kp 12, kd 12, t_ff 12, the highest bits first.
    fn motion(&self, data: [u8; 8]) -> Setpoint {
        let all = u64::from_be_bytes(data);
        let field = |low: u32, bits: u32| (all >> low & ((1 << bits) - 1)) as u32;
        let ranges = &self.ranges;
        Setpoint {
            position: to_float(field(48, 16), ranges.position, 16),
            velocity: to_float(field(36, 12), ranges.velocity, 12),
            kp: to_float(field(24, 12), ranges.kp, 12),
            kd: to_float(field(12, 12), ranges.kd, 12),
            torque: to_float(field(0, 12), ranges.torque, 12),
        }
    }

    /// Section 5.3: identifier 8 bits, position 16, velocity 12, torque 12, then two bytes "NULL".
    fn motion_reply(&self, shaft: &Shaft) -> Frame {
        let ranges = &self.ranges;
        let position = u64::from(to_code(shaft.position - self.zero, ranges.position, 16));
        let velocity = u64::from(to_code(shaft.velocity, ranges.velocity, 12));
        let torque = u64::from(to_code(self.torque, ranges.torque, 12));
        let all = u64::from(self.id) << 56 | position << 40 | velocity << 28 | torque << 16;
        Frame::standard(MOTION_REPLY + self.id, all.to_be_bytes().to_vec())
    }

    fn answer_with(&self, data: [u8; 8]) -> Frame {
        Frame { id: ANSWER + u32::from(self.id), extended: false, data: data.to_vec() }
    }

    /// Section 2.13: temperatures of motor and MOSFET, brake released, 0.1 V, errors as bits.
    fn status(&self) -> Frame {
        let errors: u16 = match self.error {
            0 => 0,
            error::OVER_VOLTAGE => 0x0008,
            error::UNDER_VOLTAGE => 0x0004,
            error::HOT => 0x1000,
            error::OVERLOAD => 0x0040,
            _ => 0x0010,
        };
        // The cast saturates.
        let [volts_low, volts_high] = ((10.0 * self.supply) as u16).to_le_bytes();
        let [low, high] = errors.to_le_bytes();
        let released = u8::from(self.gives_torque());
        self.answer_with([0x9a, self.temperature, self.temperature, released, volts_low, volts_high, low, high])
    }

    /// Interval of the frames that the drive sends without being asked, and the frame; `None` if it has nothing to report.
    fn report(&self) -> Option<(f64, Frame)> {
        match self.language {
            Language::MyActuator if !self.powered => None,
            Language::MyActuator if self.is_silent() => {
                Some((EXPIRED_EVERY, self.answer_with([0xf1, 0, 0, 0, 0, 0, 0, 0])))
            }
            Language::MyActuator if self.error != 0 && self.reports_errors => Some((STATUS_EVERY, self.status())),
            _ => None,
        }
    }

    /// Simulates `dt` seconds of waiting for the next report.
    pub(super) fn wait_to_report(&mut self, dt: f64) {
        self.unasked_for = if self.report().is_some() { self.unasked_for + dt } else { 0.0 };
        self.releasing.iter_mut().for_each(|left| *left -= dt);
    }

    /// Returns the frame that the drive sends without being asked, if one is due.
    pub fn unasked(&mut self) -> Option<Frame> {
        if self.powered && self.releasing.pop_front_if(|left| *left <= 0.0).is_some() {
            return Some(self.answer_with([0x77, 0, 0, 0, 0, 0, 0, 0]));
        }
        let (every, frame) = self.report()?;
        if self.unasked_for < every {
            return None;
        }
        self.unasked_for = 0.0;
        Some(frame)
    }
}
