//! An actuator in MIT mode, from its own side of the wire.
//!
//! Field layout and special frames after B. Katz, `CAN_com.cpp` of the mini-cheetah motor controller, with its arithmetic:
//! `float_to_uint` cuts off, `uint_to_float` is `code span / (2^bits - 1) + min`.

use crate::frame::{Frame, Order};

/// Identifier of a Damiao's requests about registers.
const REGISTERS: u32 = 0x7ff;

/// Unit of a timeout in registers and parameters, s.
const TIMEOUT_UNIT: f64 = 50e-6;

/// Ranges of the fields, `(lowest, highest)`, at the shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ranges {
    /// rad
    pub position: (f64, f64),
    /// rad/s
    pub velocity: (f64, f64),
    /// N m/rad
    pub kp: (f64, f64),
    /// N m s/rad
    pub kd: (f64, f64),
    /// N m
    pub torque: (f64, f64),
}

/// Last command to an actuator.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Setpoint {
    /// rad
    pub position: f64,
    /// rad/s
    pub velocity: f64,
    /// N m/rad
    pub kp: f64,
    /// N m s/rad
    pub kd: f64,
    /// N m
    pub torque: f64,
}

/// Motion of a shaft.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shaft {
    /// rad
    pub position: f64,
    /// rad/s
    pub velocity: f64,
}

/// The part of a position that survives a loss of power.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Memory {
    /// All of it.
    Absolute,
    /// The angle within a turn of this many rad of the shaft: of a motor behind a gear of 6, 2 pi / 6.
    Turn(f64),
    /// Nothing: the shaft is at 0 where it starts.
    Nothing,
}

/// Codes of [`Electronics::error`], after the feedback frame in Damiao's manual of the DM4310.
pub mod error {
    /// The supply voltage is too high.
    pub const OVER_VOLTAGE: u8 = 0x8;
    /// The supply voltage is too low.
    pub const UNDER_VOLTAGE: u8 = 0x9;
    /// The drive is too hot.
    pub const HOT: u8 = 0xb;
    /// No command has come for [`Electronics::timeout`](super::Electronics::timeout); a Damiao's alone.
    pub const SILENCE: u8 = 0xd;
    /// The load is too much; somebody else finds that.
    pub const OVERLOAD: u8 = 0xe;
}

/// Frames that an actuator speaks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Language {
    /// The mini-cheetah's.
    #[default]
    MiniCheetah,
    /// Damiao's: the same commands; replies with state, error and temperatures.
    Damiao,
    /// RobStride's private protocol; its replies go to the host with the identifier [`Electronics::reply_id`].
    RobStride,
}

impl Language {
    /// The frames with this name in robot files.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let all = [("mit", Self::MiniCheetah), ("damiao", Self::Damiao), ("robstride", Self::RobStride)];
        all.into_iter().find(|(other, _)| *other == name).map(|(_, language)| language)
    }
}

