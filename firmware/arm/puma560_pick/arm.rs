// Generated from a robot and a scene file. Do not edit: change the files instead.

use dynamics_core::control::{ControlLaw, Encoder, Friction, Gains, Guard, TrackingObserver};
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
pub const N: usize = 6;

/// The scene.
pub const NAME: &str = "puma560_pick";

/// The robot.
pub const ROBOT: &str = "Puma 560";

/// Hash of everything that decides the bits of a tick.
pub const HASH: u64 = 0x1979_913d_5574_d390;

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
                    mass: 0.0,
                    first_moment: Vector3::new(0.0, 0.0, 0.0),
                    about_origin: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.35),
                },
                rotor: 0.78402996,
                limits: Limits {
                    position: (-2.7925267, 2.7925267),
                    velocity: 1.92,
                    torque: 97.6,
                    torque_rate: f32::INFINITY,
                },
            },
            Link {
                kind: JointKind::Revolute,
                rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0),
                translation: Vector3::new(0.0, 0.0, 0.67183),
                inertia: Inertia {
                    mass: 17.4,
                    first_moment: Vector3::new(1.1832, 0.1044, 3.9585),
                    about_origin: Matrix3::new(
                        1.0311852, -0.0070992, -0.269178, -0.0070992, 1.5050163, -0.023751, -0.269178, -0.023751,
                        0.620084,
                    ),
                },
                rotor: 2.3248148,
                limits: Limits {
                    position: (-0.7853982, 3.9269907),
                    velocity: 1.51,
                    torque: 186.4,
                    torque_rate: f32::INFINITY,
                },
            },
            Link {
                kind: JointKind::Revolute,
                rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
                translation: Vector3::new(0.4318, 0.0, 0.0),
                inertia: Inertia {
                    mass: 4.8,
                    first_moment: Vector3::new(0.0, 0.336, 0.78792),
                    about_origin: Matrix3::new(
                        0.21885706,
                        -8.6736174e-19,
                        -1.7347235e-18,
                        0.0,
                        0.14183708,
                        -0.0551544,
                        0.0,
                        -0.0551544,
                        0.10952,
                    ),
                },
                rotor: 0.5768733,
                limits: Limits {
                    position: (-3.9269907, 0.7853982),
                    velocity: 2.4,
                    torque: 89.4,
                    torque_rate: f32::INFINITY,
                },
            },
            Link {
                kind: JointKind::Revolute,
                rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0),
                translation: Vector3::new(0.0203, 0.0, 0.15005),
                inertia: Inertia {
                    mass: 0.82,
                    first_moment: Vector3::new(0.0, 0.0, 0.369656),
                    about_origin: Matrix3::new(0.16844092, 0.0, 0.0, 0.0, 0.16844092, 0.0, 0.0, 0.0, 0.0013),
                },
                rotor: 0.19079062,
                limits: Limits {
                    position: (-1.9198622, 2.9670596),
                    velocity: 5.34,
                    torque: 24.2,
                    torque_rate: f32::INFINITY,
                },
            },
            Link {
                kind: JointKind::Revolute,
                rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0),
                translation: Vector3::new(0.0, 0.0, 0.4318),
                inertia: Inertia {
                    mass: 0.34,
                    first_moment: Vector3::new(0.0, 0.0, 0.0),
                    about_origin: Matrix3::new(0.0003, 0.0, 0.0, 0.0, 0.0003, 0.0, 0.0, 0.0, 0.0004),
                },
                rotor: 0.17070629,
                limits: Limits {
                    position: (-1.7453293, 1.7453293),
                    velocity: 5.09,
                    torque: 20.1,
                    torque_rate: f32::INFINITY,
                },
            },
            Link {
                kind: JointKind::Revolute,
                rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0),
                translation: Vector3::new(0.0, 0.0, 0.0),
                inertia: Inertia {
                    mass: 0.09,
                    first_moment: Vector3::new(0.0, 0.0, 0.00288),
                    about_origin: Matrix3::new(0.00024216, 0.0, 0.0, 0.0, 0.00024216, 0.0, 0.0, 0.0, 4e-5),
                },
                rotor: 0.19406451,
                limits: Limits {
                    position: (-4.6425757, 4.6425757),
                    velocity: 5.74,
                    torque: 21.3,
                    torque_rate: f32::INFINITY,
                },
            },
        ],
        Placement {
            rotation: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
            translation: Vector3::new(0.0, 0.0, 0.0),
        },
    )
}

/// Gravity, payload, wrench at the tip, and the terms of the model.
pub const fn scene() -> Scene<f32, N> {
    Scene {
        gravity: Term::Constant(Vector3::new(0.0, 0.0, -9.81)),
        payload: Term::Constant(Inertia {
            mass: 2.0,
            first_moment: Vector3::new(0.0, 0.0, 0.1),
            about_origin: Matrix3::new(0.00644, 0.0, 0.0, 0.0, 0.00644, 0.0, 0.0, 0.0, 0.0012),
        }),
        tip_wrench: Term::Absent,
        rotor: Term::Constant([0.78402996, 2.3248148, 0.5768733, 0.19079062, 0.17070629, 0.19406451]),
        coriolis: Term::Live,
    }
}

