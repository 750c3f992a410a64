//! The AS5047P magnetic encoder: 14 bits a turn over SPI (mode 1, words of 16 bits, most significant first).
//!
//! | bit | to the encoder | from it |
//! |---|---|---|
//! | 15 | parity: even over the word | the same |
//! | 14 | 1: read | EF: the word before was in error |
//! | 13:0 | address | value |
//!
//! The reply to a word comes with the **next** word. A tick sends two: the first asks for the angle and brings the
//! reply to the last tick's second word (diagnostics, or the error register after an EF); the second asks for
//! diagnostics and brings the angle, sampled in this tick. (ams AS5047P datasheet v1-11, "SPI transactions", figures 15
//! to 26.)

use embedded_hal::spi::SpiDevice;

/// Counts a turn.
pub const COUNTS: i32 = 1 << 14;

/// Nothing: only fetches the reply to the word before.
pub const NOP: u16 = 0x0000;
/// The error register; reading clears it.
pub const ERRFL: u16 = 0x0001;
/// Gain and magnet: bits 11 (field too low), 10 (too high), 9 (CORDIC overflow), 8 (loops ready).
pub const DIAAGC: u16 = 0x3ffc;
/// The angle, with the errors of a moving shaft compensated.
pub const ANGLECOM: u16 = 0x3fff;

/// DIAAGC: too little field, too much, or an invalid angle.
const DOUBTS: u16 = 1 << 11 | 1 << 10 | 1 << 9;
/// DIAAGC: the offset loop has settled.
const READY: u16 = 1 << 8;
const EF: u16 = 1 << 14;
const VALUE: u16 = 0x3fff;

/// The word that reads a register: `0xffff` for the angle.
#[must_use]
pub const fn read_word(address: u16) -> u16 {
    let word = EF | address & VALUE;
    word | (word.count_ones() as u16 & 1) << 15
}

/// Contents of a word from the encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Word {
    /// Fourteen bits.
    pub value: u16,
    /// EF: the encoder found an error in a word before, and the error register has not been read since.
    pub flagged: bool,
}

impl Word {
    /// From the wire; `None` when the parity is odd: then no bit means anything.
    #[inline]
    #[must_use]
    pub const fn new(word: u16) -> Option<Self> {
        if word.count_ones() & 1 == 1 {
            return None;
        }
        Some(Self { value: word & VALUE, flagged: word & EF != 0 })
    }
}

/// Errors of an encoder; every count wraps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EncoderCounts {
    /// Words with odd parity.
    pub parity: u32,
    /// Words with the error flag.
    pub flagged: u32,
    /// Bits of the error register, all that were read so far: 0 framing, 1 invalid command, 2 parity.
    pub errors_seen: u16,
    /// Readings with diagnostics that report a doubtful magnet.
    pub doubted: u32,
    /// Transfers that the bus refused.
    pub bus: u32,
}

/// An encoder, behind a device with a chip select that rises between words.
#[derive(Debug)]
pub struct As5047p<D> {
    device: D,
    /// Register requested by the last word.
    asked: u16,
    /// A word was flagged, and the error register has not been asked for since.
    flagged: bool,
    doubtful: bool,
    counts: EncoderCounts,
}

impl<D: SpiDevice> As5047p<D> {
    /// An encoder that has not been asked anything. Its first diagnostics come with the second tick; until then its angles
    /// are doubtful.
    pub const fn new(device: D) -> Self {
        let counts = EncoderCounts { parity: 0, flagged: 0, errors_seen: 0, doubted: 0, bus: 0 };
        Self { device, asked: NOP, flagged: false, doubtful: true, counts }
    }

    /// The angle now, counts from 0 to 16383; `None` when the wire or the encoder is in error.
    pub fn angle(&mut self) -> Option<u16> {
        let last = self.asked;
        if let Some(word) = self.ask(ANGLECOM) {
            match last {
                DIAAGC if !word.flagged => {
                    self.doubtful = word.value & DOUBTS != 0 || word.value & READY == 0;
                    self.counts.doubted = self.counts.doubted.wrapping_add(u32::from(self.doubtful));
                }
                ERRFL => self.counts.errors_seen |= word.value,
                _ => {}
            }
        }
        // After a flag, the error register: reading it is what clears the flag.
        let second = if core::mem::take(&mut self.flagged) { ERRFL } else { DIAAGC };
        let asked_for_angle = self.asked == ANGLECOM;
        let word = self.ask(second)?;
        (asked_for_angle && !word.flagged).then_some(word.value)
    }

