//! Tests of the session under supervision: requests of a host, actions of the drives, and reports.

use super::{Build, Looks, OWN, UnitMasses, config, protected, soft};
use dynamics_core::Inertia;
use dynamics_core::control::{Controller, ControllerConfig, Fault, Measurement, Reference, Sensed};
use dynamics_core::safety::heat::HeatRules;
use dynamics_core::safety::{self, HoldCause, Protected, SafeAction};
use dynamics_core::trig::Polynomial;
use link::codec::Received;
use link::{
    Actuation, Cost, Denial, Frame, Hello, Pacing, Parts, Point, Refusal, Request, Setting, StateCode, Status, Value,
    Watch,
};
use newtau_session::black_box::{Report, TICKS, TICKS_AFTER};
use newtau_session::meter::Meter;
use newtau_session::parameters::{HEAT, LAW};
use newtau_session::readings::Lines;
use newtau_session::readings::{JointFaults, Readings};
use newtau_session::{Drives, Reaction, Session, State};
use std::cell::Cell;

fn refused(refusal: Refusal) -> Reaction {
    Reaction::Reply(Frame::Refusal(refusal))
}

const SAFE: Drives<2> = Drives::Safe(SafeAction::DampedStop);

/// A session with a host that sends a heartbeat before every tick.
pub(super) struct Arm {
    pub(super) session: Session<2, Build>,
    pub(super) meter: Meter<Looks>,
    pub(super) q: [f32; 2],
    pub(super) qd: [f32; 2],
    pub(super) faults: [JointFaults; 2],
    pub(super) errors: [u8; 2],
    pub(super) age_ticks: [u32; 2],
    pub(super) lines: Lines,
    pub(super) heard: bool,
    pub(super) on: [bool; 2],
    pub(super) zero_lost: bool,
    /// Number of the last request.
    pub(super) number: u8,
}

impl Arm {
    pub(super) fn live() -> Self {
        Self::with(config(), true)
    }

    pub(super) fn with(config: ControllerConfig<f32, 2>, tunable: bool) -> Self {
        Self::with_rules(config, tunable, protected())
    }

    fn with_rules(config: ControllerConfig<f32, 2>, tunable: bool, protected: Protected<f32, 2>) -> Self {
        let controller = Controller::new(config, UnitMasses, Polynomial);
        let protected = Protected { control: config, ..protected };
        let mut arm = Self {
            session: Session::new(OWN, controller, protected).with_tuning(tunable),
            meter: Meter::new(Looks(Cell::new(0))),
            q: [0.1, 0.2],
            qd: [0.0; 2],
            faults: [JointFaults::NONE; 2],
            errors: [0; 2],
            age_ticks: [0; 2],
            lines: Lines::NONE,
            heard: true,
            on: [true; 2],
            zero_lost: false,
            number: 0,
        };
        let hello = Hello { pacing: Pacing::Live, ..OWN };
        assert_eq!(arm.receive(Frame::Hello(hello)), Reaction::Start(Pacing::Live, Frame::Hello(hello)));
        arm
    }

    /// An arm that is homed and holds its position by torque.
    pub(super) fn armed() -> Self {
        Self::live().arm()
    }

    pub(super) fn arm(mut self) -> Self {
        let arm = &mut self;
        assert_eq!(arm.asked(Request::Home), SAFE);
        assert_eq!(arm.asked(Request::Confirm), SAFE);
        assert_eq!(arm.asked(Request::Arm), Drives::Drive([0.0; 2]));
        assert_eq!(arm.state(), safety::State::Armed);
        self
    }

    /// An arm on a motion to 0.1 rad further in 100 ticks, and back.
    pub(super) fn running() -> Self {
        let mut arm = Self::armed();
        arm.point(0, arm.q);
        arm.point(100, arm.q.map(|q| q + 0.1));
        arm.point(100, arm.q);
        assert!(matches!(arm.asked(Request::Run), Drives::Drive(_)));
        assert_eq!(arm.state(), safety::State::Running);
        arm
    }

    pub(super) fn receive(&mut self, frame: Frame) -> Reaction {
        self.session.receive(Ok(Received { frame, missed: 0 }))
    }

    pub(super) fn point(&mut self, ticks: u16, q: [f32; 2]) -> Reaction {
        let reference = link::Reference::new(&Reference::at_rest(q));
        self.receive(Frame::Point(Point { ticks, reference }))
    }

    pub(super) fn tick(&mut self) -> Drives<2> {
        if self.heard {
            self.receive(Frame::Alive);
        }
        let sensed = Sensed::State { q: self.q, qd: self.qd };
        let readings = Readings {
            sensed,
            torque: [0.0; 2],
            age_ticks: self.age_ticks,
            faults: self.faults,
            errors: self.errors,
            on: self.on,
            zero_lost: core::mem::take(&mut self.zero_lost),
        };
        self.session.sense(Some(&readings), &self.lines);
        self.session.tick(&self.meter)
    }

    pub(super) fn asked(&mut self, request: Request) -> Drives<2> {
        self.ask(request);
        self.tick()
    }

    /// Sends a request with the next number.
    pub(super) fn ask(&mut self, request: Request) -> Reaction {
        self.number = self.number.wrapping_add(1);
        self.receive(Frame::request(self.number, request))
    }

    /// Runs one tick of an arm that follows the reference.
    pub(super) fn follow(&mut self) -> Drives<2> {
        let drives = self.tick();
        if let Drives::Drive(torque) = drives {
            // Unit masses: the feedback alone determines the remaining error.
            for i in 0..2 {
                self.qd[i] += torque[i] * 0.002;
                self.q[i] += self.qd[i] * 0.002;
            }
        }
        drives
    }

