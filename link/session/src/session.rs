//! The session's state machine between frames and ticks: its fields, its states, and the effect of a hello.

mod change;
mod outcome;
mod receive;
mod requests;
mod say;
mod tick;
mod waiting;

pub use change::JUMP;
pub use outcome::{Outcome, Reaction};
pub use receive::Message;
pub use tick::Drives;

use crate::black_box::{BlackBox, LiveContext, Record};
use crate::readings::{Lines, Readings};
use crate::supervisor::Supervisor;
use crate::trajectory::Trajectory;
use core::borrow::BorrowMut;
use core::fmt::Debug;
use dynamics_core::control::{
    ArmBuild, BuildOf, Configuration, Controller, ControllerOf, Fault, Measurement, Protection, Reference, Spring,
    SpringOwner,
};
use dynamics_core::newton_euler::InverseDynamics;
use dynamics_core::safety::{self, SafeAction};
use dynamics_core::scene::Live;
use dynamics_core::trig::Trig;
use heapless::Deque;
use link::{DriveFaultReport, Frame, Hello, Pacing, Parts, Refusal, Value, Watch};
use requests::Requests;
use waiting::Change;

/// State of the session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// No matching hello has arrived yet: the drives perform the safe action and no tick runs.
    Waiting,
    /// Ticks run in a bench mode; the controller brakes if there is a fault.
    Bench(Pacing, Option<Fault>),
    /// Ticks run under the safety state machine, which is in this state.
    Supervised(Pacing, safety::State),
}

impl State {
    /// Returns the source of ticks; `None` if no tick runs.
    #[inline]
    #[must_use]
    pub const fn pacing(self) -> Option<Pacing> {
        match self {
            Self::Waiting => None,
            Self::Bench(pacing, _) | Self::Supervised(pacing, _) => Some(pacing),
        }
    }
}

/// The large buffers. On a chip they are in static RAM, so that they are never copied to the stack.
#[derive(Clone, Debug, Default)]
pub struct Buffers<const N: usize> {
    trajectory: Trajectory<N>,
    black_box: BlackBox<N>,
}

impl<const N: usize> Buffers<N> {
    /// Creates empty buffers.
    #[must_use]
    pub const fn new() -> Self {
        Self { trajectory: Trajectory::new(), black_box: BlackBox::new() }
    }

    /// Returns the buffered reference motion.
    #[must_use]
    pub const fn trajectory(&self) -> &Trajectory<N> {
        &self.trajectory
    }
}

/// The session's state machine. `B` holds the buffers, by value or as a reference.
#[derive(Clone)]
pub struct Session<const N: usize, A: ArmBuild<f32, N>, B = Buffers<N>> {
    own: Hello,
    pacing: Option<Pacing>,
    controller: Controller<f32, N, A>,
    supervisor: Supervisor<N, A::Settings>,
    safety: A::Settings,
    reference: Option<Reference<f32, N>>,
    measurement: Option<Measurement<f32, N>>,
    /// Tick number from the last measurement; the timer counts on from it.
    tick: u32,
    /// True if a measurement has arrived since the last tick.
    fresh: bool,
    /// Number of frames received since the hello, including lost ones.
    taken: u16,
    /// Answer of the last bench tick, until it is sent.
    answer: Option<Frame>,
    /// True if the last tick under supervision is still to be reported; the black box holds it.
    unsaid: bool,
    /// A change that waits for the next tick, while torque acts.
    change: Option<Change<N>>,
    /// Answers to changes that ticks have made or refused, until they are sent.
    changed: Deque<Result<Value, Refusal>, CHANGED_MAX>,
    /// Requests of the next tick, and the last verdicts.
    requests: Requests,
    /// Number of measurements that a host has sent since the hello, although the board uses its own sensors.
    foreign: u16,
    /// True if parameters may be changed, provided that the controller's configuration can be changed at all.
    tunable: bool,
    watch: Watch,
    /// Ticks until the next report.
    until: u16,
    /// Last report of the first joint with a fault. In the fault state a report stays until another replaces it.
    drive_fault: Option<DriveFaultReport>,
    buffers: B,
    /// Index of the next tick of the black box to be sent.
    past: Option<usize>,
    /// True if the last hello has ended a live session.
    left_live: bool,
    /// True if the last hello was refused because the arm is driven: only stop requests are accepted from its host.
    shut_out: bool,
}

