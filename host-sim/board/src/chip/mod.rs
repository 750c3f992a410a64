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

pub mod cost;
mod emulator;
mod error;
mod hello;
pub mod interrupt;
pub mod on_chip;
mod program;

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
pub(crate) use error::refusal as refusal_in_words;
pub use hello::hello;
pub use program::{build_firmware, build_firmware_by_dma, build_firmware_with};
pub(crate) use program::{run_cost, run_interrupt};

use crate::key;
use dynamics_core::{Command, Live, Measurement, Reference};
use link::codec::{FrameTooLong, Received};
use link::seal::SealKey;
use link::{Cost, Encoder, Frame, Hello, HostChannel, Pacing, Packet};
use std::path::Path;

/// Step between the tick numbers of [`Chip::push`]: more than the chip's timer can count while a measurement is on its
/// way.
const PUSH_STRIDE: u32 = 10_000;

/// Answer of the chip to one measurement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChipReply<const N: usize> {
    /// The command, with the exact bits of the chip.
    pub command: Command<f32, N>,
    /// Instructions that the controller took, if the emulator counts them.
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
    /// All bytes sent, for who replays them.
    #[cfg(test)]
    sent: Vec<u8>,
}

impl Chip {
    /// Start the emulator on a program and exchange hellos in lock step.
    ///
    /// # Errors
    /// The emulator cannot be started, or the program does not answer in time or was not built for `expect`.
    pub fn start(elf: &Path, expect: Hello) -> Result<Self, ChipError> {
        Self::over(Emulator::start("qemu-system-arm".as_ref(), elf, Timeouts::default())?, expect)
    }

    /// Exchange hellos with a running emulator.
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
        // The chip sends its first hello by itself. A packet sent before it may be lost, because the chip's receiver
        // may still be off.
        chip.agree("the chip's hello", expect)?;
        chip.join()?;
        chip.send(&Frame::Hello(expect))?;
        chip.agree("the chip's answer to a hello", expect)?;
        Ok(chip)
    }

    /// The handshake behind which all packets are sealed, where the chip has a key.
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

    /// Begin a new session, whatever bytes came before. Returns the key of its packets, for a host that makes them itself.
    pub fn join_anew(&mut self) -> Result<Option<SealKey>, ChipError> {
        self.write(&[0])?;
        let packet = self.channel.join(key::random()?)?;
        self.write(&packet)?;
        loop {
            let byte = self.emulator.read_byte("the chip's challenge")?;
            // Whatever else comes was for the session before.
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

    /// Set the live inputs, which act on the arm from the next tick until the next call. Unchanged inputs cost nothing.
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

    /// Run one tick of the chip's controller.
    ///
    /// # Errors
    /// The chip refuses, is silent, died, or answers another tick. After an error the chip cannot be used: drop it.
    pub fn tick<const N: usize>(
        &mut self,
        reference: &Reference<f32, N>,
        measurement: &Measurement<f32, N>,
    ) -> Result<ChipReply<N>, ChipError> {
        // The chip keeps a reference until the next one, so an unchanged one is not sent: bytes take most of a tick's
        // time.
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

    /// The next answer of a chip paced by its own timer, with the number of its tick. See [`Chip::start_timer`].
    ///
    /// # Errors
    /// As [`Chip::tick`].
    pub fn next_timed<const N: usize>(&mut self) -> Result<(u32, ChipReply<N>), ChipError> {
        let answer = self.receive("an answer in the timer's pace")?;
        let tick = match &answer {
            Frame::Command(command) => command.tick,
            Frame::Fault(fault) => fault.tick,
            _ => self.tick,
        };
        Ok((tick, self.reply(answer, tick)?))
    }

    /// Let the chip's timer set the pace. Sends one reference and one measurement to start from, and the current live
    /// inputs.
    ///
    /// # Errors
    /// As [`Chip::start`].
    pub fn start_timer<const N: usize>(
        &mut self,
        expect: Hello,
        reference: &Reference<f32, N>,
        measurement: &Measurement<f32, N>,
    ) -> Result<(), ChipError> {
        let timed = Hello { pacing: Pacing::Timer, ..expect };
        self.send(&Frame::Hello(timed))?;
        self.agree("the chip's answer to a hello", timed)?;
        // The hello has made the chip forget its live inputs.
        if let Some(live) = self.live.clone() {
            self.send(&live)?;
        }
        self.send(&Frame::Reference(link::Reference::new(reference)))?;
        self.send(&Frame::Measurement(link::Measurement::new(0, measurement)))
    }

    /// Send live inputs, reference and measurement to a chip paced by its own timer, without waiting for an answer.
    /// Returns the number of the tick that takes them. An answer for this tick or a later one confirms that the chip
    /// took all of them.
    ///
    /// # Errors
    /// A payload that a frame cannot carry, or a chip that died.
    pub fn push<const N: usize>(
        &mut self,
        live: &Live<f32, N>,
        reference: &Reference<f32, N>,
        measurement: &Measurement<f32, N>,
    ) -> Result<u32, ChipError> {
        // The timer counts on from a measurement's number: the next number lies beyond any that the timer reaches
        // meanwhile.
        self.tick = self.tick.wrapping_add(PUSH_STRIDE);
        self.send(&Frame::Live(link::Live::new(live)?))?;
        self.send(&Frame::Reference(link::Reference::new(reference)))?;
        self.send(&Frame::Measurement(link::Measurement::new(self.tick, measurement)))?;
        Ok(self.tick)
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

    /// Restart with another pacing; both sides forget the live inputs and the reference.
    ///
    /// # Errors
    /// As [`Chip::start`].
    pub(crate) fn change_pacing(&mut self, hello: Hello) -> Result<(), ChipError> {
        (self.reference, self.live) = (None, None);
        self.send(&Frame::Hello(hello))?;
        self.agree("the chip's answer to a hello", hello)
    }

    pub(crate) fn send(&mut self, frame: &Frame) -> Result<(), ChipError> {
        let packet = self.channel.encode(frame)?;
        self.write(&packet)
    }

    /// Send raw bytes, valid or not.
    pub fn write(&mut self, bytes: &[u8]) -> Result<(), ChipError> {
        #[cfg(test)]
        self.sent.extend_from_slice(bytes);
        self.emulator.write(bytes)
    }

    /// Returns the next frame; waits for it no longer than the chip's timeout.
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

/// Returns whether a frame differs from the last one sent. Compares the bits, because `==` takes -0 for 0 and NaN never
/// equals NaN.
fn differs(before: Option<&Frame>, now: &Frame) -> Result<bool, FrameTooLong> {
    let packet = |frame: &Frame| Encoder::new().encode(frame);
    let before: Option<Packet> = before.map(packet).transpose()?;
    Ok(before != Some(packet(now)?))
}
