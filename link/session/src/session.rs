//! From frames to ticks to frames: between the link, the controller, and the safety state machine around it.
//!
//! ```text
//!            hello agrees, on the bench    measurement (lock step) or timer
//! waiting ----------------------------> bench ------------------------------> command or fault
//!    ^  \                                 |
//!    |   \   hello agrees, supervised     |  hello (any state)
//!    |    `----------------------> supervised ------------------------------> status
//!    +------------------------------------+
//!       hello for another robot
//! ```
//!
//! A hello always starts afresh: the controller is reset, reference, trajectory and measurement are forgotten, every live input is
//! zero, ticks are counted from 1, and the safety state machine idles, not homed. On the bench the controller stands alone and no
//! drive is driven; its faults stay until the next hello. Supervised, [`Supervisor`] decides in every tick what the drives do.
//!
//! Live inputs and parameters come between ticks and hold from the next one on. Where torque acts they hold from the one after: the
//! next tick computes its torque twice, with the old and with the new, and where a joint's would change by more than it may in a
//! tick ([`JUMP`] of its limit where nothing says how much that is), it refuses. Live inputs are answered only when they are refused.

use crate::black_box::{BlackBox, Report};
use crate::readings::{Lines, Readings};
use crate::meter::{Counter, Meter};
use crate::parameters;
use crate::supervisor::Supervisor;
use crate::trajectory::{NotTaken, Trajectory};
use core::borrow::BorrowMut;
use dynamics_core::control::{
    Command, Configuration, Controller, ControllerConfig, Fault, LimitFlags, Measurement, Protection, Reference,
    Unprotected,
};
use dynamics_core::newton_euler::InverseDynamics;
use dynamics_core::safety::{self, Actuation, SafeAction};
use dynamics_core::scene::Live;
use dynamics_core::trig::Trig;
use link::codec::Received;
use link::{Cost, DecodeError, Frame, Hello, Pacing, Parts, Refusal, Request, Setting, TickCost, Watch};

/// What the session is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// No hello has agreed yet: the arm is braked and no tick runs.
    Waiting,
    /// Ticks run on the bench; the controller brakes where there is a fault.
    Bench(Pacing, Option<Fault>),
    /// Ticks run under the safety state machine, which does this.
    Supervised(Pacing, safety::State),
}

impl State {
    /// What starts ticks, if any run.
    #[inline]
    #[must_use]
    pub const fn pacing(self) -> Option<Pacing> {
        match self {
            Self::Waiting => None,
            Self::Bench(pacing, _) | Self::Supervised(pacing, _) => Some(pacing),
        }
    }
}

/// What a received frame asks for.
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
    /// Run one tick now.
    Tick,
}

/// What a tick asks of the drives.
#[derive(Clone, Copy, Debug, PartialEq)]
// A tag of a word: behind a byte, copies of the rest start at odd addresses, at three times the instructions.
#[repr(u32)]
pub enum Drives<const N: usize> {
    /// These torques or forces, N m or N.
    Drive([f32; N]),
    /// The safe action.
    Safe(SafeAction),
}

/// Share of a joint's torque limit that its torque may change by at once where no torque rate is given.
pub const JUMP: f32 = 0.02;

/// A change that waits for its tick.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Change<const N: usize> {
    Live(Live<f32, N>),
    Parameter(Setting),
}

impl<const N: usize> Change<N> {
    fn make<D, T, C, P>(&self, controller: &mut Controller<f32, N, D, T, C, P>)
    where
        D: InverseDynamics<f32, N>,
        T: Trig<f32>,
        C: Configuration<f32, N>,
        P: Protection<f32, N>,
    {
        match self {
            Self::Live(live) => *controller.live_mut() = *live,
            Self::Parameter(setting) => {
                if let Some(config) = controller.config_mut() {
                    parameters::set(*setting, config);
                }
            }
        }
    }
}

/// What is large: kept where a chip has room, so that it never goes over a stack.
#[derive(Clone, Debug, Default)]
pub struct Buffers<const N: usize> {
    trajectory: Trajectory<N>,
    black_box: BlackBox<N>,
}

impl<const N: usize> Buffers<N> {
    /// Empty.
    #[must_use]
    pub const fn new() -> Self {
        Self { trajectory: Trajectory::new(), black_box: BlackBox::new() }
    }
}

