//! One state, its events, and the step by one control period.

use super::digest;
use super::event::{DARK, Event, Step, TAIL};
use super::faulty::{Faulty, Mutant};
use super::host::{Host, Presence};
use super::judge::{Judge, Period};
use super::scene::{self, Lift, Numbers, Setup};
use super::world::{Brake, CommandFate, ReplyFate, Wire, World};
use core::borrow::{Borrow, BorrowMut};
use core::cell::Cell;
use core::fmt::Debug;
use dynamics_core::control::{BuildOf, Controller, Unprotected};
use dynamics_core::safety;
use dynamics_core::trig::Polynomial;
use joint_io::can::CanJoints;
use joint_io::can_bus::NoBus;
use joint_io::frames::Frames;
use link::codec::Received;
use link::{Answer, Cost, Frame, Hello, Pacing, Point, Request, Verdict};
use session::black_box::Report;
use session::meter::{Counter, Meter};
use session::readings::Lines;
use session::{Buffers, Reaction, Session};

/// The session's buffers. The black box is telemetry and not part of the hashed text.
#[derive(Clone)]
pub struct Kept<const N: usize>(Box<Buffers<N>>);

impl<const N: usize> Borrow<Buffers<N>> for Kept<N> {
    fn borrow(&self) -> &Buffers<N> {
        &self.0
    }
}

impl<const N: usize> BorrowMut<Buffers<N>> for Kept<N> {
    fn borrow_mut(&mut self) -> &mut Buffers<N> {
        &mut self.0
    }
}

impl<const N: usize> Debug for Kept<N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.0.trajectory().fmt(f)
    }
}

/// A counter that does not count.
#[derive(Clone, Copy, Debug)]
pub struct Uncounted;

impl Counter for Uncounted {
    fn now(&self) -> u32 {
        0
    }

    fn cost(count: u32) -> Cost {
        Cost::Instructions(count)
    }

    fn exercise(&self) {}
}

type Board<const N: usize> = Session<N, BuildOf<Lift, Polynomial, Numbers<N>, Unprotected, Numbers<N>>, Kept<N>>;

/// A state of the search: the board, its environment, and the judge.
#[derive(Clone)]
pub struct State<F, const N: usize> {
    /// The board's session.
    pub session: Board<N>,
    /// The board's drivers of the joints, with their bus and brakes.
    pub joints: CanJoints<F, Wire, NoBus, NoBus, Brake, N>,
    /// Drives and joints.
    pub world: World<N>,
    /// The operator.
    pub host: Host<N>,
    /// The judge.
    pub judge: Judge<N>,
    /// Number of events that may still happen.
    pub left: u8,
    /// Number of periods in which they may still happen, once the first has happened.
    pub within: u8,
    /// Used by mutants: the last request before this period, and the last start of a trajectory.
    withheld: Option<Frame>,
    old: Option<Point>,
    digest: u64,
}

impl<F: Frames + Clone + Debug, const N: usize> State<F, N> {
    /// Creates the board after power-up and a hello of the host.
    #[must_use]
    pub fn new(setup: &Setup, numbers: Numbers<N>) -> Self {
        let controller = Controller::new(numbers, Lift, Polynomial);
        let buffers = Kept(Box::new(Buffers::new()));
        let session = Session::with_buffers(scene::own(N as u8), controller.with_settings(), numbers, buffers);
        let drives = core::array::from_fn(|i| scene::drive(setup, i as u8));
        let mut state = Self {
            session,
            joints: CanJoints::new((Wire::default(), NoBus, NoBus), Brake::default(), drives),
            world: World::new(setup),
            host: Host::new(),
            judge: Judge::new(),
            left: setup.budget,
            within: setup.within.unwrap_or(u8::MAX),
            withheld: None,
            old: None,
            digest: 0,
        };
        state.hello(setup);
        state.digest();
        state
    }

    /// The machine's state; idle before a hello.
    pub fn machine(&self) -> safety::State {
        match self.session.state() {
            session::State::Supervised(_, state) => state,
            session::State::Waiting | session::State::Bench(..) => safety::State::Idle,
        }
    }

    fn digest(&mut self) {
        let Self { session, joints, world, host, judge, left, within, withheld, old, digest: _ } = &*self;
        self.digest = digest::of(&[session, joints, world, host, judge, left, within, withheld, old]);
    }

    /// The part of the state that determines all later transitions, as text.
    #[must_use]
    pub fn text(&self) -> String {
        let Self { session, joints, world, host, judge, left, .. } = self;
        digest::text(&(session, joints, world, host, judge, left))
    }

