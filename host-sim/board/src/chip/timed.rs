//! A chip that is paced by its own timer.

use super::{Chip, ChipError, ChipReply};
use dynamics_core::{Live, Measurement, Reference};
use link::{Frame, Hello, Pacing};

/// Step between the tick numbers of [`Chip::push`]: more than the chip's timer counts while a measurement is being sent.
const PUSH_STRIDE: u32 = 10_000;

impl Chip {
    /// Returns the next answer of a chip that is paced by its own timer, with its tick number. See [`Chip::start_timer`].
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

    /// Lets the chip's timer set the pace. Sends a reference and a measurement to start from, and the current live inputs.
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

    /// Sends live inputs, reference and measurement to a chip paced by its own timer, without waiting for an answer.
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
        // The timer counts on from a measurement's number. So the next measurement gets a number that the timer does not reach meanwhile.
        self.tick = self.tick.wrapping_add(PUSH_STRIDE);
        self.send(&Frame::Live(link::Live::new(live)?))?;
        self.send(&Frame::Reference(link::Reference::new(reference)))?;
        self.send(&Frame::Measurement(link::Measurement::new(self.tick, measurement)))?;
        Ok(self.tick)
    }

    /// Restarts with another pacing; both sides forget the live inputs and the reference.
    ///
    /// # Errors
    /// As [`Chip::start`].
    #[cfg(feature = "session")]
    pub(crate) fn change_pacing(&mut self, hello: Hello) -> Result<(), ChipError> {
        (self.reference, self.live) = (None, None);
        self.send(&Frame::Hello(hello))?;
        self.agree("the chip's answer to a hello", hello)
    }
}