/// The state machine. `B` has the buffers: they themselves, or a reference to them.
pub struct Session<const N: usize, D, T, K, C = ControllerConfig<f32, N>, P = Unprotected, B = Buffers<N>> {
    own: Hello,
    pacing: Option<Pacing>,
    controller: Controller<f32, N, D, T, C, P>,
    supervisor: Supervisor<N, K>,
    safety: K,
    reference: Option<Reference<f32, N>>,
    measurement: Option<Measurement<f32, N>>,
    /// The number that the last measurement gave to its tick; the timer counts on from it.
    tick: u32,
    /// A measurement has come since the last tick.
    fresh: bool,
    /// Frames taken since the hello.
    taken: u16,
    /// What the last bench tick answered, until it is sent.
    answer: Option<Frame>,
    /// The last tick under supervision, which the black box has, is still to be sent.
    unsaid: bool,
    /// What waits for the next tick, while torque acts.
    change: Option<Change<N>>,
    /// Whether parameters may be changed where the controller's configuration can be.
    tunable: bool,
    watch: Watch,
    /// Ticks until the next report.
    until: u16,
    buffers: B,
    /// The next tick of the black box to be sent.
    past: Option<usize>,
}

impl<const N: usize, D, T, K, C, P> Session<N, D, T, K, C, P>
where
    D: InverseDynamics<f32, N> + Clone,
    T: Trig<f32> + Clone,
    K: safety::Configuration<f32, N> + Clone,
    C: Configuration<f32, N> + Clone,
    P: Protection<f32, N> + Clone,
{
    /// A session that waits for a hello like `own`.
    pub fn new(own: Hello, controller: Controller<f32, N, D, T, C, P>, safety: K) -> Self {
        Self::with_buffers(own, controller, safety, Buffers::new())
    }
}

