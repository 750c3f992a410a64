//! Generated from a robot and a scene file. Do not edit: change the files instead.

use dynamics_core::control::{ControlLaw, Encoder, Gains, Guard, TrackingObserver};
use dynamics_core::model::{Link, Placement};
use dynamics_core::safety::{JointRules, Rules, SafeAction};
use dynamics_core::trig::Polynomial;
use dynamics_core::{ControllerConfig, Inertia, InertiaBounds, JointKind, Limits, Model, Scene, Term};
use nalgebra::{Matrix3, Vector3};

/// The type of [`TRIG`].
pub type Trig = Polynomial;

/// Which sine and cosine.
pub const TRIG: Trig = Polynomial;

/// Joints.
pub const N: usize = 4;

/// The scene.
pub const NAME: &str = "scara_pick";

/// The robot.
pub const ROBOT: &str = "generic SCARA";

/// Hash of everything that decides the bits of a tick.
pub const HASH: u64 = 0xcafa_c91e_9678_642f;

/// Control rate, Hz.
pub const RATE_HZ: f32 = 1000.0;

/// The arm.
pub const fn model() -> Model<f32, N> {
    Model::from_checked(
        [
            Link {
                kind: JointKind::Revolute,
                rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
                translation: Vector3::new(0.0, 0.0, 0.0),
                inertia: Inertia {
                    mass: 6.0,
                    first_moment: Vector3::new(1.08, 0.072, 2.22),
                    about_origin: Matrix3::new(
                        1.081375, -0.043008, -0.431517, -0.043008, 1.120548, -0.14001, -0.431517, -0.14001, 0.389135,
                    ),
                },
                rotor: 0.0,
                limits: Limits { position: (-2.4, 2.4), velocity: 5.0, torque: 80.0, torque_rate: f32::INFINITY },
            },
            Link {
                kind: JointKind::Revolute,
                rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
                translation: Vector3::new(0.35, 0.0, 0.4),
                inertia: Inertia {
                    mass: 4.0,
                    first_moment: Vector3::new(0.64, 0.032, 0.04),
                    about_origin: Matrix3::new(
                        0.052762, -0.015694, -0.042684, -0.015694, 0.181962, -0.012263, -0.042684, -0.012263, 0.14924,
                    ),
                },
                rotor: 0.0,
                limits: Limits { position: (-2.6, 2.6), velocity: 7.0, torque: 40.0, torque_rate: f32::INFINITY },
            },
            Link {
                kind: JointKind::Revolute,
                rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0),
                translation: Vector3::new(0.3, 0.0, 0.05),
                inertia: Inertia {
                    mass: 0.8,
                    first_moment: Vector3::new(0.0032, 0.0024, 0.056),
                    about_origin: Matrix3::new(
                        0.0075462, 0.0018174, -0.00115, 0.0018174, 0.0071418, 0.000816, -0.00115, 0.000816, 0.003753,
                    ),
                },
                rotor: 0.0,
                limits: Limits {
                    position: (-6.2831855, 6.2831855),
                    velocity: 15.0,
                    torque: 8.0,
                    torque_rate: f32::INFINITY,
                },
            },
            Link {
                kind: JointKind::Prismatic,
                rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
                translation: Vector3::new(0.0, 0.0, 0.02),
                inertia: Inertia {
                    mass: 1.2,
                    first_moment: Vector3::new(0.004065929, -0.0050227703, -0.036),
                    about_origin: Matrix3::new(
                        0.004203999,
                        -0.0006060701,
                        0.0003684718,
                        -0.0006060701,
                        0.0031988008,
                        -0.00077157014,
                        0.0003684718,
                        -0.00077157014,
                        0.0021868,
                    ),
                },
                rotor: 0.0,
                limits: Limits { position: (0.0, 0.85), velocity: 1.2, torque: 120.0, torque_rate: f32::INFINITY },
            },
        ],
        Placement {
            rotation: Matrix3::new(0.9553365, -0.29552022, 0.0, 0.29552022, 0.9553365, 0.0, 0.0, 0.0, 1.0),
            translation: Vector3::new(0.0, 0.0, 0.05),
        },
    )
}

