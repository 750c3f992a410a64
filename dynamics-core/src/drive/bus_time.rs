//! Duration of frames on a CAN bus.
//!
//! All times are worst cases: the frame has as many stuff bits as its kind allows, for any identifier and data.
//!
//! **Classic frames** use one bit rate. In the bits up to the end of the check sum, a stuff bit follows at most the first five bits and then
//! every fourth (ISO 11898-1; Davis, Burns, Bril, Lukkien, "Controller Area Network (CAN) schedulability analysis", Real-Time Systems 35,
//! 2007, eq. 1). With `n` data bytes:
//!
//! | field | standard identifier | extended |
//! |---|---|---|
//! | start, identifier, RTR, IDE, r0, length | 1 + 11 + 1 + 1 + 1 + 4 | 20 more: SRR, 18 of the identifier, r1 |
//! | data | 8 n | 8 n |
//! | check sum | 15 | 15 |
//! | stuffing of these `s` bits | `floor((s - 1) / 4)`, `s = 34 + 8 n` | the same, `s = 54 + 8 n` |
//! | delimiter, acknowledge slot and delimiter, end | 1 + 1 + 1 + 7 | the same |
//! | space between frames | 3 | 3 |
//!
//! **FD frames** (ISO 11898-1:2015) switch to the data rate in the bit BRS and back in the delimiter of the check sum. Both bits are counted at
//! the slower rate.
//!
//! | field, standard identifier | nominal rate | data rate |
//! |---|---|---|
//! | start, identifier, RRS, IDE; FDF, res, BRS | 14 + 3; extended 33 + 3 | |
//! | stuffing of the first 14 or 33; FDF ends a run of dominant bits, and BRS begins one | `floor((14 - 1) / 4)`; extended `floor((33 - 1) / 4)` | |
//! | ESI, length, data | | 1 + 4 + 8 n |
//! | stuffing from BRS to the end of the data | | `floor((6 + 8 n - 1) / 4)` |
//! | count of stuff bits, check sum | | 4 + 17; above 16 bytes 4 + 21 |
//! | fixed stuff bits: before the count, and after every fourth bit of both | | 6; above 16 bytes 7 |
//! | delimiter, acknowledge slot and delimiter, end, space | 1 + 1 + 1 + 7 + 3 | |

use super::MitDrive;

/// Bits per second of classic frames, and of an FD frame's arbitration.
pub const NOMINAL_RATE: u32 = 1_000_000;

/// Time from the end of a command to the start of its reply, us: the longest that a maker states. Only the last actuator's time counts,
/// because the others answer while the bus is busy.
pub const TURNAROUND_US: u32 = 60;

/// Time from the start of a tick to its commands, us: the time allowed for the controller.
pub const LEAD_US: u32 = 100;

/// Data bytes of a command.
const COMMAND_BYTES: u32 = 8;

/// After the check sum: delimiter, acknowledge slot and delimiter, end, space between frames.
const TAIL: u32 = 1 + 1 + 1 + 7 + 3;

/// Length of identifiers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Identifier {
    /// 11 bits.
    Standard,
    /// 29 bits.
    Extended,
}

/// Number of bits, by the rate at which they are sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bits {
    /// At the nominal rate.
    pub nominal: u32,
    /// At the data rate of FD frames.
    pub data: u32,
}

/// Bits of a classic frame, including the space after it and worst-case stuffing: 55 to 135, or 80 to 160.
#[must_use]
pub const fn classic_bits(identifier: Identifier, data_bytes: u32) -> u32 {
    let head = match identifier {
        Identifier::Standard => 34,
        Identifier::Extended => 54,
    };
    let stuffed = head + 8 * data_bytes;
    stuffed + (stuffed - 1) / 4 + TAIL
}

/// Bits of an FD frame that switches its rate, including the space after it and worst-case stuffing. A number of data bytes that no frame can
/// have is rounded up to the next possible one, as a controller pads it.
#[must_use]
pub const fn fd_bits(identifier: Identifier, data_bytes: u32) -> Bits {
    let bytes = fd_length(data_bytes);
    let arbitration = match identifier {
        Identifier::Standard => 14,
        Identifier::Extended => 33,
    };
    let (sum, fixed) = if bytes > 16 { (21, 7) } else { (17, 6) };
    Bits {
        nominal: arbitration + (arbitration - 1) / 4 + 3 + TAIL,
        data: 1 + 4 + 8 * bytes + (6 + 8 * bytes - 1) / 4 + 4 + sum + fixed,
    }
}