/// Its controller.
pub const fn config() -> ControllerConfig<f32, N> {
    ControllerConfig {
        law: ControlLaw::ComputedTorque,
        gains: [
            Gains { position: 1600.0, velocity: 80.0, inertia: 4.114922 },
            Gains { position: 1600.0, velocity: 80.0, inertia: 6.8536873 },
            Gains { position: 1600.0, velocity: 80.0, inertia: 1.3923004 },
            Gains { position: 1600.0, velocity: 80.0, inertia: 0.1948815 },
            Gains { position: 1600.0, velocity: 80.0, inertia: 0.17778845 },
            Gains { position: 1600.0, velocity: 80.0, inertia: 0.19530451 },
        ],
        friction: Some([
            Friction { viscous: 5.80182, coulomb: 25.9836, per_smoothing_speed: 20.0 },
            Friction { viscous: 9.49687, coulomb: 10.6198, per_smoothing_speed: 20.0 },
            Friction { viscous: 3.98043, coulomb: 6.3642, per_smoothing_speed: 20.0 },
            Friction { viscous: 0.411645, coulomb: 1.06831, per_smoothing_speed: 20.0 },
            Friction { viscous: 0.427283, coulomb: 0.854445, per_smoothing_speed: 20.0 },
            Friction { viscous: 0.215823, coulomb: 0.55444, per_smoothing_speed: 20.0 },
        ]),
        limits: [
            Limits { position: (-2.7925267, 2.7925267), velocity: 1.92, torque: 97.6, torque_rate: f32::INFINITY },
            Limits { position: (-0.7853982, 3.9269907), velocity: 1.51, torque: 186.4, torque_rate: f32::INFINITY },
            Limits { position: (-3.9269907, 0.7853982), velocity: 2.4, torque: 89.4, torque_rate: f32::INFINITY },
            Limits { position: (-1.9198622, 2.9670596), velocity: 5.34, torque: 24.2, torque_rate: f32::INFINITY },
            Limits { position: (-1.7453293, 1.7453293), velocity: 5.09, torque: 20.1, torque_rate: f32::INFINITY },
            Limits { position: (-4.6425757, 4.6425757), velocity: 5.74, torque: 21.3, torque_rate: f32::INFINITY },
        ],
        torque_step: [f32::INFINITY, f32::INFINITY, f32::INFINITY, f32::INFINITY, f32::INFINITY, f32::INFINITY],
        guard: [
            Guard { position_margin: 0.05, velocity_max: 2.88 },
            Guard { position_margin: 0.05, velocity_max: 2.265 },
            Guard { position_margin: 0.05, velocity_max: 3.6 },
            Guard { position_margin: 0.05, velocity_max: 8.01 },
            Guard { position_margin: 0.05, velocity_max: 7.635 },
            Guard { position_margin: 0.05, velocity_max: 8.61 },
        ],
        age_max: 2,
        encoder: [
            Encoder { zero: 0, per_count: 0.000100352576 },
            Encoder { zero: 0, per_count: 7.284684e-5 },
            Encoder { zero: 0, per_count: 0.000116991585 },
            Encoder { zero: 0, per_count: 8.263392e-5 },
            Encoder { zero: 0, per_count: 8.735989e-5 },
            Encoder { zero: 0, per_count: 0.00016386787 },
        ],
        observer: TrackingObserver::from_gains(0.001, 5e-7, 0.6988058, 203.57094),
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
        payload: InertiaBounds { mass: 23.45, radius: 1.0 },
        joints: [
            JointRules {
                rest_speed: 0.05,
                jump_step: 0.00384,
                resolution: 0.00020070515,
                deceleration: 7.68,
                reach: 0.2,
                reach_speed: 0.192,
                rotor_max: 3.1361198,
                damping: 50.833332,
                lowering_speed: 0.020143958,
            },
            JointRules {
                rest_speed: 0.05,
                jump_step: 0.00302,
                resolution: 0.00014569367,
                deceleration: 6.04,
                reach: 0.2,
                reach_speed: 0.151,
                rotor_max: 9.299259,
                damping: 123.44371,
                lowering_speed: 0.020143958,
            },
            JointRules {
                rest_speed: 0.05,
                jump_step: 0.0048,
                resolution: 0.00023398317,
                deceleration: 9.6,
                reach: 0.2,
                reach_speed: 0.24,
                rotor_max: 2.3074932,
                damping: 37.25,
                lowering_speed: 0.020143958,
            },
            JointRules {
                rest_speed: 0.05,
                jump_step: 0.01068,
                resolution: 0.00016526783,
                deceleration: 21.36,
                reach: 0.2,
                reach_speed: 0.534,
                rotor_max: 0.7631625,
                damping: 4.531835,
                lowering_speed: 0.020143958,
            },
            JointRules {
                rest_speed: 0.05,
                jump_step: 0.01018,
                resolution: 0.00017471978,
                deceleration: 20.36,
                reach: 0.2,
                reach_speed: 0.509,
                rotor_max: 0.68282515,
                damping: 3.9489195,
                lowering_speed: 0.020143958,
            },
            JointRules {
                rest_speed: 0.05,
                jump_step: 0.01148,
                resolution: 0.00032773573,
                deceleration: 22.96,
                reach: 0.2,
                reach_speed: 0.574,
                rotor_max: 0.77625805,
                damping: 3.7108014,
                lowering_speed: 0.020143958,
            },
        ],
    }
}
