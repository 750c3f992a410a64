//! A motor of any kind whose settings can be read: its state, and changes of its settings.

use super::adapter::Adapter;
use super::damiao_motor::DamiaoMotor;
use super::damiao_register::{POSITION_RANGE, SHOWN, TORQUE_RANGE, VELOCITY_RANGE};
use super::motors::Value;
use super::robstride_motor::RobStrideMotor;
use super::robstride_parameter;
use dynamics_core::drive::Protocol;
use std::io;

/// Offset from a Damiao motor's identifier to that of its replies, as makers of arms set it.
const REPLY_OFFSET: u8 = 16;

/// A number with its name and unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// Its name for users.
    pub name: &'static str,
    /// The number; `None` if the motor does not have it or does not answer.
    pub value: Option<Value>,
    /// Its unit.
    pub unit: &'static str,
}

/// State, motion and settings of a motor.
#[derive(Clone, Debug, PartialEq)]
pub struct MotorReport {
    /// Off, on, and its error.
    pub state: String,
    /// Temperatures with their places, degrees Celsius.
    pub temperatures: Vec<(&'static str, f64)>,
    /// Its motion and its settings.
    pub readings: Vec<Reading>,
}

/// Result of a new zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewZero {
    /// Position before, rad.
    pub before: f64,
    /// Position afterwards, rad.
    pub after: f64,
    /// Where the zero is stored, and what it is after power-up; empty if no document says it.
    pub note: &'static str,
}

/// A motor whose settings can be read and changed. What is written is read back. A change fails if the motor is silent or on, or if the adapter is gone.
pub trait Motor {
    /// Its kind.
    fn kind(&self) -> Protocol;

    /// Text for the user: where a changed setting is stored, and with which others.
    fn stored(&self) -> &'static str;

    /// State, motion and settings.
    ///
    /// # Errors
    /// The adapter is gone, or the motor is silent.
    fn report(&mut self) -> io::Result<MotorReport>;

    /// Sets the communication timeout in units of 50 us, and stores it in flash.
    ///
    /// # Errors
    /// See the trait; the motor did not take or store the value.
    fn set_timeout(&mut self, units: u32) -> io::Result<()>;

    /// Sets the identifier, and stores it in flash.
    ///
    /// # Errors
    /// As for [`Motor::set_timeout`]; another motor has this identifier.
    fn set_id(&mut self, id: u8) -> io::Result<()>;

    /// Makes the present position the zero.
    ///
    /// # Errors
    /// As for [`Motor::set_timeout`].
    fn set_zero(&mut self) -> io::Result<NewZero>;

    /// Clears the error. The motor stays off.
    ///
    /// # Errors
    /// See the trait; an error remains.
    fn clear(&mut self) -> io::Result<()>;
}

/// The motor with this identifier, of this kind or of whatever kind answers. Enables and moves nothing.
///
/// # Errors
/// The adapter is gone; no motor answers; motors of two kinds answer; the kind has no settings that can be read.
pub fn motor_with(adapter: &mut dyn Adapter, id: u8, kind: Option<Protocol>) -> io::Result<Box<dyn Motor + '_>> {
    let may_be = |this| kind.is_none_or(|kind| kind == this);
    let is_damiao = may_be(Protocol::Damiao) && DamiaoMotor::new(adapter, id).answers()?;
    let is_robstride = may_be(Protocol::RobStride) && RobStrideMotor::new(adapter, id).answers()?;
    match (is_damiao, is_robstride) {
        (true, false) => Ok(Box::new(DamiaoMotor::new(adapter, id))),
        (false, true) => Ok(Box::new(RobStrideMotor::new(adapter, id))),
        (false, false) => Err(io::Error::other(format!("motor {id} does not answer"))),
        (true, true) => Err(io::Error::other(format!(
            "a damiao and a robstride motor have the identifier {id}: expected `--kind damiao` or `--kind robstride`"
        ))),
    }
}

fn silent() -> io::Error {
    io::Error::other("the motor no longer answers")
}