/// Data bytes of the shortest FD frame that holds this many; 64 at most.
const fn fd_length(bytes: u32) -> u32 {
    match bytes {
        0..=8 => bytes,
        9..=12 => 12,
        13..=16 => 16,
        17..=20 => 20,
        21..=24 => 24,
        25..=32 => 32,
        33..=48 => 48,
        _ => 64,
    }
}

/// Time of this many bits at a rate above zero, ns, rounded up.
const fn at_rate_ns(bits: u32, rate: u32) -> u64 {
    (bits as u64 * 1_000_000_000).div_ceil(rate as u64)
}

/// Frames on one bus in one tick: a command of 8 bytes to every actuator, and a reply from every actuator.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusLoad {
    /// Actuators on the bus.
    pub actuators: u32,
    /// Kind of identifier of commands and replies.
    pub identifier: Identifier,
    /// Number of data bytes of the longest reply.
    pub reply_bytes: u32,
    /// Bits per second at the nominal rate.
    pub bit_rate: u32,
    /// Bits per second of the data of FD frames; `None` for classic frames.
    pub data_rate: Option<u32>,
    /// Longest time from the end of the last command to the start of its reply, us.
    pub turnaround_us: u32,
}

impl BusLoad {
    /// Load of the bus with this number, counted from 0, by those of the drives that are on it.
    #[must_use]
    pub const fn of(drives: &[MitDrive], bus: u8, identifier: Identifier) -> Self {
        let mut load = Self {
            actuators: 0,
            identifier,
            reply_bytes: 0,
            bit_rate: NOMINAL_RATE,
            data_rate: None,
            turnaround_us: TURNAROUND_US,
        };
        let mut rest = drives;
        while let Some((drive, others)) = rest.split_first() {
            if drive.bus == bus {
                load.actuators += 1;
                load.data_rate = match drive.data_rate {
                    Some(rate) => Some(rate.bits_per_second()),
                    None => None,
                };
                if drive.reply_bytes as u32 > load.reply_bytes {
                    load.reply_bytes = drive.reply_bytes as u32;
                }
            }
            rest = others;
        }
        load
    }

    /// Greatest number of bits in one tick.
    #[must_use]
    pub const fn bits(&self) -> Bits {
        let (command, reply) = (self.frame_bits(COMMAND_BYTES), self.frame_bits(self.reply_bytes));
        Bits {
            nominal: self.actuators * (command.nominal + reply.nominal),
            data: self.actuators * (command.data + reply.data),
        }
    }

    const fn frame_bits(&self, data_bytes: u32) -> Bits {
        match self.data_rate {
            Some(_) => fd_bits(self.identifier, data_bytes),
            None => Bits { nominal: classic_bits(self.identifier, data_bytes), data: 0 },
        }
    }

    /// Longest time for which frames occupy the bus in one tick, ns, rounded up; `u32::MAX` if a bit rate is zero, and from
    /// 4.29 s on.
    #[must_use]
    pub const fn frames_ns(&self) -> u32 {
        let bits = self.bits();
        let data_rate = match self.data_rate {
            Some(rate) => rate,
            None => self.bit_rate,
        };
        if self.bit_rate == 0 || data_rate == 0 {
            return u32::MAX;
        }
        let ns = at_rate_ns(bits.nominal, self.bit_rate) + at_rate_ns(bits.data, data_rate);
        if ns < u32::MAX as u64 { ns as u32 } else { u32::MAX }
    }

    /// Longest time from the first command to the end of the last reply, us, rounded up; `u32::MAX` if a bit rate is zero.
    #[must_use]
    pub const fn time_us(&self) -> u32 {
        match self.frames_ns() {
            u32::MAX => u32::MAX,
            ns => ns.div_ceil(1000).saturating_add(self.turnaround_us),
        }
    }

    /// Least share of a tick in which the bus is free, percent, rounded down; 0 if the frames do not fit.
    ///
    /// `100 (1 - frames rate)`
    #[must_use]
    pub const fn slack_percent(&self, rate_hz: u32) -> u32 {
        let busy = (self.frames_ns() as u64 * rate_hz as u64).div_ceil(10_000_000);
        100_u64.saturating_sub(busy) as u32
    }

    /// The highest control rate, whole Hz, at which every reply arrives before the next tick begins, if commands are sent at
    /// most `lead_us` after the tick began.
    #[must_use]
    pub const fn max_rate_hz(&self, lead_us: u32) -> u32 {
        match 1_000_000_u32.checked_div(self.time_us().saturating_add(lead_us)) {
            Some(rate) => rate,
            None => u32::MAX,
        }
    }
}
