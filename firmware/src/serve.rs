//! The task between link and session: it reads the received frames, and sends answers and reports. It runs below the tick.
//!
//! Whatever comes in, and however little the host reads of what is sent, the next request is read in time:
//!
//! | rule | so that |
//! |---|---|
//! | Reading comes first and never waits for the line | a stop is not read later because reports or refusals fill the line |
//! | One run reads at most a full buffer, and sends at most three reports | neither reading nor reporting keeps the other waiting |
//! | Packets outside of the session share one answer a run, sent where a report still finds room behind it | a flood costs what reading it costs |
//! | A report that finds no room is sent later, or the next one in its place | a host that wants more reports than the line carries gets fewer |
//! | An answer to the session's host that finds no room is dropped | the same for one that asks more than it reads |
//!
//! `firmware/tests/flood.rs` holds all of it to a stated time, against a model of the hardware.

use crate::board::{ANSWER_ROOM, Incoming, LinkOutput, READ_AT_ONCE, REPORT_ROOM, STRANGER_ROOM};
use link::channel::NewNonce;
use link::{BoardChannel, Frame, Hello, Received};

/// The session, as this task reaches it.
pub trait Served<O> {
    /// Takes a frame of the session, and answers it.
    fn take(&mut self, received: Received, channel: &mut BoardChannel, output: &mut O);

    /// The next report, and whether it is a tick of the black box; `None` when there are no more.
    fn say(&mut self) -> Option<(Frame, bool)>;

    /// True if more of the black box is to be sent.
    fn dumps(&mut self) -> bool;
}

/// One run of the task. True if it has to run again by itself: bytes wait that were not read, or ticks of the black box. Otherwise the next
/// byte, the next tick or the next free space in the line starts it.
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
    // Where the line is full, the end of the next piece goes on with the black box.
    !all || served.dumps() && output.room() >= REPORT_ROOM
}

/// Takes the received frames, up to a full buffer. True if all bytes were read. A function of its own: its frame is gone when reports are
/// made.
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

/// Sends the session's reports, as far as there is room: an answer, the last tick, and one tick of the black box. The rest of the black box
/// waits until the frames that came meanwhile are handled.
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

/// Sends an answer to the session's host, where it finds room.
pub fn reply<O: LinkOutput>(channel: &mut BoardChannel, output: &mut O, frame: &Frame) {
    if output.room() >= ANSWER_ROOM {
        send(channel, output, frame);
    }
}

/// Sends a frame, and waits for the line if it has to. One copy of it, not one at each place that sends.
#[inline(never)]
pub fn send<O: LinkOutput>(channel: &mut BoardChannel, output: &mut O, frame: &Frame) {
    channel.send(frame, &mut |bytes| output.write(bytes));
}
