//! The chip in the loop: the firmware in an emulated STM32F405, driven in lock step.
//!
//! ```text
//! host                                   chip
//!                               <------  hello {robot, joints, rate}      when it has started
//! join, proof                   <----->  challenge                         from here on all is sealed
//! hello {robot, joints, rate}   ------>
//!                               <------  hello {robot, joints, rate}      compared on both sides
//! live inputs (when they changed) ---->
//! reference (when it changed)   ------>
//! measurement {tick}            ------>  runs one tick
//!                               <------  command {tick} | fault {tick} | refusal
//! ```
//!
//! Nothing here can hang: every wait has a timeout from [`Timeouts`]. Its expiry is a [`ChipError`] that names the
//! awaited answer. The emulator ends with its [`Chip`].
//!
//! A byte to the emulated serial port costs about 13 us if all threads of the emulator share one processor: each byte
//! wakes its input thread and its processor thread in turn, and waking across processors takes four times as long. So
//! [`Chip::start`] pins the emulator to one processor.

mod emulator;
mod emulator_process;
mod error;
mod hello;
pub mod on_chip;
mod program;
mod timed;

#[cfg(test)]
mod attack_tests;
#[cfg(test)]
mod firmware_tests;
#[cfg(test)]
mod live_tests;
#[cfg(test)]
mod tests;

pub use emulator::{Carried, Emulator, Timeouts};
pub use error::ChipError;
#[cfg(feature = "session")]
pub(crate) use error::refusal as refusal_in_words;
pub use hello::{hello, hello_of};
pub use program::{build_firmware, build_firmware_by_dma, build_firmware_with};

use crate::key;
use dynamics_core::{Command, Live, Measurement, Reference};
use link::codec::{FrameTooLong, Received};
use link::seal::SealKey;
use link::{Cost, Encoder, Frame, Hello, HostChannel, Packet};
use std::path::Path;

/// Answer of the chip to one measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChipReply<const N: usize> {
    /// The command, with the exact bits of the chip.
    pub command: Command<f32, N>,
    /// Instructions that the controller executed, if the emulator counts them.
    pub instructions: Option<u32>,
}

/// A running chip that has agreed on robot, joint count and rate.
#[derive(Debug)]
pub struct Chip {
    emulator: Emulator,
    channel: HostChannel,
    tick: u32,
    /// The last frames sent, whose values the chip keeps until it gets new ones.
    reference: Option<Frame>,
    live: Option<Frame>,
    /// All bytes sent, for tests that replay them.
    #[cfg(test)]
    sent: Vec<u8>,
}

impl Chip {
    /// Starts the emulator on a program and exchanges hellos in lock step.
    ///
    /// # Errors
    /// The emulator cannot be started, or the program does not answer in time or was not built for `expect`.
    pub fn start(elf: &Path, expect: Hello) -> Result<Self, ChipError> {
        Self::over(Emulator::start("qemu-system-arm".as_ref(), elf, Timeouts::default())?, expect)
    }

    /// Exchanges hellos with a running emulator.
    ///
    /// # Errors
    /// As [`Chip::start`].
    pub fn over(emulator: Emulator, expect: Hello) -> Result<Self, ChipError> {
        let channel = HostChannel::new(emulator.key());
        let mut chip = Self {
            emulator,
            channel,
            tick: 0,
            reference: None,
            live: None,
            #[cfg(test)]
            sent: Vec::new(),
        };
        // The chip sends its first hello without a request. A packet sent before it may be lost, because the chip's receiver may still be off.
        chip.agree("the chip's hello", expect)?;
        chip.join()?;
        chip.send(&Frame::Hello(expect))?;
        chip.agree("the chip's answer to a hello", expect)?;
        Ok(chip)
    }

    /// Performs the handshake after which all packets are sealed, if the chip has a key.
    fn join(&mut self) -> Result<(), ChipError> {
        let packet = self.channel.join(key::random()?)?;
        self.write(&packet)?;
        let challenge = match self.receive("the chip's challenge")? {
            Frame::Challenge(challenge) => challenge,
            frame => return Err(ChipError::unexpected("a challenge", frame)),
        };
        match self.channel.answer(&challenge)? {
            Some(packet) => self.write(&packet),
            None => Ok(()),
        }
    }

    /// Begins a new session, whatever bytes came before. Returns the key of its packets, for a host that seals them itself.
    pub fn join_anew(&mut self) -> Result<Option<SealKey>, ChipError> {
        self.write(&[0])?;
        let packet = self.channel.join(key::random()?)?;
        self.write(&packet)?;
        loop {
            let byte = self.emulator.read_byte("the chip's challenge")?;
            // All other packets belong to the previous session.
            if let Some(Ok(Received { frame: Frame::Challenge(challenge), .. })) = self.channel.push(byte) {
                if let Some(packet) = self.channel.answer(&challenge)? {
                    self.write(&packet)?;
                }
                return Ok(self.channel.sending_key());
            }
        }
    }

