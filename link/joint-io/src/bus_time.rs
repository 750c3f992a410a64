//! How long frames take on a CAN bus.
//!
//! Classical CAN 2.0A, standard identifier, `n` data bytes (ISO 11898-1; worst-case stuffing: Davis, Burns, Bril, Lukkien,
//! "Controller Area Network (CAN) schedulability analysis", Real-Time Systems 35, 2007, eq. 1):
//!
//! | field | bits |
//! |---|---|
//! | start, identifier, RTR, IDE, r0, length | 1 + 11 + 1 + 1 + 1 + 4 |
//! | data | 8 n |
//! | check sum | 15 |
//! | its delimiter, acknowledge slot and delimiter, end | 1 + 1 + 1 + 7 |
//! | space between frames | 3 |
//! | stuffing, at worst, of the `34 + 8 n` bits up to the check sum's end | `floor((34 + 8 n - 1) / 4)` |

/// Bits of a frame with `data_bytes` of data, space after it and worst-case stuffing included: 55 to 135.
#[must_use]
pub const fn frame_bits(data_bytes: u32) -> u32 {
    let stuffed = 34 + 8 * data_bytes;
    stuffed + 10 + 3 + (stuffed - 1) / 4
}

/// Frames of the schedule on one bus in one tick: to every actuator a command of 8 bytes, from every actuator a reply.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusLoad {
    /// Actuators on the bus.
    pub actuators: u32,
    /// Data bytes of a reply.
    pub reply_bytes: u32,
    /// Bits per second.
    pub bit_rate: u32,
    /// From the end of a command to the start of its reply, at most, us. Only the last actuator's counts: the others answer
    /// while the bus is busy.
    pub turnaround_us: u32,
}

impl BusLoad {
    /// Bits in one tick, at most.
    #[must_use]
    pub const fn bits(&self) -> u32 {
        self.actuators * (frame_bits(8) + frame_bits(self.reply_bytes))
    }

    /// Time from the first command to the end of the last reply, at most, us, rounded up; `u32::MAX` at no bit rate.
    #[must_use]
    pub const fn time_us(&self) -> u32 {
        if self.bit_rate == 0 {
            return u32::MAX;
        }
        (self.bits() as u64 * 1_000_000).div_ceil(self.bit_rate as u64) as u32 + self.turnaround_us
    }

    /// The highest control rate, whole Hz, at which every reply is in before the next tick begins, when commands go out at
    /// most `lead_us` after the tick began.
    #[must_use]
    pub const fn max_rate_hz(&self, lead_us: u32) -> u32 {
        match 1_000_000_u32.checked_div(self.time_us().saturating_add(lead_us)) {
            Some(rate) => rate,
            None => u32::MAX,
        }
    }
}
