//! Disarming an arm whose brakes need time to engage: torque holds it until they have engaged.

use crate::safety::support::*;
use dynamics_core::Fault;
use dynamics_core::control::Controller;
use dynamics_core::safety::{Actuation, HoldCause, Inputs, Protected, Refusal, Request, SafeAction, State};
use dynamics_core::trig::Polynomial;
use dynamics_core::{Command, Reference, Sensed};

const DELAY: u32 = 7;
const AT: [f32; 2] = [0.5, -0.25];

fn slow_brakes(delay: u32) -> Protected<f32, 2> {
    let mut protected = config();
    protected.rules.brake_delay = delay;
    protected
}

/// An armed machine with these rules.
fn armed(protected: Protected<f32, 2>) -> Machine {
    let mut machine = Machine::new(protected);
    granted(&mut machine, &calm(AT));
    for request in TO_ARMED {
        granted(&mut machine, &asked(request, &calm(AT)));
        arm(&mut machine, AT);
    }
    machine
}

fn preloads(output: &Said) -> bool {
    matches!(output.actuation, Actuation::Preload { .. })
}

fn alone() -> Setpoint {
    Inputs { heartbeat_age: HEARTBEAT_MAX + 1, reference: None, ..calm(AT) }
}

#[test]
fn torque_goes_on_for_exactly_as_long_as_the_brakes_need() {
    for delay in [1, 2, DELAY, 1000] {
        let mut machine = armed(slow_brakes(delay));
        let first = granted(&mut machine, &asked(Request::Disarm, &calm(AT)));
        assert!(preloads(&first) && first.state == State::Disarming);
        for tick in 1..delay {
            let output = granted(&mut machine, &calm(AT));
            assert!(preloads(&output) && output.state == State::Disarming, "{tick} of {delay}");
        }
        let last = granted(&mut machine, &calm(AT));
        assert_eq!((last.actuation, last.state), (Actuation::Safe(SafeAction::Brake), State::Idle), "{delay}");
    }
    // Brakes that engage at once.
    let mut machine = armed(slow_brakes(0));
    let output = granted(&mut machine, &asked(Request::Disarm, &calm(AT)));
    assert_eq!((output.actuation, output.state), (Actuation::Safe(SafeAction::Brake), State::Idle));
}

/// The torque continues without a step, and still reacts when the arm moves, because the model's weight alone may be wrong.
#[test]
fn the_arm_is_held_in_the_loop_until_the_brakes_have_engaged() {
    let protected = slow_brakes(DELAY);
    let (mut machine, mut inside) = (Machine::new(protected), Controller::new(protected, Weights, Polynomial));
    let mut step = |machine: &mut Machine, inputs: &Setpoint| machine.tick(inputs, |ask| ask.of(&mut inside));
    for request in TO_ARMED {
        step(&mut machine, &asked(request, &calm(AT)));
        while machine.state() == State::Arming {
            step(&mut machine, &calm(AT));
        }
    }
    // It hangs 1 mrad below its reference, as with a load that the model does not know: 400 N m/rad carry it.
    let below = AT.map(|q| q - 0.001);
    let given = |output: &Said| match output.actuation {
        Actuation::Drive { torque, .. } | Actuation::Preload { torque, .. } => torque[0],
        _ => panic!("no torque in {:?}", output.state),
    };
    for _ in 0..5 {
        step(&mut machine, &calm(below));
    }
    let before = given(&step(&mut machine, &calm(below)));
    assert!((before - (WEIGHT + 0.4)).abs() < 1e-3, "{before}");
    let first = step(&mut machine, &asked(Request::Disarm, &calm(below)));
    assert!(preloads(&first) && (given(&first) - before).abs() < 1e-3, "{before}, {first:?}");
    // It sinks another milliradian.
    let sunk = step(&mut machine, &calm(AT.map(|q| q - 0.002)));
    assert!(preloads(&sunk) && (given(&sunk) - (WEIGHT + 0.8)).abs() < 1e-3, "{sunk:?}");
}

/// An input that ends the torque at once, and the fault that it raises.
type DriveFaultReport = (fn(&mut Setpoint), Fault);

