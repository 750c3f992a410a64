//! Random arms and states for property tests.

use dynamics_core::{Body, Dh, Frame, Inertia, JointKind, JointSpec, Limits, Model, Rotor, Tool, geometry};
use nalgebra::{Matrix3, Vector3};
use proptest::prelude::{Just, Strategy, any, prop_oneof};

/// An arm of `N` joints, revolute and prismatic mixed, in every frame convention, with physical bodies.
pub fn arm<const N: usize>() -> impl Strategy<Value = Model<f64, N>> {
    (proptest::array::uniform::<_, N>(joint()), body(), vector(1.0), rotation())
        .prop_map(|(joints, body, p, r)| Model::new(&joints, &Tool { rotation: r, translation: p, body }).unwrap())
}

/// A joint vector with entries up to `size`.
pub fn joints<const N: usize>(size: f64) -> impl Strategy<Value = [f64; N]> {
    proptest::array::uniform::<_, N>(-size..size)
}

pub fn vector(size: f64) -> impl Strategy<Value = Vector3<f64>> {
    proptest::array::uniform3(-size..size).prop_map(Vector3::from)
}

/// Angles, half of them right angles, because real tables often have them.
fn angle() -> impl Strategy<Value = f64> {
    prop_oneof![(-2_i8..3).prop_map(|k| f64::from(k) * core::f64::consts::FRAC_PI_2), -3.2..3.2]
}

pub fn rotation() -> impl Strategy<Value = Matrix3<f64>> {
    (angle(), angle(), angle()).prop_map(|(r, p, y)| geometry::from_rpy(r, p, y))
}

fn frame() -> impl Strategy<Value = Frame> {
    let dh = || (-0.6..0.6, angle(), -0.6..0.6, angle()).prop_map(|(a, alpha, d, theta)| Dh { a, alpha, d, theta });
    let axis = prop_oneof![
        (0_usize..3, any::<bool>()).prop_map(|(k, minus)| {
            Vector3::from_fn(|i, _| if i == k { if minus { -1.0 } else { 1.0 } } else { 0.0 })
        }),
        vector(1.0).prop_filter_map("too short to point anywhere", |v| {
            let length = v.dot(&v).sqrt();
            (length > 0.1).then(|| v / length)
        }),
    ];
    prop_oneof![
        dh().prop_map(Frame::ClassicalDh),
        dh().prop_map(Frame::ModifiedDh),
        (rotation(), vector(0.6), axis).prop_map(|(rotation, translation, axis)| Frame::Placement {
            rotation,
            translation,
            axis
        }),
    ]
}

/// A body made of point masses, so that its inertia tensor is physically possible.
pub fn body() -> impl Strategy<Value = Body> {
    proptest::array::uniform4((0.05..3.0, vector(0.3))).prop_map(|points| {
        let mass = points.iter().map(|(m, _)| m).sum::<f64>();
        let com = points.iter().map(|(m, r)| r * *m).sum::<Vector3<f64>>() / mass;
        let inertia = points
            .iter()
            .map(|(m, r)| {
                let r = r - com;
                (Matrix3::identity() * r.dot(&r) - r * r.transpose()) * *m
            })
            .sum();
        Body { mass, com, inertia }
    })
}

/// The ten numbers of a body held by the tip.
pub fn held(body: &Body) -> Inertia<f64> {
    Inertia::from_mass_centre(body.mass, &body.com, &body.inertia)
}

fn joint() -> impl Strategy<Value = JointSpec> {
    let kind = prop_oneof![3 => Just(JointKind::Revolute), 1 => Just(JointKind::Prismatic)];
    (kind, frame(), body(), 0.0..1e-3, -100.0..100.0).prop_map(|(kind, frame, body, inertia, gear)| JointSpec {
        kind,
        frame,
        body,
        rotor: Rotor { inertia, gear },
        limits: Limits::none(),
    })
}
