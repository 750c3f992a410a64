//! An actuator in MIT mode, from its own side of the wire.
//!
//! Field layout and special frames after B. Katz, `CAN_com.cpp` of the mini-cheetah motor controller, with its arithmetic:
//! `float_to_uint` cuts off, `uint_to_float` is `code span / (2^bits - 1) + min`.

mod actuator;
mod frames;
mod language;

use crate::frame::{Frame, Order};

pub use actuator::Actuator;
pub use language::{Language, Ranges, Setpoint, error, to_code, to_float};

/// Identifier of a Damiao's requests about registers.
const REGISTERS: u32 = 0x7ff;

/// Unit of a timeout in registers and parameters, s.
const TIMEOUT_UNIT: f64 = 50e-6;

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
}
