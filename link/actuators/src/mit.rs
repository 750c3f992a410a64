//! Model of an actuator in MIT mode.
//!
//! Field layout and special frames follow B. Katz, `CAN_com.cpp` of the mini-cheetah motor controller, with its arithmetic: `float_to_uint`
//! truncates, `uint_to_float` is `code span / (2^bits - 1) + min`.

mod actuator;
mod frames;
mod language;
mod my_actuator;

use crate::frame::{Frame, Order};
use std::collections::VecDeque;

pub use actuator::Actuator;
pub use language::{Language, Ranges, Setpoint, error, to_code, to_float};

/// Identifier of a Damiao's requests about registers.
const REGISTERS: u32 = 0x7ff;

/// Unit of a timeout in registers and parameters, s.
const TIMEOUT_UNIT: f64 = 50e-6;

/// Motion of a shaft.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shaft {
    /// Position, rad.
    pub position: f64,
    /// Velocity, rad/s.
    pub velocity: f64,
}

/// Part of a position that survives a loss of power.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Memory {
    /// The whole position.
    Absolute,
    /// The angle within one turn of this many rad at the shaft; 2 pi / 6 for an encoder on the motor and a gear ratio of 6.
    Turn(f64),
    /// Nothing: the position after the start is 0.
    Nothing,
}

/// Electronics of an actuator: frames in and out, and the torque on a shaft that the caller moves.
///
/// `torque = kp (position - p) + kd (velocity - v) + feed-forward`, limited to `torque_max` in both directions. There is no torque while the
/// drive is off, has an error, or has received nothing for `timeout`:
///
/// | frames | after `timeout` without a frame while it is on | timeout after a start |
/// |---|---|---|
/// | mini-cheetah | no torque until the next command (B. Katz: the command becomes zero) | unchanged: it cannot be read or set over the bus |
/// | Damiao | off, with [`error::SILENCE`] until it is cleared | 0.4 s (i2rt's setting of YAM) |
/// | RobStride | off | none |
/// | MyActuator | no torque until the second command after it | unchanged; the maker's is none |
#[derive(Clone, Debug, PartialEq)]
pub struct Electronics {
    /// Its protocol.
    pub language: Language,
    /// Identifier of its commands.
    pub id: u16,
    /// Identifier of its replies.
    pub reply_id: u16,
    /// Length of its replies, bytes.
    pub reply_bytes: usize,
    /// Ranges of its frames' fields.
    pub ranges: Ranges,
    /// Largest torque, N m, whatever the command.
    pub torque_max: f64,
    /// Time without a frame after which it gives no torque, s; 0 for no timeout.
    pub timeout: f64,
    /// Value of `timeout` after a start, s.
    pub first_timeout: f64,
    /// True if it ignores frames about its settings, as older firmware of a drive does.
    pub has_no_settings: bool,
    /// True if it sends its status by itself while it has an error; only MyActuator drives do.
    pub reports_errors: bool,
    /// Time from the frame that releases the holding brake to its answer, s; only MyActuator drives need one. 0: at once.
    pub release_time: f64,
    /// True if it ignores the frame that enables it.
    pub ignores_enable: bool,
    /// Part of its position that survives a loss of power.
    pub memory: Memory,
    /// Its error code; with an error it gives no torque.
    pub error: u8,
    /// Temperature in its replies, degrees Celsius (a mini-cheetah's byte may have an offset).
    pub temperature: u8,
    /// Highest permitted value of `temperature`; above it, the error is [`error::HOT`].
    pub temperature_max: u8,
    /// Supply voltage, V.
    pub supply: f64,
    /// Lowest and highest permitted supply voltage, V; outside, the error is [`error::UNDER_VOLTAGE`] or [`error::OVER_VOLTAGE`].
    pub supply_range: (f64, f64),
    /// True if it has power. Without power it receives and sends nothing and gives no torque until [`Electronics::restart`].
    pub powered: bool,
    enabled: bool,
    /// True if a frame switched it off while it gave torque.
    told_off: bool,
    silent_for: f64,
    /// Time for which it has had something to report and has not sent it by itself, s.
    unasked_for: f64,
    /// Times left until its answers to frames that release the holding brake, s.
    releasing: VecDeque<f64>,
    zero: f64,
    told: Setpoint,
    torque: f64,
}