    fn hello(&mut self, setup: &Setup) {
        let hello = Frame::Hello(Hello { pacing: Pacing::Live, ..scene::own(N as u8) });
        let Host { number, seen, .. } = self.host;
        self.host = Host { number, seen, ..Host::new() };
        let before = self.machine();
        self.receive(setup, hello);
        self.judge.hello(before);
    }

    fn answered(&mut self, setup: &Setup, answer: Answer) {
        let times = match setup.mutant {
            Some(Mutant::NoAnswer) if answer.verdict == Verdict::Superseded => 0,
            Some(Mutant::TwoAnswers) => 2,
            _ => 1,
        };
        (0..times).for_each(|_| self.judge.answered(answer));
    }

    /// Receives a frame of the host.
    fn receive(&mut self, setup: &Setup, frame: Frame) {
        let start = matches!(&frame, Frame::Point(point) if point.ticks == 0);
        let keeps = setup.mutant == Some(Mutant::OldTrajectory);
        let point = if let (true, Frame::Point(point)) = (keeps, &frame) { Some(point.clone()) } else { None };
        let request = if let Frame::Request(request) = &frame { Some(*request) } else { None };
        let missed = core::mem::take(&mut self.host.owed);
        let reaction = match (setup.mutant, &frame) {
            // The session forgets a request of higher rank only with a new session. So this mutant withholds the request until the period begins.
            (Some(Mutant::LastRequestWins), Frame::Request(_)) => {
                self.withheld = Some(frame);
                Reaction::None
            }
            _ => self.session.receive(Ok(Received { frame, missed: missed.into() })),
        };
        let lost = matches!(reaction, Reaction::Reply(Frame::Refusal(link::Refusal::Lost { .. })));
        // After lost packets a request is refused, and the board reports that; stops are always accepted.
        if let Some(request) = request
            && (!lost || matches!(request.request, Request::Hold | Request::Stop))
        {
            self.host.arrived |= request.number == self.host.number;
            self.judge.asked(request);
        }
        match reaction {
            Reaction::None if start => {
                self.judge.fresh_points = true;
                self.old = point;
            }
            Reaction::Reply(Frame::Answer(answer)) => self.answered(setup, answer),
            _ => {}
        }
    }

    /// Mutant: resumes the trajectory that has ended.
    fn revive(&mut self) {
        if let (Some(point), None) = (&self.old, self.session.way_from()) {
            let frame = Frame::Point(point.clone());
            self.session.receive(Ok(Received { frame, missed: 0 }));
        }
    }

    /// Collects the possible events.
    pub fn events(&self, setup: &Setup, events: &mut Vec<Step>) {
        let kinds = &setup.events;
        let mut add = |event| events.push(Step::Event(event));
        for (i, drive) in (0_u8..).zip(&self.world.axes) {
            if kinds.frames && drive.command == CommandFate::Arrives {
                for fate in [CommandFate::Refused, CommandFate::Lost, CommandFate::Late, CommandFate::Twice] {
                    add(Event::Command(i, fate));
                }
            }
            if kinds.frames && drive.reply == ReplyFate::Arrives {
                for fate in [ReplyFate::Lost, ReplyFate::Late, ReplyFate::Twice] {
                    add(Event::Reply(i, fate));
                }
            }
            if kinds.drives && drive.dark == 0 {
                for dark in DARK {
                    add(Event::Dark(i, dark));
                }
                if drive.electronics.is_enabled() {
                    add(Event::Trip(i));
                }
                if drive.electronics.error == 0 && super::scene::reports_errors(setup.language) {
                    add(Event::DriveError(i));
                }
            }
        }
        if kinds.frames && self.world.bus_off == 0 {
            add(Event::BusOff);
        }
        if kinds.host && !self.world.late {
            add(Event::Overrun);
        }
        if kinds.drives && self.world.stop == 0 {
            add(Event::EmergencyStop);
            for dark in DARK {
                add(Event::Cut(dark));
            }
        }
        if kinds.requests && self.host.presence == Presence::Here {
            Request::OF_THE_MACHINE.into_iter().for_each(|request| add(Event::Ask(request)));
            if self.host.last.is_some() {
                add(Event::Repeat);
            }
        }
        if kinds.host {
            if self.host.presence == Presence::Here {
                if self.host.lose.is_none() {
                    (0..3).for_each(|n| add(Event::LoseFrame(n)));
                }
                add(Event::Away(5));
                add(Event::Gone);
            }
            add(Event::Hello);
        }
    }

    /// The next state.
    #[must_use]
    pub fn next(&self, setup: &Setup, meter: &Meter<Uncounted>, step: Step) -> Self {
        let mut next = self.clone();
        match step {
            Step::Tick => {
                next.tick(setup, meter);
                next.pass(setup);
            }
            Step::Tail => {
                for _ in 0..TAIL {
                    next.tick(setup, meter);
                    if !next.judge.all_hold() {
                        break;
                    }
                }
            }
            Step::Event(event) => {
                next.left -= 1;
                next.happen(setup, event);
            }
        }
        next.digest();
        next
    }

