//! The equations of motion as the core computes them, split into inertia, velocity and gravity terms; bodies, arms and
//! random draws for the examples from 336 on and for the exercises.
#![allow(unreachable_pub, reason = "helpers of one test binary")]

use crate::common::arms::joints;
use crate::common::{torque, turns};
use dynamics_core::chapter::contact::{base_wrench, contact_wrench};
use dynamics_core::chapter::lagrange;
use dynamics_core::chapter::posture::{Chain, Posture};
use dynamics_core::chapter::trace_form::Transforms;
use dynamics_core::dual::Dual;
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::newton_euler::joint_wrenches;
use dynamics_core::{
    Body, Dh, Dynamics, Frame, Inertia, JointKind, JointSpec, Limits, Live, Model, Rotor, Scene, SinCos, Term, Tool,
    Wrench,
};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use proptest::prelude::Strategy;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;

/// Standard gravity to three digits, as in the chapter, m/s^2.
pub const G: f64 = 9.81;

/// Gravity of the planar examples (eq. 12.269).
pub const DOWN_Y: Vector3<f64> = Vector3::new(0.0, -G, 0.0);

/// Greatest difference of a closed form from the general code.
pub const TOLERANCE: f64 = 1e-12;

/// `D qdd + C qd + G` at one position and velocity (eq. 12.217).
#[derive(Clone, Copy, Debug)]
pub struct Equations<const N: usize> {
    pub d: SMatrix<f64, N, N>,
    pub c: SMatrix<f64, N, N>,
    pub g: SVector<f64, N>,
}

impl<const N: usize> Equations<N> {
    /// From the recursions. The velocity torques `h` are quadratic in the velocity, so `h(u + v) - h(u) - h(v)`
    /// is twice their symmetric bilinear form, without any step length. With `u` a unit vector and `v = qd` it is a
    /// column of the `C` of Christoffel symbols (eq. 12.281).
    pub fn of(dynamics: &Dynamics<f64, N>, q: &[f64; N], qd: &[f64; N]) -> Self {
        let still = [0.0; N];
        let h = |qd: &[f64; N]| coupling(dynamics, q, qd);
        let columns: [_; N] = core::array::from_fn(|j| {
            let (mut unit, mut both) = (still, *qd);
            unit[j] = 1.0;
            both[j] += 1.0;
            (h(&both) - h(&unit) - h(qd)) * 0.5
        });
        Self {
            d: mass_matrix(dynamics, &turns(q), q, &Live::zero()),
            c: SMatrix::from_columns(&columns),
            g: SVector::from(torque(dynamics, q, &still, &still)),
        }
    }

    pub fn torque(&self, qd: &[f64; N], qdd: &[f64; N]) -> [f64; N] {
        (self.d * SVector::from(*qdd) + self.c * SVector::from(*qd) + self.g).into()
    }

    /// The same three by Lagrange's equations from the links' Jacobians.
    fn by_jacobians(dynamics: &Dynamics<f64, N>, q: &[f64; N], qd: &[f64; N]) -> Self {
        let posture = posture(dynamics, q);
        Self {
            d: lagrange::mass_matrix(&posture),
            c: lagrange::coriolis_matrix(&posture, qd),
            g: SVector::from(lagrange::gravity(&posture, &gravity(dynamics))),
        }
    }

    /// The same three by Lagrange's equations from derivatives of transformation matrices.
    pub fn by_traces(dynamics: &Dynamics<f64, N>, q: &[f64; N], qd: &[f64; N]) -> Self {
        let transforms = Transforms::new(&chain(dynamics), &turns(q), q);
        let symbols = transforms.coupling();
        Self {
            d: transforms.mass_matrix(),
            c: SMatrix::from_fn(|i, j| (0..N).map(|k| symbols[i][j][k] * qd[k]).sum()),
            g: SVector::from(transforms.gravity(&gravity(dynamics))),
        }
    }

