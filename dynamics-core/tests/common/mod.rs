//! Golden data and random arms, shared by the tests.
#![allow(unreachable_pub, reason = "a module of a test program")]
#![allow(clippy::unwrap_used, reason = "a broken data file should stop the test")]

pub mod arms;
pub mod linkages;
pub mod moving;

use dynamics_core::chapter::posture::Posture;
use dynamics_core::{
    Body, Dh, Frame, InverseDynamics, JointKind, JointSpec, Limits, Live, Model, Real, Rotor, SinCos, Tool, Wrench,
};
use nalgebra::{Matrix3, SMatrix, Vector3};
use serde_json::Value;

/// External reference data of one robot; conventions in `robots/golden/README.md`.
pub struct Golden {
    data: Value,
}

impl Golden {
    pub fn load(robot: &str) -> Self {
        let path = format!("{}/../robots/golden/{robot}.json", env!("CARGO_MANIFEST_DIR"));
        let text = std::fs::read_to_string(&path).unwrap();
        Self { data: serde_json::from_str(&text).unwrap() }
    }

    pub fn has_dh(&self) -> bool {
        self.data["dh"].is_array()
    }

    pub fn gravity(&self) -> Vector3<f64> {
        vector(&self.data["gravity"])
    }

    pub fn states(&self) -> impl Iterator<Item = &Value> {
        self.data["states"].as_array().unwrap().iter()
    }

    /// The model from the `joints` block: general placements with any axis.
    pub fn placed<const N: usize>(&self) -> Model<f64, N> {
        let joints: [JointSpec; N] = core::array::from_fn(|i| {
            let j = &self.data["joints"][i];
            JointSpec {
                kind: kind(j),
                frame: Frame::Placement {
                    rotation: matrix(&j["placement_R"]),
                    translation: vector(&j["placement_p"]),
                    axis: vector(&j["axis"]),
                },
                body: body(j),
                rotor: Rotor { inertia: j["rotor_inertia_reflected"].as_f64().unwrap(), gear: 1.0 },
                limits: Limits::none(),
            }
        });
        let tip = &self.data["tip_in_last_joint"];
        let tool = Tool { rotation: matrix(&tip["R"]), translation: vector(&tip["p"]), body: Body::massless() };
        Model::new_unphysical(&joints, &tool).unwrap()
    }

    /// The model from the `dh` block: the chapter's classical rows.
    pub fn classical<const N: usize>(&self) -> Model<f64, N> {
        let joints: [JointSpec; N] = core::array::from_fn(|i| {
            let j = &self.data["dh"][i];
            let number = |key: &str| j[key].as_f64().unwrap();
            let offset = number("offset");
            let (theta, d) = match kind(j) {
                JointKind::Revolute => (offset, number("d")),
                JointKind::Prismatic => (number("theta"), offset),
            };
            JointSpec {
                kind: kind(j),
                frame: Frame::ClassicalDh(Dh { a: number("a"), alpha: number("alpha"), d, theta }),
                body: body(j),
                rotor: Rotor { inertia: number("motor_inertia_Jm"), gear: number("gear_ratio_G") },
                limits: Limits::none(),
            }
        });
        Model::new_unphysical(&joints, &Tool::default()).unwrap()
    }
}

fn kind(joint: &Value) -> JointKind {
    match joint["type"].as_str() {
        Some("R") => JointKind::Revolute,
        Some("P") => JointKind::Prismatic,
        other => unreachable!("joint type {other:?}"),
    }
}

fn body(joint: &Value) -> Body {
    Body { mass: joint["mass"].as_f64().unwrap(), com: vector(&joint["com"]), inertia: matrix(&joint["inertia_com"]) }
}

pub fn numbers<const N: usize>(value: &Value) -> [f64; N] {
    let list = value.as_array().unwrap();
    assert_eq!(list.len(), N);
    core::array::from_fn(|i| list[i].as_f64().unwrap())
}

pub fn vector(value: &Value) -> Vector3<f64> {
    numbers::<3>(value).into()
}

pub fn matrix(value: &Value) -> Matrix3<f64> {
    Matrix3::from_fn(|r, c| value[r][c].as_f64().unwrap())
}

pub fn square<const N: usize>(value: &Value) -> SMatrix<f64, N, N> {
    SMatrix::from_fn(|r, c| value[r][c].as_f64().unwrap())
}

/// Sine and cosine of every joint, in double precision and rounded once.
pub fn turns<S: Real, const N: usize>(q: &[f64; N]) -> [SinCos<S>; N] {
    q.map(|angle| SinCos { sin: S::literal(angle.sin()), cos: S::literal(angle.cos()) })
}