impl<const N: usize, D, T, K, C, P, B> Session<N, D, T, K, C, P, B>
where
    B: BorrowMut<Buffers<N>>,
    D: InverseDynamics<f32, N> + Clone,
    T: Trig<f32> + Clone,
    K: safety::Configuration<f32, N> + Clone,
    C: Configuration<f32, N> + Clone,
    P: Protection<f32, N> + Clone,
{
    /// A session that waits for a hello like `own`, with its buffers elsewhere.
    pub fn with_buffers(own: Hello, controller: Controller<f32, N, D, T, C, P>, safety: K, buffers: B) -> Self {
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
            tunable: true,
            watch: QUIET,
            until: 0,
            buffers,
            past: None,
        }
    }

    /// The same, with parameters fixed or not: for a desk, whose configuration can always be changed.
    #[must_use]
    pub fn with_tuning(self, tunable: bool) -> Self {
        Self { tunable, ..self }
    }

    /// What the session is doing.
    pub fn state(&self) -> State {
        match self.pacing {
            None => State::Waiting,
            Some(pacing) if pacing.is_supervised() => State::Supervised(pacing, self.supervisor.state()),
            Some(pacing) => State::Bench(pacing, self.controller.fault()),
        }
    }

    /// Whether the drives are driven.
    #[inline]
    pub fn is_live(&self) -> bool {
        self.pacing == Some(Pacing::Live)
    }

    /// What the drives do when no torque is commanded.
    #[inline]
    pub fn safe_action(&self) -> SafeAction {
        self.safety.rules().safe_action
    }

    /// Take what the link received.
    pub fn receive(&mut self, received: Result<Received, DecodeError>) -> Reaction {
        let received = match received {
            Ok(received) => received,
            Err(error) => return refuse(Refusal::Undecodable(error)),
        };
        self.taken = self.taken.wrapping_add(1);
        // Whatever was lost before it: a stop must not wait for the host to notice.
        let stops = matches!(received.frame, Frame::Request(Request::Hold));
        if received.missed > 0 && !stops {
            return refuse(Refusal::Lost { missed: received.missed });
        }
        if let Frame::Hello(theirs) = received.frame {
            return self.hello(theirs);
        }
        let Some(pacing) = self.pacing else { return refuse(Refusal::NoHello) };
        if pacing.is_supervised() {
            self.supervisor.heard();
        }
        let reaction = match received.frame {
            Frame::Measurement(measurement) => self.measured(pacing, &measurement),
            Frame::Live(live) => self.live(pacing, &live),
            frame if pacing.is_supervised() => self.supervised(pacing, &frame),
            Frame::Reference(reference) => reference.to_core().map_err(Refusal::from).map(|reference| {
                self.reference = Some(reference);
                Reaction::None
            }),
            _ => Err(Refusal::Unexpected),
        };
        reaction.unwrap_or_else(refuse)
    }

    /// A frame that means something under supervision alone.
    fn supervised(&mut self, pacing: Pacing, frame: &Frame) -> Result<Reaction, Refusal> {
        match frame {
            Frame::Alive => {}
            Frame::Request(request) => self.supervisor.request(request.to_core()),
            Frame::Point(point) => {
                let trajectory = &mut self.buffers.borrow_mut().trajectory;
                self.supervisor.point(trajectory, point.ticks, &point.reference.to_core()?)?;
            }
            Frame::Watch(watch) => (self.watch, self.until) = (*watch, 0),
            Frame::Dump => self.past = Some(0),
            Frame::Get(index) => return self.value(*index).map(Reaction::Reply),
            Frame::Set(setting) => return self.set(*setting),
            Frame::Lines(lines) if pacing == Pacing::Drill => {
                let link::Lines { emergency_stop, overrun, zeroed, drive_fault, supply, temperature } = *lines;
                self.supervisor.lines(&Lines { emergency_stop, supply, temperature });
                self.supervisor.drives_say(core::array::from_fn(|i| drive_fault >> i & 1 == 1), zeroed);
                if overrun {
                    self.supervisor.overrun();
                }
            }
            _ => return Err(Refusal::Unexpected),
        }
        Ok(Reaction::None)
    }

    fn measured(&mut self, pacing: Pacing, measurement: &link::Measurement) -> Result<Reaction, Refusal> {
        let values = measurement.to_core()?;
        (self.tick, self.fresh) = (measurement.tick, true);
        if pacing.is_supervised() {
            self.supervisor.measured(&values);
        }
        self.measurement = Some(values);
        Ok(match pacing {
            Pacing::Timer | Pacing::Live => Reaction::None,
            Pacing::LockStep if self.reference.is_none() => return Err(Refusal::NoReference),
            Pacing::LockStep | Pacing::Drill => Reaction::Tick,
        })
    }

    fn live(&mut self, pacing: Pacing, live: &link::Live) -> Result<Reaction, Refusal> {
        let values = live.to_core()?;
        if !live.is_finite() {
            return Err(Refusal::NonFiniteLive);
        }
        parameters::check_live(&values, &self.safety.rules().payload)?;
        let change = Change::Live(values);
        if pacing.is_supervised() {
            self.change(change)?;
        } else {
            change.make(&mut self.controller);
        }
        Ok(Reaction::None)
    }

    /// Make a change at once where no torque acts, else in the next tick; whether it is made.
    fn change(&mut self, change: Change<N>) -> Result<bool, Refusal> {
        if !self.supervisor.state().drives() {
            change.make(&mut self.controller);
            return Ok(true);
        }
        if self.change.is_some() {
            return Err(Refusal::Busy);
        }
        self.change = Some(change);
        Ok(false)
    }

    fn value(&mut self, index: u8) -> Result<Frame, Refusal> {
        let tunable = self.is_tunable();
        let (built_in, payload) = (self.safety.get(), &self.safety.rules().payload);
        let (config, live) = (self.controller.config(), self.controller.live());
        parameters::read(index, config, built_in, live, payload, tunable).map(Frame::Value)
    }

    fn set(&mut self, setting: Setting) -> Result<Reaction, Refusal> {
        let tunable = self.is_tunable();
        let payload = &self.safety.rules().payload;
        parameters::check(setting, self.safety.get(), self.controller.live(), payload, tunable)?;
        Ok(match self.change(Change::Parameter(setting))? {
            true => Reaction::Reply(self.value(setting.index)?),
            // Answered by the tick that makes it.
            false => Reaction::None,
        })
    }

    fn is_tunable(&mut self) -> bool {
        self.tunable && self.controller.config_mut().is_some()
    }

    /// One tick: what the drives do. What is to be said of it waits in [`Session::say`].
    ///
    /// The bench's cost is that of the controller alone. Nothing is said while the session waits, or while the timer already runs on
    /// the bench but reference or measurement has not come yet.
    #[inline]
    pub fn tick<M: Counter>(&mut self, meter: &Meter<M>) -> Drives<N> {
        let safe = Drives::Safe(self.safe_action());
        let Some(pacing) = self.pacing else { return safe };
        if !core::mem::take(&mut self.fresh) {
            self.tick = self.tick.wrapping_add(1);
            if let Some(measurement) = &mut self.measurement {
                measurement.age_ticks = measurement.age_ticks.saturating_add(1);
            }
        }
        if pacing.is_supervised() {
            return self.supervise(pacing, meter);
        }
        if let (Some(reference), Some(measurement)) = (&self.reference, &self.measurement) {
            let (command, cost) = control(&mut self.controller, meter, false, reference, measurement);
            self.answer = Some(Frame::answer(self.tick, &command, cost));
        }
        safe
    }

    /// A tick under supervision.
    #[inline]
    fn supervise<M: Counter>(&mut self, pacing: Pacing, meter: &Meter<M>) -> Drives<N> {
        let change = self.change.take();
        let Self { controller, supervisor, .. } = self;
        let (mut alone, mut jumps) = (None, None);
        let (output, all) = meter.measure(|| {
            supervisor.tick(|ask| {
                let trial = change.map(|change| {
                    let mut trial = controller.clone();
                    change.make(&mut trial);
                    trial
                });
                let (command, cost) = control(controller, meter, ask.start, ask.reference, ask.measurement);
                if let Some(mut trial) = trial {
                    let (other, _) = control(&mut trial, meter, ask.start, ask.reference, ask.measurement);
                    jumps = jump(&command, &other, controller.config());
                }
                alone = cost;
                command
            })
        });
        let cost = all.map(|all: Cost| TickCost { all, controller: alone });
        let (tick, taken) = (self.tick, self.taken);
        let Buffers { trajectory, black_box } = self.buffers.borrow_mut();
        if let Some(record) = black_box.begin() {
            // One part after the other: made as a whole it would be copied once more.
            (record.tick, record.taken, record.cost) = (tick, taken, cost);
            record.inputs = *supervisor.inputs();
            record.output = output;
        }
        supervisor.age(trajectory);
        self.unsaid = true;
        if let Some(change) = change {
            self.settle(&change, jumps);
        }
        match output.actuation {
            // In a drill nothing is driven but what the host plays.
            Actuation::Drive { torque, .. } if pacing == Pacing::Live => Drives::Drive(torque),
            Actuation::Drive { .. } => Drives::Safe(self.safe_action()),
            Actuation::Safe(action) => Drives::Safe(action),
        }
    }

    /// Make a change that waited, or refuse it.
    #[cold]
    fn settle(&mut self, change: &Change<N>, jumps: Option<u8>) {
        self.answer = match (jumps, change) {
            (Some(joint), _) => Some(Frame::Refusal(Refusal::WouldJump { joint })),
            (None, change) => {
                change.make(&mut self.controller);
                match change {
                    Change::Live(_) => None,
                    Change::Parameter(setting) => self.value(setting.index).ok(),
                }
            }
        };
    }

    /// What is to be said now, one report at a time; `None` when that is all. Only copies: the frame is made outside the lock.
    ///
    /// The black box comes behind what else is to be said.
    pub fn say(&mut self) -> Option<Report<N>> {
        if let Some(answer) = self.answer.take() {
            return Some(Report::Answer(answer));
        }
        if core::mem::take(&mut self.unsaid)
            && let Some(parts) = self.is_due()
        {
            let room = u8::try_from(self.buffers.borrow().trajectory.room()).unwrap_or(u8::MAX);
            return Some(Report::Tick(*self.buffers.borrow().black_box.now(), parts, room));
        }
        let place = self.past?;
        let past = self.buffers.borrow().black_box.get(place).copied();
        self.past = past.is_some().then_some(place + 1);
        Some(Report::Past(past))
    }

    /// Whether the black box is being sent: [`Session::say`] has more to say without another tick.
    #[must_use]
    pub fn dumps(&self) -> bool {
        self.past.is_some()
    }

    /// The parts of the last tick that are to be reported, if any are.
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

    /// The tick had not ended when the next was due: the next one says the fault, and this one must not drive.
    pub fn overrun(&mut self) {
        self.controller.overrun();
        self.supervisor.overrun();
    }

    /// Take what the board's own lines and joints say. Call it at the start of a tick. On the bench and in a drill the host plays them.
    #[inline]
    pub fn sense(&mut self, readings: Option<&Readings<N>>, lines: &Lines) {
        if !self.is_live() {
            return;
        }
        self.supervisor.lines(lines);
        if let Some(readings) = readings {
            self.supervisor.sense(readings);
        }
    }

    fn hello(&mut self, theirs: Hello) -> Reaction {
        self.controller.reset();
        *self.controller.live_mut() = Live::zero();
        self.supervisor.reset(self.safety.clone());
        (self.reference, self.measurement, self.fresh, self.taken, self.tick) = (None, None, false, 0, 0);
        (self.answer, self.unsaid, self.past, self.until, self.change) = (None, false, None, 0, None);
        let Buffers { trajectory, black_box } = self.buffers.borrow_mut();
        trajectory.clear();
        black_box.clear();
        let answer = Frame::Hello(Hello { pacing: theirs.pacing, ..self.own });
        if (Hello { pacing: self.own.pacing, ..theirs }) != self.own {
            self.pacing = None;
            return Reaction::Stop(answer, Frame::Refusal(Refusal::OtherRobot));
        }
        self.pacing = Some(theirs.pacing);
        // In a drill every tick is answered, as on the bench.
        self.watch = if theirs.pacing == Pacing::Drill { EVERYTHING } else { QUIET };
        Reaction::Start(theirs.pacing, answer)
    }
}