    pub(super) fn state(&self) -> safety::State {
        match self.session.state() {
            State::Supervised(_, state) => state,
            other => panic!("{other:?}"),
        }
    }

    /// Frames that the session sends, except answers to requests.
    pub(super) fn reports(&mut self) -> Vec<Frame> {
        self.said().into_iter().filter(|frame| !matches!(frame, Frame::Answer(_))).collect()
    }

    pub(super) fn said(&mut self) -> Vec<Frame> {
        std::iter::from_fn(|| self.session.say()).map(Report::frame).collect()
    }

    pub(super) fn watched(&mut self) -> Status {
        self.receive(Frame::Watch(Watch { every: 1, parts: Parts::ALL }));
        self.tick();
        match self.reports().as_slice() {
            [Frame::Status(status)] => status.clone(),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn no_torque_before_home_confirm_and_arm_whatever_is_asked() {
    for request in [Request::Arm, Request::Run, Request::Hold, Request::Confirm] {
        let mut arm = Arm::live();
        arm.point(0, arm.q);
        assert_eq!(arm.asked(request), SAFE, "{request:?}");
        assert_eq!(arm.state(), safety::State::Idle);
    }
}

#[test]
fn an_armed_arm_follows_its_trajectory_to_the_end_and_stays() {
    let mut arm = Arm::running();
    let furthest = (0..800).map(|_| (arm.follow(), arm.q[0]).1).fold(0.0, f32::max);
    assert!((furthest - 0.2).abs() < 0.01, "{furthest}");
    assert!((arm.q[0] - 0.1).abs() < 0.01, "{:?}", arm.q);
    assert_eq!(arm.state(), safety::State::Running);
}

#[test]
fn an_underrun_is_a_stop_that_needs_a_new_trajectory() {
    let mut arm = Arm::armed();
    arm.point(0, arm.q);
    let moving = Reference { q: arm.q.map(|q| q + 0.01), qd: [0.3; 2], qdd: [0.0; 2] };
    arm.receive(Frame::Point(Point { ticks: 40, reference: link::Reference::new(&moving) }));
    arm.asked(Request::Run);
    for _ in 0..41 {
        arm.follow();
    }
    assert_eq!(arm.state(), safety::State::Holding(HoldCause::NoReference));
    for _ in 0..800 {
        assert!(matches!(arm.follow(), Drives::Drive(_)));
    }
    assert!(arm.qd.iter().all(|qd| qd.abs() < 1e-3), "it came to rest: {:?}", arm.qd);
    arm.receive(Frame::Watch(Watch { every: 1, parts: Parts::NONE }));
    arm.asked(Request::Run);
    assert!(matches!(arm.reports().as_slice(), [Frame::Status(Status { refused: Some(Denial { code: 8, .. }), .. })]));
}

#[test]
fn whatever_a_line_or_a_joint_says_is_a_fault_in_the_same_tick() {
    type Case = (&'static str, fn(&mut Arm), Fault);
    let cases: [Case; 9] = [
        ("emergency stop", |arm| arm.lines.emergency_stop = true, Fault::EmergencyStop),
        ("low supply", |arm| arm.lines.supply = Some(19.9), Fault::SupplyOutOfBounds),
        ("supply no number", |arm| arm.lines.supply = Some(f32::NAN), Fault::SupplyOutOfBounds),
        ("hot", |arm| arm.lines.temperature = Some(80.1), Fault::TemperatureOutOfBounds),
        ("a drive's error", |arm| arm.faults[1] = JointFaults::DRIVE, Fault::DriveFault { joint: 1 }),
        ("an old measurement", |arm| arm.age_ticks[1] = 3, Fault::StaleMeasurement),
        ("a position that is no number", |arm| arm.q[1] = f32::NAN, Fault::NonFiniteMeasurement { joint: 1 }),
        ("a jump", |arm| arm.q[0] += 0.2, Fault::ImpossibleJump { joint: 0 }),
        ("an overrun", |arm| arm.session.overrun(), Fault::Overrun),
    ];
    for (name, happens, fault) in cases {
        for mut arm in [Arm::armed(), Arm::running()] {
            assert!(matches!(arm.tick(), Drives::Drive(_)), "{name}");
            happens(&mut arm);
            assert_eq!(arm.tick(), SAFE, "{name}");
            assert_eq!(arm.state(), safety::State::Fault(fault), "{name}");
            assert_eq!(arm.tick(), SAFE, "{name}: it latches");
        }
    }
}

#[test]
fn every_fault_of_a_joint_but_a_missing_measurement_is_its_drive_s() {
    for (fault, name) in JointFaults::NAMES {
        let mut arm = Arm::armed();
        arm.faults[0] = fault;
        let drives = arm.tick();
        if fault == JointFaults::MISSING {
            assert!(matches!(drives, Drives::Drive(_)), "known by its age: {name}");
        } else {
            assert_eq!((drives, arm.state()), (SAFE, safety::State::Fault(Fault::DriveFault { joint: 0 })), "{name}");
        }
    }
}

#[test]
fn a_silent_host_is_a_stop_and_then_the_safe_action() {
    let mut arm = Arm::running();
    arm.heard = false;
    let states: Vec<_> = (0..12).map(|_| (arm.follow(), arm.state()).1).collect();
    let holds = states.iter().filter(|state| **state == safety::State::Holding(HoldCause::HeartbeatLost)).count();
    assert_eq!(states.iter().filter(|state| **state == safety::State::Running).count(), 3);
    assert_eq!(holds, 4);
    assert_eq!(states.last(), Some(&safety::State::Fault(Fault::HeartbeatLost)));
}

#[test]
fn a_fault_is_left_by_clear_alone_and_the_black_box_has_what_was_before_and_behind_it() {
    let mut arm = Arm::running();
    for _ in 0..60 {
        arm.follow();
    }
    arm.lines.emergency_stop = true;
    for _ in 0..50 {
        assert_eq!(arm.tick(), SAFE);
    }
    arm.receive(Frame::Dump);
    let mut past = Vec::new();
    for frame in arm.reports() {
        match frame {
            Frame::Past(Some(status)) => past.push(status),
            Frame::Past(None) => {}
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(past.len(), TICKS);
    assert!(past.windows(2).all(|two| two[1].tick == two[0].tick + 1));
    let first = past.iter().position(|status| status.state == StateCode::Fault).unwrap();
    assert_eq!(past.len() - first, usize::from(TICKS_AFTER) + 1);
    assert!(
        past[..first]
            .iter()
            .all(|s| s.state == StateCode::Running && matches!(s.actuation, Some(Actuation::Drive { .. })))
    );
    assert_eq!((past[first].cause, past[first].actuation.clone()), (9, Some(Actuation::DampedStop)));

    arm.asked(Request::Arm);
    assert_eq!(arm.state(), safety::State::Fault(Fault::EmergencyStop));
    arm.lines.emergency_stop = false;
    arm.qd = [0.0; 2];
    arm.asked(Request::Clear);
    assert_eq!(arm.state(), safety::State::Idle);
}

#[test]
fn a_status_has_the_parts_that_were_asked_for_at_the_rate_that_was_asked_for() {
    let mut arm = Arm::armed();
    assert_eq!(arm.reports(), []);
    let status = arm.watched();
    let Some(Actuation::Drive { torque, .. }) = &status.actuation else { panic!("{status:?}") };
    assert_eq!((torque.as_slice(), status.state, status.homed), ([0.0; 2].as_slice(), StateCode::Armed, true));
    assert!(status.sensed.unwrap().lines.zeroed);
    assert!(matches!(status.cost.unwrap().all, Cost::Instructions(_)));
    assert_eq!(status.room, 16);

    arm.receive(Frame::Watch(Watch { every: 5, parts: Parts::NONE }));
    let mut ticks = Vec::new();
    for _ in 0..20 {
        arm.tick();
        ticks.extend(arm.reports().into_iter().map(|frame| match frame {
            Frame::Status(Status { tick, sensed: None, actuation: None, cost: None, .. }) => tick,
            other => panic!("{other:?}"),
        }));
    }
    assert_eq!(ticks.len(), 4);
    assert!(ticks.windows(2).all(|two| two[1] - two[0] == 5));
}

#[test]
fn frames_of_the_bench_and_the_chip_s_own_are_refused_and_points_by_their_reason() {
    let mut arm = Arm::running();
    let still = Reference { q: [0.0; 2], qd: [0.0; 2], qdd: [0.0; 2] };
    assert_eq!(arm.receive(Frame::Reference(link::Reference::new(&still))), refused(Refusal::Unexpected));
    assert_eq!(arm.receive(Frame::Refusal(Refusal::NoHello)), refused(Refusal::Unexpected));
    let lines = link::Lines::CALM;
    assert_eq!(arm.receive(Frame::Lines(lines)), refused(Refusal::Unexpected), "the board's own lines count");
    assert_eq!(arm.point(0, [0.0; 2]), refused(Refusal::Running));
    assert_eq!(arm.point(1, [f32::NAN; 2]), refused(Refusal::NonFinitePoint));
    for _ in 0..14 {
        assert_eq!(arm.point(1, [0.1; 2]), Reaction::None);
    }
    assert_eq!(arm.point(1, [0.1; 2]), refused(Refusal::TrajectoryFull));
    assert_eq!(Arm::armed().point(1, [0.1; 2]), refused(Refusal::NoStart));
    let wrong = Reference { q: [0.0_f32; 3], qd: [0.0; 3], qdd: [0.0; 3] };
    let point = Point { ticks: 1, reference: link::Reference::new(&wrong) };
    assert_eq!(arm.receive(Frame::Point(point)), refused(Refusal::JointCount { expected: 2, found: 3 }));
}

#[test]
fn a_stop_is_taken_even_where_frames_were_lost_before_it_and_nothing_else_is() {
    let mut arm = Arm::running();
    let lost = |frame| Ok(Received { frame, missed: 3 });
    let answer = arm.session.receive(lost(Frame::request(101, Request::Disarm)));
    assert_eq!(answer, Reaction::Reply(Frame::Refusal(Refusal::Lost { missed: 3 })));
    arm.session.receive(lost(Frame::request(102, Request::Hold)));
    arm.tick();
    assert_eq!(arm.state(), safety::State::Holding(HoldCause::Requested));
}

/// Even if no tick follows, the host gets a report that the drives perform the safe action.
#[test]
fn a_status_follows_a_hello_that_ends_a_live_session() {
    let safe = link::Actuation::new(&safety::Actuation::<f32, 2>::Safe(SafeAction::DampedStop));
    let other = Hello { robot: OWN.robot + 1, pacing: Pacing::Live, ..OWN };
    for theirs in [Pacing::DryRun, Pacing::LockStep, Pacing::Timer]
        .map(|pacing| Hello { pacing, ..OWN })
        .into_iter()
        .chain([other])
    {
        let mut arm = Arm::live();
        arm.said();
        arm.receive(Frame::Hello(theirs));
        let said = arm.said();
        let [Frame::Status(status)] = &said[..] else { panic!("{theirs:?}: {said:?}") };
        assert_eq!(
            (status.state, status.homed, &status.actuation),
            (StateCode::Idle, false, &Some(safe.clone())),
            "{theirs:?}"
        );
        // Only the first hello has ended it.
        arm.receive(Frame::Hello(theirs));
        assert_eq!(arm.said(), []);
    }
    let mut arm = Arm::live();
    arm.said();
    arm.receive(Frame::Hello(Hello { pacing: Pacing::Live, ..OWN }));
    assert_eq!(arm.said(), [], "ticks of the new session say it");
}

#[test]
fn a_dry_run_is_the_same_with_the_host_in_the_place_of_board_and_joints_and_drives_nothing() {
    let mut arm = Arm::live();
    let hello = Hello { pacing: Pacing::DryRun, ..OWN };
    arm.receive(Frame::Hello(hello));
    assert_eq!(arm.said().len(), 1, "the end of the live session");
    let lines = link::Lines::CALM;
    arm.receive(Frame::Lines(lines));
    let sensed = Sensed::State { q: [0.1; 2], qd: [0.0; 2] };
    let mut statuses = Vec::new();
    for (tick, request) in [Request::Home, Request::Confirm, Request::Arm].into_iter().enumerate() {
        arm.ask(request);
        let measurement = link::Measurement::new(tick as u32 + 1, &Measurement { sensed, age_ticks: 0 });
        assert_eq!(arm.receive(Frame::Measurement(measurement)), Reaction::Tick);
        assert_eq!(arm.session.tick(&arm.meter), SAFE);
        statuses.extend(arm.reports());
    }
    let Some(Frame::Status(status)) = statuses.last() else { panic!("{statuses:?}") };
    assert_eq!((statuses.len(), status.state, status.tick), (3, StateCode::Armed, 3));
    assert!(matches!(status.actuation, Some(Actuation::Drive { .. })));
}

#[test]
fn a_hello_takes_everything_away_from_an_arm_that_is_not_driven() {
    let mut arm = Arm::armed();
    assert_eq!(arm.asked(Request::Disarm), SAFE);
    assert!(arm.session.homed());
    arm.receive(Frame::Hello(Hello { pacing: Pacing::Live, ..OWN }));
    assert_eq!(arm.tick(), SAFE);
    assert_eq!(arm.state(), safety::State::Idle);
    assert_eq!(arm.asked(Request::Arm), SAFE, "not homed any more");
    assert_eq!(arm.watched().tick, 3, "ticks are counted from 1 again");
}

/// A host reconnects to a driven arm, and repeats its hello.
#[test]
fn the_same_hello_keeps_an_arm_that_is_driven_and_stops_its_motion() {
    let live = Hello { pacing: Pacing::Live, ..OWN };
    for hellos in 1..=3 {
        let mut arm = Arm::with(config(), true).arm();
        answers(&mut arm, set(16, 99.0));
        arm.point(0, arm.q);
        arm.point(100, arm.q.map(|q| q + 0.1));
        arm.asked(Request::Run);
        (0..5).for_each(|_| {
            arm.follow();
        });
        let tick = arm.watched().tick;
        for _ in 0..hellos {
            assert_eq!(arm.receive(Frame::Hello(live)), Reaction::Resume(Frame::Hello(live)));
            assert_eq!(arm.state(), safety::State::Running, "a hello does nothing that a tick does");
        }
        for _ in 0..100 {
            assert!(matches!(arm.tick(), Drives::Drive(_)), "torque acts in each tick");
        }
        assert_eq!(arm.state(), safety::State::Holding(HoldCause::Requested));
        let status = arm.watched();
        assert_eq!((status.tick, status.homed), (tick + 101, true), "its ticks go on");
        // A heartbeat before each tick, and the frame that requested this status.
        assert!((100..110).contains(&status.taken), "frames are counted from the hello: {}", status.taken);
        let value = Frame::Value(Value { index: 16, value: 99.0, low: 25.0, high: 400.0 });
        assert_eq!(answers(&mut arm, Frame::Get(16)).first(), Some(&value), "parameters are kept");
        // A request may have the number of a request of the previous host: it is a new one.
        assert!(matches!(arm.asked(Request::Disarm), Drives::Drive(_) | Drives::Safe(_)));
    }
}

/// A motion that the previous host has requested and that has not begun does not begin.
#[test]
fn a_motion_that_waits_does_not_begin_for_another_host() {
    let live = Hello { pacing: Pacing::Live, ..OWN };
    let mut arm = Arm::armed();
    arm.point(0, arm.q);
    arm.point(100, arm.q.map(|q| q + 0.1));
    arm.ask(Request::Run);
    arm.receive(Frame::Hello(live));
    arm.tick();
    assert_eq!(arm.state(), safety::State::Armed);
    arm.asked(Request::Run);
    assert_ne!(arm.state(), safety::State::Running, "its points are gone");
    // A stop is carried out nevertheless.
    let mut arm = Arm::running();
    arm.ask(Request::Stop);
    arm.receive(Frame::Hello(live));
    arm.tick();
    assert_eq!(arm.state(), safety::State::Fault(Fault::EmergencyStop));
}

/// A hello of any other host does not let the arm fall.
#[test]
fn no_other_hello_counts_while_the_arm_is_driven() {
    let strangers = [
        Hello { pacing: Pacing::DryRun, ..OWN },
        Hello { pacing: Pacing::LockStep, ..OWN },
        Hello { pacing: Pacing::Timer, ..OWN },
        Hello { robot: 8, pacing: Pacing::Live, ..OWN },
        Hello { joints: 3, pacing: Pacing::Live, ..OWN },
        Hello { rate_hz: f32::NAN, pacing: Pacing::Live, ..OWN },
    ];
    for theirs in strangers {
        for mut arm in [Arm::armed(), Arm::running()] {
            let before = arm.state();
            assert_eq!(arm.receive(Frame::Hello(theirs)), refused(Refusal::Driven), "{theirs:?}");
            assert!(matches!(arm.tick(), Drives::Drive(_)));
            assert_eq!(arm.state(), before);
        }
    }
}

/// The host disconnects, and reconnects before the arm is lowered or released.
#[test]
fn an_arm_that_holds_because_its_host_went_is_held_when_it_comes_back() {
    let live = Hello { pacing: Pacing::Live, ..OWN };
    let mut arm = Arm::armed();
    arm.heard = false;
    let mut ticks = 0;
    while arm.state() != safety::State::Holding(HoldCause::HeartbeatLost) {
        arm.tick();
        ticks += 1;
        assert!(ticks < 1000);
    }
    arm.receive(Frame::Hello(live));
    arm.heard = true;
    for _ in 0..1000 {
        assert!(matches!(arm.tick(), Drives::Drive(_)));
    }
    assert!(matches!(arm.state(), safety::State::Holding(_)));
}

/// The count of frames stays correct even if thousands of packets are lost.
#[test]
fn frames_taken_are_counted_right_however_many_were_lost() {
    for missed in [1, 254, 255, 256, 1000, 70_000] {
        let mut arm = Arm::live();
        let before = arm.watched().taken;
        let lost = Received { frame: Frame::Alive, missed };
        let told = u8::try_from(missed).unwrap_or(u8::MAX);
        assert_eq!(arm.session.receive(Ok(lost)), refused(Refusal::Lost { missed: told }));
        arm.tick();
        assert_eq!(arm.watched().taken, before.wrapping_add(missed as u16).wrapping_add(4), "{missed}");
    }
}

/// Answers of the session to a frame, including those of the next tick.
pub(super) fn answers(arm: &mut Arm, frame: Frame) -> Vec<Frame> {
    let mut all = match arm.receive(frame) {
        Reaction::None => Vec::new(),
        Reaction::Reply(frame) => vec![frame],
        other => panic!("{other:?}"),
    };
    arm.tick();
    all.extend(arm.reports());
    all
}

pub(super) fn set(index: u8, value: f32) -> Frame {
    Frame::Set(Setting { index, value })
}

#[test]
fn every_parameter_is_read_back_with_its_bounds_and_nothing_else_is() {
    let mut arm = Arm::live();
    let value = |arm: &mut Arm, index| match answers(arm, Frame::Get(index)).as_slice() {
        [Frame::Value(value)] => Some(*value),
        [Frame::Refusal(Refusal::NoParameter)] => None,
        other => panic!("{other:?}"),
    };
    assert_eq!(value(&mut arm, 16), Some(Value { index: 16, value: 100.0, low: 25.0, high: 400.0 }));
    assert_eq!(value(&mut arm, 4).map(|v| (v.value, v.low.is_nan())), Some((50.0, true)));
    for index in 0..=255 {
        let named = newtau_session::parameters::name(index).filter(|(_, joint)| joint.is_none_or(|joint| joint < 2));
        assert_eq!(value(&mut arm, index).is_some(), named.is_some(), "{index}: {named:?}");
    }
}

#[test]
fn the_heat_of_a_motor_is_read_where_its_numbers_are_known_and_cannot_be_set() {
    let mut protected = protected();
    // The second motor reaches 1 - exp(-1) of its final heat in one time constant, which is 50 updates or 100 ticks.
    let known = HeatRules::new(2.0, 0.2, 0.004);
    let known = HeatRules { per_rated: known.per_rated as f32, share: known.share as f32 };
    protected.rules.heat = Some([HeatRules { per_rated: 0.0, share: 0.0 }, known]);
    let mut arm = Arm::with_rules(soft(), true, protected).arm();
    let heat = |arm: &mut Arm, joint: u8| match answers(arm, Frame::Get(16 * joint + HEAT)).as_slice() {
        [Frame::Value(Value { value, low, high, .. })] => {
            assert!(low.is_nan() && high.is_nan());
            *value
        }
        other => panic!("{other:?}"),
    };
    assert!(heat(&mut arm, 0).is_nan(), "a motor of unknown numbers has no heat");
    assert!(heat(&mut arm, 1) < 1e-3, "it begins cold");
    // 0.02 rad away from the reference, times 100 1/s^2: 2 N m, the rated torque.
    arm.q[1] += 0.02;
    arm.tick();
    let Drives::Drive([_, torque]) = arm.tick() else { panic!("a torque") };
    assert!((torque + 2.0).abs() < 1e-3, "{torque}");
    (0..98).for_each(|_| {
        arm.tick();
    });
    let after = heat(&mut arm, 1);
    assert!((after - 0.632).abs() < 0.02, "{after}");
    // A host can reset the heat neither by a setting nor by a hello.
    assert_eq!(answers(&mut arm, set(16 + HEAT, 0.0)), [Frame::Refusal(Refusal::Fixed)]);
    arm.receive(Frame::Hello(Hello { pacing: Pacing::Live, ..OWN }));
    arm.q[1] -= 0.02;
    arm.tick();
    assert!(heat(&mut arm, 1) > 0.6 && heat(&mut arm, 0).is_nan());
    // Without thermal data the heat of all motors is unknown.
    let mut bare = Arm::live();
    assert!((0..2).all(|joint| heat(&mut bare, joint).is_nan()));
}

#[test]
fn a_parameter_is_set_within_its_bounds_and_where_the_scene_leaves_it_free() {
    let refused = |refusal| [Frame::Refusal(refusal)];
    let mut arm = Arm::live();
    assert_eq!(
        answers(&mut arm, set(0, 200.0)),
        [Frame::Value(Value { index: 0, value: 200.0, low: 25.0, high: 400.0 })]
    );
    for value in [24.9, 400.1, f32::NAN, f32::INFINITY, -100.0] {
        assert_eq!(answers(&mut arm, set(0, value)), refused(Refusal::OutOfBounds), "{value}");
    }
    assert_eq!(answers(&mut arm, set(4, 10.0)), refused(Refusal::Fixed));
    assert_eq!(answers(&mut arm, set(2, 0.0)), refused(Refusal::Fixed), "no friction is made up for");
    assert_eq!(answers(&mut arm, set(200, 0.0)), refused(Refusal::NoParameter));
    let mut fixed = Arm::with(config(), false);
    assert_eq!(answers(&mut fixed, set(0, 200.0)), refused(Refusal::Fixed));
}

#[test]
fn a_change_is_made_while_torque_acts_only_where_no_torque_jumps() {
    let slow = ControllerConfig { torque_step: [f32::INFINITY; 2], ..config() };
    let gain = |arm: &mut Arm| match answers(arm, Frame::Get(16)).as_slice() {
        [Frame::Value(value)] => value.value,
        other => panic!("{other:?}"),
    };
    // A jump of 2 % of 50 N m is permitted. At rest on the reference a change of gain has no effect.
    let mut arm = Arm::with(slow, true).arm();
    assert!(matches!(answers(&mut arm, set(16, 200.0)).as_slice(), [Frame::Value(Value { value: 200.0, .. })]));
    // 0.05 rad away from the reference, 100 1/s^2 more of gain change the torque by 5 N m, and 10 1/s^2 by 0.5 N m.
    arm.q[1] += 0.05;
    arm.tick();
    assert_eq!(answers(&mut arm, set(16, 300.0)), [Frame::Refusal(Refusal::WouldJump { joint: 1 })]);
    assert_eq!(gain(&mut arm).to_bits(), 200_f32.to_bits());
    assert!(matches!(answers(&mut arm, set(16, 210.0)).as_slice(), [Frame::Value(Value { value: 210.0, .. })]));
    let Drives::Drive([_, torque]) = arm.tick() else { panic!("a torque") };
    assert!((torque + 210.0 * 0.05).abs() < 1e-5, "{torque}");
    // Only one change can wait.
    assert_eq!(arm.receive(set(16, 211.0)), Reaction::None);
    assert_eq!(arm.receive(set(16, 212.0)), Reaction::Reply(Frame::Refusal(Refusal::Busy)));
}

#[test]
fn another_law_is_taken_where_no_torque_jumps_the_arm_stands_and_the_scene_has_all_of_it() {
    use dynamics_core::control::{ControlLaw, Gains};
    let number = |law: ControlLaw| f32::from(law.code());
    let soft = soft();
    let mut arm = Arm::with(soft, true).arm();
    assert!(arm.session.springs().is_none());
    for law in [ControlLaw::Impedance, ControlLaw::PdGravity, ControlLaw::Teach, ControlLaw::ComputedTorque] {
        let answer = answers(&mut arm, set(LAW, number(law)));
        let value = number(law);
        assert_eq!(answer, [Frame::Value(Value { index: LAW, value, low: 0.0, high: 7.0 })], "{law:?}");
    }
    // Refused: a number of no control law, and a law that the drives were not configured for.
    for value in [0.5, 8.0, -1.0, f32::NAN, number(ControlLaw::Split)] {
        assert_eq!(answers(&mut arm, set(LAW, value)), [Frame::Refusal(Refusal::OutOfBounds)], "{value}");
    }
    arm.point(0, arm.q);
    arm.point(100, arm.q.map(|q| q + 0.1));
    arm.asked(Request::Run);
    assert_eq!(answers(&mut arm, set(LAW, 1.0)), [Frame::Refusal(Refusal::Running)]);
    // Away from the reference the torques of the two laws differ by more than 2 % of the limit, because the gains are for another inertia.
    let heavy = ControllerConfig { gains: [Gains { inertia: 4.0, ..soft.gains[0] }; 2], teach: None, ..soft };
    let mut arm = Arm::with(heavy, true).arm();
    arm.q[1] += 0.02;
    arm.tick();
    let jumps = [Frame::Refusal(Refusal::WouldJump { joint: 1 })];
    assert_eq!(answers(&mut arm, set(LAW, number(ControlLaw::PdGravity))), jumps);
    assert_eq!(answers(&mut arm, set(LAW, number(ControlLaw::Teach))), [Frame::Refusal(Refusal::OutOfBounds)]);
    // Without tuning the control law is fixed too.
    let mut fixed = Arm::with(soft, false).arm();
    assert_eq!(answers(&mut fixed, set(LAW, 1.0)), [Frame::Refusal(Refusal::Fixed)]);
    // A control law that uses the drives' springs returns them.
    let split = Arm::with(ControllerConfig { law: ControlLaw::Split, ..soft }, true);
    assert_eq!(split.session.springs(), Some(soft.gains.map(|gains| gains.spring())));
}

#[test]
fn an_arm_whose_law_became_teach_is_led_and_its_reference_is_where_it_is() {
    use dynamics_core::control::{ControlLaw, Teach};
    let (none, wall) = (0.0, (-3.0, 3.0));
    let teach = Teach {
        friction: none,
        per_still_speed: 100.0,
        breakaway: none,
        slip: none,
        drag: 0.1,
        speed: 1.0,
        wall,
        per_wall: none,
        stiffness: 100.0,
        damping: none,
        slowing: 0.0,
    };
    let config = ControllerConfig { teach: Some([teach; 2]), ..config() };
    let mut arm = Arm::with(config, true).arm();
    answers(&mut arm, set(LAW, f32::from(ControlLaw::Teach.code())));
    arm.point(0, arm.q);
    arm.asked(Request::Run);
    // Slowly further away than a reference may be.
    for _ in 0..400 {
        arm.q = arm.q.map(|q| q + 5e-4);
        arm.qd = [0.25; 2];
        let Drives::Drive(torque) = arm.tick() else { panic!("{:?}", arm.state()) };
        assert!(torque.iter().all(|torque| torque.abs() < 0.2), "{torque:?}");
    }
    assert_eq!(arm.state(), safety::State::Running);
}

#[test]
fn a_fault_of_a_drive_is_told_with_the_drive_s_own_code_until_it_is_left() {
    let mut arm = Arm::armed();
    let trouble = |arm: &mut Arm| match arm.watched().extra {
        link::ExtraFields::DriveFault(trouble) => Some(trouble),
        _ => None,
    };
    assert_eq!(trouble(&mut arm), None);
    (arm.faults[1], arm.errors[1]) = (JointFaults::DRIVE, 0xb);
    let told = Some(link::DriveFaultReport { joint: 1, faults: JointFaults::DRIVE.bits(), error: 0xb });
    assert_eq!(trouble(&mut arm), told);
    assert_eq!(arm.state(), safety::State::Fault(Fault::DriveFault { joint: 1 }));
    // The drive no longer reports the fault; the board still does.
    (arm.faults[1], arm.errors[1]) = (JointFaults::NONE, 0);
    assert_eq!(trouble(&mut arm), told);
    arm.asked(Request::Clear);
    arm.reports();
    assert_eq!((trouble(&mut arm), arm.state()), (None, safety::State::Idle));
}

#[test]
fn live_inputs_that_would_jump_are_refused_and_those_from_before_hold_on() {
    let slow = ControllerConfig { torque_step: [f32::INFINITY; 2], ..config() };
    let rotor = |rotor: f32| {
        let live = dynamics_core::Live { rotor: [rotor; 2], ..dynamics_core::Live::<f32, 2>::zero() };
        Frame::Live(link::Live::new(&live).unwrap())
    };
    let mut arm = Arm::with(slow, true).arm();
    arm.q[0] += 0.05;
    arm.tick();
    // Unit masses accelerated back at 5 rad/s^2: a rotor of 0.5 adds 2.5 N m, one of 0.1 adds 0.5 N m.
    assert_eq!(answers(&mut arm, rotor(0.5)), [Frame::Refusal(Refusal::WouldJump { joint: 0 })]);
    assert_eq!(answers(&mut arm, rotor(0.1)), []);
    let Drives::Drive([torque, _]) = arm.tick() else { panic!("a torque") };
    assert!((torque + 1.1 * 100.0 * 0.05).abs() < 1e-5, "{torque}");
}

#[test]
fn a_payload_is_taken_up_to_its_bounds_and_one_that_cannot_be_is_not() {
    let told = |live: dynamics_core::Live<f32, 2>| Frame::Live(link::Live::new(&live).unwrap());
    let zero = dynamics_core::Live::<f32, 2>::zero();
    // A small ball at (far, 0, 0); up to 5 kg within 0.5 m is allowed.
    let ball = |mass: f32, far: f32| {
        let mut body = Inertia { mass, ..Inertia::zero() };
        body.first_moment.x = mass * far;
        body.about_origin.fill_diagonal(mass * (0.001 + far * far));
        body.about_origin.m11 = mass * 0.001;
        body
    };
    let payload = |mass, far| told(dynamics_core::Live { payload: ball(mass, far), ..zero });
    let gravity = |down: f32| {
        let mut live = zero;
        live.gravity.z = down;
        told(live)
    };
    let mut hollow = ball(1.0, 0.2);
    hollow.first_moment.x = 0.25;
    let bad = [payload(5.01, 0.1), payload(1.0, 0.51), payload(-1.0, 0.1), gravity(-20.1), gravity(20.1)];
    let bad = bad.into_iter().chain([told(dynamics_core::Live { payload: hollow, ..zero })]);
    // While no torque acts, nothing can jump, and only the bounds apply.
    let mut arm = Arm::live();
    for frame in [payload(5.0, 0.1), payload(1.0, 0.49), payload(0.0, 0.0), gravity(-19.9)] {
        assert_eq!(answers(&mut arm, frame.clone()), [], "{frame:?}");
    }
    answers(&mut arm, payload(4.0, 0.1));
    for frame in bad {
        assert_eq!(answers(&mut arm, frame.clone()), [Frame::Refusal(Refusal::OutOfBounds)], "{frame:?}");
    }
    let mass = Value { index: 96, value: 4.0, low: 0.0, high: 5.0 };
    assert_eq!(answers(&mut arm, Frame::Get(96)), [Frame::Value(mass)]);
    // The payload's mass is set by another frame.
    assert_eq!(answers(&mut arm, set(96, 1.0)), [Frame::Refusal(Refusal::Fixed)]);
}

/// A rotor's inertia is not negative, and not larger than the bound of the drive.
#[test]
fn rotors_are_taken_up_to_their_bound_and_never_below_zero() {
    let told = |rotor: [f32; 2]| {
        Frame::Live(link::Live::new(&dynamics_core::Live { rotor, ..dynamics_core::Live::zero() }).unwrap())
    };
    let mut arm = Arm::live();
    for rotor in [[0.0, 0.0], [2.0, 2.0], [-0.0, 1.0]] {
        assert_eq!(answers(&mut arm, told(rotor)), [], "{rotor:?}");
    }
    for rotor in [[-1e-6, 0.0], [0.0, -5.0], [2.0_f32.next_up(), 0.0], [0.0, 1e9]] {
        assert_eq!(answers(&mut arm, told(rotor)), [Frame::Refusal(Refusal::OutOfBounds)], "{rotor:?}");
    }
}

/// Live inputs sent while no torque acts are not checked for jumps: an arm that could not hold the load they describe is not armed.
#[test]
fn an_arm_that_cannot_hold_what_it_was_told_is_not_armed() {
    let pushed = |force: f32| {
        let mut live = dynamics_core::Live::<f32, 2>::zero();
        live.tip_wrench.force.x = force;
        Frame::Live(link::Live::new(&live).unwrap())
    };
    for (force, holds) in [(49.9, true), (-49.9, true), (50.1, false), (-1000.0, false)] {
        let mut arm = Arm::live();
        for request in [Request::Home, Request::Confirm] {
            arm.asked(request);
        }
        assert_eq!(answers(&mut arm, pushed(force)), []);
        let drives = arm.asked(Request::Arm);
        if holds {
            assert!(matches!(drives, Drives::Drive(_)), "{force} N");
        } else {
            assert_eq!(drives, SAFE, "{force} N");
            let overload = dynamics_core::control::Fault::Overload { joint: 0 };
            assert_eq!(arm.state(), safety::State::Fault(overload));
            // With correct live inputs, and after clearing the fault, it is armed.
            assert_eq!(answers(&mut arm, pushed(0.0)), []);
            arm.asked(Request::Clear);
            assert!(matches!(arm.asked(Request::Arm), Drives::Drive(_)));
        }
    }
}

/// The first request of a new host is ranked against a waiting request of the previous host.
#[test]
fn a_stop_that_waits_is_not_displaced_by_another_host() {
    let live = Hello { pacing: Pacing::Live, ..OWN };
    for (request, state) in [
        (Request::Stop, safety::State::Fault(Fault::EmergencyStop)),
        (Request::Hold, safety::State::Holding(HoldCause::Requested)),
    ] {
        let mut arm = Arm::running();
        arm.ask(request);
        arm.receive(Frame::Hello(live));
        arm.number = 200;
        let answer = arm.receive(Frame::request(201, Request::Disarm));
        let superseded = Frame::Answer(link::Answer { number: 201, verdict: link::Verdict::Superseded });
        assert_eq!(answer, Reaction::Reply(superseded), "{request:?}");
        arm.tick();
        assert_eq!(arm.state(), state, "{request:?}");
    }
    // A disarm of the previous host is dropped.
    let mut arm = Arm::running();
    arm.ask(Request::Disarm);
    arm.receive(Frame::Hello(live));
    arm.tick();
    assert_eq!(arm.state(), safety::State::Holding(HoldCause::Requested), "it neither goes on nor lets go");
    let mut arm = Arm::armed();
    arm.ask(Request::Disarm);
    arm.receive(Frame::Hello(live));
    assert!(matches!(arm.tick(), Drives::Drive(_)), "an arm that was taken over is not let go");
}

/// The report of a tick before the hello is not sent: its state is about to end, and it counts frames of another host.
#[test]
fn no_report_of_before_follows_a_hello() {
    let mut arm = Arm::running();
    arm.receive(Frame::Watch(Watch { every: 1, parts: Parts::ALL }));
    arm.tick();
    arm.receive(Frame::Hello(Hello { pacing: Pacing::Live, ..OWN }));
    arm.receive(Frame::Watch(Watch { every: 1, parts: Parts::ALL }));
    assert_eq!(arm.said(), []);
    arm.tick();
    let said = arm.said();
    let [Frame::Status(status)] = &said[..] else { panic!("{said:?}") };
    // Two frames: the watch, and the heartbeat before the tick.
    assert_eq!((status.state, status.taken), (StateCode::Holding, 2));
}

/// Frames of a host with a refused hello do not count as heartbeats. A stop is accepted from any host that has the key.
#[test]
fn a_host_that_was_refused_is_not_heard_but_for_a_stop() {
    let stranger = Hello { robot: 8, pacing: Pacing::Live, ..OWN };
    let mut arm = Arm::armed();
    arm.heard = false;
    assert_eq!(arm.receive(Frame::Hello(stranger)), refused(Refusal::Driven));
    for _ in 0..1000 {
        assert_eq!(arm.receive(Frame::Alive), refused(Refusal::NoHello));
        arm.tick();
    }
    assert_eq!(arm.state(), safety::State::Fault(Fault::HeartbeatLost));
    let mut arm = Arm::running();
    arm.receive(Frame::Hello(stranger));
    assert_eq!(arm.receive(Frame::request(9, Request::Disarm)), refused(Refusal::NoHello));
    arm.receive(Frame::request(10, Request::Hold));
    arm.tick();
    assert_eq!(arm.state(), safety::State::Holding(HoldCause::Requested));
    arm.receive(Frame::Hello(Hello { pacing: Pacing::Live, ..OWN }));
    assert_eq!(arm.receive(Frame::Alive), Reaction::None, "the right hello is heard again");
}
