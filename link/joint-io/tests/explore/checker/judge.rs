//! The properties, judged from the simulated drives and the motion, never from the board's own estimate.

use super::event::Event;
use super::scene::{AGE_MAX, INERTIA, LOWERING_SPEED, PERIOD, Setup, WEIGHT, reports_state};
use super::world::World;
use dynamics_core::control::Fault;
use dynamics_core::safety::{self, SafeAction, State};
use joint_io::can::WEAK_MAX;
use link::{Answer, NumberedRequest, Request, Verdict};

/// A property of every period.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Brakes open only if every drive was actually on at the end of the previous period.
    BrakesOpenOnlyWhenAllDrivesAreOn,
    /// Brakes close at the latest [`off_max`] periods after a drive has gone off.
    BrakesCloseWhenADriveIsOff,
    /// After a hold that was received the arm does not run; after a stop it is in the fault state.
    StopWinsWithinOnePeriod,
    /// An arm does not count as homed if one of its drives may have restarted with another zero.
    HomingEndsWithTheZero,
    /// An arm runs only along points that were sent after the last fault, stop, disarming or homing.
    NoOldTrajectoryRuns,
    /// While torque is to act, no joint falls by more than [`fall_max`].
    NoJointFallsWhileArmed,
    /// Every request is answered exactly once; a repeated request gets the same answer again.
    EveryRequestIsAnsweredOnce,
    /// Of several requests for one period the one of highest rank is decided on (the first of equal ones), and all others are superseded.
    TheStrongestRequestWins,
    /// If the host is lost and the drives still receive the board, the brakes hold an arm with brakes, and an arm with a rest pose is released
    /// only there.
    NobodyFallsWithoutAHost,
    /// In the period in which the brakes open, the torque of every joint's drive is within [`JUMP_MAX`] of its weight.
    TorqueCarriesTheArmWhenBrakesOpen,
}

impl Rule {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::EveryRequestIsAnsweredOnce,
        Self::TheStrongestRequestWins,
        Self::NobodyFallsWithoutAHost,
        Self::BrakesOpenOnlyWhenAllDrivesAreOn,
        Self::BrakesCloseWhenADriveIsOff,
        Self::StopWinsWithinOnePeriod,
        Self::HomingEndsWithTheZero,
        Self::NoOldTrajectoryRuns,
        Self::NoJointFallsWhileArmed,
        Self::TorqueCarriesTheArmWhenBrakesOpen,
    ];

    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::EveryRequestIsAnsweredOnce => "every request is answered once",
            Self::TheStrongestRequestWins => "the strongest request wins",
            Self::NobodyFallsWithoutAHost => "nobody falls without a host",
            Self::BrakesOpenOnlyWhenAllDrivesAreOn => "brakes open only when all drives are on",
            Self::BrakesCloseWhenADriveIsOff => "brakes close when a drive is off",
            Self::StopWinsWithinOnePeriod => "stop wins within one period",
            Self::HomingEndsWithTheZero => "homing ends with the zero",
            Self::NoOldTrajectoryRuns => "no old trajectory runs",
            Self::NoJointFallsWhileArmed => "no joint falls while armed",
            Self::TorqueCarriesTheArmWhenBrakesOpen => "torque carries the arm when brakes open",
        }
    }

    const fn bit(self) -> u16 {
        1 << self as u16
    }
}

/// Largest number of periods for which brakes may stay open while a drive is off.
///
/// Replies may be missing for [`AGE_MAX`] periods, the next one is late by one period, and the brakes close in the period that finds the drive
/// off. If replies carry no state, torque must be missing in more than [`WEAK_MAX`] of them.
#[must_use]
pub const fn off_max(setup: &Setup) -> u8 {
    let replies = if reports_state(setup.language) { 0 } else { WEAK_MAX + 1 };
    replies + AGE_MAX as u8 + 2
}

/// Largest permitted fall of a joint while torque should act, rad: free fall for [`off_max`] periods from the operator's highest speed.
#[must_use]
pub fn fall_max(setup: &Setup) -> f64 {
    let time = PERIOD * f64::from(off_max(setup));
    time * (SPEED_MAX + 0.5 * time * WEIGHT / INERTIA)
}

/// Highest speed of the operator's motion, rad/s.
const SPEED_MAX: f64 = 0.25;

/// Largest position at which a joint counts as being at its rest pose, rad.
const REST_MAX: f64 = 0.006;

/// Largest difference between a drive's torque and the weight when brakes open, N m.
pub const JUMP_MAX: f64 = 1.0;

/// Number of periods with power after which a drive's changed zero must have ended the homing: its first reply is one period old, and may be late
/// or lost.
const SHIFTED_MAX: u8 = 4;

/// Rank of a hold request.
const HOLD: u8 = safety::Request::Hold.rank();

