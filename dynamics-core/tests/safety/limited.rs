//! Limits due to a person or a motor's heat: the first motion after homing, and warm motors.

use crate::safety::support::*;
use dynamics_core::control::{Controller, ControllerOf, Fault, LimitFlags};
use dynamics_core::safety::heat::{FAULT, HeatRules, WARNING};
use dynamics_core::safety::{Actuation, HoldCause, Inputs, LiveInput, Protected, Refusal, Request, SafeAction, State};
use dynamics_core::trig::Polynomial;
use dynamics_core::{Reference, Sensed};

/// Share of the limits in the first motion, and the resulting limits, N m and rad/s.
const SHARE: f32 = 0.2;
const BEYOND: f32 = SHARE * TORQUE;
const SPEED: f32 = SHARE * 3.0;

struct Arm {
    machine: Machine,
    controller: ControllerOf<f32, 2, Weights, Polynomial, Protected<f32, 2>>,
}

impl Arm {
    fn of(protected: Protected<f32, 2>) -> Self {
        Self { machine: Machine::new(protected), controller: Controller::new(protected, Weights, Polynomial) }
    }

    fn tick(&mut self, inputs: &Setpoint) -> Said {
        self.machine.tick(inputs, |ask| ask.of(&mut self.controller))
    }

    fn ask(&mut self, requests: &[Request]) {
        for request in requests {
            assert_eq!(self.tick(&asked(*request, &calm([0.0; 2]))).refused, None, "{request:?}");
            while self.machine.state() == State::Arming {
                self.tick(&calm([0.0; 2]));
            }
        }
    }
}

/// A machine that limits the first motion.
fn limited() -> Protected<f32, 2> {
    let mut protected = config();
    protected.rules.first_motion = Some(SHARE);
    protected
}

fn moving(speed: f32) -> Setpoint {
    let reference = Reference { q: [0.0; 2], qd: [speed; 2], qdd: [0.0; 2] };
    Inputs { reference: Some(reference), sensed: Sensed::State { q: [0.0; 2], qd: [speed; 2] }, ..calm([0.0; 2]) }
}

/// An arm at rest, with a reference at this distance.
fn drawn(distance: f32) -> Setpoint {
    Inputs { reference: Some(Reference::at_rest([distance; 2])), ..calm([0.0; 2]) }
}