/// Electronics of an actuator: frames in and out, and the torque on a shaft that somebody else moves.
///
/// `torque = kp (position - p) + kd (velocity - v) + feed-forward`, held inside `torque_max` either way; none while the drive is off, has
/// an error, or has heard nothing for `timeout`:
///
/// | frames | after `timeout` without a frame while it is on | timeout after a start |
/// |---|---|---|
/// | mini-cheetah | no torque until the next command (B. Katz: the command becomes zero) | what it was: it cannot be read or set over the bus |
/// | Damiao | off, with [`error::SILENCE`] until it is cleared | 0.4 s (i2rt's setting of YAM) |
/// | RobStride | off | none |
#[derive(Clone, Debug, PartialEq)]
pub struct Electronics {
    /// Its frames.
    pub language: Language,
    /// Identifier of its commands.
    pub id: u16,
    /// Identifier of its replies.
    pub reply_id: u16,
    /// Bytes of its replies.
    pub reply_bytes: usize,
    /// Ranges of its frames' fields.
    pub ranges: Ranges,
    /// Its greatest torque, for any command, N m.
    pub torque_max: f64,
    /// Seconds without a frame after which it gives no torque; 0: it never stops.
    pub timeout: f64,
    /// The same after a start.
    pub first_timeout: f64,
    /// It answers nothing about its settings, and takes none: an older program.
    pub has_no_settings: bool,
    /// The frame that enables it does nothing.
    pub ignores_enable: bool,
    /// The part of its position that survives a loss of power.
    pub memory: Memory,
    /// Its own error; not zero: it gives no torque.
    pub error: u8,
    /// Its temperature's byte.
    pub temperature: u8,
    /// Highest temperature's byte; above: [`error::HOT`].
    pub temperature_max: u8,
    /// Supply voltage, V.
    pub supply: f64,
    /// Lowest and highest supply voltage, V; beyond: [`error::UNDER_VOLTAGE`], [`error::OVER_VOLTAGE`].
    pub supply_range: (f64, f64),
    /// It has power. Without it the drive hears nothing, says nothing and gives no torque until [`Electronics::restart`].
    pub powered: bool,
    enabled: bool,
    /// A frame has switched it off, and nothing else did before.
    told_off: bool,
    silent_for: f64,
    zero: f64,
    told: Setpoint,
    torque: f64,
}

impl Electronics {
    /// Electronics that are off.
    #[must_use]
    pub fn new(id: u16, ranges: Ranges) -> Self {
        Self {
            language: Language::default(),
            id,
            reply_id: 0,
            reply_bytes: 6,
            ranges,
            torque_max: ranges.torque.1,
            timeout: 0.1,
            first_timeout: 0.1,
            has_no_settings: false,
            ignores_enable: false,
            memory: Memory::Turn(core::f64::consts::TAU / 6.0),
            error: 0,
            temperature: 25,
            temperature_max: u8::MAX,
            supply: 24.0,
            supply_range: (0.0, f64::INFINITY),
            powered: true,
            enabled: false,
            told_off: false,
            silent_for: 0.0,
            zero: 0.0,
            told: Setpoint::default(),
            torque: 0.0,
        }
    }

    /// The same, with other frames, and with what their makers' drives have: the communication timeout and the memory of the position.
    #[must_use]
    pub fn speaking(self, language: Language) -> Self {
        let (timeout, memory) = match language {
            Language::MiniCheetah => (self.first_timeout, self.memory),
            Language::Damiao => (0.4, Memory::Turn(core::f64::consts::TAU)),
            Language::RobStride => (0.0, Memory::Turn(core::f64::consts::TAU)),
        };
        Self { language, timeout, first_timeout: timeout, memory, ..self }
    }

    /// Power comes back: it is off, without an error, with the settings of a start, and knows of its position what its memory holds.
    pub fn restart(&mut self, shaft: &Shaft) {
        (self.enabled, self.error, self.silent_for, self.timeout) = (false, 0, 0.0, self.first_timeout);
        self.told_off = false;
        (self.told, self.torque, self.powered) = (Setpoint::default(), 0.0, true);
        let position = shaft.position - self.zero;
        let shown = match self.memory {
            Memory::Absolute => position,
            Memory::Turn(turn) => position - turn * (position / turn).round(),
            Memory::Nothing => 0.0,
        };
        self.zero = shaft.position - shown;
    }

    /// Switches itself off without a word, as after a fault that it forgets.
    pub fn trip(&mut self) {
        (self.enabled, self.told_off, self.told) = (false, false, Setpoint::default());
    }

    /// A frame switches it off.
    fn exit(&mut self) {
        self.told_off |= self.gives_torque();
        (self.enabled, self.told) = (false, Setpoint::default());
    }

    /// True if a disable frame switched it off while it followed commands.
    #[must_use]
    pub fn was_told_off(&self) -> bool {
        self.told_off && !self.enabled
    }