    /// The largest relative difference from the core's results: of `D`, `C` and `G` by all three methods, and of the
    /// torque by the recursion.
    ///
    /// It is relative to the possible size of each, not to its actual value, because sines can vanish: `C` is a rate of `D`,
    /// and `G` is at most `g sqrt(m D)` by Cauchy and Schwarz.
    pub fn error(&self, dynamics: &Dynamics<f64, N>, state: &State<N>) -> f64 {
        let State { q, qd, qdd } = state;
        let found = Self::of(dynamics, q, qd);
        let norm = |v: &[f64; N]| v.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
        let inertia = found.d.amax();
        let velocity = inertia * norm(qd);
        let gravity = weight(dynamics) * libm::sqrt(inertia / mass(dynamics));
        let all = inertia * norm(qdd) + velocity * norm(qd) + gravity;
        let tau = SVector::from(torque::<f64, N>(dynamics, q, qd, qdd)) - SVector::from(self.torque(qd, qdd));
        let methods = [found, Self::by_jacobians(dynamics, q, qd), Self::by_traces(dynamics, q, qd)];
        let parts = methods.into_iter().flat_map(|found| {
            [
                (found.d - self.d).amax() / inertia,
                (found.c - self.c).amax() / velocity,
                (found.g - self.g).amax() / (gravity + f64::MIN_POSITIVE),
            ]
        });
        parts.fold(tau.amax() / all, larger)
    }
}

/// The larger of two; NaN if either is.
pub fn larger(a: f64, b: f64) -> f64 {
    if a.is_nan() || b <= a { a } else { b }
}

fn payload<const N: usize>(dynamics: &Dynamics<f64, N>) -> Inertia<f64> {
    *dynamics.scene().payload.value(&Inertia::zero()).unwrap_or(&Inertia::zero())
}

fn mass<const N: usize>(dynamics: &Dynamics<f64, N>) -> f64 {
    dynamics.model().links().iter().map(|link| link.inertia.mass).sum::<f64>() + payload(dynamics).mass
}

fn gravity<const N: usize>(dynamics: &Dynamics<f64, N>) -> Vector3<f64> {
    *dynamics.scene().gravity.value(&Vector3::zeros()).unwrap_or(&Vector3::zeros())
}

fn weight<const N: usize>(dynamics: &Dynamics<f64, N>) -> f64 {
    let g = gravity(dynamics);
    mass(dynamics) * libm::sqrt(g.dot(&g))
}

/// The same arm with its payload, but without gravity and contact.
pub fn floating<const N: usize>(dynamics: &Dynamics<f64, N>) -> Dynamics<f64, N> {
    let scene = Scene { gravity: Term::Absent, tip_wrench: Term::Absent, ..*dynamics.scene() };
    Dynamics::new(*dynamics.model(), scene)
}

/// The velocity coupling vector `H(q, qd)` (eq. 12.216), from the recursion.
pub fn coupling<const N: usize>(dynamics: &Dynamics<f64, N>, q: &[f64; N], qd: &[f64; N]) -> SVector<f64, N> {
    SVector::from(torque::<f64, N>(&floating(dynamics), q, qd, &[0.0; N]))
}

/// The arm with its payload, in the form that the chapter's methods need.
pub fn chain<const N: usize>(dynamics: &Dynamics<f64, N>) -> Chain<f64, N> {
    Chain::new(dynamics.model(), &payload(dynamics))
}

/// Posture of all links, in the base frame.
pub fn posture<const N: usize>(dynamics: &Dynamics<f64, N>, q: &[f64; N]) -> Posture<f64, N> {
    chain(dynamics).posture(&turns(q), q)
}

/// Wrench that each joint carries, about the joint's origin and in base axes: the chapter's `0F_{i-1}`, `0M_{i-1}`.
pub fn wrenches_in_base<const N: usize>(dynamics: &Dynamics<f64, N>, state: &State<N>) -> [Wrench<f64>; N] {
    let State { q, qd, qdd } = state;
    let wrenches = joint_wrenches(dynamics, &turns(q), q, qd, qdd, &Live::zero());
    let posture = posture(dynamics, q);
    core::array::from_fn(|i| wrenches[i].in_parent(&posture.links[i].rotation, &Vector3::zeros()))
}