impl Asked {
    fn rank(&self) -> u8 {
        self.request.request.to_core().map_or(0, safety::Request::rank)
    }
}

/// Memory of the judge.
#[derive(Clone, Copy, Debug)]
pub struct Judge<const N: usize> {
    /// Rules that were broken, as bits.
    broken: u16,
    /// A trajectory was sent after the last fault, stop, disarming or homing.
    pub fresh_points: bool,
    /// Requests that were received since the last period.
    asked: [Option<Asked>; ASKED],
    /// Rank of the request that the board has made itself for the next period, because the host has changed.
    own: Option<u8>,
    /// True if there were more requests than `asked` can hold.
    overflow: bool,
    /// The last request that was received, and its verdict.
    last: Option<NumberedRequest>,
    verdict: Option<Verdict>,
    /// True if an event other than the host's absence has happened.
    disturbed: bool,
    /// True if the brakes were open in the previous period.
    was_open: bool,
    /// Drives that were on at the end of the previous period.
    was_on: [bool; N],
    /// Number of periods for which brakes have been open while a drive was off.
    off_for: [u8; N],
    /// Number of periods with power and with a zero that has moved since the operator set it.
    shifted: [u8; N],
    /// Position from which a joint falls without enough torque to carry it, rad.
    falls_from: [Option<f64>; N],
}

/// Capacity for requests of one period: those of the operator and of the events.
const ASKED: usize = 5;

/// A request that was received.
#[derive(Clone, Copy, Debug)]
struct Asked {
    request: NumberedRequest,
    /// Number of times that it was sent in this period.
    sent: u8,
    /// True if its verdict was sent in an earlier period.
    before: bool,
    /// The verdict, and how often it was sent.
    verdict: Option<Verdict>,
    answers: u8,
}

/// The board before and after a period.
#[derive(Clone, Copy, Debug)]
pub struct Period {
    /// State before.
    pub before: State,
    /// State after.
    pub after: State,
    /// True if the brakes are open.
    pub open: bool,
    /// True if the joints count as homed.
    pub homed: bool,
    /// True if the host is present.
    pub here: bool,
    /// True if every drive was on in the period. A late command may switch on a drive of some kinds at its end.
    pub all_on: bool,
}