    /// Makes the present position the zero, as a frame from somebody else would.
    pub fn set_zero(&mut self, shaft: &Shaft) {
        self.zero = shaft.position;
    }

    /// Position of the shaft at which it shows 0, rad.
    #[must_use]
    pub fn zero(&self) -> f64 {
        self.zero
    }

    /// Seconds since the last frame to it.
    #[must_use]
    pub fn silent_for(&self) -> f64 {
        self.silent_for
    }

    /// Kind of a frame that it hears.
    #[must_use]
    pub fn order(&self, frame: &Frame) -> Order {
        match (self.language, frame.data.as_slice()) {
            (Language::RobStride, [first, ..]) => match frame.id >> 24 {
                3 => Order::Enable,
                4 if *first == 1 => Order::Clear,
                4 => Order::Disable,
                17 | 18 => Order::Setting,
                _ => Order::Torque,
            },
            (Language::Damiao, _) if frame.id == REGISTERS => Order::Setting,
            (_, [0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, last]) => match last {
                0xfc => Order::Enable,
                0xfd => Order::Disable,
                0xfb => Order::Clear,
                _ => Order::Torque,
            },
            _ => Order::Torque,
        }
    }

    /// True if it drives.
    #[must_use]
    pub fn is_enabled(&self) -> bool {
        self.enabled
    }

    /// Last command to it.
    #[must_use]
    pub fn told(&self) -> Setpoint {
        self.told
    }

    /// Torque that it gave last, N m.
    #[must_use]
    pub fn torque(&self) -> f64 {
        self.torque
    }

    /// True if the torque depends on the shaft. Otherwise it is constant until the next frame, or the timeout.
    #[must_use]
    pub fn follows_the_shaft(&self) -> bool {
        self.gives_torque() && (self.told.kp != 0.0 || self.told.kd != 0.0)
    }

    /// True if a frame on the bus is for this actuator.
    #[must_use]
    pub fn hears(&self, frame: &Frame) -> bool {
        match self.language {
            Language::RobStride => frame.extended && frame.id & 0xff == u32::from(self.id),
            Language::MiniCheetah => !frame.extended && frame.id == u32::from(self.id),
            Language::Damiao => {
                let asked = frame.id == REGISTERS && frame.data.first().copied() == Some(self.id as u8);
                !frame.extended && (frame.id == u32::from(self.id) || asked)
            }
        }
    }

    /// Take a frame; the reply. It measures now.
    pub fn answer(&mut self, frame: &Frame, shaft: &Shaft) -> Option<Frame> {
        match self.language {
            _ if !self.powered => None,
            Language::RobStride => self.answer_as_robstride(frame, shaft),
            Language::Damiao if frame.id == REGISTERS => self.answer_about_a_register(frame),
            Language::MiniCheetah | Language::Damiao => {
                self.receive(&frame.data, shaft).map(|data| Frame::standard(self.reply_id, data))
            }
        }
    }

    /// Identifier, 0, 0x33 to read or 0x55 to write, the register, a value, low byte first; the answer is the same with the value. Register 9
    /// is the timeout, by 50 us.
    fn answer_about_a_register(&mut self, frame: &Frame) -> Option<Frame> {
        let &[id, 0, what, register, a, b, c, d] = frame.data.as_slice() else { return None };
        if self.has_no_settings {
            return None;
        }
        self.silent_for = 0.0;
        if (what, register) == (0x55, 9) {
            self.timeout = f64::from(u32::from_le_bytes([a, b, c, d])) * TIMEOUT_UNIT;
        }
        let value = if register == 9 { (self.timeout / TIMEOUT_UNIT).round() as u32 } else { 0 };
        let [a, b, c, d] = value.to_le_bytes();
        Some(Frame::standard(self.reply_id, vec![id, 0, what, register, a, b, c, d]))
    }

    /// Bits 28 to 24 of the identifier say what it is: 1 a command, whose torque stands in bits 23 to 8, 3 on, 4 off.
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
            // A parameter: 17 read, 18 written. Index, 0, 0, value, low bytes first; 0x7028 is the timeout, by 50 us.
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

