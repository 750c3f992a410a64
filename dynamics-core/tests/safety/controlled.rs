//! The machine with a controller inside it: bumpless arming, running, stopping; encoder counts instead of states.

use crate::safety::support::*;
use dynamics_core::control::{ControlLaw, Controller, ControllerOf, Fault, LimitFlags, Teach};
use dynamics_core::safety::{Actuation, HoldCause, Inputs, Request, State};
use dynamics_core::trig::Polynomial;
use dynamics_core::{Command, Reference, Sensed};

fn preload(output: &Said) -> Option<[f32; 2]> {
    match output.actuation {
        Actuation::Preload { torque, .. } => Some(torque),
        _ => None,
    }
}

type Inside = ControllerOf<f32, 2, Weights, Polynomial, dynamics_core::safety::Protected<f32, 2>>;

fn controller() -> Inside {
    let config = config();
    assert_eq!(config.control.law, ControlLaw::ComputedTorque);
    Controller::new(config, Weights, Polynomial)
}

/// Sends all requests, and then waits as long as an arm takes to be armed.
fn ask_all(machine: &mut Machine, controller: &mut Inside, requests: &[Request], inputs: &Setpoint) {
    for request in requests {
        step(machine, controller, &asked(*request, inputs));
        while machine.state() == State::Arming {
            step(machine, controller, inputs);
        }
    }
}

fn step(machine: &mut Machine, controller: &mut Inside, inputs: &Setpoint) -> Said {
    let output = machine.tick(inputs, |ask| ask.of(controller));
    assert_eq!(output.refused, None);
    output
}

/// Number of ticks for which the drives carry the weight before the brakes open.
const CARRIED: u32 = 8;

#[test]
fn torque_rises_from_nothing_at_its_rate_when_the_arm_is_armed() {
    let (mut machine, mut inside) = (Machine::new(config()), controller());
    for request in [Request::Home, Request::Confirm] {
        assert_eq!(torque(&step(&mut machine, &mut inside, &asked(request, &calm([0.5; 2])))), None);
    }
    let armed = step(&mut machine, &mut inside, &asked(Request::Arm, &calm([0.5; 2])));
    // With engaged brakes the torque rises by 4 N m a tick to the 6 N m that hold the weight, for any reference of the host. Then the brakes open.
    assert_eq!((preload(&armed), armed.state), (Some([4.0; 2]), State::Arming));
    let far = Inputs { reference: Some(Reference::at_rest([-1.0; 2])), ..calm([0.5; 2]) };
    // The brakes open only after the drives have carried the weight for some ticks.
    for _ in 0..CARRIED {
        assert_eq!(preload(&step(&mut machine, &mut inside, &far)), Some([6.0; 2]));
    }
    let armed = step(&mut machine, &mut inside, &far);
    assert_eq!((torque(&armed), armed.state), (Some([6.0; 2]), State::Armed));
    // The arm stays where it was armed, as on a spring.
    let away = step(&mut machine, &mut inside, &calm([0.499; 2]));
    let wanted = 6.0 + 400.0 * 0.001;
    assert!((torque(&away).unwrap()[0] - wanted).abs() < 1e-3);
}

#[test]
fn every_change_of_state_is_bumpless_and_a_fault_starts_afresh() {
    let (mut machine, mut inside) = (Machine::new(config()), controller());
    ask_all(&mut machine, &mut inside, &TO_ARMED, &calm([0.0; 2]));
    step(&mut machine, &mut inside, &calm([0.0; 2]));
    let (mut q, mut last) = (0.0_f32, 6.0_f32);
    // Armed, running from rest with 1 rad/s^2, holding in full motion, running again.
    let mut kinds = Vec::new();
    for tick in 0..600_u32 {
        let t = tick as f32 * PERIOD;
        let request = match tick {
            50 => Some(Request::Run),
            300 => Some(Request::Hold),
            500 => Some(Request::Run),
            _ => None,
        };
        let since = (t - 0.05).max(0.0);
        let wanted = match tick {
            0..=50 => Reference::at_rest([q; 2]),
            51..=299 => Reference { q: [0.5 * since * since; 2], qd: [since; 2], qdd: [1.0; 2] },
            _ => Reference::at_rest([q; 2]),
        };
        let mut followed = wanted;
        let told = Inputs {
            request,
            reference: Some(wanted),
            sensed: Sensed::State { q: [q; 2], qd: [wanted.qd[0]; 2] },
            ..calm([q; 2])
        };
        let output = machine.tick(&told, |ask| {
            followed = *ask.reference;
            ask.of(&mut inside)
        });
        assert_eq!(output.refused, None, "{tick}");
        let now = torque(&output).unwrap()[0];
        assert!((now - last).abs() <= STEP * 1.000_01, "tick {tick}: from {last} to {now}");
        // The reference in force never jumps farther than it moves in a tick.
        assert!((followed.q[0] - q).abs() <= 2e-3, "tick {tick}");
        (q, last) = (followed.q[0], now);
        if kinds.last() != Some(&output.state) {
            kinds.push(output.state);
        }
    }
    assert_eq!(kinds, [State::Armed, State::Running, State::Holding(HoldCause::Requested), State::Running]);
    // After a fault that is cleared, and arming again, the ramp begins at zero.
    let stopped = machine.tick(&Inputs { emergency_stop: true, ..calm([q; 2]) }, |_| panic!("asked for torque"));
    assert_eq!(stopped.state, State::Fault(Fault::EmergencyStop));
    step(&mut machine, &mut inside, &asked(Request::Clear, &calm([q; 2])));
    let armed = step(&mut machine, &mut inside, &asked(Request::Arm, &calm([q; 2])));
    assert_eq!(preload(&armed), Some([4.0; 2]));
}

