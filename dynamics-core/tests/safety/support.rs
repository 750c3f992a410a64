//! A machine for two joints, and inputs for it.

use dynamics_core::control::{ControlLaw, Encoder, Gains, Guard, LimitFlags, TrackingObserver};
use dynamics_core::newton_euler::InverseDynamics;
use dynamics_core::safety::{
    Actuation, Inputs, JointRules, Output, Protected, Request, Rules, SafeAction, Safety, State, TorqueRequest,
};
use dynamics_core::{Command, ControllerConfig, InertiaBounds, Limits, Live, Reference, Sensed, SinCos};

pub(crate) const LIMIT: f32 = 2.0;
pub(crate) const MARGIN: f32 = 0.5;
pub(crate) const TORQUE: f32 = 10.0;
pub(crate) const STEP: f32 = 4.0;
pub(crate) const HEARTBEAT_MAX: u32 = 5;
pub(crate) const HOLD_MAX: u32 = 3;
pub(crate) const AGE_MAX: u32 = 2;
pub(crate) const ARMING_MAX: u32 = 3;
pub(crate) const DECELERATION: f32 = 10.0;
pub(crate) const LATENCY: f32 = 0.002;
pub(crate) const PERIOD: f32 = 0.001;
pub(crate) const REACH: f32 = 0.2;
pub(crate) const REST: f32 = 0.05;
pub(crate) const JUMP: f32 = 1.0;
pub(crate) const SUPPLY: (f32, f32) = (20.0, 30.0);
pub(crate) const TEMPERATURE: (f32, f32) = (-10.0, 80.0);

pub(crate) type Machine = Safety<f32, 2, Protected<f32, 2>>;
pub(crate) type Setpoint = Inputs<f32, 2>;
pub(crate) type Said = Output<f32, 2>;

pub(crate) fn config() -> Protected<f32, 2> {
    let limits = Limits { position: (-2.0, 2.0), velocity: 3.0, torque: 10.0, torque_rate: 4000.0 };
    let control: ControllerConfig<f64, 2> = ControllerConfig {
        law: ControlLaw::ComputedTorque,
        gains: [Gains::new(20.0, 1.0, 1.0); 2],
        friction: None,
        limits: [limits; 2],
        torque_step: [4.0; 2],
        guard: [Guard { position_margin: 0.5, velocity_max: 6.0 }; 2],
        age_max: AGE_MAX,
        encoder: [Encoder { zero: 0, per_count: 1e-4 }; 2],
        observer: TrackingObserver::new(200.0, 1e-3),
        integral: None,
        teach: None,
        posture_damping: None,
    };
    let joint = JointRules {
        rest_speed: REST,
        jump_step: JUMP,
        resolution: 0.001,
        deceleration: DECELERATION,
        reach: REACH,
        reach_speed: 0.3,
        rotor_max: 2.0,
        damping: 1.0,
        lowering_speed: 0.2,
    };
    let rules = Rules {
        safe_action: SafeAction::Brake,
        heartbeat_max: HEARTBEAT_MAX,
        hold_max: HOLD_MAX,
        supply: SUPPLY,
        temperature: TEMPERATURE,
        period: PERIOD,
        rate: 1000.0,
        latency: LATENCY,
        arming_max: ARMING_MAX,
        brake_delay: 0,
        live: 0,
        live_max: 0,
        rest: None,
        first_motion: None,
        heat: None,
        payload: InertiaBounds { mass: 5.0, radius: 0.5 },
        joints: [joint; 2],
    };
    Protected { control: control.cast(), rules }
}

/// Inputs without any problem: the arm at rest at `q`, and the reference there.
pub(crate) fn calm(q: [f32; 2]) -> Setpoint {
    Inputs {
        request: None,
        emergency_stop: false,
        overrun: false,
        heartbeat_age: 0,
        zeroed: true,
        sensed: Sensed::State { q, qd: [0.0; 2] },
        age_ticks: [0; 2],
        drive_fault: [false; 2],
        on: [true; 2],
        zero_lost: false,
        live_age: 0,
        supply: None,
        temperature: None,
        reference: Some(Reference::at_rest(q)),
    }
}

pub(crate) fn asked(request: Request, inputs: &Setpoint) -> Setpoint {
    Inputs { request: Some(request), ..*inputs }
}

/// The command of a controller that asks for this torque on every joint.
pub(crate) fn wanting(torque: f32) -> Command<f32, 2> {
    Command::Drive { torque: [torque; 2], limits: [LimitFlags::NONE; 2] }
}

/// A tick whose request must be accepted, with a controller that asks for one newton metre.
pub(crate) fn granted(machine: &mut Machine, inputs: &Setpoint) -> Said {
    let output = machine.tick(inputs, |_: TorqueRequest<'_, f32, 2>| wanting(1.0));
    assert_eq!(output.refused, None, "{:?} in {:?}", inputs.request, output.state);
    output
}

/// A machine after these requests, one a tick, without any problem, at `q`.
pub(crate) fn after(requests: &[Request], q: [f32; 2]) -> Machine {
    let mut machine = Machine::new(config());
    granted(&mut machine, &calm(q));
    for request in requests {
        granted(&mut machine, &asked(*request, &calm(q)));
        arm(&mut machine, q);
    }
    machine
}

/// Waits until an arm that is being armed is armed.
pub(crate) fn arm(machine: &mut Machine, q: [f32; 2]) {
    while machine.state() == State::Arming {
        granted(machine, &calm(q));
    }
}

/// Torque of each weight, N m.
pub(crate) const WEIGHT: f32 = 6.0;

/// Unit masses, each under a weight: `tau = qdd + 6`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Weights;

impl InverseDynamics<f32, 2> for Weights {
    fn inverse_dynamics(
        &self,
        _turn: &[SinCos<f32>; 2],
        _q: &[f32; 2],
        _qd: &[f32; 2],
        qdd: &[f32; 2],
        _live: &Live<f32, 2>,
    ) -> [f32; 2] {
        qdd.map(|x| x + WEIGHT)
    }
}

pub(crate) const TO_ARMED: [Request; 3] = [Request::Home, Request::Confirm, Request::Arm];
pub(crate) const TO_RUNNING: [Request; 4] = [Request::Home, Request::Confirm, Request::Arm, Request::Run];

pub(crate) fn torque(output: &Said) -> Option<[f32; 2]> {
    match output.actuation {
        Actuation::Drive { torque, .. } => Some(torque),
        Actuation::Safe(_) | Actuation::Enable(_) | Actuation::Preload { .. } => None,
    }
}

pub(crate) fn is_fault(state: State) -> bool {
    matches!(state, State::Fault(_))
}