/// Report nothing.
const QUIET: Watch = Watch { every: 0, parts: Parts::NONE };

/// Report what each tick did.
const EVERYTHING: Watch = Watch { every: 1, parts: Parts::TORQUE.and(Parts::REFERENCE).and(Parts::COST) };

/// The controller's tick, and what it cost alone. Out of line, so that bench and supervision share one copy of it.
#[inline(never)]
fn control<const N: usize, D, T, C, P, M>(
    controller: &mut Controller<f32, N, D, T, C, P>,
    meter: &Meter<M>,
    start: bool,
    reference: &Reference<f32, N>,
    measurement: &Measurement<f32, N>,
) -> (Command<f32, N>, Option<Cost>)
where
    D: InverseDynamics<f32, N>,
    T: Trig<f32>,
    C: Configuration<f32, N>,
    P: Protection<f32, N>,
    M: Counter,
{
    if start {
        controller.reset();
    }
    meter.measure(|| controller.tick(reference, measurement))
}

/// The first joint whose torque would change at once by more than it may, if there is one. Where only one of both commands is held by
/// a limit, the other's torque says nothing of how far apart they are.
#[cold]
fn jump<const N: usize>(
    now: &Command<f32, N>,
    then: &Command<f32, N>,
    config: &ControllerConfig<f32, N>,
) -> Option<u8> {
    let (Command::Drive { torque, limits }, Command::Drive { torque: other, limits: others }) = (now, then) else {
        return Some(0);
    };
    let held = LimitFlags::TORQUE | LimitFlags::TORQUE_RATE;
    let jumps = |i: usize| {
        let share = JUMP * config.limits[i].torque;
        let most = if config.torque_step[i].is_finite() { config.torque_step[i] } else { share };
        let near = (torque[i] - other[i]).abs() <= most;
        !near || limits[i].bits() & held.bits() != others[i].bits() & held.bits()
    };
    (0..N).find(|&i| jumps(i)).map(|joint| joint as u8)
}

fn refuse(refusal: Refusal) -> Reaction {
    Reaction::Reply(Frame::Refusal(refusal))
}

impl From<NotTaken> for Refusal {
    fn from(not_taken: NotTaken) -> Self {
        match not_taken {
            NotTaken::NonFinite => Self::NonFinitePoint,
            NotTaken::Full => Self::TrajectoryFull,
            NotTaken::NoStart => Self::NoStart,
            NotTaken::Running => Self::Running,
        }
    }
}