/// Shows the state in which two sessions of one build can differ: without constants, and of the controller only its fault and live inputs.
impl<const N: usize, A: ArmBuild<f32, N>, B: Debug> Debug for Session<N, A, B>
where
    A::Settings: Debug,
{
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self {
            own: _,
            pacing,
            controller,
            supervisor,
            safety: _,
            reference,
            measurement,
            tick,
            fresh,
            taken,
            answer,
            unsaid,
            change,
            changed,
            requests,
            foreign,
            tunable,
            watch,
            until,
            drive_fault,
            buffers,
            past,
            left_live,
            shut_out,
        } = self;
        let live = controller.live();
        f.debug_struct("Session")
            .field("pacing", pacing)
            .field("fault", &controller.fault())
            .field("live", &(*live != Live::zero()).then_some(live))
            .field("supervisor", supervisor)
            .field("reference", reference)
            .field("measurement", measurement)
            .field("tick", tick)
            .field("fresh", fresh)
            .field("taken", taken)
            .field("answer", answer)
            .field("unsaid", unsaid)
            .field("change", change)
            .field("changed", changed)
            .field("requests", requests)
            .field("foreign", foreign)
            .field("tunable", tunable)
            .field("watch", watch)
            .field("until", until)
            .field("drive_fault", drive_fault)
            .field("buffers", buffers)
            .field("past", past)
            .field("left_live", left_live)
            .field("shut_out", shut_out)
            .finish()
    }
}

impl<const N: usize, D, T, C, P, K> Session<N, BuildOf<D, T, C, P, K>>
where
    D: InverseDynamics<f32, N> + Clone,
    T: Trig<f32> + Clone,
    C: Configuration<f32, N> + Clone,
    P: Protection<f32, N> + Clone,
    K: safety::SafetyConfiguration<f32, N> + Clone,
{
    /// Creates a session that waits for a hello that matches `own`.
    pub fn new(own: Hello, controller: ControllerOf<f32, N, D, T, C, P>, safety: K) -> Self {
        Self::with_buffers(own, controller.with_settings(), safety, Buffers::new())
    }
}

impl<const N: usize, A: ArmBuild<f32, N>, B: BorrowMut<Buffers<N>>> Session<N, A, B> {
    /// Creates a session that waits for a hello that matches `own`, with the given buffers.
    pub fn with_buffers(own: Hello, controller: Controller<f32, N, A>, safety: A::Settings, mut buffers: B) -> Self {
        buffers.borrow_mut().black_box.prepare();
        Self {
            own,
            pacing: None,
            controller,
            supervisor: Supervisor::new(safety.clone()),
            safety,
            reference: None,
            measurement: None,
            tick: 0,
            fresh: false,
            taken: 0,
            answer: None,
            unsaid: false,
            change: None,
            changed: Deque::new(),
            requests: Requests::NONE,
            foreign: 0,
            tunable: true,
            watch: QUIET,
            until: 0,
            drive_fault: None,
            buffers,
            past: None,
            left_live: false,
            shut_out: false,
        }
    }

    /// Sets whether parameters may be changed. For the desk, where the controller's configuration is always in RAM.
    #[must_use]
    pub fn with_tuning(self, tunable: bool) -> Self {
        Self { tunable, ..self }
    }

    /// Returns the state of the session.
    pub fn state(&self) -> State {
        match self.pacing {
            None => State::Waiting,
            Some(pacing) if pacing.is_supervised() => State::Supervised(pacing, self.supervisor.state()),
            Some(pacing) => State::Bench(pacing, self.controller.fault()),
        }
    }

    /// True if the joints' zeros have been confirmed, and nothing has put them in doubt since.
    pub fn homed(&self) -> bool {
        self.supervisor.homed()
    }

    /// True if the drives are driven.
    #[inline]
    pub fn is_live(&self) -> bool {
        self.pacing == Some(Pacing::Live)
    }

    /// Returns the safe action: the action of the drives while no torque is commanded.
    #[inline]
    pub fn safe_action(&self) -> SafeAction {
        safety::SafetyConfiguration::rules(&self.safety).safe_action
    }

