//! Registers, state and settings of a Damiao motor.
//!
//! Requests have the identifier 0x7FF: the motor's identifier in two bytes, the operation (0x33 read, 0x55 write, 0xAA store, 0xCC report the state), the
//! register, the value in four bytes, low byte first. Source of the last operation: the maker's `DM_CAN.py` (`refresh_motor_status`). Not tried on
//! hardware.

use super::adapter::Adapter;
use super::damiao_register::{ID, MODE, POSITION_RANGE, REPLY_ID, Register, TIMEOUT, TORQUE_RANGE, VELOCITY_RANGE};
use super::frame::CanFrame;
use super::motors::{TRIES, UNTIL_POWER_OFF, Value, ask};
use dynamics_core::drive::Protocol;
use embedded_can::Frame as _;
use joint_io::damiao::CLEAR;
use joint_io::frames::error_text;
use std::io;

const REQUESTS: u32 = 0x7FF;
const READ: u8 = 0x33;
const WRITE: u8 = 0x55;
const STORE: u8 = 0xAA;
const REPORT: u8 = 0xCC;

/// Frame that makes the present position the zero.
const ZERO: [u8; 8] = [0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFE];

/// Largest position after the zero was set, as a share of the range: a motor at rest moves less.
const ZERO_MAX: f64 = 1e-3;

/// State of a motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// 0 off, 1 on, from 8 an error.
    pub code: u8,
    /// Raw position, velocity and torque of the frame, as shares of their ranges, -1 to 1.
    pub shares: [f64; 3],
    /// Temperatures of the transistors and of the winding, degrees Celsius.
    pub temperatures: [u8; 2],
}

impl State {
    /// True if the motor gives torque.
    #[must_use]
    pub fn is_on(&self) -> bool {
        self.code == 1
    }

    /// Text of the state.
    #[must_use]
    pub fn text(&self) -> &'static str {
        match self.code {
            0 => "off",
            1 => "on",
            code => error_text(Protocol::Damiao)(code),
        }
    }
}

/// Ranges of a motor's frames, at its shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameRanges {
    /// Highest position, rad.
    pub position: f64,
    /// Highest velocity, rad/s.
    pub velocity: f64,
    /// Highest torque, N m.
    pub torque: f64,
}

/// Settings that decide what a frame means to a motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorSettings {
    /// Identifier of its replies.
    pub reply_id: u32,
    /// Control mode; 1 is MIT. `None` if the motor answers nothing about it.
    pub mode: Option<u32>,
    /// Ranges of its frames.
    pub ranges: FrameRanges,
}

/// A Damiao motor at an adapter.
pub struct DamiaoMotor<'a> {
    adapter: &'a mut dyn Adapter,
    id: u8,
}

impl<'a> DamiaoMotor<'a> {
    /// The motor with this identifier.
    pub fn new(adapter: &'a mut dyn Adapter, id: u8) -> Self {
        Self { adapter, id }
    }

    /// True if it answers a request about a register.
    ///
    /// # Errors
    /// As [`DamiaoMotor::read`].
    pub fn answers(&mut self) -> io::Result<bool> {
        Ok(self.read_with_retries(REPLY_ID)?.is_some())
    }

    fn request(&self, what: u8, register: u8, value: [u8; 4]) -> io::Result<CanFrame> {
        let [a, b, c, d] = value;
        let data = [self.id, 0, what, register, a, b, c, d];
        CanFrame::of(REQUESTS, false, &data).ok_or_else(|| io::ErrorKind::InvalidInput.into())
    }

    /// Reads a register; `None` if the motor does not answer.
    ///
    /// # Errors
    /// The adapter is gone, or does not send.
    pub fn read(&mut self, register: Register) -> io::Result<Option<Value>> {
        let (request, own) = (self.request(READ, register.number, [0; 4])?, self.id);
        ask(self.adapter, &request, |answer| {
            let &[id, 0, READ, number, a, b, c, d] = answer.data() else { return None };
            let bits = u32::from_le_bytes([a, b, c, d]);
            // A request of another program looks the same but for its identifier.
            (id == own && number == register.number && !answer.is_extended() && answer.raw_id() != REQUESTS)
                .then(|| register.kind.value(bits))
        })
    }

