//! Effect of a received frame.

use link::{Answer, Frame, Hello, Pacing, Refusal, Value};

/// Answer to a received frame.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "made and taken apart at once, where there is nothing to allocate from")]
pub enum Reaction {
    /// Nothing to do: the frame was accepted.
    None,
    /// Send these frames, in order; ticks stop until the next matching hello.
    Stop(Frame, Frame),
    /// Send this frame.
    Reply(Frame),
    /// Start ticks with this pacing, and send this hello.
    Start(Pacing, Frame),
    /// Send this hello: the live session goes on.
    Resume(Frame),
    /// Run one tick now.
    Tick,
}

/// Effect of a received frame, as [`Reaction`] but without frames: small enough to be copied out of a lock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// Nothing to do: the frame was accepted.
    None,
    /// The frame was refused.
    Refused(Refusal),
    /// A parameter's value.
    Value(Value),
    /// The verdict on a request.
    Answer(Answer),
    /// A host's hello: no tick runs until the caller has called [`Session::forget_controller`](super::Session::forget_controller),
    /// [`Session::forget_arm`](super::Session::forget_arm) and [`Session::begin`](super::Session::begin).
    Hello(Hello),
    /// Start ticks with the pacing of this hello.
    Start(Hello),
    /// The live session goes on for the host that sent this hello.
    Resume(Hello),
    /// Ticks stop until the next matching hello; holds the session's own hello and the reason.
    Stop(Hello, Refusal),
    /// Run one tick now.
    Tick,
}

impl Outcome {
    /// Converts to a reaction with the frames to send.
    #[must_use]
    pub fn reaction(self) -> Reaction {
        match self {
            Self::None | Self::Hello(_) => Reaction::None,
            Self::Refused(refusal) => Reaction::Reply(Frame::Refusal(refusal)),
            Self::Value(value) => Reaction::Reply(Frame::Value(value)),
            Self::Answer(answer) => Reaction::Reply(Frame::Answer(answer)),
            Self::Start(hello) => Reaction::Start(hello.pacing, Frame::Hello(hello)),
            Self::Resume(hello) => Reaction::Resume(Frame::Hello(hello)),
            Self::Stop(hello, refusal) => Reaction::Stop(Frame::Hello(hello), Frame::Refusal(refusal)),
            Self::Tick => Reaction::Tick,
        }
    }
}