    /// Take a command; the reply's data. It measures now.
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

    /// Time goes by, s: towards the timeout, and the drive looks after itself.
    pub fn pass(&mut self, dt: f64) {
        if !self.powered {
            return;
        }
        self.silent_for += dt;
        if self.error == 0 {
            self.error = self.found();
        }
        if self.enabled && self.is_silent() {
            match self.language {
                Language::MiniCheetah => {}
                Language::Damiao => (self.enabled, self.error) = (false, error::SILENCE),
                Language::RobStride => self.enabled = false,
            }
        }
    }

    /// True if no frame has come for longer than the timeout.
    fn is_silent(&self) -> bool {
        self.timeout > 0.0 && self.silent_for > self.timeout
    }

    /// Error that the drive finds in itself; 0 for none.
    fn found(&self) -> u8 {
        let (lowest, highest) = self.supply_range;
        if self.supply > highest {
            error::OVER_VOLTAGE
        } else if self.supply < lowest {
            error::UNDER_VOLTAGE
        } else if self.temperature > self.temperature_max {
            error::HOT
        } else {
            0
        }
    }

    /// Torque on the shaft now, N m: one turn of the drive's own loop.
    pub fn drive(&mut self, shaft: &Shaft) -> f64 {
        self.torque = if self.gives_torque() {
            let Setpoint { position, velocity, kp, kd, torque } = self.told;
            let wanted = kp * (position - (shaft.position - self.zero)) + kd * (velocity - shaft.velocity) + torque;
            wanted.clamp(-self.torque_max, self.torque_max)
        } else {
            0.0
        };
        self.torque
    }

    /// True if it follows commands: it has power, is on, has no error, and hears somebody.
    #[must_use]
    pub fn gives_torque(&self) -> bool {
        self.powered && self.enabled && self.error == 0 && !self.is_silent()
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

/// An actuator at a bus: electronics and the shaft that they measure.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuator {
    /// Frames, loop, errors.
    pub electronics: Electronics,
    /// The shaft: moved by [`Actuator::step`], or by an arm that carries it.
    pub shaft: Shaft,
    /// Inertia at the shaft, kg m^2, where [`Actuator::step`] moves it.
    pub inertia: f64,
}

impl Actuator {
    /// An actuator at rest at 0, off, with a free shaft.
    #[must_use]
    pub fn new(id: u16, ranges: Ranges) -> Self {
        Self { electronics: Electronics::new(id, ranges), shaft: Shaft::default(), inertia: 0.01 }
    }

    /// Take a command; the reply's data.
    pub fn receive(&mut self, data: &[u8]) -> Option<Vec<u8>> {
        self.electronics.receive(data, &self.shaft)
    }

    /// Take a frame of the bus; the reply.
    pub fn answer(&mut self, frame: &Frame) -> Option<Frame> {
        self.electronics.answer(frame, &self.shaft)
    }

    /// Time goes by for a free shaft, under a torque from outside, N m.
    pub fn step(&mut self, dt: f64, load: f64) {
        self.electronics.pass(dt);
        let torque = self.electronics.drive(&self.shaft);
        self.shaft.velocity += dt * (torque + load) / self.inertia;
        self.shaft.position += dt * self.shaft.velocity;
    }
}

/// `float_to_uint`, on a value held inside the range.
#[must_use]
pub fn to_code(x: f64, (lo, hi): (f64, f64), bits: u32) -> u32 {
    let top = f64::from((1_u32 << bits) - 1);
    ((x.clamp(lo, hi) - lo) * top / (hi - lo)) as u32
}

/// `uint_to_float`.
#[must_use]
pub fn to_float(code: u32, (lo, hi): (f64, f64), bits: u32) -> f64 {
    f64::from(code) * (hi - lo) / f64::from((1_u32 << bits) - 1) + lo
}