    fn agree(&mut self, waiting_for: &'static str, expect: Hello) -> Result<(), ChipError> {
        match self.receive(waiting_for)? {
            Frame::Hello(theirs) if theirs == expect => Ok(()),
            Frame::Hello(theirs) => Err(ChipError::OtherRobot { expected: expect, found: theirs }),
            frame => Err(ChipError::unexpected("a hello", frame)),
        }
    }

    /// Sets the live inputs, which act on the arm from the next tick until the next call. Unchanged inputs are not sent again.
    ///
    /// If the chip refuses the inputs, the next tick returns the error.
    ///
    /// # Errors
    /// A payload that a frame cannot carry, or a chip that died.
    pub fn set_live<const N: usize>(&mut self, live: &Live<f32, N>) -> Result<(), ChipError> {
        let live = Frame::Live(link::Live::new(live)?);
        if differs(self.live.as_ref(), &live)? {
            self.send(&live)?;
            self.live = Some(live);
        }
        Ok(())
    }

    /// Runs one tick of the chip's controller.
    ///
    /// # Errors
    /// The chip refuses, is silent, died, or answers another tick. After an error the chip cannot be used any more.
    pub fn tick<const N: usize>(
        &mut self,
        reference: &Reference<f32, N>,
        measurement: &Measurement<f32, N>,
    ) -> Result<ChipReply<N>, ChipError> {
        // The chip keeps a reference until the next one, so an unchanged one is not sent: sending takes most of a tick's time.
        let reference = Frame::Reference(link::Reference::new(reference));
        if differs(self.reference.as_ref(), &reference)? {
            self.send(&reference)?;
            self.reference = Some(reference);
        }
        self.tick = self.tick.wrapping_add(1);
        self.send(&Frame::Measurement(link::Measurement::new(self.tick, measurement)))?;
        let answer = self.receive("the answer to a measurement")?;
        self.reply(answer, self.tick)
    }

    /// Bytes that the link has carried since the emulator's start.
    #[must_use]
    pub fn carried(&self) -> Carried {
        self.emulator.carried()
    }

    fn reply<const N: usize>(&self, frame: Frame, expected: u32) -> Result<ChipReply<N>, ChipError> {
        let (tick, command, cost) = match frame {
            Frame::Command(command) => (command.tick, command.to_core()?, command.cost),
            Frame::Fault(fault) => {
                let known = fault.to_core().ok_or(ChipError::UnknownFault { code: fault.code })?;
                (fault.tick, Command::Brake(known), None)
            }
            frame => return Err(ChipError::unexpected("a command", frame)),
        };
        if tick != expected {
            return Err(ChipError::OtherTick { expected, found: tick });
        }
        let instructions = match cost {
            Some(Cost::Instructions(count)) => Some(count),
            Some(Cost::Cycles(_)) | None => None,
        };
        Ok(ChipReply { command, instructions })
    }

    pub(crate) fn send(&mut self, frame: &Frame) -> Result<(), ChipError> {
        let packet = self.channel.encode(frame)?;
        self.write(&packet)
    }

    /// Sends raw bytes, valid or not.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), ChipError> {
        #[cfg(test)]
        self.sent.extend_from_slice(bytes);
        self.emulator.write(bytes)
    }

    /// Returns the next frame. Waits no longer than the chip's timeout.
    ///
    /// # Errors
    /// Silence, or bytes that are no frame.
    pub fn receive(&mut self, waiting_for: &'static str) -> Result<Frame, ChipError> {
        loop {
            let byte = self.emulator.read_byte(waiting_for)?;
            match self.channel.push(byte) {
                None => {}
                Some(Err(error)) => return Err(ChipError::Undecodable(error)),
                Some(Ok(Received { missed: missed @ 1.., .. })) => return Err(ChipError::Lost { missed }),
                Some(Ok(Received { frame, .. })) => return Ok(frame),
            }
        }
    }
}

/// True if a frame differs from the last one sent. Compares the bits, because `==` treats -0 and 0 as equal, and NaN never equals NaN.
fn differs(before: Option<&Frame>, now: &Frame) -> Result<bool, FrameTooLong> {
    let packet = |frame: &Frame| Encoder::new().encode(frame);
    let before: Option<Packet> = before.map(packet).transpose()?;
    Ok(before != Some(packet(now)?))
}
