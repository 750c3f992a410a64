//! Reports to be sent.

use super::{Buffers, Session};
use crate::black_box::{LiveContext, Report};
use core::borrow::BorrowMut;
use dynamics_core::control::{ArmBuild, Protection as _};
use dynamics_core::safety;
use link::{Frame, Parts};

impl<const N: usize, A: ArmBuild<f32, N>, B: BorrowMut<Buffers<N>>> Session<N, A, B> {
    /// Returns the next report to be sent; `None` if there are no more. It only copies: the frame is made outside the lock.
    ///
    /// The ticks of the black box are sent after all other reports. Not inlined: the caller would take the record apart, and copy it in pieces from
    /// odd addresses.
    #[inline(never)]
    pub fn say(&mut self) -> Option<Report<N>> {
        if let Some(answer) = self.answer.take() {
            return Some(Report::Answer(answer));
        }
        if let Some(answer) = self.requests.say() {
            return Some(Report::Answer(Frame::Answer(answer)));
        }
        if let Some(changed) = self.changed.pop_front() {
            return Some(Report::Answer(changed.map_or_else(Frame::Refusal, Frame::Value)));
        }
        if core::mem::take(&mut self.unsaid)
            && let Some(parts) = self.is_due()
        {
            let beside = self.beside(parts);
            return Some(Report::Tick(*self.buffers.borrow().black_box.now(), parts, beside));
        }
        let place = self.past?;
        let black_box = &mut self.buffers.borrow_mut().black_box;
        let is_last = black_box.get(place).is_none();
        black_box.read(place, is_last);
        self.past = (!is_last).then_some(place + 1);
        Some(black_box.get(place).map_or(Report::End, |record| Report::Past(*record)))
    }

    /// True if the black box is being sent: [`Session::say`] has more reports without another tick.
    #[must_use]
    pub fn dumps(&self) -> bool {
        self.past.is_some()
    }

    fn beside(&self, parts: Parts) -> LiveContext<N> {
        let failed = matches!(self.supervisor.state(), safety::State::Fault(_));
        let Buffers { trajectory, black_box } = self.buffers.borrow();
        LiveContext {
            kept: black_box.keeps(),
            room: u8::try_from(trajectory.room()).unwrap_or(u8::MAX),
            drive_fault: self.drive_fault.filter(|_| failed),
            external: self.controller.protection().external().copied().filter(|_| parts.contains(Parts::EXTERNAL)),
        }
    }

    /// Returns the parts of the last tick to report, if a report is due.
    fn is_due(&mut self) -> Option<Parts> {
        match self.watch.every {
            0 => None,
            every => {
                let due = self.until == 0;
                self.until = if due { every - 1 } else { self.until - 1 };
                due.then_some(self.watch.parts)
            }
        }
    }
}
