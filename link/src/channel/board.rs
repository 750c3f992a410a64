//! The board's side of the link.
//!
//! A packet from outside the session costs little: the board decodes, counts and drops it. All of them together get one answer of each kind,
//! sent when the line has free capacity. So a flood of packets cannot keep the board from reading those of its host.

use crate::codec::{Codec, Received};
use crate::frame::{Challenge, Frame, Hello, NonceSource, Refusal, Trust};
use crate::packet::Packet;
use crate::seal::{KEY_BYTES, Key, Nonce, Proof, Side, Transcript};
use crate::{DecodeError, Pacing};

/// The hosts that a board accepts.
#[derive(Clone, Copy)]
pub enum Access {
    /// A host that proves that it has this key.
    Key(&'static [u8; KEY_BYTES]),
    /// The board has no key: any host may use the bench modes, in which no drive is driven.
    NoKey,
    /// Any host may drive the arm.
    Insecure,
}

/// Returns a number that is never repeated, and its origin; `None` if the origin has failed.
pub type NewNonce<'a> = &'a mut dyn FnMut() -> Option<(Nonce, NonceSource)>;

/// Sends bytes.
pub type Write<'a> = &'a mut dyn FnMut(&[u8]);

/// Packets of a board, in and out.
pub struct BoardChannel {
    codec: Codec,
    access: Access,
    /// The last packet. Kept here so that no packet is copied to the stack.
    packet: Packet,
    /// Transcript of the last challenge, until a correct proof arrives for it.
    challenged: Option<Transcript>,
    /// Packets refused because they are not authentic.
    refused: u16,
    owed: Owed,
}

/// Pending answers to packets from outside the session, until [`BoardChannel::answer`] sends them. Several packets of one kind get one answer,
/// so answering a flood needs no more of the line than answering one packet.
#[derive(Clone, Copy, Debug, Default)]
struct Owed {
    /// True if any of the other fields is set.
    any: bool,
    /// The last packet that could not be decoded.
    undecodable: Option<DecodeError>,
    /// Packets were refused as not authentic since the last answer.
    unauthentic: bool,
    /// A host asked for a supervised session, but this board has no key: the refusal must still be sent.
    no_key: bool,
    /// Nonce of the last host that asked for a challenge.
    join: Option<Nonce>,
}

impl BoardChannel {
    /// Creates a channel that has not sent or received anything.
    #[must_use]
    pub const fn new(access: Access) -> Self {
        let owed = Owed { any: false, undecodable: None, unauthentic: false, no_key: false, join: None };
        Self { codec: Codec::new(), access, packet: Packet::new(), challenged: None, refused: 0, owed }
    }

    /// Sends a frame, sealed if a session with a key is open. A frame that does not fit a packet is not sent; every frame of up to
    /// [`crate::JOINTS_MAX`] joints fits.
    pub fn send(&mut self, frame: &Frame, write: Write<'_>) {
        if self.codec.encoder.encode_to(frame, &mut self.packet).is_ok() {
            write(&self.packet);
        }
    }

    /// Takes one byte and sends pending answers at once: [`BoardChannel::take`] followed by [`BoardChannel::answer`]. For a board whose line is
    /// never full. `own` is the board's hello, `nonce` returns a new nonce and its origin.
    ///
    /// # Errors
    /// [`DecodeError`] if a packet could not be decoded; the caller must answer it. A packet that is not authentic is no error: it is refused
    /// and counted.
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

    /// Takes one byte. Returns a frame if the byte ends a packet that is accepted: one of the session, or of any host if the board has no key.
    /// Sends nothing: [`BoardChannel::answer`] answers all other packets.
    ///
    /// Cost of a packet that is not accepted: decoding COBS and checking its check sum or seal. Bytes beyond the longest packet are dropped, up
    /// to the next zero.
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

    /// Handles a complete packet. Not inlined, so that its stack frame exists only here and not while bytes are collected or reports are sent.
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

    /// Sends the pending answers to packets from outside the session: at most [`ANSWERS_MAX`] bytes, however many packets there were. `own` is
    /// the board's hello, `nonce` returns a new nonce and its origin.
    #[cold]
    #[inline(never)]
    pub fn answer(&mut self, own: &Hello, nonce: NewNonce<'_>, write: Write<'_>) {
        let owed = core::mem::take(&mut self.owed);
        if let Some(error) = owed.undecodable {
            self.send(&Frame::Refusal(Refusal::Undecodable(error)), write);
        }
        if owed.unauthentic {
            // If there is a session, this answer is sealed and reaches its host.
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

    /// Begins a session if the proof fits. After a wrong proof the challenge stays valid, so that guesses cannot lock out the real host.
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

    /// Sends an open packet, for a receiver without a session.
    fn answer_openly(&mut self, frame: &Frame, write: Write<'_>) {
        if self.codec.encoder.encode_open_to(frame, &mut self.packet).is_ok() {
            write(&self.packet);
        }
    }
}

/// Longest answer of [`BoardChannel::answer`], bytes: two sealed refusals, an open one and a challenge.
pub const ANSWERS_MAX: usize = 144;
