//! The safety state machine around one joint: home, confirm, arm, run, emergency stop, clear.
//!
//! ```console
//! $ cargo run -p dynamics-core --example safety
//! ```

use dynamics_core::control::{Gains, LimitFlags};
use dynamics_core::safety::{
    Actuation, Inputs, JointRules, Output, Protected, Refusal, Request, Rules, SafeAction, Safety, State, TorqueRequest,
};
use dynamics_core::{Command, ControllerConfig, Fault, InertiaBounds, Limits, Reference, Sensed};

/// Settings for a joint with a holding brake, at one tick a millisecond.
fn settings() -> Protected<f32, 1> {
    let limits = Limits { position: (-2.0, 2.0), velocity: 3.0, torque: 30.0, torque_rate: 2000.0 };
    let control = ControllerConfig::new([Gains::new(20.0, 1.0, 1.0)], [limits], 1e-3);
    let joint = JointRules {
        rest_speed: 0.05,
        jump_step: 0.05,
        resolution: 1e-3,
        deceleration: 10.0,
        reach: 0.2,
        reach_speed: 0.3,
        rotor_max: 0.0,
        damping: 1.0,
        lowering_speed: 0.2,
    };
    let rules = Rules {
        safe_action: SafeAction::Brake,
        heartbeat_max: 50,
        hold_max: 500,
        supply: (20.0, 30.0),
        temperature: (-10.0, 80.0),
        period: 1e-3,
        rate: 1e3,
        latency: 2e-3,
        arming_max: 100,
        brake_delay: 20,
        live: 0,
        live_max: 0,
        rest: None,
        first_motion: None,
        heat: None,
        payload: InertiaBounds { mass: 0.0, radius: 0.0 },
        joints: [joint],
    };
    Protected { control: control.cast(), rules }
}

fn main() {
    let mut machine = Safety::new(settings());
    // A joint at rest, and a board that reports no problem.
    let calm = Inputs {
        emergency_stop: false,
        overrun: false,
        heartbeat_age: 0,
        zeroed: true,
        sensed: Sensed::State { q: [0.0], qd: [0.0] },
        age_ticks: [0],
        drive_fault: [false],
        on: [true],
        zero_lost: false,
        supply: Some(24.0),
        temperature: Some(25.0),
        reference: Some(Reference::at_rest([0.0])),
        ..Inputs::unknown()
    };
    let mut tick = |what: &str, request, emergency_stop| {
        let inputs = Inputs { request, emergency_stop, ..calm };
        // The control law: here the weight of the link, 9.81 N m. With a `Controller` it is `|ask| ask.of(&mut controller)`.
        let law = |_: TorqueRequest<'_, f32, 1>| Command::Drive { torque: [9.81], limits: [LimitFlags::NONE] };
        let Output { state, actuation, refused, .. } = machine.tick(&inputs, law);
        if !what.is_empty() {
            let torque = if matches!(actuation, Actuation::Drive { .. }) { "torque" } else { "no torque" };
            let reason = refused.map_or(String::new(), |reason| format!(", refused: {reason}"));
            println!("{what:<24} {state}, {torque}{reason}");
        }
        (state, refused)
    };
    assert_eq!(tick("start", None, false), (State::Idle, None));
    assert_eq!(tick("arm, not homed", Some(Request::Arm), false), (State::Idle, Some(Refusal::NotHomed)));
    assert_eq!(tick("home", Some(Request::Home), false).0, State::Homing);
    assert_eq!(tick("confirm", Some(Request::Confirm), false).0, State::Idle);
    assert_eq!(tick("arm", Some(Request::Arm), false).0, State::Arming);
    // The drives take up the weight at the allowed torque rate before the brake opens.
    let waited = (1..100).take_while(|_| tick("", None, false).0 == State::Arming).count();
    assert_eq!(tick("drives carry the weight", None, false).0, State::Armed, "after {waited} ticks");
    assert_eq!(tick("run", Some(Request::Run), false).0, State::Running);

    let stopped = State::Fault(Fault::EmergencyStop);
    assert_eq!(tick("emergency stop pressed", None, true), (stopped, None));
    println!("{:24} check {}", "", Fault::EmergencyStop.check());
    assert_eq!(tick("clear, still pressed", Some(Request::Clear), true).0, stopped);
    assert_eq!(tick("released", None, false).0, stopped);
    assert_eq!(tick("clear", Some(Request::Clear), false).0, State::Idle);
}