impl<const N: usize> Judge<N> {
    /// Creates a judge with no broken rule.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            broken: 0,
            fresh_points: false,
            asked: [None; ASKED],
            own: None,
            overflow: false,
            last: None,
            verdict: None,
            disturbed: false,
            was_open: false,
            was_on: [false; N],
            off_for: [0; N],
            shifted: [0; N],
            falls_from: [None; N],
        }
    }

    /// True if the rule holds.
    #[must_use]
    pub const fn holds(&self, rule: Rule) -> bool {
        self.broken & rule.bit() == 0
    }

    /// True if every rule holds.
    #[must_use]
    pub const fn all_hold(&self) -> bool {
        self.broken == 0
    }

    fn demand(&mut self, rule: Rule, holds: bool) {
        if !holds {
            self.broken |= rule.bit();
        }
    }

    /// Records a received request.
    pub fn asked(&mut self, request: NumberedRequest) {
        if let Some(asked) = self.asked.iter_mut().flatten().find(|asked| asked.request == request) {
            asked.sent += 1;
            return;
        }
        let before = self.verdict.is_some() && self.last == Some(request);
        let verdict = if before { self.verdict } else { None };
        (self.last, self.verdict) = (Some(request), verdict);
        match self.asked.iter_mut().find(|place| place.is_none()) {
            Some(place) => *place = Some(Asked { request, sent: 1, before, verdict, answers: 0 }),
            None => self.overflow = true,
        }
    }

    /// Records a verdict that is sent to the host.
    pub fn answered(&mut self, answer: Answer) {
        if self.last.is_some_and(|last| last.number == answer.number) {
            self.verdict = Some(answer.verdict);
        }
        let asked = self.asked.iter_mut().flatten().find(|asked| asked.request.number == answer.number);
        let same = asked.is_some_and(|asked| {
            asked.answers += 1;
            asked.verdict.replace(answer.verdict).is_none_or(|verdict| verdict == answer.verdict)
        });
        self.demand(Rule::EveryRequestIsAnsweredOnce, same);
    }

    /// Begins a new session: requests of the old one no longer count, but one that stops the arm stays in force. A motion of the old host is held.
    /// `state` is the machine's before it.
    pub fn hello(&mut self, state: State) {
        let waits = self.asked.iter().flatten().filter(|asked| asked.verdict.is_none()).map(Asked::rank).max();
        let stops = waits.max(self.own).filter(|rank| *rank >= HOLD);
        let own = stops.or(matches!(state, State::Running | State::Arming).then_some(HOLD));
        // An arm without torque is as before the first host: nothing waits.
        self.own = own.filter(|_| state.has_or_awaits_torque());
        (self.asked, self.fresh_points, self.last, self.verdict) = ([None; ASKED], false, None, None);
    }

    /// Records an event.
    pub fn happened(&mut self, event: Event) {
        self.disturbed |= !matches!(event, Event::Away(_) | Event::Gone | Event::Hello | Event::LoseFrame(_));
    }

    fn judge_requests(&mut self, after: State) {
        let asked = core::mem::replace(&mut self.asked, [None; ASKED]);
        let new = || asked.iter().flatten().filter(|asked| !asked.before);
        // The board's own request was there first.
        let own = self.own.take();
        let strongest = new().map(Asked::rank).max().filter(|rank| own.is_none_or(|own| *rank > own));
        let first = new().position(|asked| Some(asked.rank()) == strongest);
        for (i, asked) in new().enumerate() {
            let wins = Some(i) == first;
            let superseded = asked.verdict == Some(Verdict::Superseded);
            self.demand(Rule::TheStrongestRequestWins, wins != superseded);
        }
        for asked in asked.iter().flatten() {
            // If it is sent again while it waits, it is answered once; after its verdict, it is answered again.
            self.demand(Rule::EveryRequestIsAnsweredOnce, asked.answers >= 1 && asked.answers <= asked.sent);
        }
        let received = |request| new().any(|asked| asked.request.request == request);
        let moves = matches!(after, State::Running | State::Lowering | State::Arming);
        self.demand(Rule::StopWinsWithinOnePeriod, !(received(Request::Hold) || own.is_some()) || !moves);
        self.demand(Rule::StopWinsWithinOnePeriod, !received(Request::Stop) || matches!(after, State::Fault(_)));
    }

    /// Judges a period at its end.
    pub fn judge(&mut self, setup: &Setup, world: &World<N>, period: &Period) {
        let Period { before, after, open, homed, here, all_on } = *period;
        let opened = core::mem::replace(&mut self.was_open, open);
        let brakes = setup.action == SafeAction::Brake;
        let opens = brakes && open && !opened;
        if opens {
            self.demand(Rule::BrakesOpenOnlyWhenAllDrivesAreOn, self.was_on.iter().all(|on| *on));
            let carried = world.axes.iter().all(|drive| {
                let over = drive.torque - WEIGHT;
                over <= JUMP_MAX && (over >= -JUMP_MAX || drive.q <= 0.0)
            });
            // Another rule covers a drive that goes off in this period.
            self.demand(Rule::TorqueCarriesTheArmWhenBrakesOpen, carried || !all_on);
        }
        self.judge_requests(after);
        let falls = before.has_torque() && after == State::Fault(Fault::HeartbeatLost) && !self.disturbed;
        let caught = if brakes { !open } else { !setup.rest || world.axes.iter().all(|axis| axis.q <= REST_MAX) };
        self.demand(Rule::NobodyFallsWithoutAHost, here || !falls || caught);
        let lowers = after == State::Lowering && !self.disturbed;
        let slow = world.axes.iter().all(|axis| axis.qd >= -2.0 * f64::from(LOWERING_SPEED));
        self.demand(Rule::NobodyFallsWithoutAHost, !lowers || slow);
        let runs = after == State::Running && before != State::Running;
        self.demand(Rule::NoOldTrajectoryRuns, !runs || self.fresh_points);
        let code = after.code();
        if code != before.code() && !after.drives() || matches!(after, State::Holding(_)) && before == State::Running {
            self.fresh_points = false;
        }
        let (free, off_max) = (open || !brakes, off_max(setup));
        for (i, drive) in world.axes.iter().enumerate() {
            self.was_on[i] = drive.is_on();
            let off = brakes && open && !drive.is_on();
            self.off_for[i] = if off { (self.off_for[i] + 1).min(off_max + 1) } else { 0 };
            self.demand(Rule::BrakesCloseWhenADriveIsOff, self.off_for[i] <= off_max);
            let shifted = drive.dark == 0 && drive.turns != 0;
            self.shifted[i] = if shifted { (self.shifted[i] + 1).min(SHIFTED_MAX + 1) } else { 0 };
            self.demand(Rule::HomingEndsWithTheZero, !homed || self.shifted[i] <= SHIFTED_MAX);
            let sinks = free && drive.qd < 0.0 && drive.torque < 0.5 * WEIGHT;
            self.falls_from[i] = if sinks { self.falls_from[i].or(Some(drive.q)) } else { None };
            let fallen = self.falls_from[i].map_or(0.0, |from| from - drive.q);
            self.demand(Rule::NoJointFallsWhileArmed, !after.drives() || fallen <= fall_max(setup));
        }
    }
}

impl<const N: usize> Default for Judge<N> {
    fn default() -> Self {
        Self::new()
    }
}
