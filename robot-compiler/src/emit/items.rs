//! The core's structures as expressions.
//!
//! Each is taken apart by name, so that a field added to one does not compile until it is written out.

use super::expression::{Float, Item, call, integer, list, number, record, word};
use dynamics_core::control::{CollisionConfig, Encoder, Friction, Gains, Guard};
use dynamics_core::model::{Link, Placement};
use dynamics_core::safety::{JointRules, Rules};
use dynamics_core::{ControllerConfig, Inertia, JointKind, Limits, Model, Scene, Term, Wrench};
use nalgebra::{Matrix3, Vector3};

pub(super) fn vector<S: Float>(v: &Vector3<S>) -> Item {
    call("Vector3::new", v.iter().map(|x| number(*x)).collect())
}

/// Row by row, as `Matrix3::new` takes them.
fn matrix<S: Float>(m: &Matrix3<S>) -> Item {
    call("Matrix3::new", m.transpose().iter().map(|x| number(*x)).collect())
}

pub(super) fn numbers<S: Float>(all: &[S]) -> Item {
    list(all.iter().map(|x| number(*x)).collect())
}

fn term<T>(term: &Term<T>, constant: impl FnOnce(&T) -> Item) -> Item {
    match term {
        Term::Absent => word("Term::Absent"),
        Term::Constant(value) => call("Term::Constant", vec![constant(value)]),
        Term::Live => word("Term::Live"),
    }
}

pub(super) fn model_item<S: Float, const N: usize>(model: &Model<S, N>) -> Item {
    let links = model.links().iter().map(|Link { kind, rotation, translation, inertia, rotor, limits }| {
        let kind = match kind {
            JointKind::Revolute => "JointKind::Revolute",
            JointKind::Prismatic => "JointKind::Prismatic",
        };
        record(
            "Link",
            vec![
                ("kind", word(kind)),
                ("rotation", matrix(rotation)),
                ("translation", vector(translation)),
                ("inertia", inertia_item(inertia)),
                ("rotor", number(*rotor)),
                ("limits", limits_item(limits)),
            ],
        )
    });
    let Placement { rotation, translation } = model.tip();
    let tip = record("Placement", vec![("rotation", matrix(rotation)), ("translation", vector(translation))]);
    call("Model::from_checked", vec![list(links.collect()), tip])
}

pub(super) fn inertia_item<S: Float>(inertia: &Inertia<S>) -> Item {
    let Inertia { mass, first_moment, about_origin } = inertia;
    record(
        "Inertia",
        vec![("mass", number(*mass)), ("first_moment", vector(first_moment)), ("about_origin", matrix(about_origin))],
    )
}

pub(super) fn wrench_item<S: Float>(Wrench { force, moment }: &Wrench<S>) -> Item {
    record("Wrench", vec![("force", vector(force)), ("moment", vector(moment))])
}

fn limits_item<S: Float>(limits: &Limits<S>) -> Item {
    let Limits { position: (lo, hi), velocity, torque, torque_rate } = limits;
    record(
        "Limits",
        vec![
            ("position", call("", vec![number(*lo), number(*hi)])),
            ("velocity", number(*velocity)),
            ("torque", number(*torque)),
            ("torque_rate", number(*torque_rate)),
        ],
    )
}

pub(super) fn scene_item<S: Float, const N: usize>(scene: &Scene<S, N>) -> Item {
    let Scene { gravity, payload, tip_wrench, rotor, coriolis } = scene;
    record(
        "Scene",
        vec![
            ("gravity", term(gravity, vector)),
            ("payload", term(payload, inertia_item)),
            ("tip_wrench", term(tip_wrench, wrench_item)),
            ("rotor", term(rotor, |rotor| numbers(rotor))),
            ("coriolis", term(coriolis, |coriolis| numbers(coriolis))),
        ],
    )
}

