//! The link key in a board's flash. It has a separate page, which reflashing the program does not erase.
//!
//! | bytes | hold |
//! |---|---|
//! | 0 to 7 | `linkkey1` |
//! | 8 to 39 | the key |
//! | 40 to 55 | a random number, for nonces on a board without a random number generator |
//! | 56 to 59 | CRC-32 of all before, least significant byte first |

use crate::codec::CRC;
use crate::seal::{KEY_BYTES, Key, Nonce};

/// Address of the page on the STM32F405: its last sector. `memory.x` has the addresses for the other chips.
pub const ADDRESS: u32 = 0x080e_0000;

/// Length of the page's contents, bytes.
pub const LENGTH: usize = 60;

const MAGIC: &[u8; 8] = b"linkkey1";

/// A page's contents. Does not implement `Debug`, which would show the key.
#[derive(Clone, Copy)]
pub struct KeyPage<'a> {
    key: &'a [u8; KEY_BYTES],
    /// Random number, written with the key.
    pub seed: &'a Nonce,
}

impl<'a> KeyPage<'a> {
    /// Reads a page; `None` if it was never written or is damaged.
    #[must_use]
    pub fn read(page: &'a [u8; LENGTH]) -> Option<Self> {
        let (body, check) = page.split_last_chunk::<4>()?;
        let (magic, rest) = body.split_first_chunk::<8>()?;
        let (key, seed) = rest.split_first_chunk::<KEY_BYTES>()?;
        let whole = magic == MAGIC && CRC.checksum(body).to_le_bytes() == *check;
        Some(Self { key, seed: seed.first_chunk()? }).filter(|_| whole)
    }

    /// The key's bytes.
    #[must_use]
    pub const fn key(&self) -> &'a [u8; KEY_BYTES] {
        self.key
    }
}

/// Bytes of a page that holds this key and seed.
#[must_use]
pub fn write(key: &Key, seed: &Nonce) -> [u8; LENGTH] {
    let mut page = [0; LENGTH];
    page[..8].copy_from_slice(MAGIC);
    page[8..40].copy_from_slice(key.bytes());
    page[40..56].copy_from_slice(seed);
    let check = CRC.checksum(&page[..56]).to_le_bytes();
    page[56..].copy_from_slice(&check);
    page
}
