//! CAN data frames, bit by bit (ISO 11898-1): classic ones, and lengths of FD frames.

/// The bits of a classic frame that are stuffed: start of frame to the end of the check sum.
#[must_use]
pub fn stuffed_part(id: u32, extended: bool, data: &[u8]) -> Vec<bool> {
    let mut bits = beginning(id, extended);
    // RTR, and IDE and the reserved bit, or two reserved bits: dominant.
    push(&mut bits, 0, 3);
    push(&mut bits, data.len() as u32, 4);
    for byte in data {
        push(&mut bits, u32::from(*byte), 8);
    }
    let sum = crc15(&bits);
    push(&mut bits, u32::from(sum), 15);
    bits
}

/// A value's bits, the highest first.
fn push(bits: &mut Vec<bool>, value: u32, count: u32) {
    bits.extend((0..count).rev().map(|bit| value >> bit & 1 == 1));
}

/// Start of frame and identifier; behind the first part of an extended one SRR and IDE.
fn beginning(id: u32, extended: bool) -> Vec<bool> {
    let mut bits = vec![false];
    if extended {
        push(&mut bits, id >> 18, 11);
        // Recessive.
        push(&mut bits, 0b11, 2);
        push(&mut bits, id & 0x3_ffff, 18);
    } else {
        push(&mut bits, id, 11);
    }
    bits
}

/// Bits of a classic frame on the wire, with stuffing, delimiters, end of frame and the space after it.
#[must_use]
pub fn length(id: u32, extended: bool, data: &[u8]) -> u32 {
    let bits = stuffed_part(id, extended, data);
    (bits.len() + stuff_bits(&bits)) as u32 + 10 + 3
}

/// Number of bits that stuffing adds: one of the other kind after five alike, which itself counts for the next five.
#[must_use]
pub fn stuff_bits(bits: &[bool]) -> usize {
    let (mut last, mut alike, mut added) = (None, 0, 0);
    for &bit in bits {
        alike = if last == Some(bit) { alike + 1 } else { 1 };
        last = Some(bit);
        if alike == 5 {
            added += 1;
            last = Some(!bit);
            alike = 1;
        }
    }
    added
}

/// The check sum, polynomial 0x4599.
fn crc15(bits: &[bool]) -> u16 {
    bits.iter().fold(0, |sum: u16, &bit| {
        let next = bit != (sum >> 14 & 1 == 1);
        let shifted = sum << 1 & 0x7fff;
        if next { shifted ^ 0x4599 } else { shifted }
    })
}

/// An FD frame that switches its rate (ISO 11898-1:2015), by the rate at which its parts are sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FdLength {
    /// Bits up to BRS and from the delimiter of the check sum on, the space after the frame included.
    pub nominal: u32,
    /// The others.
    pub data: u32,
}

/// Bits on the wire of an FD frame, with stuffing. `data` has a length that the standard has; `passive` is the state of error that ESI says.
#[must_use]
pub fn fd_length(id: u32, extended: bool, passive: bool, data: &[u8]) -> FdLength {
    const LONGER: [usize; 7] = [12, 16, 20, 24, 32, 48, 64];
    let code = LONGER.iter().position(|&length| length == data.len()).map_or(data.len(), |at| 9 + at);
    let mut bits = beginning(id, extended);
    // RRS, or RRS and IDE: dominant.
    push(&mut bits, 0, if extended { 1 } else { 2 });
    // FDF, res, BRS.
    push(&mut bits, 0b101, 3);
    let arbitration = bits.len();
    push(&mut bits, u32::from(passive), 1);
    push(&mut bits, code as u32, 4);
    data.iter().for_each(|byte| push(&mut bits, u32::from(*byte), 8));
    // A stuff bit right after BRS comes after the switch.
    let early = stuff_bits(&bits[..arbitration]) - usize::from(ends_stuffed(&bits[..arbitration]));
    let late = stuff_bits(&bits) - early;
    let sum = if data.len() > 16 { 21 } else { 17 };
    // One before the count of stuff bits, then one after every four bits of count and check sum.
    let fixed = 1 + (4 + sum) / 4;
    FdLength {
        nominal: (arbitration + early + 13) as u32,
        data: (bits.len() - arbitration + late + 4 + sum + fixed) as u32,
    }
}

/// True if the last bit is one after which a bit is stuffed.
fn ends_stuffed(bits: &[bool]) -> bool {
    bits.split_last().is_some_and(|(_, before)| stuff_bits(bits) > stuff_bits(before))
}
