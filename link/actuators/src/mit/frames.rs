//! Received frames, and the replies to them.

use super::{Electronics, Language, REGISTERS, Setpoint, Shaft, TIMEOUT_UNIT, error, to_code, to_float};
use crate::frame::Frame;

impl Electronics {
    /// True if a frame on the bus is for this actuator.
    #[must_use]
    pub fn hears(&self, frame: &Frame) -> bool {
        match self.language {
            Language::RobStride => frame.extended && frame.id & 0xff == u32::from(self.id),
            Language::MiniCheetah => !frame.extended && frame.id == u32::from(self.id),
            Language::MyActuator => self.hears_as_my_actuator(frame),
            Language::Damiao => {
                let asked = frame.id == REGISTERS && frame.data.first().copied() == Some(self.id as u8);
                !frame.extended && (frame.id == u32::from(self.id) || asked)
            }
        }
    }

    /// Takes a frame and returns the reply, with the present state of the shaft.
    pub fn answer(&mut self, frame: &Frame, shaft: &Shaft) -> Option<Frame> {
        match self.language {
            _ if !self.powered => None,
            Language::RobStride => self.answer_as_robstride(frame, shaft),
            Language::MyActuator => self.answer_as_my_actuator(frame, shaft),
            Language::Damiao if frame.id == REGISTERS => self.answer_about_a_register(frame),
            Language::MiniCheetah | Language::Damiao => {
                self.receive(&frame.data, shaft).map(|data| Frame::standard(self.reply_id, data))
            }
        }
    }

    /// Answers a request about a register. Request: identifier, 0, 0x33 to read or 0x55 to write, the register, and a value, low byte first. The
    /// answer repeats it with the register's value: 7 identifier of the replies, 8 identifier, 9 timeout in units of 50 us, 10 control mode (1 MIT), 21 to
    /// 23 the highest position, velocity and torque of its frames, as 32-bit floats.
    fn answer_about_a_register(&mut self, frame: &Frame) -> Option<Frame> {
        let &[id, 0, what, register, a, b, c, d] = frame.data.as_slice() else { return None };
        if self.has_no_settings {
            return None;
        }
        self.silent_for = 0.0;
        if (what, register) == (0x55, 9) {
            self.timeout = f64::from(u32::from_le_bytes([a, b, c, d])) * TIMEOUT_UNIT;
        }
        let highest = |range: (f64, f64)| (range.1 as f32).to_bits();
        let value = match register {
            7 => self.reply_id.into(),
            8 => self.id.into(),
            9 => (self.timeout / TIMEOUT_UNIT).round() as u32,
            10 => 1,
            21 => highest(self.ranges.position),
            22 => highest(self.ranges.velocity),
            23 => highest(self.ranges.torque),
            _ => 0,
        };
        let [a, b, c, d] = value.to_le_bytes();
        Some(Frame::standard(self.reply_id, vec![id, 0, what, register, a, b, c, d]))
    }