    /// As [`DamiaoMotor::read`], several times if no answer comes, because a frame may be lost.
    fn read_with_retries(&mut self, register: Register) -> io::Result<Option<Value>> {
        (0..TRIES).find_map(|_| self.read(register).transpose()).transpose()
    }

    /// The motor's state; `None` if it does not answer.
    ///
    /// # Errors
    /// As [`DamiaoMotor::read`].
    pub fn state(&mut self) -> io::Result<Option<State>> {
        let (request, own) = (self.request(REPORT, 0, [0; 4])?, self.id);
        ask(self.adapter, &request, |answer| state(answer, own))
    }

    /// Settings that decide what a frame means to the motor; `None` if it does not answer.
    ///
    /// # Errors
    /// As [`DamiaoMotor::read`]; it answers, but not about each of them.
    pub fn settings(&mut self) -> io::Result<Option<MotorSettings>> {
        let own = self.id;
        let silent =
            |register: Register| io::Error::other(format!("motor {own}: no answer about its {}", register.name));
        let Some(Value::Integer(reply_id)) = self.read_with_retries(REPLY_ID)? else { return Ok(None) };
        let mode = match self.read_with_retries(MODE)? {
            Some(Value::Integer(mode)) => Some(mode),
            _ => None,
        };
        let mut range = |register| match self.read_with_retries(register)? {
            Some(Value::Float(value)) => Ok(f64::from(value)),
            _ => Err(silent(register)),
        };
        let ranges = FrameRanges {
            position: range(POSITION_RANGE)?,
            velocity: range(VELOCITY_RANGE)?,
            torque: range(TORQUE_RANGE)?,
        };
        Ok(Some(MotorSettings { reply_id, mode, ranges }))
    }

    /// Sets the ranges of the frames and stores them in flash. Afterwards every frame has another meaning to the motor.
    ///
    /// # Errors
    /// As for [`DamiaoMotor::set_id`].
    pub fn set_ranges(&mut self, ranges: &[(Register, f32)]) -> io::Result<()> {
        for (place, (register, value)) in ranges.iter().enumerate() {
            self.write(*register, value.to_bits(), place + 1 == ranges.len()).map_err(|error| match place {
                0 => error,
                _ => io::Error::other(format!("{error}; the ranges before it are set, too")),
            })?;
        }
        Ok(())
    }

    /// Writes a register, reads it back, and stores it in flash if `stores`. The motor must be off.
    ///
    /// # Errors
    /// As [`DamiaoMotor::read`]; the motor is silent, is on, or has another value afterwards.
    fn write(&mut self, register: Register, value: u32, stores: bool) -> io::Result<()> {
        self.must_be_off()?;
        let request = self.request(WRITE, register.number, value.to_le_bytes())?;
        let number = register.number;
        ask(self.adapter, &request, |answer| {
            matches!(answer.data(), [_, 0, WRITE, at, ..] if *at == number).then_some(())
        })?;
        if register == ID {
            // From now on it answers to the new one. A value that does not fit is refused before.
            self.id = value as u8;
        }
        let wrote = register.kind.value(value);
        let found = self.read_with_retries(register)?;
        if found != Some(wrote) {
            let found = found.map_or_else(|| "no answer".to_owned(), |it| it.to_string());
            return Err(io::Error::other(format!(
                "{}: wrote {wrote}, read {found}: nothing was stored, but it may use the new value: {UNTIL_POWER_OFF}",
                register.name
            )));
        }
        if stores {
            let request = self.request(STORE, 1, [0; 4])?;
            ask(self.adapter, &request, |answer| matches!(answer.data(), [_, 0, STORE, ..]).then_some(()))?
                .ok_or_else(|| {
                    io::Error::other(format!(
                        "{}: {wrote} is set, and the motor did not confirm that it stored it: {UNTIL_POWER_OFF}",
                        register.name
                    ))
                })?;
        }
        Ok(())
    }

