//! Effect of a received frame.

use link::{Answer, Frame, Hello, Pacing, Refusal, Value};

/// Answer to a received frame.
#[derive(Clone, Debug, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "made and taken apart at once, where there is nothing to allocate from")]
pub enum Reaction {
    /// Nothing: it was taken.
    None,
    /// Send these, in order; ticks stop until the next agreed hello.
    Stop(Frame, Frame),
    /// Send this.
    Reply(Frame),
    /// Start pacing like this, and send this hello.
    Start(Pacing, Frame),
    /// Send this hello: the live session goes on.
    Resume(Frame),
    /// Run one tick now.
    Tick,
}

/// The same, small enough to be handed out of a lock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// Nothing: it was taken.
    None,
    /// It was not taken.
    Refused(Refusal),
    /// A parameter's value.
    Value(Value),
    /// The verdict on a request.
    Answer(Answer),
    /// A host's hello: no tick runs until [`Session::forget_controller`](super::Session::forget_controller),
    /// [`Session::forget_arm`](super::Session::forget_arm) and [`Session::begin`](super::Session::begin).
    Hello(Hello),
    /// Start pacing as this hello says.
    Start(Hello),
    /// The live session goes on, for the host that sent this hello.
    Resume(Hello),
    /// Ticks stop until the next agreed hello; this is the own one, and why.
    Stop(Hello, Refusal),
    /// Run one tick now.
    Tick,
}

impl Outcome {
    /// With the frames to send.
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
