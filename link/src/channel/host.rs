//! The host's side of the link.

use crate::DecodeError;
use crate::codec::{Codec, FrameTooLong, Received};
use crate::frame::{Challenge, Frame, Refusal, Trust};
use crate::packet::Packet;
use crate::seal::{Key, Nonce, SealKey, Side, Transcript};
use core::fmt;

/// Reason why a host does not talk to a board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distrust {
    /// The board requires a key, and the host has none.
    KeyNeeded,
    /// The board's proof does not fit the key: it has another, or is not the board.
    WrongProof,
    /// The host has a key, and the board reports that it has none.
    BoardHasNoKey,
    /// The host has a key, and the board reports that it was built to trust anybody.
    BoardIsInsecure,
}

impl fmt::Display for Distrust {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::KeyNeeded => "the board asks for a key: `--key FILE`, the one that it was given by `cargo newtau firmware key write FILE --board BOARD`",
            Self::WrongProof => "the board does not have this key: it has another one, or is not the board that it seems",
            Self::BoardHasNoKey => "the board has no key, or is not the board that it seems; `cargo newtau firmware key write FILE --board BOARD` gives it one",
            Self::BoardIsInsecure => "the board was built to trust anybody, or is not the board that it seems; without `--key` it can be used",
        })
    }
}

impl core::error::Error for Distrust {}

/// Packets of a host, in and out.
#[derive(Debug, Default)]
pub struct HostChannel {
    codec: Codec,
    key: Option<Key>,
    sending: Option<SealKey>,
    nonce: Nonce,
    /// The host has requested a challenge and not answered one yet.
    asked: bool,
    sealed: bool,
}

impl HostChannel {
    /// Creates a channel that has not sent or received anything. With a key, the host accepts only a board with the same key.
    #[must_use]
    pub const fn new(key: Option<Key>) -> Self {
        Self { codec: Codec::new(), key, sending: None, nonce: [0; 16], asked: false, sealed: false }
    }

    /// Key of the seals that this side makes, for a host that encodes its packets itself; `None` before the session.
    #[must_use]
    pub fn sending_key(&self) -> Option<SealKey> {
        self.sending.clone()
    }

    /// True if the packets are sealed.
    #[must_use]
    pub const fn is_sealed(&self) -> bool {
        self.sealed
    }

    /// Returns the packet that requests a challenge. `nonce` must be random and new.
    ///
    /// # Errors
    /// As [`crate::Encoder::encode`].
    pub fn join(&mut self, nonce: Nonce) -> Result<Packet, FrameTooLong> {
        (self.nonce, self.asked) = (nonce, true);
        self.codec.encoder.encode_open(&Frame::Join(nonce))
    }

    /// Checks that the board can be trusted. Sends nothing, and begins no session.
    ///
    /// # Errors
    /// [`Distrust`]: the board cannot be trusted with this key, or requires one and the host has none.
    pub fn check(&self, challenge: &Challenge) -> Result<(), Distrust> {
        self.secret(challenge).map(|_| ())
    }

    /// Answers a challenge. Returns the packet with the host's proof, or `None` for a board without a key. After a proof all packets are sealed.
    ///
    /// # Errors
    /// As [`HostChannel::check`].
    pub fn answer(&mut self, challenge: &Challenge) -> Result<Option<Packet>, Distrust> {
        let secret = self.secret(challenge)?;
        self.asked = false;
        let Some((key, transcript)) = secret else { return Ok(None) };
        let packet = self.codec.encoder.encode_open(&Frame::Proof(key.proof(Side::Host, &transcript))).ok();
        let keys = key.session(Side::Host, &transcript);
        self.sending = Some(keys.sending.clone());
        self.codec.seal_with(keys);
        self.sealed = true;
        Ok(packet)
    }

    /// Key and transcript of the session that a challenge offers; `None` for a board that needs no key.
    fn secret(&self, challenge: &Challenge) -> Result<Option<(Key, Transcript)>, Distrust> {
        match (challenge.trust, self.key) {
            (Trust::Key { nonce, proof, .. }, Some(key)) => {
                let transcript = Transcript::new(&self.nonce, &nonce);
                let right = proof.fits(&key.proof(Side::Board, &transcript));
                if right { Ok(Some((key, transcript))) } else { Err(Distrust::WrongProof) }
            }
            (Trust::Key { .. }, None) => Err(Distrust::KeyNeeded),
            (Trust::NoKey, Some(_)) => Err(Distrust::BoardHasNoKey),
            (Trust::Insecure, Some(_)) => Err(Distrust::BoardIsInsecure),
            (Trust::NoKey | Trust::Insecure, None) => Ok(None),
        }
    }

    /// Encodes the next packet, sealed in a session with a key. A request begins with a zero byte. It ends any noise that came before on the
    /// wire, which would otherwise merge with the request and destroy it.
    ///
    /// # Errors
    /// As [`crate::Encoder::encode`].
    pub fn encode(&mut self, frame: &Frame) -> Result<Packet, FrameTooLong> {
        let mut packet = self.codec.encoder.encode(frame)?;
        if matches!(frame, Frame::Request { .. }) {
            packet.insert(0, 0).map_err(|_| FrameTooLong)?;
        }
        Ok(packet)
    }

    /// Takes one byte. In a sealed session an open packet is accepted only if the board has to send it without a seal: after a restart, or in
    /// answer to a join.
    ///
    /// # Errors
    /// As [`crate::Decoder::push`].
    pub fn push(&mut self, byte: u8) -> Option<Result<Received, DecodeError>> {
        match self.codec.decoder.push_known(byte)? {
            Err(error) => Some(Err(error)),
            Ok((received, true)) => Some(Ok(received)),
            Ok((received, false)) => {
                let counts = match received.frame {
                    // If this host has not asked, the challenge answers another host.
                    Frame::Challenge(_) => self.asked,
                    Frame::Hello(_) | Frame::Refusal(Refusal::Unauthentic { .. } | Refusal::NoNonce) => true,
                    _ => !self.sealed,
                };
                counts.then_some(Ok(received))
            }
        }
    }
}