impl Electronics {
    /// Creates electronics that are off.
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
            reports_errors: false,
            release_time: 0.0,
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
            unasked_for: 0.0,
            releasing: VecDeque::new(),
            zero: 0.0,
            told: Setpoint::default(),
            torque: 0.0,
        }
    }

    /// Sets the protocol, and the communication timeout and memory of the position that drives of this maker have.
    #[must_use]
    pub fn speaking(self, language: Language) -> Self {
        let (timeout, memory) = match language {
            Language::MiniCheetah => (self.first_timeout, self.memory),
            Language::Damiao => (0.4, Memory::Turn(core::f64::consts::TAU)),
            Language::RobStride => (0.0, Memory::Turn(core::f64::consts::TAU)),
            Language::MyActuator => (0.0, self.memory),
        };
        Self { language, timeout, first_timeout: timeout, memory, ..self }
    }

    /// Simulates the return of power: the drive is off, without an error, with its settings after a start. Of its position it knows what its
    /// memory holds.
    pub fn restart(&mut self, shaft: &Shaft) {
        (self.enabled, self.error, self.silent_for, self.timeout) = (false, 0, 0.0, self.first_timeout);
        (self.told_off, self.reports_errors) = (false, false);
        self.releasing.clear();
        (self.told, self.torque, self.powered) = (Setpoint::default(), 0.0, true);
        let position = shaft.position - self.zero;
        let shown = match self.memory {
            Memory::Absolute => position,
            Memory::Turn(turn) => position - turn * (position / turn).round(),
            Memory::Nothing => 0.0,
        };
        self.zero = shaft.position - shown;
    }

    /// Simulates that the drive switches itself off without reporting an error.
    pub fn trip(&mut self) {
        (self.enabled, self.told_off, self.told) = (false, false, Setpoint::default());
    }

    /// Handles a frame that switches it off.
    fn exit(&mut self) {
        self.told_off |= self.gives_torque();
        (self.enabled, self.told) = (false, Setpoint::default());
    }

    /// True if a disable frame switched it off while it followed commands.
    #[must_use]
    pub fn was_told_off(&self) -> bool {
        self.told_off && !self.enabled
    }

    /// Makes the present position the zero, as a frame from another device would.
    pub fn set_zero(&mut self, shaft: &Shaft) {
        self.zero = shaft.position;
    }

    /// Returns the position of the shaft at which it reports 0, rad.
    #[must_use]
    pub fn zero(&self) -> f64 {
        self.zero
    }

    /// Returns the time since it last received a frame, s.
    #[must_use]
    pub fn silent_for(&self) -> f64 {
        self.silent_for
    }

    /// Returns the kind of a frame that is for it.
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
            (Language::MyActuator, _) => self.order_of_my_actuator(frame),
            (_, [0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, last]) => match last {
                0xfc => Order::Enable,
                0xfd => Order::Disable,
                0xfb => Order::Clear,
                _ => Order::Torque,
            },
            _ => Order::Torque,
        }
    }

    /// True if it is switched on.
    #[must_use]
    pub fn is_enabled(&self) -> bool {
        self.enabled
    }

    /// Returns the last command to it.
    #[must_use]
    pub fn told(&self) -> Setpoint {
        self.told
    }

    /// Returns the torque that it gave last, N m.
    #[must_use]
    pub fn torque(&self) -> f64 {
        self.torque
    }

    /// True if the torque depends on the shaft. Otherwise it is constant until the next frame, or the timeout.
    #[must_use]
    pub fn follows_the_shaft(&self) -> bool {
        self.gives_torque() && (self.told.kp != 0.0 || self.told.kd != 0.0)
    }

    /// Simulates `dt` seconds of the electronics: the communication timeout, and the drive's checks of supply and temperature.
    pub fn pass(&mut self, dt: f64) {
        if !self.powered {
            return;
        }
        self.silent_for += dt;
        self.wait_to_report(dt);
        if self.error == 0 {
            self.error = self.found();
        }
        if self.enabled && self.is_silent() {
            match self.language {
                Language::MiniCheetah | Language::MyActuator => {}
                Language::Damiao => (self.enabled, self.error) = (false, error::SILENCE),
                Language::RobStride => self.enabled = false,
            }
        }
    }

    /// True if no frame has arrived for longer than the timeout.
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

    /// Runs one cycle of the drive's own loop and returns the torque on the shaft, N m.
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

    /// True if it follows commands: it has power, is on, has no error, and its timeout has not expired.
    #[must_use]
    pub fn gives_torque(&self) -> bool {
        self.powered && self.enabled && self.error == 0 && !self.is_silent()
    }
}
