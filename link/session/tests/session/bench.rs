//! Tests of the session in bench modes, through its interface: frames in, ticks and frames out.

use super::{Build, Looks, OWN, UnitMasses, config, protected};
use dynamics_core::control::{Controller, Measurement, Reference, Sensed};
use dynamics_core::safety::SafeAction;
use dynamics_core::scene::Live;
use dynamics_core::trig::Polynomial;
use link::codec::Received;
use link::{Cost, DecodeError, Frame, Hello, Pacing, Refusal};
use newtau_session::black_box::Report;
use newtau_session::meter::Meter;
use newtau_session::{Drives, Message, Outcome, Reaction, Session, State};
use std::cell::Cell;

struct Bench {
    session: Session<2, Build>,
    meter: Meter<Looks>,
}

impl Bench {
    fn new() -> Self {
        let config = config();
        let session = Session::new(OWN, Controller::new(config, UnitMasses, Polynomial), protected());
        Self { session, meter: Meter::new(Looks(Cell::new(0))) }
    }
    fn running(pacing: Pacing) -> Self {
        let mut bench = Self::new();
        bench.receive(Frame::Hello(Hello { pacing, ..OWN }));
        bench
    }

    fn receive(&mut self, frame: Frame) -> Reaction {
        self.session.receive(Ok(Received { frame, missed: 0 }))
    }

    fn tick(&mut self) -> Option<Frame> {
        let drives = self.session.tick(&self.meter);
        assert_eq!(drives, Drives::Safe(SafeAction::DampedStop), "nothing is driven on the bench");
        self.session.say().map(Report::frame)
    }

    fn fault_code(&mut self) -> Option<u8> {
        match self.tick() {
            Some(Frame::Fault(fault)) => Some(fault.code),
            _ => None,
        }
    }
}

fn reference(qdd: f32) -> Frame {
    Frame::Reference(link::Reference::new(&Reference { q: [0.0; 2], qd: [0.0; 2], qdd: [qdd; 2] }))
}

fn measurement(tick: u32, q: f32) -> Frame {
    let sensed = Sensed::State { q: [q; 2], qd: [0.0; 2] };
    Frame::Measurement(link::Measurement::new(tick, &Measurement { sensed, age_ticks: 0 }))
}

fn live(rotor: [f32; 2]) -> Frame {
    Frame::Live(link::Live::new(&Live { rotor, ..Live::zero() }).unwrap())
}

fn refused(refusal: Refusal) -> Reaction {
    Reaction::Reply(Frame::Refusal(refusal))
}

#[test]
fn nothing_runs_before_an_agreed_hello() {
    let mut bench = Bench::new();
    assert_eq!(bench.receive(measurement(1, 0.0)), refused(Refusal::NoHello));
    assert_eq!(bench.receive(reference(1.0)), refused(Refusal::NoHello));
    assert_eq!(bench.tick(), None);
}

#[test]
fn a_hello_that_agrees_starts_the_pacing_it_asks_for() {
    for pacing in [Pacing::LockStep, Pacing::Timer] {
        let mut bench = Bench::new();
        let hello = Hello { pacing, ..OWN };
        assert_eq!(bench.receive(Frame::Hello(hello)), Reaction::Start(pacing, Frame::Hello(hello)));
        assert_eq!(bench.session.state(), State::Bench(pacing, None));
    }
}

#[test]
fn a_hello_for_anything_else_stops_and_says_what_this_is() {
    let others = [
        Hello { robot: 8, ..OWN },
        Hello { joints: 3, ..OWN },
        Hello { rate_hz: 1000.0, ..OWN },
        Hello { rate_hz: f32::NAN, ..OWN },
    ];
    for other in others {
        let mut bench = Bench::running(Pacing::LockStep);
        let answer = bench.receive(Frame::Hello(other));
        assert_eq!(answer, Reaction::Stop(Frame::Hello(OWN), Frame::Refusal(Refusal::OtherRobot)), "{other:?}");
        assert_eq!(bench.session.state(), State::Waiting);
        assert_eq!(bench.tick(), None);
    }
}

#[test]
fn in_lock_step_a_measurement_starts_one_tick_and_the_answer_has_its_number_and_cost() {
    let mut bench = Bench::running(Pacing::LockStep);
    assert_eq!(bench.receive(measurement(1, 0.0)), refused(Refusal::NoReference));
    assert_eq!(bench.receive(reference(2.0)), Reaction::None);
    assert_eq!(bench.receive(measurement(41, 0.01)), Reaction::Tick);
    let Some(Frame::Command(command)) = bench.tick() else { panic!("a command") };
    assert_eq!(command.tick, 41);
    assert_eq!(command.torque.as_slice(), [2.0 - 100.0 * 0.01; 2]);
    assert_eq!(command.cost, Some(Cost::Instructions(0)));
}

