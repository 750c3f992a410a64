//! Settings and state of a RobStride motor.
//!
//! Frames as in [`joint_io::robstride`], and four more kinds: 0 asks for the number of the motor's chip, 6 makes the present position the zero (first
//! byte 1), 7 gives another identifier (in bits 23 to 16), 22 stores all parameters (bytes 1 to 8). Sources: the maker's manuals of RS00 to RS06, and
//! GitHub RobStride/SampleProgram, which says that old firmware has no frame of kind 22. Not tried on hardware.
//!
//! No frame asks for the state alone. A motor answers a written parameter by a reply, so the state is read by writing the timeout that the motor has.
//! Before that, the bus is listened to for 0.2 s: a motor that another program uses replies to that program, and then nothing is written. The version
//! is not read, because older firmware takes the request for it as the frame that switches the motor off.

use super::adapter::Adapter;
use super::frame::CanFrame;
use super::motors::{ANSWER, HOST_ID, TRIES, UNTIL_POWER_OFF, Value, ask, ask_within, with_id};
use super::robstride_parameter::{POSITION, Parameter, TIMEOUT};
use super::robstride_state::{OFF, State, WRITE, state_for_others};
use dynamics_core::drive::RobStride;
use embedded_can::Frame as _;
use joint_io::frames::Frames as _;
use std::io;
use std::time::Duration;

const CHIP: u32 = 0;
const SET_ZERO: u32 = 6;
const SET_ID: u32 = 7;
const READ: u32 = 17;
const STORE: u32 = 22;

/// Largest timeout, in units of 50 us.
const TIMEOUT_MAX: u32 = 100_000;

/// Time for the answer to the frame that stores. Flash is slow.
const STORING: Duration = Duration::from_millis(500);

/// Largest position after the zero was set, rad: a motor at rest moves less.
const ZERO_MAX: f64 = 0.01;

/// A RobStride motor at an adapter.
pub struct RobStrideMotor<'a> {
    adapter: &'a mut dyn Adapter,
    id: u8,
}

impl<'a> RobStrideMotor<'a> {
    /// The motor with this identifier.
    pub fn new(adapter: &'a mut dyn Adapter, id: u8) -> Self {
        Self { adapter, id }
    }

    fn frame(&self, kind: u32, argument: u8, data: [u8; 8]) -> io::Result<CanFrame> {
        let id = kind << 24 | u32::from(argument) << 16 | u32::from(HOST_ID) << 8 | u32::from(self.id);
        CanFrame::of(id, true, &data).ok_or_else(|| io::ErrorKind::InvalidInput.into())
    }

    /// Sends a frame that the motor answers by a reply; `None` if it does not.
    fn command(&mut self, kind: u32, data: [u8; 8]) -> io::Result<Option<State>> {
        let (frame, own) = (self.frame(kind, 0, data)?, self.id);
        let time = if kind == STORE { STORING } else { ANSWER };
        ask_within(time, self.adapter, &frame, |answer| {
            State::of(answer, own).filter(|_| answer.raw_id() as u8 == HOST_ID as u8)
        })
    }

    /// Sends a frame that changes something. The motor must confirm `what`, and that it is off.
    fn change(&mut self, kind: u32, data: [u8; 8], what: &str) -> io::Result<()> {
        match self.command(kind, data)? {
            Some(State { code: 0, .. }) => Ok(()),
            Some(state) => Err(io::Error::other(format!("it is now {}", state.text()))),
            None => Err(io::Error::other(format!("it did not confirm {what}"))),
        }
    }

    /// Answer to the request for a parameter: its bytes, or `None` if the motor has no such parameter. Asked several times.
    fn answer_about(&mut self, parameter: Parameter) -> io::Result<Option<Option<[u8; 4]>>> {
        let [low, high] = parameter.index.to_le_bytes();
        let (frame, own) = (self.frame(READ, 0, [low, high, 0, 0, 0, 0, 0, 0])?, with_id(self.id));
        for _ in 0..TRIES {
            let answer = ask(self.adapter, &frame, |answer| {
                let id = answer.raw_id();
                let &[a, b, _, _, v0, v1, v2, v3] = answer.data() else { return None };
                let is_ours = RobStride::answers(&own, answer.id()) && id >> 24 == READ && [a, b] == [low, high];
                is_ours.then(|| (id >> 16 & 0xFF == 0).then_some([v0, v1, v2, v3]))
            })?;
            if answer.is_some() {
                return Ok(answer);
            }
        }
        Ok(None)
    }