pub(super) fn config_item<S: Float, const N: usize>(config: &ControllerConfig<S, N>) -> Item {
    let ControllerConfig { law, gains, friction, limits, torque_step, guard, age_max, encoder, observer } = config;
    let gains = gains.iter().map(|Gains { position, velocity, inertia }| {
        let fields =
            vec![("position", number(*position)), ("velocity", number(*velocity)), ("inertia", number(*inertia))];
        record("Gains", fields)
    });
    let friction = friction.as_ref().map(|all| {
        let one = |Friction { viscous, coulomb, per_smoothing_speed }: &Friction<S>| {
            record(
                "Friction",
                vec![
                    ("viscous", number(*viscous)),
                    ("coulomb", number(*coulomb)),
                    ("per_smoothing_speed", number(*per_smoothing_speed)),
                ],
            )
        };
        call("Some", vec![list(all.iter().map(one).collect())])
    });
    let guard = guard.iter().map(|Guard { position_margin, velocity_max }| {
        let fields = vec![("position_margin", number(*position_margin)), ("velocity_max", number(*velocity_max))];
        record("Guard", fields)
    });
    let encoder = encoder.iter().map(|Encoder { zero, per_count }| {
        record("Encoder", vec![("zero", integer(i64::from(*zero))), ("per_count", number(*per_count))])
    });
    record(
        "ControllerConfig",
        vec![
            ("law", word(&format!("Law::{law:?}"))),
            ("gains", list(gains.collect())),
            ("friction", friction.unwrap_or_else(|| word("None"))),
            ("limits", list(limits.iter().map(limits_item).collect())),
            ("torque_step", numbers(torque_step)),
            ("guard", list(guard.collect())),
            ("age_max", integer(i64::from(*age_max))),
            ("encoder", list(encoder.collect())),
            ("observer", call("TrackingObserver::from_gains", observer.gains().map(number).into())),
        ],
    )
}

pub(super) fn collision_item<const N: usize>(config: &CollisionConfig<f32, N>) -> Item {
    let CollisionConfig { filter, threshold, released, ticks, release_ticks, reaction } = config;
    record(
        "CollisionConfig",
        vec![
            ("filter", call("MomentumFilter::from_numbers", filter.numbers().map(number).into())),
            ("threshold", numbers(threshold)),
            ("released", numbers(released)),
            ("ticks", integer(i64::from(*ticks))),
            ("release_ticks", integer(i64::from(*release_ticks))),
            ("reaction", word(&format!("Reaction::{reaction:?}"))),
        ],
    )
}

pub(super) fn rules_item<S: Float, const N: usize>(rules: &Rules<S, N>) -> Item {
    let Rules { safe_action, heartbeat_max, hold_max, supply, temperature, period, rate, latency, payload, joints } =
        rules;
    let pair = |(lo, hi): &(S, S)| call("", vec![number(*lo), number(*hi)]);
    let joints = joints.iter().map(|joint| {
        let JointRules { rest_speed, jump_step, resolution, deceleration, reach, reach_speed, damping } = joint;
        record(
            "JointRules",
            vec![
                ("rest_speed", number(*rest_speed)),
                ("jump_step", number(*jump_step)),
                ("resolution", number(*resolution)),
                ("deceleration", number(*deceleration)),
                ("reach", number(*reach)),
                ("reach_speed", number(*reach_speed)),
                ("damping", number(*damping)),
            ],
        )
    });
    record(
        "Rules",
        vec![
            ("safe_action", word(&format!("SafeAction::{safe_action:?}"))),
            ("heartbeat_max", integer(i64::from(*heartbeat_max))),
            ("hold_max", integer(i64::from(*hold_max))),
            ("supply", pair(supply)),
            ("temperature", pair(temperature)),
            ("period", number(*period)),
            ("rate", number(*rate)),
            ("latency", number(*latency)),
            (
                "payload",
                record("InertiaBounds", vec![("mass", number(payload.mass)), ("radius", number(payload.radius))]),
            ),
            ("joints", list(joints.collect())),
        ],
    )
}