/// Gravity, payload, wrench at the tip, and the terms of the model.
pub const fn scene() -> Scene<f32, N> {
    Scene {
        gravity: Term::Constant(Vector3::new(0.0, 0.0, -9.81)),
        payload: Term::Constant(Inertia {
            mass: 0.5,
            first_moment: Vector3::new(0.0, 0.0, 0.01),
            about_origin: Matrix3::new(0.0002, 0.0, 0.0, 0.0, 0.0002, 0.0, 0.0, 0.0, 0.0),
        }),
        tip_wrench: Term::Absent,
        rotor: Term::Absent,
        coriolis: Term::Live,
    }
}

/// Its controller.
pub const fn config() -> ControllerConfig<f32, N> {
    ControllerConfig {
        law: ControlLaw::ComputedTorque,
        gains: [
            Gains { position: 2500.0, velocity: 100.0, inertia: 1.9017526 },
            Gains { position: 2500.0, velocity: 100.0, inertia: 0.38453937 },
            Gains { position: 2500.0, velocity: 100.0, inertia: 0.0059398 },
            Gains { position: 2500.0, velocity: 100.0, inertia: 1.7 },
        ],
        friction: None,
        limits: [
            Limits { position: (-2.4, 2.4), velocity: 5.0, torque: 80.0, torque_rate: f32::INFINITY },
            Limits { position: (-2.6, 2.6), velocity: 7.0, torque: 40.0, torque_rate: f32::INFINITY },
            Limits { position: (-6.2831855, 6.2831855), velocity: 15.0, torque: 8.0, torque_rate: f32::INFINITY },
            Limits { position: (0.0, 0.85), velocity: 1.2, torque: 120.0, torque_rate: f32::INFINITY },
        ],
        torque_step: [f32::INFINITY, f32::INFINITY, f32::INFINITY, f32::INFINITY],
        guard: [
            Guard { position_margin: 0.05, velocity_max: 7.5 },
            Guard { position_margin: 0.05, velocity_max: 10.5 },
            Guard { position_margin: 0.05, velocity_max: 22.5 },
            Guard { position_margin: 0.05, velocity_max: 1.8 },
        ],
        age_max: 2,
        encoder: [
            Encoder { zero: 0, per_count: 9.58738e-5 },
            Encoder { zero: 0, per_count: 9.58738e-5 },
            Encoder { zero: 0, per_count: 9.58738e-5 },
            Encoder { zero: 0, per_count: 5e-6 },
        ],
        observer: TrackingObserver::from_gains(0.001, 5e-7, 0.63212055, 154.81812),
        integral: None,
        teach: None,
        posture_damping: None,
    }
}

/// The safety state machine around it.
pub const fn rules() -> Rules<f32, N> {
    Rules {
        safe_action: SafeAction::Brake,
        heartbeat_max: 100,
        hold_max: 500,
        supply: (f32::NEG_INFINITY, f32::INFINITY),
        temperature: (f32::NEG_INFINITY, f32::INFINITY),
        period: 0.001,
        rate: 1000.0,
        latency: 0.002,
        arming_max: 1000,
        brake_delay: 100,
        live: 0,
        live_max: 0,
        rest: None,
        first_motion: None,
        heat: None,
        payload: InertiaBounds { mass: 12.0, radius: 1.0 },
        joints: [
            JointRules {
                rest_speed: 0.05,
                jump_step: 0.01,
                resolution: 0.0001917476,
                deceleration: 20.0,
                reach: 0.2,
                reach_speed: 0.5,
                rotor_max: 0.0,
                damping: 16.0,
                lowering_speed: 0.010651583,
            },
            JointRules {
                rest_speed: 0.05,
                jump_step: 0.014,
                resolution: 0.0001917476,
                deceleration: 28.0,
                reach: 0.2,
                reach_speed: 0.7,
                rotor_max: 0.0,
                damping: 5.714286,
                lowering_speed: 0.010651583,
            },
            JointRules {
                rest_speed: 0.05,
                jump_step: 0.03,
                resolution: 0.0001917476,
                deceleration: 60.0,
                reach: 0.2,
                reach_speed: 1.5,
                rotor_max: 0.0,
                damping: 0.53333336,
                lowering_speed: 0.010651583,
            },
            JointRules {
                rest_speed: 0.05,
                jump_step: 0.0024,
                resolution: 1e-5,
                deceleration: 4.8,
                reach: 0.05,
                reach_speed: 0.12,
                rotor_max: 0.0,
                damping: 100.0,
                lowering_speed: 0.010651583,
            },
        ],
    }
}
