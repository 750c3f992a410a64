//! Kinds of frames, their error codes, and numbers in the fields of a frame.

/// Protocol of an actuator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Language {
    /// The mini-cheetah's protocol.
    #[default]
    MiniCheetah,
    /// Damiao's protocol: the same commands; replies with state, error and temperatures.
    Damiao,
    /// RobStride's private protocol; its replies go to the host with the identifier [`Electronics::reply_id`](super::Electronics::reply_id).
    RobStride,
    /// The motion mode of MyActuator's RMD drives.
    MyActuator,
}

impl Language {
    /// Returns the protocol with this name in robot files.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let all = [
            ("mit", Self::MiniCheetah),
            ("damiao", Self::Damiao),
            ("robstride", Self::RobStride),
            ("myactuator", Self::MyActuator),
        ];
        all.into_iter().find(|(other, _)| *other == name).map(|(_, language)| language)
    }
}

/// Codes of [`Electronics::error`](super::Electronics::error), after the feedback frame in Damiao's manual of the DM4310.
pub mod error {
    /// The supply voltage is too high.
    pub const OVER_VOLTAGE: u8 = 0x8;
    /// The supply voltage is too low.
    pub const UNDER_VOLTAGE: u8 = 0x9;
    /// The drive is too hot.
    pub const HOT: u8 = 0xb;
    /// No command has arrived for [`Electronics::timeout`](super::super::Electronics::timeout); only Damiao drives have this error.
    pub const SILENCE: u8 = 0xd;
    /// The drive is overloaded; this model does not detect that, a test or simulation sets it.
    pub const OVERLOAD: u8 = 0xe;
}

/// Converts a value, clamped to its range, to a field's code (`float_to_uint` of the mini-cheetah).
#[must_use]
pub fn to_code(x: f64, (lo, hi): (f64, f64), bits: u32) -> u32 {
    let top = f64::from((1_u32 << bits) - 1);
    ((x.clamp(lo, hi) - lo) * top / (hi - lo)) as u32
}

/// Converts a field's code to a value (`uint_to_float` of the mini-cheetah).
#[must_use]
pub fn to_float(code: u32, (lo, hi): (f64, f64), bits: u32) -> f64 {
    f64::from(code) * (hi - lo) / f64::from((1_u32 << bits) - 1) + lo
}

/// Ranges of the fields, `(lowest, highest)`, at the shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ranges {
    /// Position, rad.
    pub position: (f64, f64),
    /// Velocity, rad/s.
    pub velocity: (f64, f64),
    /// Stiffness, N m/rad.
    pub kp: (f64, f64),
    /// Damping, N m s/rad.
    pub kd: (f64, f64),
    /// Torque, N m.
    pub torque: (f64, f64),
}

/// Last command to an actuator.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Setpoint {
    /// Position, rad.
    pub position: f64,
    /// Velocity, rad/s.
    pub velocity: f64,
    /// Stiffness, N m/rad.
    pub kp: f64,
    /// Damping, N m s/rad.
    pub kd: f64,
    /// Feed-forward torque, N m.
    pub torque: f64,
}