fn limits(output: &Said) -> [LimitFlags; 2] {
    match output.actuation {
        Actuation::Drive { limits, .. } => limits,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_first_motion_that_is_too_fast_is_refused_or_held_until_the_limit_is_lifted() {
    let mut arm = Arm::of(limited());
    arm.ask(&TO_ARMED);
    let refused = arm.tick(&asked(Request::Run, &moving(1.01 * SPEED)));
    assert_eq!(refused.refused, Some(Refusal::FirstMotion { joint: 0 }));
    arm.ask(&[Request::Run]);
    assert_eq!(arm.tick(&moving(0.99 * SPEED)).state, State::Running);
    assert_eq!(arm.tick(&moving(1.01 * SPEED)).state, State::Holding(HoldCause::FirstMotion { joint: 0 }));
    // The arm comes to rest where its reference does.
    let stop = (0.99 * SPEED).powi(2) / (2.0 * DECELERATION);
    for _ in 0..200 {
        arm.tick(&calm([stop; 2]));
    }
    assert_eq!(arm.tick(&asked(Request::FullRange, &calm([stop; 2]))).refused, None);
    arm.ask(&[Request::Run]);
    assert_eq!(arm.tick(&moving(1.01 * SPEED)).state, State::Running);
    // Every homing applies the limits again.
    arm.ask(&[Request::Hold]);
    for _ in 0..200 {
        arm.tick(&calm([0.0; 2]));
    }
    arm.ask(&[Request::Disarm, Request::Home, Request::Confirm, Request::Arm, Request::Run]);
    assert_eq!(arm.tick(&moving(1.01 * SPEED)).state, State::Holding(HoldCause::FirstMotion { joint: 0 }));
}

#[test]
fn an_arm_that_is_itself_too_fast_in_its_first_motion_is_a_fault() {
    let share = |velocity_max: f32| SHARE * velocity_max;
    let run = |speed: f32| {
        let mut arm = Arm::of(limited());
        arm.ask(&TO_RUNNING);
        arm.tick(&Inputs { sensed: Sensed::State { q: [0.0; 2], qd: [speed; 2] }, ..calm([0.0; 2]) }).state
    };
    assert_eq!(run(0.99 * share(6.0)), State::Running);
    assert_eq!(run(1.01 * share(6.0)), State::Fault(Fault::VelocityOutOfBounds { joint: 0 }));
}

/// The limits can be lifted neither while the drives are switched on, nor while they are about to be switched off, nor in motion.
#[test]
fn the_limits_of_the_first_motion_are_lifted_only_without_torque_or_at_rest() {
    let mut protected = limited();
    protected.rules.brake_delay = 5;
    protected.rules.rest = Some([-0.5, 0.0]);
    let mut arm = Arm::of(protected);
    let refused = |arm: &mut Arm, inputs: &Setpoint| arm.tick(&asked(Request::FullRange, inputs)).refused;
    let still = calm([0.0; 2]);
    assert_eq!(refused(&mut arm, &still), Some(Refusal::NotHomed));
    arm.tick(&asked(Request::Home, &still));
    assert_eq!(refused(&mut arm, &still), Some(Refusal::WrongState));
    arm.tick(&asked(Request::Confirm, &still));
    let idle = |arm: &mut Arm| arm.ask(&[Request::Home, Request::Confirm]);
    arm.tick(&asked(Request::Arm, &still));
    assert_eq!((arm.machine.state(), refused(&mut arm, &still)), (State::Arming, Some(Refusal::WrongState)));
    while arm.machine.state() == State::Arming {
        arm.tick(&still);
    }
    let moves = Inputs { sensed: Sensed::State { q: [0.0; 2], qd: [0.5 * SPEED; 2] }, ..still };
    assert_eq!(refused(&mut arm, &moves), Some(Refusal::NotAtRest));
    let silent = Inputs { heartbeat_age: HEARTBEAT_MAX + 1, ..still };
    while arm.machine.state() != State::Lowering {
        arm.tick(&silent);
    }
    assert_eq!(refused(&mut arm, &silent), Some(Refusal::WrongState));
    arm.ask(&[Request::Hold, Request::Disarm]);
    assert_eq!((arm.machine.state(), refused(&mut arm, &still)), (State::Disarming, Some(Refusal::WrongState)));
    while arm.machine.state() == State::Disarming {
        arm.tick(&still);
    }
    idle(&mut arm);
    assert_eq!(refused(&mut arm, &still), None);
}

#[test]
fn torque_beyond_the_weight_is_limited_in_the_first_motion_and_then_not() {
    let mut arm = Arm::of(limited());
    arm.ask(&TO_RUNNING);
    // 400 N m/rad: half of the torque that may act, all of it, and more.
    for (wanted, acts) in [(0.5 * BEYOND, 0.5 * BEYOND), (2.0 * BEYOND, BEYOND), (-2.0 * BEYOND, -BEYOND)] {
        for _ in 0..5 {
            arm.tick(&drawn(wanted / 400.0));
        }
        let output = arm.tick(&drawn(wanted / 400.0));
        let torque = torque(&output).unwrap()[0];
        assert!((torque - (WEIGHT + acts)).abs() < 1e-4, "{torque} for {wanted}");
        assert_eq!(limits(&output)[0].contains(LimitFlags::TORQUE), wanted != acts);
    }
    // The torque held back would act at once.
    let refused = |arm: &mut Arm, inputs: &Setpoint| arm.tick(&asked(Request::FullRange, inputs)).refused;
    assert_eq!(refused(&mut arm, &drawn(-2.0 * BEYOND / 400.0)), Some(Refusal::WrongState));
    arm.tick(&asked(Request::Hold, &drawn(-2.0 * BEYOND / 400.0)));
    assert_eq!(arm.machine.state(), State::Holding(HoldCause::Requested));
    for _ in 0..5 {
        assert_eq!(refused(&mut arm, &calm([0.0; 2])), Some(Refusal::NotAtRest));
        let torque = torque(&arm.tick(&calm([0.0; 2]))).unwrap()[0];
        assert!((torque - (WEIGHT - BEYOND)).abs() < 1e-4, "{torque}");
    }
    // The arm has reached its reference.
    let there = calm([-2.0 * BEYOND / 400.0; 2]);
    for _ in 0..5 {
        arm.tick(&there);
    }
    assert_eq!(refused(&mut arm, &there), None);
    let free = |arm: &mut Arm| {
        for _ in 0..5 {
            arm.tick(&calm([0.0; 2]));
        }
        torque(&arm.tick(&calm([0.0; 2]))).unwrap()[0]
    };
    let free = free(&mut arm);
    assert!((free - (WEIGHT - 2.0 * BEYOND)).abs() < 1e-4, "{free}");
}

/// Heat rules for two motors: the first one's heat settles at `1.44 = (6 / 5)^2` under the weight, and at 0 without. Time constant: 2000 ticks.
fn warming() -> Protected<f32, 2> {
    let mut protected = config();
    // The second motor is stronger.
    let rules = [5.0, 50.0].map(|rated| HeatRules::new(rated, 2.0, 2.0 * 1e-3).cast());
    protected.rules.heat = Some(rules);
    protected
}

/// A motor's heat does not end the torque that holds the arm until its brakes have engaged.
#[test]
fn an_overheated_arm_with_brakes_is_held_until_they_have_engaged() {
    let still = calm([0.0; 2]);
    let hot = |brake_delay: u32, until: f64| {
        let mut protected = warming();
        protected.rules.brake_delay = brake_delay;
        let mut arm = Arm::of(protected);
        arm.ask(&TO_ARMED);
        while f64::from(arm.machine.heat()[0]) < until && arm.machine.state() == State::Armed {
            arm.tick(&still);
        }
        arm
    };
    // An emergency stop still acts at once.
    for stop_after in [None, Some(3)] {
        let mut arm = hot(7, 2.0);
        assert_eq!(arm.machine.state(), State::Disarming);
        for tick in 1..7 {
            let stop = stop_after == Some(tick);
            let output = arm.tick(&Inputs { emergency_stop: stop, ..still });
            if stop {
                assert_eq!(output.state, State::Fault(Fault::EmergencyStop));
                break;
            }
            assert!(matches!(output.actuation, Actuation::Preload { .. }), "{tick}: {output:?}");
        }
        let fault = if stop_after.is_some() { Fault::EmergencyStop } else { Fault::Overheated { joint: 0 } };
        let output = arm.tick(&still);
        assert_eq!((output.state, output.actuation), (State::Fault(fault), Actuation::Safe(SafeAction::Brake)));
    }
    // Without brakes, or with brakes that engage at once, it ends in the same tick.
    assert_eq!(hot(0, 2.0).machine.state(), State::Fault(Fault::Overheated { joint: 0 }));
    // An arm that is already being disarmed cools, and ends as requested.
    let mut arm = hot(400, 1.03);
    arm.ask(&[Request::Disarm]);
    while arm.machine.state() == State::Disarming {
        arm.tick(&still);
    }
    assert_eq!(arm.machine.state(), State::Idle);
    assert!(f64::from(arm.machine.heat()[0]) > FAULT, "{:?}", arm.machine.heat());
}

#[test]
fn a_warm_motor_gives_less_beyond_the_weight_and_an_overheated_one_is_a_fault_that_lasts_until_it_has_cooled() {
    let mut arm = Arm::of(warming());
    arm.ask(&TO_RUNNING);
    let distance = 4.0 / 400.0;
    let (mut warnings, mut least, mut ticks) = (0, f32::MAX, 0);
    let fault = loop {
        let before = *arm.machine.heat();
        let output = arm.tick(&drawn(distance));
        ticks += 1;
        assert!(ticks < 10_000, "it never overheats: {before:?}");
        if let State::Fault(fault) = output.state {
            assert!(f64::from(before[0]) >= FAULT, "{before:?}");
            break fault;
        }
        let warm = f64::from(before[0]) >= WARNING;
        assert_eq!(limits(&output).map(|flags| flags.contains(LimitFlags::HEAT)), [warm, false], "{before:?}");
        let torque = torque(&output).unwrap()[0];
        assert!(torque >= WEIGHT - 1e-4, "the weight is carried: {torque} N m at {before:?}");
        if warm {
            warnings += 1;
            least = least.min(torque);
        }
    };
    assert_eq!(fault, Fault::Overheated { joint: 0 });
    // 1 N m is a tenth of the limit. The weight alone continues to heat the motor.
    assert!(warnings > 100 && (least - (WEIGHT + 1.0)).abs() < 1e-3, "{warnings} warnings, at least {least} N m");

    // A host that starts again finds the motors as hot as they are.
    arm.machine.reset(warming());
    assert!(f64::from(arm.machine.heat()[0]) > 1.0);
    arm.ask(&[Request::Home, Request::Confirm]);
    let refused = arm.tick(&asked(Request::Arm, &calm([0.0; 2])));
    assert_eq!(refused.refused, Some(Refusal::Fault(Fault::Overheated { joint: 0 })));
    let hot = arm.machine.heat()[0];
    for _ in 0..200 {
        arm.tick(&calm([0.0; 2]));
    }
    // It cools with its time constant.
    let expected = hot * (-0.2_f32 / 2.0).exp();
    assert!((arm.machine.heat()[0] - expected).abs() < 5e-3, "{:?}, not {expected}", arm.machine.heat());
    arm.ask(&[Request::Arm]);
}

#[test]
fn a_machine_that_knows_no_motor_s_heat_follows_none() {
    let mut arm = Arm::of(config());
    arm.ask(&TO_RUNNING);
    for _ in 0..1000 {
        assert_eq!(limits(&arm.tick(&drawn(0.009)))[0], LimitFlags::NONE);
    }
    assert_eq!(arm.machine.heat(), &[0.0; 2]);
}

#[test]
fn an_arm_without_brakes_is_limited_from_its_first_torque_on() {
    let mut protected = limited();
    protected.rules.safe_action = SafeAction::DampedStop;
    let mut arm = Arm::of(protected);
    arm.ask(&TO_ARMED);
    let torque = torque(&arm.tick(&calm([0.0; 2]))).unwrap();
    assert_eq!(torque, [WEIGHT; 2]);
}

#[test]
fn live_inputs_that_get_too_old_hold_a_running_arm_and_no_arm_starts_with_them() {
    let mut protected = config();
    (protected.rules.live, protected.rules.live_max) = (LiveInput::Payload.bit(), 50);
    let at = |age: u32| Inputs { live_age: age, ..calm([0.0; 2]) };
    let mut arm = Arm::of(protected);
    arm.ask(&[Request::Home, Request::Confirm]);
    let missing = arm.tick(&asked(Request::Arm, &at(u32::MAX)));
    assert_eq!(missing.refused, Some(Refusal::MissingInput(LiveInput::Payload)));
    let old = Some(Refusal::StaleInput(LiveInput::Payload));
    assert_eq!(arm.tick(&asked(Request::Arm, &at(51))).refused, old);
    arm.ask(&[Request::Arm]);
    assert_eq!(arm.tick(&asked(Request::Run, &at(51))).refused, old);
    arm.ask(&[Request::Run]);
    assert_eq!(arm.tick(&at(50)).state, State::Running);
    assert_eq!(arm.tick(&at(51)).state, State::Holding(HoldCause::StaleInput));
    // Without a limit the live inputs may have any age.
    protected.rules.live_max = 0;
    let mut arm = Arm::of(protected);
    arm.ask(&TO_RUNNING);
    assert_eq!(arm.tick(&at(1_000_000)).state, State::Running);
}