    /// Reads a parameter; `None` if the motor does not have it or does not answer.
    ///
    /// # Errors
    /// The adapter is gone, or does not send.
    pub fn read(&mut self, parameter: Parameter) -> io::Result<Option<Value>> {
        Ok(self.answer_about(parameter)?.flatten().map(|bytes| parameter.value(bytes)))
    }

    /// True if the motor answers a request for a parameter, whether it has that or not.
    ///
    /// # Errors
    /// As [`RobStrideMotor::read`].
    pub fn answers(&mut self) -> io::Result<bool> {
        Ok(self.answer_about(TIMEOUT)?.is_some())
    }

    fn timeout(&mut self) -> io::Result<Option<u32>> {
        Ok(self.answer_about(TIMEOUT)?.flatten().map(u32::from_le_bytes))
    }

    /// The motor's state; `None` if it does not answer, or has no timeout that could be written.
    ///
    /// # Errors
    /// As [`RobStrideMotor::read`].
    pub fn state(&mut self) -> io::Result<Option<State>> {
        match state_for_others(self.adapter, &[self.id])? {
            Some((_, state)) => Ok(Some(state)),
            None => self.state_while_unused(),
        }
    }

    /// The state, without listening. This writes, so [`state_for_others`] must have found no other program just before.
    pub(super) fn state_while_unused(&mut self) -> io::Result<Option<State>> {
        match self.timeout()? {
            Some(units) => self.command(WRITE, timeout_data(units)),
            None => Ok(None),
        }
    }

    /// Fails unless one motor has this identifier, is off, and is used by no other program. Returns the number of its chip.
    fn must_be_off(&mut self) -> io::Result<[u8; 8]> {
        let id = self.id;
        let unchanged = |why: String| io::Error::other(format!("{why}: nothing was changed"));
        let chip = self.chip().map_err(|why| unchanged(why.to_string()))?;
        match self.state()? {
            None => Err(unchanged(format!("motor {id} does not say its state"))),
            Some(State { code: 0, is_in_use: false, .. }) => Ok(chip),
            Some(state) => Err(io::Error::other(format!(
                "motor {id} is {}: nothing was changed; settings are changed while it is off and no other program runs",
                state.text()
            ))),
        }
    }

    /// The number of the motor's chip. Two motors with one identifier would both take a change, so it is asked for several times.
    pub(super) fn chip(&mut self) -> io::Result<[u8; 8]> {
        let (frame, own) = (self.frame(CHIP, 0, [0; 8])?, self.id);
        let mut found: Vec<[u8; 8]> = Vec::new();
        for _ in 0..TRIES {
            ask(self.adapter, &frame, |answer| {
                let number = <[u8; 8]>::try_from(answer.data()).ok()?;
                let id = answer.raw_id();
                if answer.is_extended() && id >> 24 == CHIP && (id >> 8) as u8 == own && !found.contains(&number) {
                    found.push(number);
                }
                // Others may answer, too.
                None::<()>
            })?;
        }
        match found.as_slice() {
            [one] => Ok(*one),
            [] => Err(io::Error::other(format!("motor {own} does not say the number of its chip"))),
            more => Err(io::Error::other(format!(
                "{} RobStride motors have the identifier {own}; connect one at a time",
                more.len()
            ))),
        }
    }

    fn store(&mut self) -> io::Result<()> {
        self.change(STORE, [1, 2, 3, 4, 5, 6, 7, 8], "that it stored anything, which old firmware cannot do")
    }