#[test]
fn a_fault_stays_and_goes_with_the_next_hello() {
    let mut bench = Bench::running(Pacing::LockStep);
    bench.receive(reference(0.0));
    bench.receive(measurement(1, f32::NAN));
    assert_eq!(bench.fault_code(), Some(1));
    bench.receive(measurement(2, 0.0));
    assert_eq!(bench.fault_code(), Some(1));
    bench.receive(Frame::Hello(OWN));
    assert_eq!(bench.session.state(), State::Bench(Pacing::LockStep, None));
    assert_eq!(bench.receive(measurement(3, 0.0)), refused(Refusal::NoReference));
}

#[test]
fn on_the_timer_measurements_age_until_they_are_stale() {
    let mut bench = Bench::running(Pacing::Timer);
    assert_eq!(bench.tick(), None);
    bench.receive(reference(0.0));
    assert_eq!(bench.receive(measurement(5, 0.0)), Reaction::None);
    for tick in 5..=7 {
        let Some(Frame::Command(command)) = bench.tick() else { panic!("a command") };
        assert_eq!(command.tick, tick);
    }
    assert_eq!(bench.fault_code(), Some(3));
}

#[test]
fn an_overrun_is_the_next_tick_s_fault() {
    let mut bench = Bench::running(Pacing::Timer);
    bench.receive(reference(0.0));
    bench.receive(measurement(1, 0.0));
    bench.tick();
    bench.session.overrun();
    assert_eq!(bench.fault_code(), Some(6));
}

#[test]
fn whatever_cannot_be_used_is_refused_by_name_and_changes_nothing() {
    let mut bench = Bench::running(Pacing::LockStep);
    bench.receive(reference(0.0));
    let other = Reference { q: [0.0_f32; 3], qd: [0.0; 3], qdd: [0.0; 3] };
    assert_eq!(
        bench.receive(Frame::Reference(link::Reference::new(&other))),
        refused(Refusal::JointCount { expected: 2, found: 3 })
    );
    assert_eq!(bench.session.receive(Err(DecodeError::BadCrc)), refused(Refusal::Undecodable(DecodeError::BadCrc)));
    let lost = Received { frame: measurement(1, 0.0), missed: 2 };
    assert_eq!(bench.session.receive(Ok(lost)), refused(Refusal::Lost { missed: 2 }));
    assert_eq!(bench.receive(Frame::Refusal(Refusal::NoHello)), refused(Refusal::Unexpected));
    assert_eq!(bench.receive(measurement(9, 0.0)), Reaction::Tick);
    assert!(matches!(bench.tick(), Some(Frame::Command(_))));
}

/// Torques of one tick at rest, with a reference acceleration of 1.
fn torques(bench: &mut Bench) -> Vec<f32> {
    bench.receive(reference(1.0));
    assert_eq!(bench.receive(measurement(1, 0.0)), Reaction::Tick);
    let Some(Frame::Command(command)) = bench.tick() else { panic!("a command") };
    command.torque.to_vec()
}

#[test]
fn live_inputs_hold_from_the_next_tick_until_others_or_a_hello_come_and_are_not_answered() {
    let mut bench = Bench::new();
    assert_eq!(bench.receive(live([1.0, 2.0])), refused(Refusal::NoHello));
    bench.receive(Frame::Hello(OWN));
    assert_eq!(torques(&mut bench), [1.0, 1.0]);
    assert_eq!(bench.receive(live([1.0, 2.0])), Reaction::None);
    assert_eq!(torques(&mut bench), [2.0, 3.0]);
    assert_eq!(torques(&mut bench), [2.0, 3.0]);
    assert_eq!(bench.receive(live([0.5, 0.0])), Reaction::None);
    assert_eq!(torques(&mut bench), [1.5, 1.0]);
    bench.receive(Frame::Hello(OWN));
    assert_eq!(torques(&mut bench), [1.0, 1.0]);
}

#[test]
fn live_inputs_that_cannot_be_used_are_refused_and_the_ones_before_hold_on() {
    let mut bench = Bench::running(Pacing::LockStep);
    bench.receive(live([1.0, 2.0]));
    let other = link::Live::new(&Live { rotor: [5.0; 3], ..Live::<f32, 3>::zero() }).unwrap();
    let wrong_count = refused(Refusal::JointCount { expected: 2, found: 3 });
    assert_eq!(bench.receive(Frame::Live(other)), wrong_count);
    assert_eq!(bench.receive(live([5.0, f32::NAN])), refused(Refusal::NonFiniteLive));
    assert_eq!(torques(&mut bench), [2.0, 3.0]);
}

#[test]
fn live_inputs_that_nobody_has_checked_are_out_of_bounds() {
    let mut bench = Bench::running(Pacing::LockStep);
    let received = || Ok(Received { frame: live([1.0, 2.0]), missed: 0 });
    let mut message = Message::new(received());
    assert_eq!(bench.session.take(&message), Outcome::Refused(Refusal::OutOfBounds));
    assert_eq!(torques(&mut bench), [1.0, 1.0]);
    message.check(&bench.session.live_bounds());
    assert_eq!(bench.session.take(&message), Outcome::None);
    assert_eq!(torques(&mut bench), [2.0, 3.0]);
}