    /// True if the last diagnostics make the angle doubtful.
    pub const fn is_doubtful(&self) -> bool {
        self.doubtful
    }

    /// Errors so far.
    pub const fn counts(&self) -> EncoderCounts {
        self.counts
    }

    /// Send the word that reads a register; the return value is the reply to the word before. `None`: the bus refused,
    /// or the parity is odd.
    fn ask(&mut self, address: u16) -> Option<Word> {
        let mut bytes = read_word(address).to_be_bytes();
        if self.device.transfer_in_place(&mut bytes).is_err() {
            self.counts.bus = self.counts.bus.wrapping_add(1);
            self.asked = NOP;
            return None;
        }
        self.asked = address;
        let word = Word::new(u16::from_be_bytes(bytes));
        match word {
            Some(Word { flagged: true, .. }) => {
                self.flagged = true;
                self.counts.flagged = self.counts.flagged.wrapping_add(1);
            }
            None => self.counts.parity = self.counts.parity.wrapping_add(1),
            Some(_) => {}
        }
        word
    }
}

/// Turns counted from single-turn angles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Turns {
    /// Counts since `zero`, turns included; `None` before the first angle, and after a turn was lost.
    position: Option<i32>,
    lost: bool,
    /// Counts of the last step, and how many ticks it spans.
    step: i32,
    jump_max: i32,
    age_ticks: u32,
    jumps: u32,
}

impl Turns {
    /// Turns of a shaft that moves `jump_max` counts in a tick, at most.
    #[must_use]
    pub fn new(jump_max: u16) -> Self {
        let jump_max = i32::from(jump_max).min(COUNTS / 2 - 1);
        Self { position: None, lost: false, step: 0, jump_max, age_ticks: 0, jumps: 0 }
    }

    /// Take this tick's angle, counts from `zero` upwards, modulo a turn; `None` without a valid angle.
    ///
    /// The first one is taken as within half a turn of zero. From then on the step is the shortest way. It is accepted
    /// up to `jump_max` for each tick since the last angle; a longer step counts as no angle. After so many ticks that
    /// the shaft can have moved half a turn, the turn is lost, and stays so until [`Turns::new`].
    pub fn update(&mut self, angle: Option<u16>) {
        self.age_ticks = self.age_ticks.saturating_add(1);
        let Some(position) = self.position else {
            if let (Some(angle), false) = (angle, self.lost) {
                (self.position, self.age_ticks) = (Some(shortest(i32::from(angle))), 0);
            }
            return;
        };
        // No overflow: the count of ticks is bounded here before it is multiplied.
        let ticks = self.age_ticks.min(COUNTS as u32) as i32;
        let reach = self.jump_max * ticks;
        if reach >= COUNTS / 2 {
            (self.position, self.lost) = (None, true);
            return;
        }
        let Some(angle) = angle else { return };
        let step = shortest(i32::from(angle).wrapping_sub(position));
        if step.abs() > reach {
            self.jumps = self.jumps.wrapping_add(1);
            return;
        }
        match position.checked_add(step) {
            Some(next) => {
                (self.position, self.step, self.age_ticks) = (Some(next), step / ticks.max(1), 0);
            }
            None => (self.position, self.lost) = (None, true),
        }
    }

    /// Counts since zero, turns included; 0 where the position is unknown.
    #[must_use]
    pub fn position(&self) -> i32 {
        self.position.unwrap_or(0)
    }

    /// Counts a tick, over the last step.
    #[must_use]
    pub const fn speed(&self) -> i32 {
        self.step
    }

    /// Ticks since the last accepted angle; `u32::MAX` while the position is unknown.
    #[must_use]
    pub fn age_ticks(&self) -> u32 {
        if self.position.is_some() { self.age_ticks } else { u32::MAX }
    }

    /// True if the turn is lost.
    #[must_use]
    pub const fn is_lost(&self) -> bool {
        self.lost
    }

    /// Angles that were further than the shaft can move; wraps.
    #[must_use]
    pub const fn jumps(&self) -> u32 {
        self.jumps
    }
}

/// The shortest way: counts from -8192 to 8191.
#[inline]
fn shortest(counts: i32) -> i32 {
    // Fourteen bits to the top of a word of 32, and back with their sign.
    (counts << 18) >> 18
}