/// The largest entry of any force or moment.
pub fn largest(wrenches: &[Wrench<f64>]) -> f64 {
    wrenches.iter().fold(0.0, |m, wrench| m.max(wrench.force.amax()).max(wrench.moment.amax()))
}

/// Result of the forward recursion (eq. 12.163-12.168) from the base's wrench on the arm about the base's origin: the
/// environment's wrench on the tip, in tip axes.
pub fn felt<const N: usize>(dynamics: &Dynamics<f64, N>, state: &State<N>, base: &Wrench<f64>) -> Wrench<f64> {
    let State { q, qd, qdd } = state;
    contact_wrench(dynamics, &turns(q), q, qd, qdd, base, &Live::zero())
}

/// Runs the backward recursion (eq. 12.157-12.162) from a wrench at the tip to the base, and the forward recursion back to the
/// tip. Returns the error of the wrench at the tip, relative to the base's wrench.
pub fn there_and_back<const N: usize>(dynamics: &Dynamics<f64, N>, state: &State<N>) -> f64 {
    let push = Wrench { force: Vector3::new(20.0, -7.0, 12.0), moment: Vector3::new(1.0, 3.0, -2.0) };
    let pushed = Dynamics::new(*dynamics.model(), Scene { tip_wrench: Term::Constant(push), ..*dynamics.scene() });
    let State { q, qd, qdd } = state;
    let base = base_wrench(&pushed, &turns(q), q, qd, qdd, &Live::zero());
    let off = felt(dynamics, state, &base) - push;
    largest(&[off]) / largest(&[base])
}

/// A joint position, velocity and acceleration.
#[derive(Clone, Copy, Debug)]
pub struct State<const N: usize> {
    pub q: [f64; N],
    pub qd: [f64; N],
    pub qdd: [f64; N],
}

impl<const N: usize> State<N> {
    pub const fn still(q: [f64; N]) -> Self {
        Self { q, qd: [0.0; N], qdd: [0.0; N] }
    }
}

/// The state at which printed forms are shown to be wrong, for two joints.
pub const STATED_2: State<2> = State { q: [0.4, 0.9], qd: [1.3, -0.7], qdd: [2.1, -1.6] };

/// The same for three joints.
pub const STATED_3: State<3> = State { q: [0.4, 0.9, -0.5], qd: [1.3, -0.7, 0.8], qdd: [2.1, -1.6, 1.1] };

/// Positions up to half a turn, speeds up to 3, accelerations up to 10.
pub fn states<const N: usize>() -> impl Strategy<Value = State<N>> {
    (joints(3.2), joints(3.0), joints(10.0)).prop_map(|(q, qd, qdd)| State { q, qd, qdd })
}

/// Quantities that must be positive: masses, lengths and inertias.
pub fn sizes<const M: usize>() -> impl Strategy<Value = [f64; M]> {
    proptest::array::uniform(0.1..2.0)
}

/// The largest error over 256 draws, the same ones in every run.
pub fn worst<S: Strategy>(strategy: S, error: impl Fn(S::Value) -> f64) -> f64 {
    let mut runner = TestRunner::deterministic();
    (0..256).map(|_| error(strategy.new_tree(&mut runner).unwrap().current())).fold(0.0, larger)
}

/// Asserts that `worst` is below the tolerance, and prints it.
pub fn assert_equal<S: Strategy>(what: &str, strategy: S, error: impl Fn(S::Value) -> f64) {
    let found = worst(strategy, error);
    println!("{what}: worst relative error {found:.1e}");
    assert!(found < TOLERANCE, "{what}: {found:e}");
}

/// Largest difference over the largest wanted entry.
pub fn difference(found: &[f64], wanted: &[f64]) -> f64 {
    crate::common::relative_error(found, wanted)
}

/// Asserts that printed forms have the stated errors, each within a thousandth: neither more nor less.
#[track_caller]
pub fn assert_stated(found: &[f64], stated: &[f64]) {
    let near = |(found, stated): (&f64, &f64)| (found - stated).abs() <= 1e-3 * stated.abs() && *stated > 1e-6;
    assert!(found.len() == stated.len() && found.iter().zip(stated).all(near), "found {found:.5?}, stated {stated:?}");
}

