//! Classic CAN data frames bit by bit, and lengths of CAN FD frames (ISO 11898-1).

/// Returns the part of a classic frame that is subject to stuffing, without stuff bits: start of frame to the end of the check sum.
#[must_use]
pub fn stuffed_part(id: u32, extended: bool, data: &[u8]) -> Vec<bool> {
    let mut bits = beginning(id, extended);
    // Dominant bits: RTR, then IDE and the reserved bit (standard) or two reserved bits (extended).
    push(&mut bits, 0, 3);
    push(&mut bits, data.len() as u32, 4);
    for byte in data {
        push(&mut bits, u32::from(*byte), 8);
    }
    let sum = crc15(&bits);
    push(&mut bits, u32::from(sum), 15);
    bits
}

/// Appends a value's bits, the highest first.
fn push(bits: &mut Vec<bool>, value: u32, count: u32) {
    bits.extend((0..count).rev().map(|bit| value >> bit & 1 == 1));
}

/// Start of frame and identifier; SRR and IDE follow the first 11 bits of an extended one.
fn beginning(id: u32, extended: bool) -> Vec<bool> {
    let mut bits = vec![false];
    if extended {
        push(&mut bits, id >> 18, 11);
        // SRR and IDE, recessive.
        push(&mut bits, 0b11, 2);
        push(&mut bits, id & 0x3_ffff, 18);
    } else {
        push(&mut bits, id, 11);
    }
    bits
}

/// Returns the bits of a classic frame on the wire, with stuffing, delimiters, end of frame and the space after it.
#[must_use]
pub fn length(id: u32, extended: bool, data: &[u8]) -> u32 {
    let bits = stuffed_part(id, extended, data);
    (bits.len() + stuff_bits(&bits)) as u32 + 10 + 3
}

/// Returns the number of bits that stuffing adds: an inverted bit after five equal ones. It counts towards the next five.
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

/// CRC-15 of the bits, polynomial 0x4599.
fn crc15(bits: &[bool]) -> u16 {
    bits.iter().fold(0, |sum: u16, &bit| {
        let next = bit != (sum >> 14 & 1 == 1);
        let shifted = sum << 1 & 0x7fff;
        if next { shifted ^ 0x4599 } else { shifted }
    })
}

/// Length of an FD frame with bit-rate switching (ISO 11898-1:2015), separated by rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FdLength {
    /// Bits at the nominal rate: up to BRS, and from the delimiter of the check sum to the end of the space after the frame.
    pub nominal: u32,
    /// Bits at the data rate.
    pub data: u32,
}

/// Returns the bits of an FD frame on the wire, with stuffing. `data` must have a length that the standard permits; `passive` is the ESI bit
/// (error passive).
#[must_use]
pub fn fd_length(id: u32, extended: bool, passive: bool, data: &[u8]) -> FdLength {
    const LONGER: [usize; 7] = [12, 16, 20, 24, 32, 48, 64];
    let code = LONGER.iter().position(|&length| length == data.len()).map_or(data.len(), |at| 9 + at);
    let mut bits = beginning(id, extended);
    // Dominant bits: RRS (extended), or RRS and IDE (standard).
    push(&mut bits, 0, if extended { 1 } else { 2 });
    // FDF, res, BRS.
    push(&mut bits, 0b101, 3);
    let arbitration = bits.len();
    push(&mut bits, u32::from(passive), 1);
    push(&mut bits, code as u32, 4);
    data.iter().for_each(|byte| push(&mut bits, u32::from(*byte), 8));
    // A stuff bit directly after BRS is sent at the data rate.
    let early = stuff_bits(&bits[..arbitration]) - usize::from(ends_stuffed(&bits[..arbitration]));
    let late = stuff_bits(&bits) - early;
    let sum = if data.len() > 16 { 21 } else { 17 };
    // Fixed stuff bits: one before the stuff count, then one after every four bits of count and check sum.
    let fixed = 1 + (4 + sum) / 4;
    FdLength {
        nominal: (arbitration + early + 13) as u32,
        data: (bits.len() - arbitration + late + 4 + sum + fixed) as u32,
    }
}

/// True if a stuff bit follows the last bit.
fn ends_stuffed(bits: &[bool]) -> bool {
    bits.split_last().is_some_and(|(_, before)| stuff_bits(bits) > stuff_bits(before))
}
