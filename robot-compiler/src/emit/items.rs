//! Structures of the core as expressions, except configurations.
//!
//! Each structure is destructured by field name: a new field does not compile until it is written out.

use super::expression::{Float, Item, call, list, number, record, word};
use super::fields::item;
use dynamics_core::model::{Link, Placement};
use dynamics_core::{Inertia, JointKind, Model, Scene, Term, Wrench};
use nalgebra::{Matrix3, Vector3};

pub(super) fn vector<S: Float>(v: &Vector3<S>) -> Item {
    call("Vector3::new", v.iter().map(|x| number(*x)).collect())
}

/// Row by row, in the order of `Matrix3::new`.
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
                ("limits", item(limits)),
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
