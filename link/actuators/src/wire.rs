//! A CAN data frame with a standard identifier, bit by bit (ISO 11898-1).

/// The bits that are stuffed: start of frame to the end of the check sum.
#[must_use]
pub fn stuffed_part(id: u16, data: &[u8]) -> Vec<bool> {
    let mut bits = vec![false];
    let mut push = |value: u32, count: u32| bits.extend((0..count).rev().map(|bit| value >> bit & 1 == 1));
    push(u32::from(id), 11);
    // RTR, IDE and the reserved bit are dominant.
    push(0, 3);
    push(data.len() as u32, 4);
    for byte in data {
        push(u32::from(*byte), 8);
    }
    let sum = crc15(&bits);
    bits.extend((0..15).rev().map(|bit| sum >> bit & 1 == 1));
    bits
}

/// Bits on the wire, with stuffing, delimiters, end of frame and the space after it.
#[must_use]
pub fn length(id: u16, data: &[u8]) -> u32 {
    let bits = stuffed_part(id, data);
    (bits.len() + stuff_bits(&bits)) as u32 + 10 + 3
}

/// How many bits stuffing adds: one of the other kind after five alike, which itself counts for the next five.
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