pub fn cast<S: Real, const N: usize>(x: &[f64; N]) -> [S; N] {
    x.map(S::literal)
}

/// Largest difference over the largest wanted entry (over 1 if that is zero).
pub fn relative_error<S: Real>(found: &[S], wanted: &[f64]) -> f64 {
    assert_eq!(found.len(), wanted.len());
    let size = wanted.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let worst = found.iter().zip(wanted).fold(0.0_f64, |m, (f, w)| m.max((f.to_f64() - w).abs()));
    // f64::max drops a NaN; a test must not.
    assert!(found.iter().all(|f| f.is_finite()));
    if size > 0.0 { worst / size } else { worst }
}

/// Forces and moments as one list.
pub fn numbers_of(wrenches: &[Wrench<f64>]) -> Vec<f64> {
    wrenches.iter().flat_map(|w| w.force.iter().chain(w.moment.iter()).copied().collect::<Vec<_>>()).collect()
}

/// Converts every wrench from its link's axes to base axes.
pub fn into_base<const N: usize>(posture: &Posture<f64, N>, wrenches: &[Wrench<f64>; N]) -> [Wrench<f64>; N] {
    core::array::from_fn(|i| wrenches[i].in_parent(&posture.links[i].rotation, &Vector3::zeros()))
}

/// Asserts that `found` equals `measured`, a number measured before, to 5 %: a change in either direction needs a reason.
pub fn pinned(what: &str, found: f64, measured: f64) {
    println!("{what}: {found:.2e}");
    assert!(found > 0.95 * measured && found < 1.05 * measured, "{what}: {found:e}, measured before: {measured:e}");
}

/// As [`pinned`], for rounding errors: to a factor of two, because another sine may round differently.
pub fn pinned_rounding(what: &str, found: f64, measured: f64) {
    println!("{what}: {found:.2e}");
    assert!(found > 0.5 * measured && found < 2.0 * measured, "{what}: {found:e}, measured before: {measured:e}");
}

/// Inverse dynamics with exactly rounded sine and cosine and no live inputs.
pub fn torque<S: Real, const N: usize>(
    dynamics: &impl InverseDynamics<S, N>,
    q: &[f64; N],
    qd: &[f64; N],
    qdd: &[f64; N],
) -> [S; N] {
    dynamics.inverse_dynamics(&turns(q), &cast(q), &cast(qd), &cast(qdd), &Live::zero())
}

/// Derivative at zero by five points: truncation error `h^4`, rounding error `|f| 2^-53 / h`.
pub fn derivative(f: impl Fn(f64) -> f64) -> f64 {
    let h = 1e-3;
    (f(-2.0 * h) - 8.0 * f(-h) + 8.0 * f(h) - f(2.0 * h)) / (12.0 * h)
}

/// `q` and `qd` at the time `t` of the motion `q + qd t + qdd t^2 / 2`.
pub fn along<const N: usize>(q: &[f64; N], qd: &[f64; N], qdd: &[f64; N], t: f64) -> ([f64; N], [f64; N]) {
    let moved = core::array::from_fn(|i| q[i] + qd[i] * t + 0.5 * qdd[i] * t * t);
    (moved, core::array::from_fn(|i| qd[i] + qdd[i] * t))
}

/// The same vector with `step` added to one entry.
pub fn stepped<const N: usize>(x: &[f64; N], i: usize, step: f64) -> [f64; N] {
    let mut moved = *x;
    moved[i] += step;
    moved
}

/// Lagrange's equation (12.215) with every derivative taken numerically: `d/dt dL/dqd - dL/dq` of `lagrangian(q, qd)`.
///
/// The Lagrangian must be quadratic in `qd`: then the central difference by `qd` is exact.
pub fn lagrange_equation<const N: usize>(
    lagrangian: impl Fn(&[f64; N], &[f64; N]) -> f64,
    q: &[f64; N],
    qd: &[f64; N],
    qdd: &[f64; N],
) -> [f64; N] {
    core::array::from_fn(|i| {
        let momentum = |t: f64| {
            let (q, qd) = along(q, qd, qdd, t);
            (lagrangian(&q, &stepped(&qd, i, 1.0)) - lagrangian(&q, &stepped(&qd, i, -1.0))) / 2.0
        };
        derivative(momentum) - derivative(|step| lagrangian(&stepped(q, i, step), qd))
    })
}