    /// Answers a frame of the RobStride protocol. Bits 28 to 24 of the identifier are its kind: 1 a command (with the torque in bits 23 to 8), 3
    /// on, 4 off, 17 read a parameter, 18 write one.
    fn answer_as_robstride(&mut self, frame: &Frame, shaft: &Shaft) -> Option<Frame> {
        let &[b0, b1, b2, b3, b4, b5, b6, b7] = frame.data.as_slice() else { return None };
        self.silent_for = 0.0;
        match frame.id >> 24 {
            1 => {
                let code = |high: u8, low: u8| u32::from(high) << 8 | u32::from(low);
                let r = &self.ranges;
                self.told = Setpoint {
                    position: to_float(code(b0, b1), r.position, 16),
                    velocity: to_float(code(b2, b3), r.velocity, 16),
                    kp: to_float(code(b4, b5), r.kp, 16),
                    kd: to_float(code(b6, b7), r.kd, 16),
                    torque: to_float(frame.id >> 8 & 0xffff, r.torque, 16),
                };
            }
            3 => {
                (self.enabled, self.told) = (self.enabled || !self.ignores_enable, Setpoint::default());
                self.told_off &= !self.enabled;
            }
            4 => {
                self.exit();
                if b0 == 1 {
                    self.error = 0;
                }
            }
            // A parameter: index, 0, 0, value, low bytes first. 0x7028 is the timeout in units of 50 us.
            17 if !self.has_no_settings => {
                let value = if [b0, b1] == [0x28, 0x70] { (self.timeout / TIMEOUT_UNIT).round() as u32 } else { 0 };
                let id = 17 << 24 | u32::from(self.id) << 8 | u32::from(self.reply_id);
                let [a, b, c, d] = value.to_le_bytes();
                return Some(Frame { id, extended: true, data: vec![b0, b1, 0, 0, a, b, c, d] });
            }
            18 if !self.has_no_settings => {
                if [b0, b1] == [0x28, 0x70] {
                    self.timeout = f64::from(u32::from_le_bytes([b4, b5, b6, b7])) * TIMEOUT_UNIT;
                }
            }
            _ => return None,
        }
        self.drive(shaft);
        let bytes = |code: u32| (code as u16).to_be_bytes();
        let data = [
            bytes(to_code(shaft.position - self.zero, self.ranges.position, 16)),
            bytes(to_code(shaft.velocity, self.ranges.velocity, 16)),
            bytes(to_code(self.torque, self.ranges.torque, 16)),
            bytes(10 * u32::from(self.temperature)),
        ];
        let errors = match self.error {
            0 => 0,
            error::UNDER_VOLTAGE => 1 << 0,
            error::HOT => 1 << 2,
            error::OVERLOAD => 1 << 4,
            _ => 1 << 1,
        };
        let state = if self.enabled && self.error == 0 { 2 } else { 0 };
        let id = 2 << 24 | state << 22 | errors << 16 | u32::from(self.id) << 8 | u32::from(self.reply_id);
        Some(Frame { id, extended: true, data: data.concat() })
    }

    /// Takes a command's data and returns the reply's data, with the present state of the shaft.
    pub fn receive(&mut self, data: &[u8], shaft: &Shaft) -> Option<Vec<u8>> {
        let &[b0, b1, b2, b3, b4, b5, b6, b7] = data else { return None };
        self.silent_for = 0.0;
        match ([b0, b1, b2, b3, b4, b5, b6] == [0xff; 7], b7) {
            (true, 0xfc) => {
                self.enabled |= !self.ignores_enable;
                self.told_off &= !self.enabled;
                self.told = Setpoint::default();
            }
            (true, 0xfd) => self.exit(),
            (true, 0xfe) => self.zero = shaft.position,
            (true, 0xfb) if self.language == Language::Damiao => (self.enabled, self.error) = (false, 0),
            _ => {
                let code = |high: u8, low: u8| u32::from(high) << 8 | u32::from(low);
                let r = &self.ranges;
                self.told = Setpoint {
                    position: to_float(code(b0, b1), r.position, 16),
                    velocity: to_float(code(b2, b3) >> 4, r.velocity, 12),
                    kp: to_float(code(b3 & 0xf, b4), r.kp, 12),
                    kd: to_float(code(b5, b6) >> 4, r.kd, 12),
                    torque: to_float(code(b6 & 0xf, b7), r.torque, 12),
                };
            }
        }
        self.drive(shaft);
        Some(self.reply(shaft))
    }

    fn reply(&self, shaft: &Shaft) -> Vec<u8> {
        let p = to_code(shaft.position - self.zero, self.ranges.position, 16);
        let v = to_code(shaft.velocity, self.ranges.velocity, 12);
        let t = to_code(self.torque, self.ranges.torque, 12);
        let damiao = self.language == Language::Damiao;
        let state = if self.error == 0 { u8::from(self.enabled) } else { self.error };
        let mut data = vec![
            if damiao { state << 4 | self.id as u8 & 0xf } else { self.id as u8 },
            (p >> 8) as u8,
            p as u8,
            (v >> 4) as u8,
            ((v & 0xf) << 4) as u8 + (t >> 8) as u8,
            t as u8,
            self.temperature,
            if damiao { self.temperature } else { self.error },
        ];
        data.truncate(self.reply_bytes);
        data
    }
}