#[test]
fn the_controller_s_own_fault_becomes_the_machine_s() {
    let (mut machine, mut inside) = (Machine::new(config()), controller());
    ask_all(&mut machine, &mut inside, &TO_RUNNING, &calm([0.0; 2]));
    let wild = Reference { q: [0.0; 2], qd: [0.0; 2], qdd: [0.0, f32::MAX] };
    let fine = Inputs { reference: Some(wild), ..calm([0.0; 2]) };
    // The torque is finite, and limited.
    assert_eq!(torque(&step(&mut machine, &mut inside, &fine)), Some([6.0, 10.0]));
    inside.overrun();
    let output = machine.tick(&calm([0.0; 2]), |ask| ask.of(&mut inside));
    assert_eq!(output.state, State::Fault(Fault::Overrun));
    assert!(matches!(output.actuation, Actuation::Safe(_)));
}

#[test]
fn encoders_are_judged_by_their_counts_and_a_slip_takes_the_homing_away() {
    let mut protected = config();
    protected.rules.joints.iter_mut().for_each(|joint| joint.jump_step = 0.006);
    let mut machine = Machine::new(protected);
    let mut inside = Controller::new(protected, Weights, Polynomial);
    let counts = |n: i32| Inputs { sensed: Sensed::Counts([n, 0]), ..calm([n as f32 * 1e-4, 0.0]) };
    // The observer of a joint far from zero first has to converge.
    for _ in 0..100 {
        step(&mut machine, &mut inside, &counts(8000));
    }
    ask_all(&mut machine, &mut inside, &TO_RUNNING, &counts(8000));
    // 50 counts are 5 mrad: as far as 5 rad/s moves. 75 are more than 6 mrad plus the encoder's resolution.
    let mut quick = machine;
    assert_ne!(
        quick.tick(&counts(8050), |ask| ask.of(&mut inside)).state,
        State::Fault(Fault::ImpossibleJump { joint: 0 })
    );
    let output = machine.tick(&counts(8075), |_| panic!("asked for torque"));
    assert_eq!((output.state, output.homed), (State::Fault(Fault::ImpossibleJump { joint: 0 }), false));
}

/// An arm that should hold still raises a fault if it is out of reach of its reference: at the edge, from both sides, in every state that holds.
#[test]
fn an_arm_that_does_not_stay_where_it_holds_is_a_fault() {
    const AT: [f32; 2] = [0.25, -0.5];
    let to_holding = [Request::Home, Request::Confirm, Request::Arm, Request::Run, Request::Hold];
    for (requests, reach) in [(&TO_ARMED[..], REACH), (&to_holding[..], 1.5 * REACH)] {
        for joint in 0..2 {
            for side in [-1.0, 1.0] {
                let mut near = AT;
                near[joint] += side * (reach - 1e-4);
                let mut beyond = AT;
                beyond[joint] += side * (reach + 1e-4);
                let mut machine = after(requests, AT);
                let held = machine.state();
                let pushed = |q| Inputs { reference: None, ..calm(q) };
                assert_eq!(granted(&mut machine, &pushed(near)).state, held, "{requests:?}, joint {joint}");
                let output = machine.tick(&pushed(beyond), |_| panic!("asked for torque"));
                assert_eq!(output.state, State::Fault(Fault::FollowingError { joint: joint as u8 }));
                // The fault stays, and can be cleared at the arm's current position: there is no reference that it could be away from.
                assert_eq!(granted(&mut machine, &asked(Request::Clear, &calm(beyond))).state, State::Idle);
            }
        }
    }
}