#[test]
fn a_fault_removes_the_torque_at_once_and_a_silent_host_does_not() {
    let troubles: [DriveFaultReport; 8] = [
        (|told| told.emergency_stop = true, Fault::EmergencyStop),
        (|told| told.request = Some(Request::Stop), Fault::EmergencyStop),
        (|told| told.overrun = true, Fault::Overrun),
        (|told| told.drive_fault[1] = true, Fault::DriveFault { joint: 1 }),
        (|told| told.on[1] = false, Fault::DriveOff { joint: 1 }),
        (|told| told.zero_lost = true, Fault::ZeroLost),
        (|told| told.age_ticks[0] = AGE_MAX + 1, Fault::StaleMeasurement),
        (
            |told| told.sensed = Sensed::State { q: [AT[0] + 1.5 * REACH + 0.01, AT[1]], qd: [0.0; 2] },
            Fault::FollowingError { joint: 0 },
        ),
    ];
    for after in 0..DELAY - 1 {
        for (trouble, fault) in troubles {
            let mut machine = armed(slow_brakes(DELAY));
            granted(&mut machine, &asked(Request::Disarm, &calm(AT)));
            for _ in 0..after {
                granted(&mut machine, &calm(AT));
            }
            let mut told = calm(AT);
            trouble(&mut told);
            let output = machine.tick(&told, |_| panic!("asked for torque"));
            let expected = (Actuation::Safe(SafeAction::Brake), State::Fault(fault));
            assert_eq!((output.actuation, output.state), expected, "after {after}");
        }
    }
    // The controller's own fault.
    let mut machine = armed(slow_brakes(DELAY));
    granted(&mut machine, &asked(Request::Disarm, &calm(AT)));
    let output = machine.tick(&calm(AT), |_| Command::Brake(Fault::Collision { joint: 0 }));
    assert_eq!(output.state, State::Fault(Fault::Collision { joint: 0 }));
    // Engaging the brakes does not need a host.
    let mut machine = armed(slow_brakes(DELAY));
    granted(&mut machine, &asked(Request::Disarm, &calm(AT)));
    for _ in 1..DELAY {
        assert_eq!(granted(&mut machine, &Inputs { heartbeat_age: u32::MAX, ..alone() }).state, State::Disarming);
    }
    assert_eq!(granted(&mut machine, &Inputs { heartbeat_age: u32::MAX, ..alone() }).state, State::Idle);
}

#[test]
fn nothing_but_a_stop_interrupts_it() {
    use Request::{Arm, Clear, Confirm, Disarm, Hold, Home, Run};
    for request in [Home, Confirm, Arm, Disarm, Run, Hold, Clear] {
        let mut machine = armed(slow_brakes(DELAY));
        granted(&mut machine, &asked(Disarm, &calm(AT)));
        for _ in 1..DELAY {
            let output = machine.tick(&asked(request, &calm(AT)), |_| wanting(1.0));
            assert!(preloads(&output), "{request:?}");
            assert_eq!((output.refused, output.state), (Some(Refusal::WrongState), State::Disarming), "{request:?}");
        }
        assert_eq!(machine.tick(&asked(request, &calm(AT)), |_| panic!("asked for torque")).state, State::Idle);
    }
}

/// Arming starts afterwards from the beginning, with neither the torque nor the tick count of before.
#[test]
fn an_arm_that_was_disarmed_is_armed_and_disarmed_again() {
    let mut machine = armed(slow_brakes(DELAY));
    for _ in 0..3 {
        let mut ticks = 0;
        granted(&mut machine, &asked(Request::Disarm, &calm(AT)));
        while machine.state() == State::Disarming {
            granted(&mut machine, &calm(AT));
            ticks += 1;
        }
        assert_eq!((ticks, machine.state()), (DELAY, State::Idle));
        let first = granted(&mut machine, &asked(Request::Arm, &calm(AT)));
        // The torque ramp starts at zero.
        assert!(matches!(first.actuation, Actuation::Preload { torque, .. } if torque == [1.0; 2]), "{first:?}");
        arm(&mut machine, AT);
        assert_eq!(machine.state(), State::Armed);
    }
}

/// The brakes have never opened before.
#[test]
fn an_arm_that_is_being_armed_is_idle_at_once() {
    let mut machine = Machine::new(slow_brakes(DELAY));
    granted(&mut machine, &calm(AT));
    for request in TO_ARMED {
        granted(&mut machine, &asked(request, &calm(AT)));
    }
    assert!(preloads(&granted(&mut machine, &calm(AT))) && machine.state() == State::Arming);
    let output = granted(&mut machine, &asked(Request::Disarm, &calm(AT)));
    assert_eq!((output.actuation, output.state), (Actuation::Safe(SafeAction::Brake), State::Idle));
}

