//! An arm with simple dynamics, and a controller for it.

use dynamics_core::control::{ControlLaw, ControllerOf, Encoder, Gains, Guard, LimitFlags, TrackingObserver};
use dynamics_core::{
    Body, Command, Controller, ControllerConfig, Dh, Dynamics, Fault, Frame, InverseDynamics, JointKind, JointSpec,
    Limits, Live, Measurement, Model, Reference, Rotor, Scene, Sensed, SinCos, Tool, Trig,
};
use nalgebra::{Matrix3, Vector3};
use std::cell::Cell;

/// The standard library's sine and cosine, because these tests are about the controller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Desk;

impl Trig<f64> for Desk {
    fn sin_cos(&self, angle: f64) -> SinCos<f64> {
        let (sin, cos) = angle.sin_cos();
        SinCos { sin, cos }
    }
}

impl Trig<f32> for Desk {
    fn sin_cos(&self, angle: f32) -> SinCos<f32> {
        let (sin, cos) = angle.sin_cos();
        SinCos { sin, cos }
    }
}

pub(crate) const LENGTH: [f64; 2] = [0.7, 0.5];
pub(crate) const CENTRE: [f64; 2] = [0.3, 0.2];
pub(crate) const MASS: [f64; 2] = [3.0, 2.0];
pub(crate) const INERTIA: [f64; 2] = [0.11, 0.05];
pub(crate) const GRAVITY: f64 = 9.81;

/// Two links in the vertical xy plane, gravity along -y.
pub(crate) fn planar() -> Dynamics<f64, 2> {
    let joints = [0, 1].map(|i| JointSpec {
        kind: JointKind::Revolute,
        frame: Frame::ClassicalDh(Dh { a: LENGTH[i], ..Dh::default() }),
        body: Body {
            mass: MASS[i],
            com: Vector3::new(CENTRE[i] - LENGTH[i], 0.0, 0.0),
            inertia: Matrix3::from_diagonal(&Vector3::new(0.6 * INERTIA[i], 0.6 * INERTIA[i], INERTIA[i])),
        },
        rotor: Rotor::default(),
        limits: Limits::none(),
    });
    let model = Model::new(&joints, &Tool::default()).unwrap();
    let scene = Scene::with_gravity(Vector3::new(0.0, -GRAVITY, 0.0), &model);
    Dynamics::new(model, scene)
}

/// The planar two-link arm's torques, written out by hand from its Lagrangian.
pub(crate) fn by_hand(q: [f64; 2], qd: [f64; 2], qdd: [f64; 2]) -> [f64; 2] {
    let ([l, _], [c1, c2], [m1, m2], [i1, i2]) = (LENGTH, CENTRE, MASS, INERTIA);
    let (sin2, cos2) = q[1].sin_cos();
    let d11 = i1 + i2 + m1 * c1 * c1 + m2 * (l * l + c2 * c2 + 2.0 * l * c2 * cos2);
    let d12 = i2 + m2 * (c2 * c2 + l * c2 * cos2);
    let d22 = i2 + m2 * c2 * c2;
    let h = m2 * l * c2 * sin2;
    let g2 = m2 * GRAVITY * c2 * (q[0] + q[1]).cos();
    let g1 = (m1 * c1 + m2 * l) * GRAVITY * q[0].cos() + g2;
    [
        d11 * qdd[0] + d12 * qdd[1] - h * (2.0 * qd[0] * qd[1] + qd[1] * qd[1]) + g1,
        d12 * qdd[0] + d22 * qdd[1] + h * qd[0] * qd[0] + g2,
    ]
}

/// No limits, wide guards, a 1 kHz observer.
pub(crate) fn config<const N: usize>(law: ControlLaw) -> ControllerConfig<f64, N> {
    ControllerConfig {
        law,
        gains: core::array::from_fn(|i| Gains::new(20.0 + 5.0 * i as f64, 0.9, 1.5 - 0.2 * i as f64)),
        friction: None,
        limits: [Limits::none(); N],
        torque_step: [f64::INFINITY; N],
        guard: [Guard { position_margin: 0.1, velocity_max: 50.0 }; N],
        age_max: 2,
        encoder: [Encoder { zero: 0, per_count: 1e-4 }; N],
        observer: TrackingObserver::new(200.0, 1e-3),
        integral: None,
        teach: None,
        posture_damping: None,
    }
}

pub(crate) fn controller(config: ControllerConfig<f64, 2>) -> ControllerOf<f64, 2, Dynamics<f64, 2>, Desk> {
    Controller::new(config, planar(), Desk)
}

pub(crate) fn measured<S, const N: usize>(q: [S; N], qd: [S; N]) -> Measurement<S, N> {
    Measurement { sensed: Sensed::State { q, qd }, age_ticks: 0 }
}

/// Inverse dynamics of unit masses on rails, which counts its calls.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct UnitMasses {
    pub(crate) calls: Cell<u32>,
}

impl<const N: usize> InverseDynamics<f64, N> for UnitMasses {
    fn inverse_dynamics(
        &self,
        _turn: &[SinCos<f64>; N],
        _q: &[f64; N],
        _qd: &[f64; N],
        qdd: &[f64; N],
        _live: &Live<f64, N>,
    ) -> [f64; N] {
        self.calls.set(self.calls.get() + 1);
        *qdd
    }
}

/// One joint of unit mass without feedback: the torque is the reference's acceleration.
pub(crate) fn one_joint(limits: Limits<f64>, torque_step: f64) -> ControllerOf<f64, 1, UnitMasses, Desk> {
    let open_loop = Gains { position: 0.0, velocity: 0.0, inertia: 0.0 };
    let config = ControllerConfig {
        gains: [open_loop],
        limits: [limits],
        torque_step: [torque_step],
        ..config(ControlLaw::ComputedTorque)
    };
    Controller::new(config, UnitMasses::default(), Desk)
}

pub(crate) fn wanting(qdd: f64) -> Reference<f64, 1> {
    Reference { q: [0.0], qd: [0.0], qdd: [qdd] }
}

pub(crate) fn driven<S: Copy, const N: usize>(command: Command<S, N>) -> ([S; N], [LimitFlags; N]) {
    match command {
        Command::Drive { torque, limits } => (torque, limits),
        Command::Brake(fault) => panic!("braked: {fault}"),
    }
}

pub(crate) fn braked<S, const N: usize>(command: &Command<S, N>) -> Option<Fault> {
    match command {
        Command::Drive { .. } => None,
        Command::Brake(fault) => Some(*fault),
    }
}
