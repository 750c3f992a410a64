//! Tests of the session through its interface: frames in, ticks and frames out, in bench modes and under supervision.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should stop there")]

mod bench;
mod edges;
mod hello;
mod supervised;
mod trajectory;

use dynamics_core::control::{
    BuildOf, ControlLaw, ControllerConfig, Encoder, Gains, Guard, Teach, TrackingObserver, Unprotected,
};
use dynamics_core::newton_euler::InverseDynamics;
use dynamics_core::safety::{JointRules, Protected, Rules, SafeAction};
use dynamics_core::scene::Live;
use dynamics_core::{InertiaBounds, Limits, SinCos};
use link::{Cost, Hello, Pacing};
use newtau_session::meter::Counter;
use std::cell::Cell;

/// Two uncoupled unit masses on unit gears with live rotor inertias, and an external force on the first: `tau = (1 + rotor) qdd - f`.
#[derive(Clone)]
struct UnitMasses;

impl InverseDynamics<f32, 2> for UnitMasses {
    fn inverse_dynamics(
        &self,
        _: &[SinCos<f32>; 2],
        _: &[f32; 2],
        _: &[f32; 2],
        qdd: &[f32; 2],
        live: &Live<f32, 2>,
    ) -> [f32; 2] {
        let force = [live.tip_wrench.force.x, 0.0];
        std::array::from_fn(|i| (1.0 + live.rotor[i]) * qdd[i] - force[i])
    }
}

/// A counter that advances by 1 at each reading and by 10 at each exercise.
struct Looks(Cell<u32>);

impl Counter for Looks {
    fn now(&self) -> u32 {
        self.0.set(self.0.get() + 1);
        self.0.get()
    }
    fn cost(count: u32) -> Cost {
        Cost::Instructions(count)
    }
    fn exercise(&self) {
        self.0.set(self.0.get() + 10);
    }
}

/// The parts of a controller of unit masses.
type Build =
    BuildOf<UnitMasses, dynamics_core::trig::Polynomial, ControllerConfig<f32, 2>, Unprotected, Protected<f32, 2>>;

const OWN: Hello = Hello { robot: 7, joints: 2, rate_hz: 500.0, pacing: Pacing::LockStep };

fn config() -> ControllerConfig<f32, 2> {
    let limits = Limits { position: (-3.0, 3.0), velocity: 5.0, torque: 50.0, torque_rate: 1e6 };
    ControllerConfig {
        law: ControlLaw::ComputedTorque,
        gains: [Gains { position: 100.0, velocity: 20.0, inertia: 1.0 }; 2],
        friction: None,
        limits: [limits; 2],
        torque_step: [2000.0; 2],
        guard: [Guard { position_margin: 0.1, velocity_max: 10.0 }; 2],
        age_max: 2,
        encoder: [Encoder { zero: 0, per_count: 0.001 }; 2],
        observer: TrackingObserver::from_gains(0.002, 2e-6, 0.5, 100.0),
        integral: None,
        teach: None,
        posture_damping: None,
    }
}

/// A configuration with hand guiding and without a limit of the torque rate.
fn soft() -> ControllerConfig<f32, 2> {
    let teach = Teach {
        friction: 0.0,
        per_still_speed: 100.0,
        breakaway: 1.0,
        slip: 0.01,
        drag: 0.1,
        speed: 1.0,
        wall: (-3.0, 3.0),
        per_wall: 0.0,
        stiffness: 100.0,
        damping: 20.0,
        slowing: 0.0,
    };
    ControllerConfig { torque_step: [f32::INFINITY; 2], teach: Some([teach; 2]), ..config() }
}

fn protected() -> Protected<f32, 2> {
    let joint = JointRules {
        rest_speed: 0.01,
        jump_step: 0.1,
        resolution: 0.01,
        deceleration: 50.0,
        reach: 0.5,
        reach_speed: 0.5,
        rotor_max: 2.0,
        damping: 1.0,
        lowering_speed: 0.2,
    };
    let rules = Rules {
        safe_action: SafeAction::DampedStop,
        heartbeat_max: 3,
        hold_max: 4,
        supply: (20.0, 30.0),
        temperature: (-20.0, 80.0),
        period: 0.002,
        rate: 500.0,
        latency: 0.002,
        arming_max: 20,
        brake_delay: 0,
        live: 0,
        live_max: 0,
        rest: None,
        first_motion: None,
        heat: None,
        payload: InertiaBounds { mass: 5.0, radius: 0.5 },
        joints: [joint; 2],
    };
    Protected { control: config(), rules }
}