/// A controller that is compliant after a collision does not follow its reference; the arm is where it was pushed.
#[test]
fn an_arm_that_gives_way_to_a_collision_may_be_pushed_away() {
    let mut machine = after(&TO_ARMED, [0.0; 2]);
    let complying = Command::Drive { torque: [0.0; 2], limits: [LimitFlags::COLLISION, LimitFlags::NONE] };
    assert_eq!(machine.tick(&calm([0.0; 2]), |_| complying).state, State::Armed);
    assert_eq!(machine.tick(&calm([0.5, 0.0]), |_| complying).state, State::Armed);
    // From here on it follows again, and is still away from its reference.
    assert_eq!(machine.tick(&calm([0.5, 0.0]), |_| wanting(0.0)).state, State::Armed);
    let output = machine.tick(&calm([0.5, 0.0]), |_| panic!("asked for torque"));
    assert_eq!(output.state, State::Fault(Fault::FollowingError { joint: 0 }));
}

#[test]
fn an_arm_that_is_led_by_hand_runs_wherever_it_is_led_and_is_held_there() {
    let teach = Teach {
        friction: 0.0,
        per_still_speed: 20.0,
        breakaway: 0.5,
        slip: 0.5 / 400.0,
        drag: 0.1,
        speed: 1.5,
        wall: (-1.9, 1.9),
        per_wall: 10.0,
        stiffness: 400.0,
        damping: 40.0,
        slowing: 0.0,
    };
    let mut config = config();
    (config.control.law, config.control.teach) = (ControlLaw::Teach, Some([teach; 2]));
    let (mut machine, mut inside) = (Machine::new(config), Controller::new(config, Weights, Polynomial));
    ask_all(&mut machine, &mut inside, &TO_ARMED, &calm([0.0; 2]));
    // While armed it is held as on a spring: 400 N m/rad of the law that holds it.
    step(&mut machine, &mut inside, &calm([0.0; 2]));
    let pushed = torque(&step(&mut machine, &mut inside, &calm([0.004; 2]))).unwrap()[0];
    assert!((pushed - (6.0 - 1.6)).abs() < 1e-4, "{pushed}");
    // The host's reference is far away, and the arm does not follow it.
    let told = |q: f32, qd: f32, request| Inputs {
        request,
        reference: Some(Reference::at_rest([-1.5; 2])),
        sensed: Sensed::State { q: [q; 2], qd: [qd; 2] },
        ..calm([q; 2])
    };
    step(&mut machine, &mut inside, &told(0.0, 0.0, Some(Request::Run)));
    let mut q = 0.0;
    for _ in 0..1000 {
        q += PERIOD;
        let output = step(&mut machine, &mut inside, &told(q, 1.0, None));
        assert_eq!(output.state, State::Running);
        let carried = torque(&output).unwrap()[0];
        // At first the spring that held it has to yield.
        assert!(q < 0.01 || (carried - (6.0 - 0.1)).abs() < 1e-4, "{carried} at {q}");
    }
    // Released, it stays still: the first tick finds it at rest. When held, it is held where it is, without a bump.
    let still = torque(&step(&mut machine, &mut inside, &told(q, 0.0, None))).unwrap()[0];
    let held = step(&mut machine, &mut inside, &told(q, 0.0, Some(Request::Hold)));
    assert_eq!(held.state, State::Holding(HoldCause::Requested));
    let held = torque(&held).unwrap()[0];
    assert!((held - 6.0).abs() < 1e-4 && (still - held).abs() <= 0.5, "{still}, {held}");
    let moved = torque(&step(&mut machine, &mut inside, &told(q + 0.004, 0.0, None))).unwrap()[0];
    assert!((moved - (6.0 - 1.6)).abs() < 1e-3, "{moved}");
    // Without a host the arm is not hand-guided.
    step(&mut machine, &mut inside, &told(q, 0.0, Some(Request::Run)));
    let silent = step(&mut machine, &mut inside, &Inputs { reference: None, ..told(q, 0.0, None) });
    assert_eq!(silent.state, State::Holding(HoldCause::NoReference));
}
