//! The task between link and session: it reads the received frames, and sends answers and reports. It runs below the tick.
//!
//! Whatever arrives, and however little the host reads, the next request is read in time:
//!
//! | rule | so that |
//! |---|---|
//! | Reading comes first and never waits for the line | reports or refusals that fill the line do not delay a stop |
//! | One run reads at most a full buffer and sends at most three reports | neither reading nor reporting blocks the other |
//! | Packets from outside the session share one answer per run, sent only if a report still fits after it | a flood costs only the time to read it |
//! | A report that does not fit is sent later, or a newer one instead | a host that requests more reports than the line carries gets fewer |
//! | An answer to the session's host that does not fit is dropped | a host that asks more than it reads does not block the board |
//!
//! `firmware/tests/flood.rs` checks these rules against stated times, with a model of the hardware.

use crate::board::{ANSWER_ROOM, Incoming, LinkOutput, READ_AT_ONCE, REPORT_ROOM, STRANGER_ROOM};
use link::channel::NewNonce;
use link::{BoardChannel, Frame, Hello, Received};

/// This task's interface to the session.
pub trait Served<O> {
    /// Takes a frame of the session, and answers it.
    fn take(&mut self, received: Received, channel: &mut BoardChannel, output: &mut O);

    /// Returns the next report, with true if it is a tick of the black box; `None` if there are no more.
    fn say(&mut self) -> Option<(Frame, bool)>;

    /// True if more of the black box is to be sent.
    fn dumps(&mut self) -> bool;
}

/// Runs the task once. Returns true if it must run again at once, because unread bytes or ticks of the black box wait. Otherwise the next byte,
/// the next tick or the end of the next piece on the line starts it.
pub fn run<I: Incoming, O: LinkOutput>(
    incoming: &mut I,
    channel: &mut BoardChannel,
    output: &mut O,
    own: &Hello,
    nonce: NewNonce<'_>,
    served: &mut impl Served<O>,
) -> bool {
    let all = listen(incoming, channel, output, served);
    if channel.owes() && output.room() >= STRANGER_ROOM {
        channel.answer(own, nonce, &mut |bytes| output.write(bytes));
    }
    report(channel, output, served);
    // If the line is full, the interrupt at the end of the next piece continues with the black box.
    !all || served.dumps() && output.room() >= REPORT_ROOM
}

/// Takes the received frames, up to a full buffer. Returns true if all bytes were read. Not inlined, so that its stack frame is gone when reports
/// are made.
#[inline(never)]
fn listen<I: Incoming, O: LinkOutput>(
    incoming: &mut I,
    channel: &mut BoardChannel,
    output: &mut O,
    served: &mut impl Served<O>,
) -> bool {
    for _ in 0..READ_AT_ONCE {
        let Some(byte) = incoming.next() else { return true };
        if let Some(received) = channel.take(byte) {
            served.take(received, channel, output);
        }
    }
    false
}

/// Sends the session's reports, as far as they fit: an answer, the last tick, and one tick of the black box. The rest of the black box waits until
/// the frames received meanwhile are handled.
#[inline(never)]
fn report<O: LinkOutput>(channel: &mut BoardChannel, output: &mut O, served: &mut impl Served<O>) {
    for _ in 0..3 {
        if output.room() < REPORT_ROOM {
            return;
        }
        let Some((frame, past)) = served.say() else { return };
        send(channel, output, &frame);
        if past {
            return;
        }
    }
}

/// Sends an answer to the session's host if it fits; otherwise drops it.
pub fn reply<O: LinkOutput>(channel: &mut BoardChannel, output: &mut O, frame: &Frame) {
    if output.room() >= ANSWER_ROOM {
        send(channel, output, frame);
    }
}

/// Sends a frame, and waits for the line if necessary. Not inlined, so that the firmware has one copy.
#[inline(never)]
pub fn send<O: LinkOutput>(channel: &mut BoardChannel, output: &mut O, frame: &Frame) {
    channel.send(frame, &mut |bytes| output.write(bytes));
}