    /// True if the host requests in this tick to clear a fault. The drives' latched errors must then be cleared first.
    #[inline]
    pub fn clears(&self) -> bool {
        self.is_live() && self.supervisor.inputs().request == Some(safety::Request::Clear)
    }

    /// Reports that the tick had not ended when the next one was due. The next tick raises the fault; the late tick must not drive.
    pub fn overrun(&mut self) {
        self.controller.overrun();
        self.supervisor.overrun();
    }

    /// Takes the readings of the board's joints and lines. Call it at the start of a tick. Has no effect in bench modes and dry runs, in which the
    /// host sends simulated readings.
    #[inline]
    pub fn sense(&mut self, readings: Option<&Readings<N>>, lines: &Lines) {
        if !self.is_live() {
            return;
        }
        self.supervisor.lines(lines);
        if let Some(readings) = readings {
            self.supervisor.sense(readings);
            self.remember(readings.drive_fault());
        }
    }

    /// Stores a joint's report. In the fault state a report stays, even if the drive no longer reports it.
    fn remember(&mut self, drive_fault: Option<DriveFaultReport>) {
        if drive_fault.is_some() || !matches!(self.supervisor.state(), safety::State::Fault(_)) {
            self.drive_fault = drive_fault;
        }
    }

    /// Returns stiffness and damping for the drives' own loops, in addition to the torques of this tick; `None` if the control law does not use
    /// these loops.
    #[inline]
    pub fn springs(&self) -> Option<[Spring<f32>; N]> {
        let config = self.controller.config();
        (config.law.traits().spring == SpringOwner::Drive).then(|| core::array::from_fn(|i| config.gains[i].spring()))
    }

    /// First part of a restart: resets the controller. No tick may run between the parts.
    pub fn forget_controller(&mut self) {
        self.controller.reset();
        *self.controller.live_mut() = Live::zero();
    }

    /// Second part of a restart: resets the safety state machine.
    pub fn forget_arm(&mut self) {
        self.supervisor.reset(self.safety.clone());
    }

    /// Last part of a restart: deletes frames and readings, and begins the session that the host's hello requests.
    pub fn begin(&mut self, theirs: &Hello) -> Outcome {
        (self.reference, self.measurement, self.fresh, self.taken, self.tick) = (None, None, false, 0, 0);
        (self.answer, self.unsaid, self.past, self.until, self.change) = (None, false, None, 0, None);
        (self.requests, self.foreign, self.drive_fault) = (Requests::NONE, 0, None);
        self.changed.clear();
        // If the last tick of a live session was late, no tick has judged that yet.
        let late = self.left_live && self.supervisor.inputs().overrun;
        self.supervisor.forget();
        if late {
            self.supervisor.overrun();
        }
        let Buffers { trajectory, black_box } = self.buffers.borrow_mut();
        trajectory.clear();
        // A black box that keeps a fault is not deleted, so that the next host can read it.
        black_box.restart(late);
        let agreed = Hello { pacing: self.own.pacing, ..*theirs } == self.own;
        self.pacing = agreed.then_some(theirs.pacing);
        if core::mem::take(&mut self.left_live) && !self.is_live() {
            // No tick drives any more, and in some modes no status would follow. This one reports that the drives perform the safe action.
            let status = Record::<N>::safe(self.safe_action()).status(Parts::TORQUE, &LiveContext::NONE);
            self.answer = Some(Frame::Status(status));
        }
        let answer = Hello { pacing: theirs.pacing, ..self.own };
        if !agreed {
            return Outcome::Stop(answer, Refusal::OtherRobot);
        }
        // In a dry run every tick is answered, as in bench modes.
        self.watch = if theirs.pacing == Pacing::DryRun { EVERYTHING } else { QUIET };
        Outcome::Start(answer)
    }
}

/// Capacity for answers to changes that wait to be sent. While it is full, another change is refused as [`Refusal::Busy`].
const CHANGED_MAX: usize = 4;

/// Reports nothing.
const QUIET: Watch = Watch { every: 0, parts: Parts::NONE };

/// Reports torque, reference and cost of each tick.
const EVERYTHING: Watch = Watch { every: 1, parts: Parts::TORQUE.and(Parts::REFERENCE).and(Parts::COST) };
