//! Model of an AS5047P: words of 16 bits with parity; the reply to each arrives with the next word.

/// Registers.
const ERRFL: u16 = 0x0001;
const DIAAGC: u16 = 0x3ffc;
const MAG: u16 = 0x3ffd;
const ANGLEUNC: u16 = 0x3ffe;
const ANGLECOM: u16 = 0x3fff;

/// The encoder.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Encoder {
    /// The angle, counts; only the low 14 bits are sent.
    pub angle: u32,
    /// True if the magnet is too far away.
    pub magnet_low: bool,
    /// Flips one bit of one word to the controller: number of words before it, and number of the bit.
    pub flip: Option<(u32, u32)>,
    /// Addresses that were read, in order.
    pub read: Vec<u16>,
    errors: u16,
    reply: u16,
}

impl Encoder {
    /// Takes one word and returns one. The chip select rises after it.
    pub fn transfer(&mut self, word: u16) -> u16 {
        let mut out = self.reply;
        self.flip = match self.flip {
            Some((0, bit)) => {
                out ^= 1 << bit;
                None
            }
            later => later.map(|(words, bit)| (words - 1, bit)),
        };
        let address = word & 0x3fff;
        let value = if word.count_ones() % 2 == 1 {
            self.errors |= 4;
            0
        } else {
            self.read.push(address);
            match address {
                0 => 0,
                // Reading clears the error register and the error flag.
                ERRFL => std::mem::take(&mut self.errors),
                DIAAGC => 0x0180 | if self.magnet_low { 0x0800 } else { 0 },
                MAG => 0x1000,
                ANGLEUNC | ANGLECOM => (self.angle & 0x3fff) as u16,
                _ => {
                    self.errors |= 2;
                    0
                }
            }
        };
        let flagged = value | if self.errors == 0 { 0 } else { 0x4000 };
        self.reply = flagged | if flagged.count_ones() % 2 == 1 { 0x8000 } else { 0 };
        out
    }
}