pub fn body(mass: f64, com: [f64; 3], inertia: [f64; 3]) -> Body {
    Body { mass, com: com.into(), inertia: Matrix3::from_diagonal(&inertia.into()) }
}

pub fn point(mass: f64, at: [f64; 3]) -> Body {
    body(mass, at, [0.0; 3])
}

/// Several bodies joined to one.
pub fn joined(parts: &[Body]) -> Body {
    let mass = parts.iter().map(|part| part.mass).sum::<f64>();
    if mass == 0.0 {
        return Body { inertia: parts.iter().map(|part| part.inertia).sum(), ..Body::massless() };
    }
    let com = parts.iter().map(|part| part.com * part.mass).sum::<Vector3<f64>>() / mass;
    let about_com = |part: &Body| Inertia::from_mass_centre(part.mass, &(part.com - com), &part.inertia).about_origin;
    Body { mass, com, inertia: parts.iter().map(about_com).sum() }
}

pub fn joint(kind: JointKind, frame: Frame, body: Body) -> JointSpec {
    JointSpec { kind, frame, body, rotor: Rotor::default(), limits: Limits::none() }
}

/// A link of a planar arm: `R || R (0)` of the chapter, its frame at the far end.
pub fn planar_link(length: f64, body: Body) -> JointSpec {
    joint(JointKind::Revolute, Frame::ClassicalDh(Dh { a: length, ..Dh::default() }), body)
}

/// A joint placed on the link before, the link's frame at the joint.
pub fn placed(kind: JointKind, rotation: Matrix3<f64>, translation: [f64; 3], axis: [f64; 3], body: Body) -> JointSpec {
    joint(kind, Frame::Placement { rotation, translation: translation.into(), axis: axis.into() }, body)
}

/// An arm with a point mass at its tip, `tip` from the last link's frame.
pub fn arm<const N: usize>(
    joints: &[JointSpec; N],
    tip: [f64; 3],
    held: f64,
    gravity: Vector3<f64>,
) -> Dynamics<f64, N> {
    let tool = Tool { translation: tip.into(), ..Tool::default() };
    // Some examples give only one moment of inertia of a body.
    let model = Model::new_unphysical(joints, &tool).unwrap();
    let payload = Inertia { mass: held, ..Inertia::zero() };
    Dynamics::new(model, Scene { payload: Term::Constant(payload), ..Scene::with_gravity(gravity, &model) })
}

/// The same arm under a wrench of the environment at its tip, given in base axes, at one position.
pub fn pushed<const N: usize>(
    dynamics: &Dynamics<f64, N>,
    q: &[f64; N],
    force: Vector3<f64>,
    moment: Vector3<f64>,
) -> Dynamics<f64, N> {
    let turned = posture(dynamics, q).tip.rotation.transpose();
    let contact = Wrench { force: turned * force, moment: turned * moment };
    Dynamics::new(*dynamics.model(), Scene { tip_wrench: Term::Constant(contact), ..*dynamics.scene() })
}

/// `dD/dq_k`, exact: [`mass_matrix`] on dual numbers.
pub fn mass_matrix_slope<const N: usize>(dynamics: &Dynamics<f64, N>, q: &[f64; N], k: usize) -> SMatrix<f64, N, N> {
    let dual = Dynamics::new(dynamics.model().cast::<Dual>(), dynamics.scene().cast());
    let along = |i: usize| if i == k { 1.0 } else { 0.0 };
    let turn = core::array::from_fn(|i| {
        let (sin, cos) = libm::sincos(q[i]);
        SinCos { sin: Dual::new(sin, cos * along(i)), cos: Dual::new(cos, -sin * along(i)) }
    });
    let q = core::array::from_fn(|i| Dual::new(q[i], along(i)));
    mass_matrix(&dual, &turn, &q, &Live::zero()).map(|entry| entry.slope)
}