impl Motor for DamiaoMotor<'_> {
    fn kind(&self) -> Protocol {
        Protocol::Damiao
    }

    fn stored(&self) -> &'static str {
        "stored in flash"
    }

    fn report(&mut self) -> io::Result<MotorReport> {
        let state = self.state()?.ok_or_else(silent)?;
        let mut settings = Vec::new();
        for register in SHOWN {
            settings.push(Reading { name: register.name, value: self.read(register)?, unit: register.unit });
        }
        let motion = [
            ("position", POSITION_RANGE, "rad"),
            ("velocity", VELOCITY_RANGE, "rad/s"),
            ("torque", TORQUE_RANGE, "N m"),
        ];
        let mut readings = Vec::new();
        for ((name, range, unit), share) in motion.into_iter().zip(state.shares) {
            let value = match settings.iter().find(|it| it.name == range.name).and_then(|it| it.value) {
                // At an end of the range, the frame cannot say more.
                Some(Value::Float(range)) if share.abs() < 1.0 => Some(Value::Float(range * share as f32)),
                _ => None,
            };
            readings.push(Reading { name, value, unit });
        }
        readings.append(&mut settings);
        let [transistors, winding] = state.temperatures.map(f64::from);
        let temperatures = vec![("transistors", transistors), ("winding", winding)];
        Ok(MotorReport { state: state.text().to_owned(), temperatures, readings })
    }

    fn set_timeout(&mut self, units: u32) -> io::Result<()> {
        DamiaoMotor::set_timeout(self, units)
    }

    fn set_id(&mut self, id: u8) -> io::Result<()> {
        DamiaoMotor::set_id(self, id, REPLY_OFFSET)
    }

    fn set_zero(&mut self) -> io::Result<NewZero> {
        let range = self.settings()?.ok_or_else(silent)?.ranges.position;
        let (before, after) = DamiaoMotor::set_zero(self)?;
        Ok(NewZero { before: range * before, after: range * after, note: "" })
    }

    fn clear(&mut self) -> io::Result<()> {
        match DamiaoMotor::clear(self)?.text() {
            "off" => Ok(()),
            state => Err(io::Error::other(format!("still: {state}"))),
        }
    }
}

impl Motor for RobStrideMotor<'_> {
    fn kind(&self) -> Protocol {
        Protocol::RobStride
    }

    fn stored(&self) -> &'static str {
        "stored in flash, with every parameter that was changed since power-up"
    }

    fn report(&mut self) -> io::Result<MotorReport> {
        let state = self.state()?;
        let mut readings = Vec::new();
        for parameter in robstride_parameter::SHOWN {
            readings.push(Reading { name: parameter.name, value: self.read(parameter)?, unit: parameter.unit });
        }
        if state.is_none() && readings.iter().all(|reading| reading.value.is_none()) {
            return Err(silent());
        }
        let temperatures = state.iter().map(|state| ("motor", state.temperature)).collect();
        let state = state.map_or_else(|| "state not available".to_owned(), |state| state.text());
        Ok(MotorReport { state, temperatures, readings })
    }

    fn set_timeout(&mut self, units: u32) -> io::Result<()> {
        RobStrideMotor::set_timeout(self, units)
    }

    fn set_id(&mut self, id: u8) -> io::Result<()> {
        RobStrideMotor::set_id(self, id)
    }

    fn set_zero(&mut self) -> io::Result<NewZero> {
        let range = self.read(robstride_parameter::POWER_UP_RANGE)?;
        let (before, after) = RobStrideMotor::set_zero(self)?;
        let note = match range {
            Some(Value::Integer(0)) => {
                "stored in flash; after power-up, this motor shows a position just below zero as nearly a whole turn (parameter 0x7029 is 0)"
            }
            Some(_) => "stored in flash",
            None => "stored in flash; this motor does not say what it knows of its position after power-up",
        };
        Ok(NewZero { before, after, note })
    }

    fn clear(&mut self) -> io::Result<()> {
        RobStrideMotor::clear(self)
    }
}
