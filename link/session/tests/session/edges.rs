//! Tests of edge cases between host and board: several requests and changes in one tick, state that is kept after a fault, missing readings.

#![allow(clippy::float_cmp, reason = "a torque that does not act is zero to the bit")]

use super::supervised::{Arm, answers, set};
use super::{Looks, OWN, UnitMasses, config, protected, soft};
use dynamics_core::control::{
    ControlLaw, Controller, ControllerConfig, Encoder, Measurement, Reference, Sensed, TrackingObserver,
};
use dynamics_core::safety::{self, HoldCause, Protected};
use dynamics_core::trig::Polynomial;
use link::codec::Received;
use link::{Answer, Frame, Hello, Pacing, Parts, Point, Refusal, Request, StateCode, Verdict, Watch};
use newtau_session::meter::Meter;
use newtau_session::parameters::LAW;
use newtau_session::readings::{JointFaults, Lines, Readings};
use newtau_session::{Drives, Reaction, Session};
use std::cell::Cell;

const ALL: [Request; 9] = Request::OF_THE_MACHINE;

const fn rank(request: Request) -> u8 {
    match request {
        Request::Stop => 3,
        Request::Hold => 2,
        Request::Disarm => 1,
        _ => 0,
    }
}

/// A situation in which several requests arrive in one tick: its name, and a function that creates an arm in it.
type Situation = (&'static str, fn() -> Arm);

fn situations() -> [Situation; 4] {
    [
        ("idle", Arm::live),
        ("armed", || {
            let mut arm = Arm::armed();
            arm.point(0, arm.q);
            arm
        }),
        ("running", Arm::running),
        ("fault", || {
            let mut arm = Arm::running();
            arm.asked(Request::Stop);
            arm
        }),
    ]
}

/// Sends these requests for one tick; returns the state after it and the verdict on each, in order.
fn collide(mut arm: Arm, requests: &[Request]) -> (safety::State, Vec<Verdict>) {
    arm.said();
    let mut answers: Vec<Answer> = Vec::new();
    let first = arm.number;
    for request in requests {
        match arm.ask(*request) {
            Reaction::None => {}
            Reaction::Reply(Frame::Answer(answer)) => answers.push(answer),
            other => panic!("{other:?}"),
        }
    }
    arm.tick();
    answers.extend(arm.said().into_iter().filter_map(|frame| match frame {
        Frame::Answer(answer) => Some(answer),
        _ => None,
    }));
    let state = arm.state();
    // No request is answered twice.
    arm.tick();
    assert!(!arm.said().iter().any(|frame| matches!(frame, Frame::Answer(_))), "{requests:?}");
    let verdicts = (1..=requests.len()).map(|at| {
        let number = first.wrapping_add(at as u8);
        let mut of_it = answers.iter().filter(|answer| answer.number == number);
        let verdict =
            of_it.next().unwrap_or_else(|| panic!("{requests:?}: request {at} has no answer: {answers:?}")).verdict;
        assert_eq!(of_it.next(), None, "{requests:?}: request {at} has two answers");
        verdict
    });
    (state, verdicts.collect())
}

/// The request of highest rank acts as if it were the only one, and every other one is superseded.
fn the_strongest_wins(name: &str, start: fn() -> Arm, requests: &[Request]) {
    // The first among equals: `max_by_key` returns the last, so the order is reversed.
    let strongest = (0..requests.len()).rev().max_by_key(|&i| rank(requests[i])).unwrap();
    let (state, verdicts) = collide(start(), requests);
    let (alone, verdict) = collide(start(), &[requests[strongest]]);
    assert_eq!(state, alone, "{name}: {requests:?}");
    for (i, found) in verdicts.iter().enumerate() {
        let expected = if i == strongest { verdict[0] } else { Verdict::Superseded };
        assert_eq!(*found, expected, "{name}: {requests:?}, request {}", i + 1);
    }
}

#[test]
fn of_all_pairs_and_triples_of_requests_in_one_tick_the_strongest_acts_and_each_is_answered_once() {
    let mut cases = 0;
    for (name, start) in situations() {
        for a in ALL {
            for b in ALL {
                the_strongest_wins(name, start, &[a, b]);
                for c in ALL {
                    the_strongest_wins(name, start, &[a, b, c]);
                    cases += 1;
                }
            }
        }
    }
    assert_eq!(cases, 4 * 9 * 9 * 9);
    // The purpose of the ranks: a hold wins over a run.
    let (state, verdicts) = collide(Arm::running(), &[Request::Hold, Request::Run]);
    assert_eq!((state, verdicts[0]), (safety::State::Holding(HoldCause::Requested), Verdict::Accepted));
}

#[test]
fn a_request_that_is_sent_again_acts_once_and_gets_the_same_answer() {
    let mut arm = Arm::running();
    arm.said();
    let hold = Frame::request(77, Request::Hold);
    // Twice before the tick, and twice after it.
    assert_eq!((arm.receive(hold.clone()), arm.receive(hold.clone())), (Reaction::None, Reaction::None));
    arm.tick();
    let accepted = Frame::Answer(Answer { number: 77, verdict: Verdict::Accepted });
    assert_eq!(arm.reports().len(), 0);
    assert_eq!(arm.state(), safety::State::Holding(HoldCause::Requested));
    for _ in 0..2 {
        assert_eq!(arm.receive(hold.clone()), Reaction::Reply(accepted.clone()));
        arm.tick();
        assert_eq!(arm.state(), safety::State::Holding(HoldCause::Requested));
    }
    // The arm runs again, then the old hold arrives late from some queue: it is a repetition, and the arm goes on.
    let mut arm = Arm::running();
    arm.receive(hold.clone());
    for _ in 0..60 {
        arm.follow();
    }
    arm.point(0, arm.q);
    arm.point(100, arm.q.map(|q| q + 0.05));
    arm.asked(Request::Run);
    assert_eq!(arm.state(), safety::State::Running);
    arm.receive(hold);
    arm.tick();
    assert_eq!(arm.state(), safety::State::Running);
}

fn torque(drives: Drives<2>) -> [f32; 2] {
    match drives {
        Drives::Drive(torque) => torque,
        other => panic!("{other:?}"),
    }
}

/// A reference 0.4 rad away makes no difference to a hand-guided arm, but means 40 N m for an arm that follows it.
#[test]
fn a_change_of_law_and_a_request_in_one_tick_never_make_torque_jump() {
    for requests in ALL.iter().filter(|request| **request != Request::Stop) {
        for change_first in [false, true] {
            let mut arm = Arm::with(soft(), true).arm();
            answers(&mut arm, set(LAW, f32::from(ControlLaw::Teach.code())));
            arm.point(0, arm.q.map(|q| q + 0.4));
            let change = set(LAW, f32::from(ControlLaw::ComputedTorque.code()));
            if change_first {
                arm.receive(change.clone());
            }
            arm.ask(*requests);
            if !change_first {
                arm.receive(change);
            }
            let mut last = [0.0_f32; 2];
            for tick in 0..4 {
                let Drives::Drive(next) = arm.tick() else { break };
                let jump = (0..2).map(|i| (next[i] - last[i]).abs()).fold(0.0, f32::max);
                assert!(jump <= 1.0, "{requests:?}, tick {tick}: {last:?} to {next:?} N m");
                last = next;
            }
        }
    }
    // Only requests that remove torque are judged together with a change; the host repeats the others.
    let mut arm = Arm::with(soft(), true).arm();
    arm.point(0, arm.q);
    arm.receive(set(0, 110.0));
    let (_, verdicts) = {
        arm.ask(Request::Run);
        arm.tick();
        (arm.state(), arm.said())
    };
    let refused = verdicts.iter().any(
        |frame| matches!(frame, Frame::Answer(Answer { verdict: Verdict::Rejected(denial), .. }) if denial.code == 11),
    );
    assert!(refused, "{verdicts:?}");
    arm.asked(Request::Run);
    assert_eq!(arm.state(), safety::State::Running);
}

#[test]
fn every_change_is_answered_though_nothing_was_read_in_between() {
    let mut arm = Arm::armed();
    let mut said = Vec::new();
    for (index, value) in [(0, 110.0), (16, 120.0)] {
        arm.receive(set(index, value));
        arm.tick();
        said.extend(arm.reports());
    }
    assert_eq!(said.len(), 2, "{said:?}");
}

#[test]
fn a_board_that_measures_takes_no_measurement_from_the_host() {
    let mut arm = Arm::armed();
    let before = arm.watched().tick;
    for count in 1..=3 {
        let sensed = Sensed::State { q: [0.0; 2], qd: [0.0; 2] };
        let lie = link::Measurement::new(u32::MAX - 1, &Measurement { sensed, age_ticks: 0 });
        let reaction = arm.receive(Frame::Measurement(lie));
        assert_eq!(reaction, Reaction::Reply(Frame::Refusal(Refusal::OwnMeasurements { count })));
    }
    assert_eq!(arm.watched().tick, before + 1);
}

#[test]
fn the_black_box_of_a_fault_survives_the_hello_of_somebody_who_comes_to_look() {
    let past = |arm: &mut Arm| -> Vec<(StateCode, u8)> {
        arm.receive(Frame::Dump);
        let past = arm.said().into_iter().filter_map(|frame| match frame {
            Frame::Past(Some(status)) => Some((status.state, status.cause)),
            _ => None,
        });
        past.collect()
    };
    let mut arm = Arm::running();
    for _ in 0..60 {
        arm.follow();
    }
    arm.faults[1] = JointFaults::DRIVE;
    for _ in 0..20 {
        arm.tick();
    }
    assert!(matches!(arm.state(), safety::State::Fault(_)));
    arm.faults[1] = JointFaults::NONE;
    for _ in 0..3 {
        arm.receive(Frame::Hello(Hello { pacing: Pacing::Live, ..OWN }));
        for _ in 0..50 {
            arm.tick();
        }
    }
    let status = arm.watched();
    assert!(status.kept && status.state == StateCode::Idle, "{status:?}");
    // The black box has not been read: it is not released.
    let (_, verdicts) = collide_one(&mut arm, Request::Release);
    assert!(matches!(verdicts, Verdict::Rejected(denial) if denial.code == 14), "{verdicts:?}");
    let kept = past(&mut arm);
    assert!(kept.contains(&(StateCode::Fault, 11)) && kept.len() > 30, "{kept:?}");
    let (_, verdict) = collide_one(&mut arm, Request::Release);
    assert_eq!(verdict, Verdict::Accepted);
    for _ in 0..60 {
        arm.tick();
    }
    assert!(!arm.watched().kept && !past(&mut arm).contains(&(StateCode::Fault, 11)));
}

fn collide_one(arm: &mut Arm, request: Request) -> (safety::State, Verdict) {
    arm.said();
    let answer = match arm.ask(request) {
        Reaction::Reply(Frame::Answer(answer)) => Some(answer),
        _ => None,
    };
    arm.tick();
    let later = arm.said().into_iter().find_map(|frame| match frame {
        Frame::Answer(answer) => Some(answer),
        _ => None,
    });
    (arm.state(), answer.or(later).unwrap().verdict)
}

/// Torques along a motion at 2 rad/s that an encoder measures, with `missing` readings missing.
fn torques_with_missing_readings(missing: i32) -> Vec<f32> {
    // 0.1 mrad per count; bandwidth 500 rad/s at 500 Hz.
    let (pole, h, speed) = ((-1.0_f32).exp(), 0.002, 2.0);
    let control = ControllerConfig {
        encoder: [Encoder { zero: 0, per_count: 1e-4 }; 2],
        observer: TrackingObserver::from_gains(h, 0.5 * h * h, 1.0 - pole * pole, (1.0 - pole) * (1.0 - pole) / h),
        torque_step: [f32::INFINITY; 2],
        ..config()
    };
    let controller = Controller::new(control, UnitMasses, Polynomial);
    let mut session = Session::new(OWN, controller, Protected { control, ..protected() });
    let meter = Meter::new(Looks(Cell::new(0)));
    let (mut number, mut age, mut counts, mut k) = (0, 0, [0; 2], 0_i32);
    let mut torques = Vec::new();
    for tick in 0..500 {
        let mut frames = vec![Frame::Alive];
        let mut ask = |frames: &mut Vec<Frame>, request| {
            number += 1;
            frames.push(Frame::request(number, request));
        };
        match tick {
            0 => frames.insert(0, Frame::Hello(Hello { pacing: Pacing::Live, ..OWN })),
            1 => ask(&mut frames, Request::Home),
            2 => ask(&mut frames, Request::Confirm),
            3 => ask(&mut frames, Request::Arm),
            30 => {
                let start = Reference::at_rest([0.0; 2]);
                let there = Reference { q: [0.2; 2], qd: [speed; 2], qdd: [0.0; 2] };
                let on = Reference { q: [0.2 + speed * h * 290.0; 2], ..there };
                for (ticks, point) in [(0, start), (100, there), (290, on)] {
                    frames.push(Frame::Point(Point { ticks, reference: link::Reference::new(&point) }));
                }
                ask(&mut frames, Request::Run);
            }
            _ => {}
        }
        for frame in frames {
            session.receive(Ok(Received { frame, missed: 0 }));
        }
        let runs = matches!(session.state(), newtau_session::State::Supervised(_, safety::State::Running));
        k += i32::from(runs);
        let absent = runs && (250..250 + missing).contains(&k);
        age = if absent { age + 1 } else { 0 };
        if !absent {
            counts = [(quintic(k, h, speed) / 1e-4).round() as i32; 2];
        }
        let readings = Readings {
            sensed: Sensed::Counts(counts),
            torque: [0.0; 2],
            age_ticks: [age; 2],
            faults: [JointFaults::NONE; 2],
            errors: [0; 2],
            on: [true; 2],
            zero_lost: false,
        };
        session.sense(Some(&readings), &Lines::NONE);
        let drives = session.tick(&meter);
        if (240..280).contains(&k) {
            torques.push(torque(drives)[0]);
        }
    }
    assert!(torques.len() >= 40, "{}", torques.len());
    torques
}

/// Position that goes from rest to 0.2 rad and velocity `v` in 100 ticks, then continues at `v`.
fn quintic(k: i32, h: f32, v: f32) -> f32 {
    if k >= 100 {
        return 0.2 + v * h * (k - 100) as f32;
    }
    let (s, v1) = (k as f32 / 100.0, v * h * 100.0);
    s * s * s * (2.0 - 4.0 * v1 + s * (-3.0 + 7.0 * v1 + s * (1.2 - 3.0 * v1)))
}

#[test]
fn a_reading_that_is_missing_is_not_taken_for_a_joint_that_stands() {
    let peak = |torques: Vec<f32>| torques.iter().fold(0.0_f32, |peak, torque| peak.max(torque.abs()));
    let whole = peak(torques_with_missing_readings(0));
    for missing in [1, 2] {
        let with_gap = peak(torques_with_missing_readings(missing));
        assert!(with_gap <= whole + 0.5, "{missing} readings missing: {with_gap} N m, without a gap {whole}");
    }
}

#[test]
fn no_trajectory_outlives_a_fault_a_disarming_or_a_homing() {
    type End = (&'static str, fn(&mut Arm));
    let ends: [End; 3] = [
        ("fault", |arm| {
            arm.lines.emergency_stop = true;
            arm.tick();
            arm.lines.emergency_stop = false;
            arm.asked(Request::Clear);
        }),
        ("stop", |arm| {
            arm.asked(Request::Stop);
            arm.asked(Request::Clear);
        }),
        ("disarm", |arm| {
            arm.asked(Request::Disarm);
        }),
    ];
    for (name, end) in ends {
        let mut arm = Arm::armed();
        arm.point(0, arm.q);
        arm.point(100, arm.q.map(|q| q + 0.1));
        end(&mut arm);
        for request in [Request::Home, Request::Confirm, Request::Arm, Request::Run] {
            arm.asked(request);
        }
        // No point has been sent since.
        assert_eq!(arm.state(), safety::State::Armed, "{name}");
    }
}

#[test]
fn an_arm_that_is_armed_beyond_its_limit_stays_where_it_is_and_may_be_moved_inward_only() {
    let mut arm = Arm::live();
    // Between the position limit and the guard's bound.
    arm.q = [3.08, 0.2];
    arm.tick();
    arm.asked(Request::Home);
    arm.asked(Request::Confirm);
    assert_eq!(torque(arm.asked(Request::Arm)), [0.0; 2]);
    for _ in 0..50 {
        assert_eq!(torque(arm.tick()), [0.0; 2]);
    }
    // A motion further outward is rejected.
    arm.point(0, arm.q);
    arm.point(100, [3.09, 0.2]);
    arm.asked(Request::Run);
    for _ in 0..100 {
        let drives = arm.follow();
        assert!(arm.q[0] <= 3.0801 && matches!(drives, Drives::Drive(_)), "{:?}", arm.q);
    }
    // A motion inward is followed.
    let mut arm = Arm::live();
    arm.q = [3.08, 0.2];
    arm.tick();
    for request in [Request::Home, Request::Confirm, Request::Arm] {
        arm.asked(request);
    }
    arm.point(0, arm.q);
    arm.point(200, [2.9, 0.2]);
    arm.asked(Request::Run);
    assert_eq!(arm.state(), safety::State::Running);
    for _ in 0..240 {
        let given = torque(arm.follow());
        assert!(given[0].abs() < 8.0, "{given:?}");
    }
    assert!((arm.q[0] - 2.9).abs() < 0.01, "{:?}", arm.q);
}

/// The scene's payload is live: arming is rejected until the payload has been sent.
#[test]
fn an_arm_with_live_inputs_is_not_armed_before_they_came() {
    let mut session_rules = protected();
    session_rules.rules.live = 0b10;
    let controller = Controller::new(config(), UnitMasses, Polynomial);
    let mut arm = Arm::live();
    arm.session = Session::new(OWN, controller, session_rules);
    arm.receive(Frame::Hello(Hello { pacing: Pacing::Live, ..OWN }));
    arm.receive(Frame::Watch(Watch { every: 0, parts: Parts::NONE }));
    arm.tick();
    arm.asked(Request::Home);
    arm.asked(Request::Confirm);
    let (state, verdict) = collide_one(&mut arm, Request::Arm);
    assert_eq!(state, safety::State::Idle);
    assert!(matches!(verdict, Verdict::Rejected(denial) if (denial.code, denial.input) == (12, 2)), "{verdict:?}");
    arm.receive(Frame::Live(link::Live::new(&dynamics_core::Live::<f32, 2>::zero()).unwrap()));
    let (state, verdict) = collide_one(&mut arm, Request::Arm);
    assert_eq!((state, verdict), (safety::State::Armed, Verdict::Accepted));
}
