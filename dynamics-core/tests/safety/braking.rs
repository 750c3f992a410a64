//! Braking: a stop begins at the right point, ends before the limit, and nothing jumps during the stop.

use crate::safety::support::*;
use dynamics_core::safety::{HoldCause, Inputs, State};
use dynamics_core::{Reference, Sensed};
use std::cell::Cell;

/// A machine that runs at `q` with the speed `qd` on joint 1, and its state, which may be another than running.
fn run_at(q: f32, qd: f32) -> (Machine, State) {
    let mut machine = after(&TO_RUNNING, [q, 0.0]);
    let output = machine.tick(&moving(q, qd), |_| wanting(1.0));
    (machine, output.state)
}

fn moving(q: f32, qd: f32) -> Setpoint {
    let reference = Reference { q: [q, 0.0], qd: [qd, 0.0], qdd: [0.0; 2] };
    Inputs { reference: Some(reference), ..calm([q, 0.0]) }
}

/// `v^2 / (2 a) + v t`, in double precision.
fn distance(v: f32) -> f64 {
    let v = f64::from(v);
    v * v / (2.0 * f64::from(DECELERATION)) + v * f64::from(LATENCY)
}

#[test]
fn a_reference_is_followed_while_there_is_room_to_stop_and_taken_over_when_there_is_none() {
    for step in 1..=60 {
        let v = 0.05 * step as f32;
        for side in [-1.0_f32, 1.0] {
            let last = f64::from(LIMIT) - distance(v);
            let (inside, beyond) = ((last - 1e-5) as f32, (last + 1e-5) as f32);
            assert_eq!(run_at(side * inside, side * v).1, State::Running, "{v}");
            let held = State::Holding(HoldCause::NoRoom { joint: 0 });
            assert_eq!(run_at(side * beyond, side * v).1, held, "{v}");
            // A joint that moves back inside has enough distance.
            assert_eq!(run_at(side * beyond, -side * v).1, State::Running, "{v}");
        }
    }
    // At the limit, at rest.
    assert_eq!(run_at(LIMIT, 0.0).1, State::Running);
}

#[test]
fn the_arm_itself_must_be_able_to_stop_before_the_guard() {
    let v = 2.5_f32;
    let last = f64::from(LIMIT + MARGIN) - distance(v);
    for (q, expected) in [(last - 1e-5, State::Running), (last + 1e-5, State::Holding(HoldCause::NoRoom { joint: 0 }))]
    {
        // The reference rests at the limit, within reach; the arm has moved past it.
        assert!(q - f64::from(LIMIT) < f64::from(REACH));
        let mut machine = after(&TO_RUNNING, [1.95, 0.0]);
        let sensed = Sensed::State { q: [q as f32, 0.0], qd: [v, 0.0] };
        let inputs = Inputs { sensed, reference: Some(Reference::at_rest([LIMIT, 0.0])), ..calm([0.0; 2]) };
        assert_eq!(machine.tick(&inputs, |_| wanting(1.0)).state, expected);
    }
}

#[test]
fn a_stop_ends_at_rest_before_the_limit_without_a_jump_of_place_or_speed() {
    let tick = PERIOD;
    for step in 1..=60 {
        let v = 0.05 * step as f32;
        for side in [-1.0_f32, 1.0] {
            let q = side * (f64::from(LIMIT) - distance(v) - 1e-5) as f32;
            let (mut machine, state) = run_at(q, side * v);
            assert_eq!(state, State::Running);
            let asked = Cell::new(Reference { q: [q, 0.0], qd: [side * v, 0.0], qdd: [0.0; 2] });
            let mut travelled = 0.0_f32;
            for count in 0.. {
                assert!(count < 400, "it does not come to rest");
                let before = asked.get();
                let told = Inputs { reference: None, ..calm([before.q[0], 0.0]) };
                let output = machine.tick(&told, |ask| {
                    asked.set(*ask.reference);
                    wanting(1.0)
                });
                assert_eq!(output.state, State::Holding(HoldCause::NoReference));
                let now = asked.get();
                let (slower, moved) = ((now.qd[0] - before.qd[0]).abs(), now.q[0] - before.q[0]);
                assert!(slower <= DECELERATION * tick * 1.000_01, "{slower}");
                assert!(moved.abs() <= before.qd[0].abs() * tick + 1e-6, "{moved}");
                assert!(now.q[0].abs() <= LIMIT);
                assert!((now.qdd[0] * tick - (now.qd[0] - before.qd[0])).abs() <= 1e-6);
                travelled += moved.abs();
                if now.qd[0] == 0.0 && before.qd[0] == 0.0 {
                    break;
                }
            }
            // The distance in the rule is that of the stop plus the latency's share.
            let needed = distance(v) - f64::from(v * LATENCY);
            assert!((f64::from(travelled) - needed).abs() <= 2e-5 + 1e-3 * needed, "{v}: {travelled}, {needed}");
        }
    }
}