    fn must_be_off(&mut self) -> io::Result<()> {
        match self.state()? {
            None => Err(io::Error::other(format!("motor {} does not answer", self.id))),
            Some(state) if state.is_on() => Err(io::Error::other(format!(
                "motor {} is on: nothing was changed; settings are changed while it is off",
                self.id
            ))),
            Some(_) => Ok(()),
        }
    }

    /// Sets the communication timeout and stores it in flash.
    ///
    /// # Errors
    /// As for [`DamiaoMotor::set_id`].
    pub fn set_timeout(&mut self, units: u32) -> io::Result<()> {
        self.write(TIMEOUT, units, true)
    }

    /// Sets the identifier, and that of the replies to it plus `reply_offset`, and stores both in flash.
    ///
    /// # Errors
    /// The adapter is gone; the motor is silent, is on, or has another value afterwards; another motor has this identifier.
    pub fn set_id(&mut self, id: u8, reply_offset: u8) -> io::Result<()> {
        for other in [id, id.saturating_add(reply_offset)] {
            if other != self.id && DamiaoMotor::new(self.adapter, other).state()?.is_some() {
                return Err(io::Error::other(format!("motor {other} is on this bus already: nothing was changed")));
            }
        }
        self.write(REPLY_ID, u32::from(id) + u32::from(reply_offset), false)?;
        self.write(ID, u32::from(id), true)
    }

    /// Makes the present position the zero. Returns the position before, as a share of the range, and after.
    ///
    /// # Errors
    /// As for [`DamiaoMotor::set_id`].
    pub fn set_zero(&mut self) -> io::Result<(f64, f64)> {
        self.must_be_off()?;
        let own = self.id;
        let position = |motor: &mut Self, what: &str| {
            let silent = || io::Error::other(format!("motor {own} does not say its position{what}"));
            io::Result::Ok(motor.state()?.ok_or_else(silent)?.shares[0])
        };
        let before = position(self, ": nothing was changed")?;
        let request = self.command(ZERO)?;
        ask(self.adapter, &request, |answer| state(answer, own))?;
        let after = position(self, " after the zero was set: look at it with `motors show`")?;
        if after.abs() < ZERO_MAX {
            return Ok((before, after));
        }
        Err(io::Error::other(format!(
            "motor {own}: its position is {after:.4} of the range, not 0: it did not take the zero"
        )))
    }

    /// Clears the error. Returns the state afterwards.
    ///
    /// # Errors
    /// The adapter is gone, or the motor is silent.
    pub fn clear(&mut self) -> io::Result<State> {
        self.must_be_off()?;
        let (request, own) = (self.command(CLEAR)?, self.id);
        ask(self.adapter, &request, |answer| state(answer, own))?;
        self.state()?.ok_or_else(|| io::Error::other(format!("motor {own} does not answer")))
    }

    fn command(&self, data: [u8; 8]) -> io::Result<CanFrame> {
        CanFrame::of(u32::from(self.id), false, &data).ok_or_else(|| io::ErrorKind::InvalidInput.into())
    }
}

/// The state in a reply of the motor with this identifier. An answer about a register is none, nor is a frame of a RobStride motor.
fn state(answer: &CanFrame, own: u8) -> Option<State> {
    let data = answer.data();
    let &[head, p_high, p_low, v, vt, t, transistors, winding] = data else { return None };
    if answer.is_extended()
        || head & 0xF != own & 0xF
        || matches!(data, [id, 0, READ | WRITE | STORE | REPORT, ..] if *id == own)
    {
        return None;
    }
    let share = |code: u16, most: u16| 2.0 * f64::from(code) / f64::from(most) - 1.0;
    let velocity = u16::from(v) << 4 | u16::from(vt >> 4);
    let torque = u16::from(vt & 0xF) << 8 | u16::from(t);
    Some(State {
        code: head >> 4,
        shares: [share(u16::from_be_bytes([p_high, p_low]), u16::MAX), share(velocity, 0xFFF), share(torque, 0xFFF)],
        temperatures: [transistors, winding],
    })
}