    /// Sets the communication timeout in units of 50 us, and stores it in flash.
    ///
    /// # Errors
    /// As for [`RobStrideMotor::set_id`].
    pub fn set_timeout(&mut self, units: u32) -> io::Result<()> {
        if units > TIMEOUT_MAX {
            return Err(io::Error::other("expected at most 5000 ms for a RobStride motor: nothing was changed"));
        }
        self.must_be_off()?;
        let mut set = || {
            self.change(WRITE, timeout_data(units), "the value")?;
            match self.timeout()? {
                Some(found) if found == units => self.store(),
                Some(found) => Err(io::Error::other(format!("wrote {units} x 50 us, read {found}"))),
                None => Err(io::Error::other("no answer about the timeout")),
            }
        };
        set().map_err(|why| unstored(self.id, "its timeout", &why))
    }

    /// Sets the identifier, and stores it in flash.
    ///
    /// # Errors
    /// The adapter is gone; the motor is silent, is on, or has another value afterwards; another program uses it; another RobStride motor has this
    /// identifier.
    pub fn set_id(&mut self, id: u8) -> io::Result<()> {
        if id == self.id {
            return Err(io::Error::other(format!("motor {id} has this identifier: nothing was changed")));
        }
        if RobStrideMotor::new(self.adapter, id).answers()? {
            return Err(io::Error::other(format!("motor {id} is on this bus already: nothing was changed")));
        }
        let chip = self.must_be_off()?;
        let (old, frame) = (self.id, self.frame(SET_ID, id, [0; 8])?);
        let mut set = || {
            // It answers with the number of its chip, under either identifier.
            ask(self.adapter, &frame, |answer| (answer.is_extended() && answer.raw_id() >> 24 == CHIP).then_some(()))?;
            self.id = id;
            if self.chip()? != chip {
                return Err(io::Error::other("another motor answers"));
            }
            self.store()
        };
        set().map_err(|why| unstored(old, "its identifier", &why))
    }

    /// The position, rad. Writes nothing.
    pub(super) fn position(&mut self) -> io::Result<f64> {
        match self.read(POSITION)? {
            Some(Value::Float(position)) if position.is_finite() => Ok(position.into()),
            _ => Err(io::Error::other(format!("motor {} does not say its position", self.id))),
        }
    }

    /// Makes the present position the zero, and stores it in flash. Returns the position before and after, rad.
    ///
    /// # Errors
    /// As for [`RobStrideMotor::set_id`].
    pub fn set_zero(&mut self) -> io::Result<(f64, f64)> {
        let before = self.position()?;
        self.must_be_off()?;
        let mut set = || {
            self.change(SET_ZERO, [1, 0, 0, 0, 0, 0, 0, 0], "the zero")?;
            let after = self.position()?;
            if after.abs() >= ZERO_MAX {
                return Err(io::Error::other(format!("its position is {after:.4} rad and not 0")));
            }
            self.store()?;
            Ok((before, after))
        };
        set().map_err(|why| unstored(self.id, "its zero", &why))
    }

    /// Clears the errors.
    ///
    /// # Errors
    /// The adapter is gone; the motor is silent or on; another program uses it; an error remains.
    pub fn clear(&mut self) -> io::Result<()> {
        self.must_be_off()?;
        let (id, data) = (self.id, [1, 0, 0, 0, 0, 0, 0, 0]);
        self.change(OFF, data, "the frame").map_err(|why| io::Error::other(format!("motor {id}: {why}")))?;
        match self.state()? {
            Some(State { error: 0, .. }) => Ok(()),
            Some(state) => Err(io::Error::other(format!("motor {id} is still {}", state.text()))),
            None => Err(io::Error::other(format!("motor {id} confirmed it, and did not say its state afterwards"))),
        }
    }
}

/// Data of the frame that writes the timeout.
fn timeout_data(units: u32) -> [u8; 8] {
    let ([low, high], [a, b, c, d]) = (TIMEOUT.index.to_le_bytes(), units.to_le_bytes());
    [low, high, 0, 0, a, b, c, d]
}

/// Error after a change that may have been taken.
fn unstored(id: u8, what: &str, why: &io::Error) -> io::Error {
    io::Error::other(format!("motor {id}: {why}: {what} may have changed, and may not be stored: {UNTIL_POWER_OFF}"))
}

#[cfg(test)]
pub(super) mod simulated_bus;
#[cfg(test)]
mod tests;