#[test]
fn without_a_host_the_brakes_engage_before_the_fault() {
    let mut machine = armed(slow_brakes(DELAY));
    for _ in 0..HOLD_MAX {
        assert_eq!(granted(&mut machine, &alone()).state, State::Holding(HoldCause::HeartbeatLost));
    }
    for tick in 0..DELAY {
        // A host that comes back does not change the disarming that has begun.
        let inputs = if tick > 2 { calm(AT) } else { alone() };
        let output = granted(&mut machine, &inputs);
        assert!(preloads(&output) && output.state == State::Disarming, "{tick}");
    }
    let output = granted(&mut machine, &calm(AT));
    let expected = (Actuation::Safe(SafeAction::Brake), State::Fault(Fault::HeartbeatLost));
    assert_eq!((output.actuation, output.state), expected);
    // The next regular disarming ends without a fault.
    granted(&mut machine, &asked(Request::Clear, &calm(AT)));
    granted(&mut machine, &asked(Request::Arm, &calm(AT)));
    arm(&mut machine, AT);
    granted(&mut machine, &asked(Request::Disarm, &calm(AT)));
    for _ in 0..DELAY {
        granted(&mut machine, &calm(AT));
    }
    assert_eq!(machine.state(), State::Idle);
}

/// An arm in full motion, in a scene with a very short hold time: its reference slows down while the brakes engage.
#[test]
fn an_arm_that_still_moves_when_its_host_is_given_up_slows_down_along_its_reference() {
    let mut protected = slow_brakes(50);
    protected.rules.hold_max = 0;
    let mut machine = armed(protected);
    let moving = |k: u32, heartbeat_age| {
        let q = AT.map(|q| q + 0.3 * PERIOD * k as f32);
        Inputs {
            heartbeat_age,
            reference: Some(Reference { q, qd: [0.3; 2], qdd: [0.0; 2] }),
            sensed: Sensed::State { q, qd: [0.3; 2] },
            ..calm(q)
        }
    };
    granted(
        &mut machine,
        &asked(Request::Run, &Inputs { sensed: Sensed::State { q: AT, qd: [0.3; 2] }, ..moving(0, 0) }),
    );
    granted(&mut machine, &moving(1, 0));
    let (mut speed, mut ticks) = (0.3, 0);
    loop {
        let mut reference = None;
        let told = Inputs {
            sensed: Sensed::State { q: moving(2, 0).reference.unwrap().q, qd: [speed; 2] },
            ..moving(2, HEARTBEAT_MAX + 1)
        };
        let output = machine.tick(&told, |ask| {
            reference = Some(*ask.reference);
            wanting(1.0)
        });
        let Some(reference) = reference else {
            assert_eq!(output.state, State::Fault(Fault::HeartbeatLost));
            break;
        };
        ticks += 1;
        assert_eq!(output.state, State::Disarming);
        let slower = (speed - DECELERATION * PERIOD).max(0.0);
        assert!((reference.qd[0] - slower).abs() < 1e-5, "{ticks}: {reference:?}");
        speed = slower;
    }
    assert_eq!((ticks, speed), (50, 0.0));
}

#[test]
fn an_arm_that_has_been_lowered_is_held_until_its_brakes_have_engaged() {
    let mut protected = slow_brakes(DELAY);
    protected.rules.rest = Some(AT.map(|q| q + 0.004));
    let mut machine = armed(protected);
    let mut states = Vec::new();
    for _ in 0..1000 {
        let output = granted(&mut machine, &alone());
        if states.last().is_none_or(|(state, _)| *state != output.state) {
            states.push((output.state, 0));
        }
        states.last_mut().unwrap().1 += 1;
        assert_eq!(preloads(&output), output.state == State::Disarming);
        if is_fault(output.state) {
            break;
        }
    }
    let names: Vec<State> = states.iter().map(|(state, _)| *state).collect();
    let lost = State::Fault(Fault::HeartbeatLost);
    assert_eq!(names, [State::Holding(HoldCause::HeartbeatLost), State::Lowering, State::Disarming, lost]);
    assert_eq!(states[2].1, DELAY);
}