    /// Counts the periods after the first event in which others may happen.
    fn pass(&mut self, setup: &Setup) {
        if setup.within.is_none() || self.left == setup.budget {
            return;
        }
        match self.within.checked_sub(1) {
            Some(within) => self.within = within,
            None => self.left = 0,
        }
        if self.left == 0 {
            // No event is left, so nothing depends on the count.
            self.within = 0;
        }
    }

    fn happen(&mut self, setup: &Setup, event: Event) {
        self.judge.happened(event);
        let drives = &mut self.world.axes;
        match event {
            Event::Command(i, fate) => drives[usize::from(i)].command = fate,
            Event::Reply(i, fate) => drives[usize::from(i)].reply = fate,
            Event::BusOff => self.world.bus_off = 2,
            Event::Dark(i, periods) => drives[usize::from(i)].dark = periods,
            Event::Cut(periods) => {
                self.world.stop = periods;
                for drive in drives {
                    drive.dark = drive.dark.max(periods);
                }
            }
            Event::EmergencyStop => self.world.stop = 1,
            Event::Overrun => self.world.late = true,
            Event::Trip(i) => drives[usize::from(i)].trip(),
            Event::DriveError(i) => drives[usize::from(i)].electronics.error = 0xc,
            Event::Ask(request) => {
                let frame = self.host.request(request);
                self.receive(setup, frame);
            }
            Event::Repeat => {
                if let Some(frame) = self.host.again() {
                    self.receive(setup, frame);
                }
            }
            Event::LoseFrame(n) => self.host.lose = Some(n),
            Event::Away(periods) => self.host.presence = Presence::Away(periods),
            Event::Gone => self.host.presence = Presence::Gone,
            Event::Hello => self.hello(setup),
        }
    }

    /// Runs one control period as the firmware's interrupt does, then simulates drives and joints, and lets the host react.
    fn tick(&mut self, setup: &Setup, meter: &Meter<Uncounted>) {
        let before = self.machine();
        self.world.prepare(self.joints.buses().0);
        if let Some(frame) = self.withheld.take() {
            self.session.receive(Ok(Received { frame, missed: 0 }));
        }
        if setup.mutant == Some(Mutant::OldTrajectory) {
            self.revive();
        }
        let lines = Lines { emergency_stop: self.world.stop > 0, ..Lines::NONE };
        // The tick becomes late only after the outputs, so that they act.
        let (late, asked) = (self.world.late, Cell::new(false));
        let mut joints = Faulty { joints: &mut self.joints, mutant: setup.mutant };
        joint_io::run_tick(&mut self.session, &mut joints, meter, || lines, || late && asked.replace(true));
        while let Some(report) = self.session.say() {
            if let Report::Answer(Frame::Answer(answer)) = report {
                self.answered(setup, answer);
            }
        }
        let at_once = setup.mutant == Some(Mutant::BlindToDrives) && self.machine().drives();
        let open = self.joints.brake().0 || at_once;
        let free = open || setup.action != safety::SafeAction::Brake;
        let all_on = self.world.step(self.joints.buses().0, free);
        let here = self.host.presence == Presence::Here;
        let period = Period { before, after: self.machine(), open, homed: self.session.homed(), here, all_on };
        self.judge.judge(setup, &self.world, &period);
        self.world.end(setup);
        if period.after == safety::State::Homing && self.host.presence == Presence::Here {
            self.world.set_zeros();
        }
        self.host.seen = self.world.shown().map(|q| q as f32);
        self.ask(setup, period.after, period.homed);
    }

    /// Sends the operator's frames for the next period.
    fn ask(&mut self, setup: &Setup, state: safety::State, homed: bool) {
        let frames = self.host.frames(state, homed);
        let lost = if frames.is_empty() { None } else { self.host.lose.take() };
        for (i, frame) in (0..).zip(frames) {
            if lost == Some(i) {
                self.host.owed += 1;
            } else {
                self.receive(setup, frame);
            }
        }
    }
}

impl<F, const N: usize> PartialEq for State<F, N> {
    fn eq(&self, other: &Self) -> bool {
        self.digest == other.digest
    }
}

impl<F, const N: usize> core::hash::Hash for State<F, N> {
    fn hash<H: core::hash::Hasher>(&self, hasher: &mut H) {
        hasher.write_u64(self.digest);
    }
}

impl<F, const N: usize> Debug for State<F, N> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "State({:016x})", self.digest)
    }
}
