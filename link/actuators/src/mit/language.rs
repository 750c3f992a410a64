//! Kinds of frames, their error codes, and numbers in the fields of a frame.

/// Frames that an actuator speaks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Language {
    /// The mini-cheetah's.
    #[default]
    MiniCheetah,
    /// Damiao's: the same commands; replies with state, error and temperatures.
    Damiao,
    /// RobStride's private protocol; its replies go to the host with the identifier [`Electronics::reply_id`](super::Electronics::reply_id).
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

/// Codes of [`Electronics::error`](super::Electronics::error), after the feedback frame in Damiao's manual of the DM4310.
pub mod error {
    /// The supply voltage is too high.
    pub const OVER_VOLTAGE: u8 = 0x8;
    /// The supply voltage is too low.
    pub const UNDER_VOLTAGE: u8 = 0x9;
    /// The drive is too hot.
    pub const HOT: u8 = 0xb;
    /// No command has come for [`Electronics::timeout`](super::super::Electronics::timeout); a Damiao's alone.
    pub const SILENCE: u8 = 0xd;
    /// The load is too much; somebody else finds that.
    pub const OVERLOAD: u8 = 0xe;
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
