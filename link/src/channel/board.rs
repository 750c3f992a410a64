//! The board's side.

use crate::codec::{Codec, Packet, Received};
use crate::frame::{Challenge, Frame, Hello, NonceSource, Refusal, Trust};
use crate::seal::{KEY_BYTES, Key, Nonce, Proof, Side, Transcript};
use crate::{DecodeError, Pacing};

/// Whom a board lets talk.
#[derive(Clone, Copy)]
pub enum Access {
    /// A host that proves to have this key.
    Key(&'static [u8; KEY_BYTES]),
    /// The board has no key: anybody may use it on the bench, where no drive is driven.
    NoKey,
    /// Anybody.
    Insecure,
}

/// Gives a number that never comes again, and its origin; `None` where the origin has failed.
pub type NewNonce<'a> = &'a mut dyn FnMut() -> Option<(Nonce, NonceSource)>;

/// Sends bytes.
pub type Write<'a> = &'a mut dyn FnMut(&[u8]);

/// Packets of a board, in and out.
pub struct BoardChannel {
    codec: Codec,
    access: Access,
    /// The last packet, kept here so that none passes over the stack.
    packet: Packet,
    /// Transcript of the last challenge, until a right proof comes for it.
    challenged: Option<Transcript>,
    /// Packets refused because they are not authentic.
    refused: u16,
}

impl BoardChannel {
    /// A channel before any packet.
    #[must_use]
    pub const fn new(access: Access) -> Self {
        Self { codec: Codec::new(), access, packet: Packet::new(), challenged: None, refused: 0 }
    }

    /// Send a frame: sealed in a session with a key. A frame that fits no packet is not sent; there is none of up to
    /// [`crate::JOINTS_MAX`] joints.
    pub fn send(&mut self, frame: &Frame, write: Write<'_>) {
        if self.codec.encoder.encode_to(frame, &mut self.packet).is_ok() {
            write(&self.packet);
        }
    }

    /// Take one byte. Returns the frames that count: those of the session, or anybody's where the board has no key. All else is
    /// answered here, through `write`. `own` is the board's hello, `nonce` gives a new nonce and its origin.
    ///
    /// # Errors
    /// A packet that could not be decoded; one that is not authentic is no error here: it is refused and counted.
    pub fn push(
        &mut self,
        byte: u8,
        own: &Hello,
        nonce: NewNonce<'_>,
        write: Write<'_>,
    ) -> Option<Result<Received, DecodeError>> {
        if self.codec.decoder.collect(byte) { self.packet_ended(own, nonce, write) } else { None }
    }

    /// A function of its own: what a packet needs of the stack is not there while bytes are collected and reports are sent.
    #[inline(never)]
    fn packet_ended(
        &mut self,
        own: &Hello,
        nonce: NewNonce<'_>,
        write: Write<'_>,
    ) -> Option<Result<Received, DecodeError>> {
        let keyed = matches!(self.access, Access::Key(_));
        let (received, sealed) = match self.codec.decoder.finish() {
            Ok(received) => received,
            Err(DecodeError::BadSeal | DecodeError::Repeated) if keyed => {
                self.refuse(write);
                return None;
            }
            Err(error) => return Some(Err(error)),
        };
        match (&received.frame, self.access) {
            (Frame::Join(theirs), _) => self.challenge(own, theirs, nonce, write),
            (Frame::Proof(proof), Access::Key(key)) if !sealed => self.check(proof, Key::new(*key), write),
            (_, Access::Key(_)) if !sealed => self.refuse(write),
            (Frame::Hello(hello), Access::NoKey) if hello.pacing.is_supervised() => self.miss_key(write),
            _ => return Some(Ok(received)),
        }
        None
    }

    #[cold]
    fn challenge(&mut self, own: &Hello, theirs: &Nonce, nonce: NewNonce<'_>, write: Write<'_>) {
        let trust = match self.access {
            Access::NoKey => Trust::NoKey,
            Access::Insecure => Trust::Insecure,
            Access::Key(key) => {
                let Some((nonce, source)) = nonce() else {
                    return self.answer(&Frame::Refusal(Refusal::NoNonce), write);
                };
                let transcript = Transcript::new(theirs, &nonce);
                self.challenged = Some(transcript);
                Trust::Key { nonce, source, proof: Key::new(*key).proof(Side::Board, &transcript) }
            }
        };
        let own = Hello { pacing: Pacing::LockStep, ..*own };
        self.answer(&Frame::Challenge(Challenge { own, trust }), write);
    }

    /// Begin a session, if the proof fits. A wrong one leaves the challenge standing: who guesses must not keep others out.
    #[cold]
    fn check(&mut self, proof: &Proof, key: Key, write: Write<'_>) {
        match self.challenged {
            Some(transcript) if proof.fits(&key.proof(Side::Host, &transcript)) => {
                self.challenged = None;
                self.codec.seal_with(key.session(Side::Board, &transcript));
            }
            _ => self.refuse(write),
        }
    }

    /// Refuse a packet that is not authentic. The session's host is told, where there is a session.
    #[cold]
    fn refuse(&mut self, write: Write<'_>) {
        self.refused = self.refused.saturating_add(1);
        self.send(&Frame::Refusal(Refusal::Unauthentic { count: self.refused }), write);
    }

    /// Refuse to drive without a key.
    #[cold]
    #[inline(never)]
    fn miss_key(&mut self, write: Write<'_>) {
        self.answer(&Frame::Refusal(Refusal::NoKey), write);
    }

    /// Answer somebody who has no part in a session.
    #[cold]
    fn answer(&mut self, frame: &Frame, write: Write<'_>) {
        if self.codec.encoder.encode_open_to(frame, &mut self.packet).is_ok() {
            write(&self.packet);
        }
    }
}
