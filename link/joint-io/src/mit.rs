//! Commands to MIT-mode actuators and their replies, in the packing of the mini-cheetah's motor controller.
//!
//! A command is eight bytes, a reply six or more, all fields unsigned, most significant bits first:
//!
//! | command | bits | | reply | bits |
//! |---|---|---|---|---|
//! | position | 16 | | actuator's id | 8 |
//! | velocity | 12 | | position | 16 |
//! | kp | 12 | | velocity | 12 |
//! | kd | 12 | | torque | 12 |
//! | feed-forward torque | 12 | | temperature, error (some drives) | 8, 8 |
//!
//! Code 0 is the low end of a field's range and the highest code its high end. Packing causes an error of up to half a step ([`Range::step`]).
//! With an even number of codes over a symmetric range **no code is zero**: "no torque" is half a step, 0.0044 N m for a range of +-18 N m. The
//! ranges of `kp` and `kd` begin at 0, which is exactly code 0.
//!
//! The actuator gives `kp (position - p) + kd (velocity - v) + torque`. Most control laws use `kp = kd = 0`, so that the controller alone
//! determines the torque; a damped stop uses only `kd`. With the control law `split` the actuator provides spring and damper. (B. Katz,
//! `CAN_com.cpp` of the mini-cheetah motor controller.)

use dynamics_core::drive::{MitDrive, MitRanges, Range};

/// Bits of a position.
pub const POSITION_BITS: u32 = 16;
/// Bits of every other field.
pub const FIELD_BITS: u32 = 12;

/// Special frame that switches motor mode on.
pub const ENTER: [u8; 8] = [0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xfc];
/// Special frame that switches motor mode off.
pub const EXIT: [u8; 8] = [0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xfd];
/// Special frame that makes the present position the zero.
pub const ZERO: [u8; 8] = [0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xfe];

/// Command to an actuator, at the actuator's shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setpoint {
    /// Position, rad.
    pub position: f32,
    /// Velocity, rad/s.
    pub velocity: f32,
    /// Stiffness, N m/rad.
    pub kp: f32,
    /// Damping, N m s/rad.
    pub kd: f32,
    /// Feed-forward torque, N m.
    pub torque: f32,
}

impl Setpoint {
    /// Creates a setpoint with this torque only, N m.
    #[inline]
    #[must_use]
    pub const fn torque(torque: f32) -> Self {
        Self { position: 0.0, velocity: 0.0, kp: 0.0, kd: 0.0, torque }
    }

    /// Creates a setpoint with this damping only, N m s/rad.
    #[inline]
    #[must_use]
    pub const fn damped(kd: f32) -> Self {
        Self { position: 0.0, velocity: 0.0, kp: 0.0, kd, torque: 0.0 }
    }

    /// Packs the setpoint into a frame's data; values beyond their range are clamped. `None` if one is NaN, which is never sent.
    ///
    /// The result cannot equal a special frame as long as `kp` is below its highest code: special frames have all bits of `kp` set.
    #[inline]
    #[must_use]
    pub fn pack(&self, ranges: &MitRanges) -> Option<[u8; 8]> {
        let [p_high, p_low] = ranges.position.code(self.position, POSITION_BITS)?.to_be_bytes();
        let v = ranges.velocity.code(self.velocity, FIELD_BITS)?;
        let kp = ranges.kp.code(self.kp, FIELD_BITS)?;
        let kd = ranges.kd.code(self.kd, FIELD_BITS)?;
        let t = ranges.torque.code(self.torque, FIELD_BITS)?;
        Some([
            p_high,
            p_low,
            (v >> 4) as u8,
            ((v & 0xf) << 4 | kp >> 8) as u8,
            kp as u8,
            (kd >> 4) as u8,
            ((kd & 0xf) << 4 | t >> 8) as u8,
            t as u8,
        ])
    }
}

/// Reply of an actuator, at the actuator's shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reply {
    /// Position, rad.
    pub position: f32,
    /// Velocity, rad/s.
    pub velocity: f32,
    /// Torque, N m.
    pub torque: f32,
    /// True if the position is at an end of its range: the true position may be beyond it.
    pub saturated: bool,
    /// Temperature, degrees Celsius, if the reply has one.
    pub temperature: Option<f32>,
    /// The drive's error code; 0 without an error, or if the reply has no such byte.
    pub error: u8,
    /// True if the drive reports that it is switched off; false if the reply carries no state.
    pub off: bool,
}

impl Reply {
    /// Reads a reply's data; `None` if its length is not that of this drive's replies, or if it is from another drive.
    #[inline]
    #[must_use]
    pub fn unpack(data: &[u8], drive: &MitDrive) -> Option<Self> {
        if data.len() != usize::from(drive.reply_bytes) {
            return None;
        }
        let (&[id, p_high, p_low, v, vt, t], rest) = data.split_first_chunk()?;
        if id != drive.id {
            return None;
        }
        Some(Self {
            temperature: drive.temperature_offset.and_then(|offset| Some(f32::from(*rest.first()?) + offset)),
            error: rest.get(1).copied().unwrap_or(0),
            ..Self::of_state([p_high, p_low, v, vt, t], &drive.ranges)
        })
    }

    /// Creates a reply with position, velocity and torque only.
    #[inline]
    pub(crate) fn of_state([p_high, p_low, v, vt, t]: [u8; 5], ranges: &MitRanges) -> Self {
        let position = u16::from_be_bytes([p_high, p_low]);
        let field = |range: &Range, code: u16| range.value(code, FIELD_BITS);
        Self {
            position: ranges.position.value(position, POSITION_BITS),
            velocity: field(&ranges.velocity, u16::from(v) << 4 | u16::from(vt) >> 4),
            torque: field(&ranges.torque, u16::from(vt & 0xf) << 8 | u16::from(t)),
            saturated: position == 0 || position == u16::MAX,
            temperature: None,
            error: 0,
            off: false,
        }
    }
}
