//! The control thread as a device of the operator.

use super::control::Shown;
use crate::session::local::shared::ControlLoop;
use crate::session::operate::Presses;
use crate::session::operate::device::{Device, DeviceError, Tap, receive_all};
use crate::session::operate::on_wire::ALIVE_EVERY;
use link::{Frame, Pacing, Received};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Longest wait for the control thread at the end: it brings the arm to rest first.
const ENDING_MAX: Duration = Duration::from_secs(900);

/// The control thread, as a board. When this is dropped, the thread brings the arm to rest as a board does whose host is gone, and ends.
pub struct DriveDevice {
    /// `None` at the end.
    to_board: Option<SyncSender<Frame>>,
    from_board: Receiver<Frame>,
    thread: Option<JoinHandle<()>>,
    shown: Arc<Shown>,
    presses: Presses,
    begun: Instant,
    sent: Instant,
    tap: Tap,
}

impl DriveDevice {
    pub(super) fn new(
        (to_board, from_board): (SyncSender<Frame>, Receiver<Frame>),
        thread: JoinHandle<()>,
        shown: Arc<Shown>,
        presses: Presses,
    ) -> Self {
        let now = Instant::now();
        let (to_board, thread) = (Some(to_board), Some(thread));
        Self { to_board, from_board, thread, shown, presses, begun: now, sent: now, tap: Tap::default() }
    }

    /// Times of the ticks so far, and what the system allowed.
    #[must_use]
    pub fn shown(&self) -> Arc<Shown> {
        Arc::clone(&self.shown)
    }
}

impl Device for DriveDevice {
    fn pacing(&self) -> Pacing {
        Pacing::Live
    }

    fn send(&mut self, frame: &Frame) -> Result<(), DeviceError> {
        let sent = self.to_board.as_ref().is_some_and(|to_board| to_board.send(frame.clone()).is_ok());
        if !sent {
            return Err(DeviceError::ControlEnded);
        }
        self.sent = Instant::now();
        Ok(self.tap.hear_sent(self.begun.elapsed(), frame)?)
    }

    fn pass(&mut self) -> Result<Vec<Frame>, DeviceError> {
        if self.sent.elapsed() >= ALIVE_EVERY {
            self.send(&Frame::Alive)?;
        }
        receive_all(&mut self.tap, self.begun, |wait| match self.from_board.recv_timeout(wait) {
            Ok(frame) => Ok(Some(Received { frame, missed: 0 })),
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(RecvTimeoutError::Disconnected) => Err(DeviceError::ControlEnded),
        })
    }

    fn now(&self) -> Duration {
        self.begun.elapsed()
    }

    fn control_loop(&self) -> Option<Arc<dyn ControlLoop>> {
        let shown: Arc<dyn ControlLoop> = Arc::<Shown>::clone(&self.shown);
        Some(shown)
    }

    fn tap(&mut self) -> &mut Tap {
        &mut self.tap
    }
}

impl Drop for DriveDevice {
    fn drop(&mut self) {
        self.to_board = None;
        let Some(thread) = self.thread.take() else { return };
        let (begun, before, mut said) = (Instant::now(), self.presses.load(Ordering::Relaxed), false);
        while !thread.is_finished() && begun.elapsed() < ENDING_MAX {
            if !said && begun.elapsed() > Duration::from_millis(500) {
                said = true;
                eprintln!("the arm is brought to rest before the program ends; Ctrl-C: emergency stop");
            }
            if self.presses.load(Ordering::Relaxed) != before {
                self.shown.stops.store(true, Ordering::Relaxed);
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        // A thread that is stuck in the system is left to the drives' timeouts.
        if thread.is_finished() {
            let _ = thread.join();
        }
    }
}
