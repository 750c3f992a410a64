//! Interface to a CAN adapter.

use super::frame::CanFrame;
use std::collections::VecDeque;
use std::io;

/// A CAN adapter at 1 Mbit/s. No call waits for hardware, because the control tick makes them.
pub trait Adapter: Send {
    /// Begins the frames of a tick. While frames of an earlier tick are still not sent, no further one is accepted, so that no old torque follows; after
    /// [`UNSENT_MAX`] such ticks the adapter counts as off.
    fn begin_tick(&mut self);

    /// Hands a frame to the adapter.
    ///
    /// # Errors
    /// `WouldBlock`: earlier frames are not sent yet. Any other error: the frame was not sent.
    fn send(&mut self, frame: &CanFrame) -> io::Result<()>;

    /// The next received frame; `None` if there is none.
    ///
    /// # Errors
    /// The adapter is gone, or reports an error.
    fn receive(&mut self) -> io::Result<Option<CanFrame>>;

    /// True if the adapter has left the bus after too many errors, or has been unplugged.
    fn is_off(&mut self) -> bool;
}

/// Received frames that an adapter keeps: as many as a tick reads. The oldest are dropped, so that none is older than a tick.
pub const RECEIVED_MAX: usize = 16;

/// Appends a received frame, or the error instead of one. Of [`RECEIVED_MAX`], the oldest is dropped.
pub(super) fn keep_newest<T>(received: &mut VecDeque<T>, frame: T) {
    if received.len() >= RECEIVED_MAX {
        received.pop_front();
    }
    received.push_back(frame);
}

/// Ticks in which frames of an earlier tick may wait. The same as without replies before a joint is at fault.
pub const UNSENT_MAX: u32 = joint_io::MISSING_MAX;
