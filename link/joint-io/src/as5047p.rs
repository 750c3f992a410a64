//! The AS5047P magnetic encoder: 14 bits per turn over SPI (mode 1, words of 16 bits, most significant first).
//!
//! | bit | to the encoder | from it |
//! |---|---|---|
//! | 15 | parity: even over the word | the same |
//! | 14 | 1: read | EF: error in an earlier word |
//! | 13:0 | address | value |
//!
//! The reply to a word arrives with the **next** word. A tick sends two words. The first requests the angle and returns the reply to the last
//! tick's second word: diagnostics, or the error register after an EF. The second requests diagnostics and returns the angle, sampled in this
//! tick. (ams AS5047P datasheet v1-11, "SPI transactions", figures 15 to 26.)

use embedded_hal::spi::SpiDevice;

/// Counts per turn.
pub const COUNTS: i32 = 1 << 14;

/// No operation: only fetches the reply to the previous word.
pub const NOP: u16 = 0x0000;
/// The error register; reading clears it.
pub const ERRFL: u16 = 0x0001;
/// Gain and magnet: bits 11 (field too low), 10 (too high), 9 (CORDIC overflow), 8 (loops ready).
pub const DIAAGC: u16 = 0x3ffc;
/// The angle, compensated for the dynamic error of a moving shaft.
pub const ANGLECOM: u16 = 0x3fff;

/// DIAAGC: field too low, field too high, or invalid angle.
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
    /// The value, 14 bits.
    pub value: u16,
    /// EF: the encoder found an error in an earlier word, and the error register has not been read since.
    pub flagged: bool,
}

impl Word {
    /// Reads a word from the wire; `None` if the parity is odd, because then no bit can be trusted.
    #[inline]
    #[must_use]
    pub const fn new(word: u16) -> Option<Self> {
        if word.count_ones() & 1 == 1 {
            return None;
        }
        Some(Self { value: word & VALUE, flagged: word & EF != 0 })
    }
}

/// An encoder on an SPI device, which must raise the chip select between words.
#[derive(Debug)]
pub struct As5047p<D> {
    device: D,
    /// Register requested by the last word.
    asked: u16,
    /// True if a word was flagged and the error register has not been requested since.
    flagged: bool,
    doubtful: bool,
}

impl<D: SpiDevice> As5047p<D> {
    /// Creates an encoder to which nothing has been sent. Its first diagnostics arrive in the second tick; until then its angles count as
    /// unreliable.
    pub const fn new(device: D) -> Self {
        Self { device, asked: NOP, flagged: false, doubtful: true }
    }

    /// Reads the present angle, counts from 0 to 16383; `None` if the wire or the encoder has an error.
    pub fn angle(&mut self) -> Option<u16> {
        let last = self.asked;
        if let Some(Word { value, flagged: false }) = self.ask(ANGLECOM)
            && last == DIAAGC
        {
            self.doubtful = value & DOUBTS != 0 || value & READY == 0;
        }
        // After a flag the error register is read, because only that clears the flag.
        let second = if core::mem::take(&mut self.flagged) { ERRFL } else { DIAAGC };
        let asked_for_angle = self.asked == ANGLECOM;
        let word = self.ask(second)?;
        (asked_for_angle && !word.flagged).then_some(word.value)
    }

    /// True if the last diagnostics make the angle unreliable.
    pub const fn is_doubtful(&self) -> bool {
        self.doubtful
    }

    /// Sends the word that reads a register and returns the reply to the previous word; `None` if the transfer failed or the parity is odd.
    fn ask(&mut self, address: u16) -> Option<Word> {
        let mut bytes = read_word(address).to_be_bytes();
        if self.device.transfer_in_place(&mut bytes).is_err() {
            self.asked = NOP;
            return None;
        }
        self.asked = address;
        let word = Word::new(u16::from_be_bytes(bytes));
        self.flagged |= word.is_some_and(|word| word.flagged);
        word
    }
}

/// Multi-turn position from single-turn angles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Turns {
    /// Counts since `zero`, turns included; `None` before the first angle, and after a turn was lost.
    position: Option<i32>,
    lost: bool,
    /// Counts per tick over the last step.
    step: i32,
    jump_max: i32,
    age_ticks: u32,
}

impl Turns {
    /// Creates a counter for a shaft that moves at most `jump_max` counts per tick.
    #[must_use]
    pub fn new(jump_max: u16) -> Self {
        let jump_max = i32::from(jump_max).min(COUNTS / 2 - 1);
        Self { position: None, lost: false, step: 0, jump_max, age_ticks: 0 }
    }

    /// Takes this tick's angle, counts above `zero`, modulo a turn; `None` without a valid angle.
    ///
    /// The first angle is taken as within half a turn of zero. After that each step is the shortest rotation to the new angle. It is accepted up
    /// to `jump_max` for each tick since the last angle; a longer step counts as no angle. If there is no angle for so long that the shaft may
    /// have moved half a turn, the turn is lost, and stays lost until [`Turns::new`].
    pub fn update(&mut self, angle: Option<u16>) {
        self.age_ticks = self.age_ticks.saturating_add(1);
        let Some(position) = self.position else {
            if let (Some(angle), false) = (angle, self.lost) {
                (self.position, self.age_ticks) = (Some(shortest(i32::from(angle))), 0);
            }
            return;
        };
        // The count of ticks is bounded first, so that the product cannot overflow.
        let ticks = self.age_ticks.min(COUNTS as u32) as i32;
        let reach = self.jump_max * ticks;
        if reach >= COUNTS / 2 {
            (self.position, self.lost) = (None, true);
            return;
        }
        let Some(angle) = angle else { return };
        let step = shortest(i32::from(angle).wrapping_sub(position));
        if step.abs() > reach {
            return;
        }
        match position.checked_add(step) {
            Some(next) => {
                (self.position, self.step, self.age_ticks) = (Some(next), step / ticks.max(1), 0);
            }
            None => (self.position, self.lost) = (None, true),
        }
    }

    /// Returns the counts since zero, turns included; 0 if the position is unknown.
    #[must_use]
    pub fn position(&self) -> i32 {
        self.position.unwrap_or(0)
    }

    /// Returns the speed over the last step, counts per tick.
    #[must_use]
    pub const fn speed(&self) -> i32 {
        self.step
    }

    /// Returns the ticks since the last accepted angle; `u32::MAX` while the position is unknown.
    #[must_use]
    pub fn age_ticks(&self) -> u32 {
        if self.position.is_some() { self.age_ticks } else { u32::MAX }
    }

    /// True if the turn is lost.
    #[must_use]
    pub const fn is_lost(&self) -> bool {
        self.lost
    }
}

/// Shortest rotation that equals `counts` modulo a turn: -8192 to 8191 counts.
#[inline]
fn shortest(counts: i32) -> i32 {
    // Sign extension of 14 bits.
    (counts << 18) >> 18
}
