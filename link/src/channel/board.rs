//! The board's side.
//!
//! A packet outside of the session is cheap: it is read, counted and dropped, and one answer is owed to all of them, which the board sends when
//! its line has room. So nobody on the wire can keep the board from reading what its host says.

use crate::codec::{Codec, Received};
use crate::frame::{Challenge, Frame, Hello, NonceSource, Refusal, Trust};
use crate::packet::Packet;
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
    owed: Owed,
}

/// Answers to packets outside of the session, until [`BoardChannel::answer`] sends them. Several packets of one kind get one answer, so a
/// flood of them needs no more of the line, and hardly more of the processor, than one packet.
#[derive(Clone, Copy, Debug, Default)]
struct Owed {
    /// Any of the others.
    any: bool,
    /// The last packet that could not be decoded.
    undecodable: Option<DecodeError>,
    /// Packets were refused as not authentic since the last answer.
    unauthentic: bool,
    /// A host wants to drive a board without a key.
    no_key: bool,
    /// Nonce of the last host that asked for a challenge.
    join: Option<Nonce>,
}

impl BoardChannel {
    /// A channel before any packet.
    #[must_use]
    pub const fn new(access: Access) -> Self {
        let owed = Owed { any: false, undecodable: None, unauthentic: false, no_key: false, join: None };
        Self { codec: Codec::new(), access, packet: Packet::new(), challenged: None, refused: 0, owed }
    }

    /// Send a frame: sealed in a session with a key. A frame that fits no packet is not sent; there is none of up to
    /// [`crate::JOINTS_MAX`] joints.
    pub fn send(&mut self, frame: &Frame, write: Write<'_>) {
        if self.codec.encoder.encode_to(frame, &mut self.packet).is_ok() {
            write(&self.packet);
        }
    }

    /// Take one byte, and send every answer at once: [`BoardChannel::take`] and [`BoardChannel::answer`], for a board whose line is never
    /// full. `own` is the board's hello, `nonce` gives a new nonce and its origin.
    ///
    /// # Errors
    /// A packet that could not be decoded, which is then not answered here; one that is not authentic is no error: it is refused and counted.
    pub fn push(
        &mut self,
        byte: u8,
        own: &Hello,
        nonce: NewNonce<'_>,
        write: Write<'_>,
    ) -> Option<Result<Received, DecodeError>> {
        let received = self.take(byte);
        if let Some(error) = self.owed.undecodable.take() {
            self.owed.any = false;
            return Some(Err(error));
        }
        if self.owes() {
            self.answer(own, nonce, write);
        }
        received.map(Ok)
    }

    /// Takes one byte. Returns the frames that count: those of the session, or anybody's where the board has no key. Sends nothing: all else
    /// is answered by [`BoardChannel::answer`].
    ///
    /// Cost of a packet that does not count: its COBS and its check sum or seal. Bytes beyond the longest packet are dropped, up to the next
    /// zero.
    #[inline]
    pub fn take(&mut self, byte: u8) -> Option<Received> {
        if self.codec.decoder.collect(byte) { self.packet_ended() } else { None }
    }

    /// True if [`BoardChannel::answer`] has something to send.
    #[inline]
    #[must_use]
    pub const fn owes(&self) -> bool {
        self.owed.any
    }

    /// A function of its own: what a packet needs of the stack is not there while bytes are collected and reports are sent.
    #[inline(never)]
    fn packet_ended(&mut self) -> Option<Received> {
        let keyed = matches!(self.access, Access::Key(_));
        let (received, sealed) = match self.codec.decoder.finish() {
            Ok(received) => received,
            Err(DecodeError::BadSeal | DecodeError::Repeated) if keyed => {
                self.refuse();
                return None;
            }
            Err(error) => {
                (self.owed.any, self.owed.undecodable) = (true, Some(error));
                return None;
            }
        };
        match (&received.frame, self.access) {
            (Frame::Join(theirs), _) => (self.owed.any, self.owed.join) = (true, Some(*theirs)),
            (Frame::Proof(proof), Access::Key(key)) if !sealed => self.check(proof, Key::new(*key)),
            (_, Access::Key(_)) if !sealed => self.refuse(),
            (Frame::Hello(hello), Access::NoKey) if hello.pacing.is_supervised() => {
                (self.owed.any, self.owed.no_key) = (true, true);
            }
            _ => return Some(received),
        }
        None
    }

    /// Sends the answers to packets outside of the session: at most [`ANSWERS_MAX`] bytes, however many packets there were. `own` is the
    /// board's hello, `nonce` gives a new nonce and its origin.
    #[cold]
    #[inline(never)]
    pub fn answer(&mut self, own: &Hello, nonce: NewNonce<'_>, write: Write<'_>) {
        let owed = core::mem::take(&mut self.owed);
        if let Some(error) = owed.undecodable {
            self.send(&Frame::Refusal(Refusal::Undecodable(error)), write);
        }
        if owed.unauthentic {
            // The session's host hears of it, where there is a session.
            self.send(&Frame::Refusal(Refusal::Unauthentic { count: self.refused }), write);
        }
        if owed.no_key {
            self.answer_openly(&Frame::Refusal(Refusal::NoKey), write);
        }
        if let Some(theirs) = owed.join {
            self.challenge(own, &theirs, nonce, write);
        }
    }

    fn challenge(&mut self, own: &Hello, theirs: &Nonce, nonce: NewNonce<'_>, write: Write<'_>) {
        let trust = match self.access {
            Access::NoKey => Trust::NoKey,
            Access::Insecure => Trust::Insecure,
            Access::Key(key) => {
                let Some((nonce, source)) = nonce() else {
                    return self.answer_openly(&Frame::Refusal(Refusal::NoNonce), write);
                };
                let transcript = Transcript::new(theirs, &nonce);
                self.challenged = Some(transcript);
                Trust::Key { nonce, source, proof: Key::new(*key).proof(Side::Board, &transcript) }
            }
        };
        let own = Hello { pacing: Pacing::LockStep, ..*own };
        self.answer_openly(&Frame::Challenge(Challenge { own, trust }), write);
    }

    /// Begin a session, if the proof fits. A wrong one leaves the challenge standing: who guesses must not keep others out.
    #[cold]
    fn check(&mut self, proof: &Proof, key: Key) {
        match self.challenged {
            Some(transcript) if proof.fits(&key.proof(Side::Host, &transcript)) => {
                self.challenged = None;
                self.codec.seal_with(key.session(Side::Board, &transcript));
            }
            _ => self.refuse(),
        }
    }

    /// Refuses a packet that is not authentic.
    fn refuse(&mut self) {
        self.refused = self.refused.saturating_add(1);
        (self.owed.any, self.owed.unauthentic) = (true, true);
    }

    /// Sends a frame to somebody who has no part in a session.
    fn answer_openly(&mut self, frame: &Frame, write: Write<'_>) {
        if self.codec.encoder.encode_open_to(frame, &mut self.packet).is_ok() {
            write(&self.packet);
        }
    }
}

/// Longest answer of [`BoardChannel::answer`], bytes: two sealed refusals, an open one and a challenge.
pub const ANSWERS_MAX: usize = 144;
