//! Keys, proofs and seals: the cryptography of the link.
//!
//! `S(k, m)` is SipHash-2-4 of the message `m` under the key `k` of 16 bytes: 8 bytes, least significant first. A link key
//! has 32 bytes, `K1 | K2`. `T` is the transcript of a handshake: version, nonce of the host, nonce of the board (33 bytes).
//!
//! | quantity | value |
//! |---|---|
//! | proof of the board | `S(K1, 01 \| T) \| S(K1, 02 \| T)` |
//! | proof of the host | `S(K1, 03 \| T) \| S(K1, 04 \| T)` |
//! | seal key, host to board | `S(K2, 01 \| T) \| S(K2, 02 \| T)` |
//! | seal key, board to host | `S(K2, 03 \| T) \| S(K2, 04 \| T)` |
//! | nonce of a board without a generator | `S(K1, 05 \| C) \| S(K1, 06 \| C)`, `C` = version, seed, count: u32, timer: u32, zeros to 33 bytes |
//! | seal of a packet | `S(seal key, number: u64 \| header and frame)` |
//!
//! SipHash is a keyed pseudorandom function for short messages (Aumasson and Bernstein, *SipHash: a fast short-input PRF*,
//! INDOCRYPT 2012). The security level is 128 bits for keys and 64 bits for seals: a guessed seal is accepted with a probability of
//! `2^-64`, and each guess must be sent to be tried. It needs a sixth of the instructions of HMAC-SHA-256.

use core::fmt;
use core::hash::Hasher;
use serde::{Deserialize, Serialize};
use siphasher::sip::SipHasher24;
use subtle::ConstantTimeEq;

/// Length of a link key, bytes.
pub const KEY_BYTES: usize = 32;

/// A number that is used once: random, or at least never the same again under one key.
pub type Nonce = [u8; 16];

/// Proof that its sender has the link key, made from both nonces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Proof([u8; 16]);

impl Proof {
    /// Compares in constant time: the duration does not reveal where the proofs differ.
    #[must_use]
    pub fn fits(&self, expected: &Self) -> bool {
        self.0.ct_eq(&expected.0).into()
    }
}

/// Side of the link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The host.
    Host,
    /// The board.
    Board,
}

/// Version and nonces of a handshake.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Transcript([u8; 33]);

impl Transcript {
    /// The transcript of these nonces.
    #[must_use]
    pub fn new(host: &Nonce, board: &Nonce) -> Self {
        let mut bytes = [0; 33];
        bytes[0] = crate::PROTOCOL_VERSION;
        bytes[1..17].copy_from_slice(host);
        bytes[17..].copy_from_slice(board);
        Self(bytes)
    }
}

/// The key that host and board share. It is never sent, and its `Debug` output does not show it.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Key([u8; KEY_BYTES]);

impl fmt::Debug for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Key(..)")
    }
}

impl Key {
    /// The key with these bytes.
    #[must_use]
    pub const fn new(bytes: [u8; KEY_BYTES]) -> Self {
        Self(bytes)
    }

    /// Returns its bytes, to be stored.
    #[must_use]
    pub const fn bytes(&self) -> &[u8; KEY_BYTES] {
        &self.0
    }

    /// Proof that `side` has the key.
    #[must_use]
    pub fn proof(&self, side: Side, transcript: &Transcript) -> Proof {
        let first = match side {
            Side::Board => 1,
            Side::Host => 3,
        };
        Proof(pair(self.half(0), first, transcript))
    }

    /// Keys of the session's seals, as `side` uses them.
    #[must_use]
    pub fn session(&self, side: Side, transcript: &Transcript) -> SessionKeys {
        let host = SealKey(pair(self.half(1), 1, transcript));
        let board = SealKey(pair(self.half(1), 3, transcript));
        match side {
            Side::Host => SessionKeys { sending: host, receiving: board },
            Side::Board => SessionKeys { sending: board, receiving: host },
        }
    }

    /// A nonce from a random number, a count and a timer, for a board without a random number generator.
    #[must_use]
    pub fn nonce(&self, seed: &Nonce, count: u32, timer: u32) -> Nonce {
        let mut counted = [0; 16];
        counted[..4].copy_from_slice(&count.to_le_bytes());
        counted[4..8].copy_from_slice(&timer.to_le_bytes());
        pair(self.half(0), 5, &Transcript::new(seed, &counted))
    }

    fn half(&self, index: usize) -> [u8; 16] {
        core::array::from_fn(|i| self.0[16 * index + i])
    }
}

/// `S(key, first | T) | S(key, first + 1 | T)`.
fn pair(key: [u8; 16], first: u8, transcript: &Transcript) -> [u8; 16] {
    let mut both = [0; 16];
    for (half, label) in both.chunks_exact_mut(8).zip(first..) {
        half.copy_from_slice(&keyed_hash(&key, &[label], &transcript.0));
    }
    both
}

/// `S(key, begin | rest)`. Not inlined, so that the firmware has one copy.
#[inline(never)]
fn keyed_hash(key: &[u8; 16], begin: &[u8], rest: &[u8]) -> [u8; 8] {
    let mut hasher = SipHasher24::new_with_key(key);
    hasher.write(begin);
    hasher.write(rest);
    hasher.finish().to_le_bytes()
}

/// Key of the seals of one direction in one session.
#[derive(Clone, PartialEq, Eq)]
pub struct SealKey([u8; 16]);

impl fmt::Debug for SealKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("SealKey(..)")
    }
}

/// Keys of a session's seals.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SessionKeys {
    /// For packets that this side sends.
    pub sending: SealKey,
    /// For packets that it receives.
    pub receiving: SealKey,
}

/// Length of a seal, bytes.
pub(crate) const SEAL: usize = 8;

impl SealKey {
    /// Seal of a packet with this number.
    pub(crate) fn seal(&self, number: u64, body: &[u8]) -> [u8; SEAL] {
        keyed_hash(&self.0, &number.to_le_bytes(), body)
    }

    /// True if this is the seal of a packet with this number, in constant time.
    pub(crate) fn fits(&self, number: u64, body: &[u8], seal: &[u8; SEAL]) -> bool {
        self.seal(number, body).ct_eq(seal).into()
    }
}

#[cfg(test)]
mod tests {
    use super::keyed_hash;

    /// The example of the paper's appendix A: key 00 to 0f, message 00 to 0e.
    #[test]
    fn the_keyed_hash_is_siphash_2_4() {
        let key = core::array::from_fn(|i| i as u8);
        let message: [u8; 15] = core::array::from_fn(|i| i as u8);
        for cut in 0..=15 {
            let hash = keyed_hash(&key, &message[..cut], &message[cut..]);
            assert_eq!(u64::from_le_bytes(hash), 0xa129_ca61_49be_45e5);
        }
    }
}
