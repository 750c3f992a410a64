//! All methods for the same dynamics, compared with each other on 200 random spatial arms of one to six mixed joints.
//!
//! The methods share only the model. The arms are the same on every machine and in every run, so the worst
//! disagreement of each pair is a fixed number; it is pinned from both sides.
#![allow(clippy::unwrap_used, reason = "a random arm that cannot be built should stop the test")]

use crate::common::arms::{arm, body, held, joints, vector};
use crate::common::{derivative, lagrange_equation, relative_error};
use dynamics_core::chapter::global::Assembled;
use dynamics_core::chapter::posture::{Chain, Posture};
use dynamics_core::chapter::reactions::Reaction;
use dynamics_core::chapter::trace_form::Transforms;
use dynamics_core::chapter::{global, lagrange, statics};
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::trig::Libm;
use dynamics_core::{
    Body, Dh, Dynamics, Frame, Inertia, InverseDynamics, JointKind, JointSpec, Limits, Live, Model, Rotor, Scene,
    SinCos, Term, Tool, Trig, Wrench, energy,
};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use proptest::prelude::Strategy;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;

/// Number of arms, for one to six joints.
const ARMS: [usize; 6] = [33, 33, 33, 33, 34, 34];

/// An arm with a payload, a state of it, and a contact at its tip.
#[derive(Debug)]
struct Case<const N: usize> {
    model: Model<f64, N>,
    payload: Inertia<f64>,
    contact: Wrench<f64>,
    gravity: Vector3<f64>,
    q: [f64; N],
    qd: [f64; N],
    qdd: [f64; N],
}

/// Inputs for one computation of torques.
struct Demand<const N: usize> {
    qd: [f64; N],
    qdd: [f64; N],
    gravity: Vector3<f64>,
}

/// One method, without contact and without rotors.
struct Method<const N: usize> {
    name: &'static str,
    torque: fn(&Case<N>, &Demand<N>) -> [f64; N],
    /// The method's own inertia matrix, if it has one; otherwise torques of unit accelerations are used.
    mass_matrix: Option<fn(&Case<N>) -> SMatrix<f64, N, N>>,
    /// The method's own gravity torques, if it has them; otherwise torques at rest are used.
    gravity: Option<fn(&Case<N>) -> [f64; N]>,
}

/// The table of methods: a new method is one more entry.
fn methods<const N: usize>() -> Vec<Method<N>> {
    vec![
        Method {
            name: "recursive",
            torque: |case, demand| {
                let scene = Scene { gravity: Term::Constant(demand.gravity), ..case.scene() };
                let dynamics = Dynamics::new(case.model, scene);
                dynamics.inverse_dynamics(&case.turn(), &case.q, &demand.qd, &demand.qdd, &Live::zero())
            },
            mass_matrix: Some(|case| {
                mass_matrix(&Dynamics::new(case.model, case.scene()), &case.turn(), &case.q, &Live::zero())
            }),
            gravity: None,
        },
        Method {
            name: "Lagrange",
            torque: |case, demand| {
                lagrange::inverse_dynamics(&case.posture(), &demand.qd, &demand.qdd, &demand.gravity, &Wrench::zero())
            },
            mass_matrix: Some(|case| lagrange::mass_matrix(&case.posture())),
            gravity: Some(|case| lagrange::gravity(&case.posture(), &case.gravity)),
        },
        Method {
            name: "trace form",
            torque: |case, demand| case.transforms().inverse_dynamics(&demand.qd, &demand.qdd, &demand.gravity),
            mass_matrix: Some(|case| case.transforms().mass_matrix()),
            gravity: Some(|case| case.transforms().gravity(&case.gravity)),
        },
        Method {
            name: "assembled system",
            torque: |case, demand| {
                let posture = case.posture();
                let motion = posture.motion(&demand.qd, &demand.qdd);
                let weights = global::weights(&posture, &demand.gravity);
                let system = Assembled::new(&posture, &motion, &weights, &Wrench::zero());
                let wrenches = system.solve().unwrap();
                core::array::from_fn(|i| {
                    let link = &posture.links[i];
                    Reaction::of(link.kind, &link.axis, &wrenches[i]).actuator
                })
            },
            mass_matrix: None,
            gravity: Some(|case| statics::holding_torque(&case.posture(), &case.gravity, &Wrench::zero())),
        },
    ]
}

/// A property that must hold for an arm. Gives its errors, one number for each quantity.
trait Check<const K: usize> {
    fn off<const N: usize>(case: &Case<N>) -> [f64; K];
}

/// The worst errors over all arms.
fn worst<C: Check<K>, const K: usize>() -> [f64; K] {
    let mut runner = TestRunner::deterministic();
    let off = [
        worst_of::<C, K, 1>(&mut runner),
        worst_of::<C, K, 2>(&mut runner),
        worst_of::<C, K, 3>(&mut runner),
        worst_of::<C, K, 4>(&mut runner),
        worst_of::<C, K, 5>(&mut runner),
        worst_of::<C, K, 6>(&mut runner),
    ];
    core::array::from_fn(|k| off.iter().fold(0.0, |m, off| f64::max(m, off[k])))
}

fn worst_of<C: Check<K>, const K: usize, const N: usize>(runner: &mut TestRunner) -> [f64; K] {
    let mut worst = [0.0_f64; K];
    for _ in 0..ARMS[N - 1] {
        let case = case::<N>().new_tree(runner).unwrap().current();
        let off = C::off(&case);
        for k in 0..K {
            // f64::max drops a NaN; a test must not.
            assert!(off[k].is_finite(), "{off:?} of {case:?}");
            worst[k] = worst[k].max(off[k]);
        }
    }
    worst
}

/// Asserts the measured numbers: not worse, and not better without a reason.
fn assert_measured(found: &[f64], names: &[String], measured: &[f64]) {
    for (name, off) in names.iter().zip(found) {
        println!("{name}: {off:.3e}");
    }
    assert_eq!(found.len(), measured.len());
    for ((name, off), before) in names.iter().zip(found).zip(measured) {
        assert!(*off < 1.05 * before && *off > 0.95 * before, "{name}: {off:.3e}, measured before: {before:e}");
    }
}

fn case<const N: usize>() -> impl Strategy<Value = Case<N>> {
    let motion = (joints(3.2), joints(3.0), joints(10.0));
    (arm(), body(), vector(30.0), vector(5.0), vector(12.0), motion).prop_map(
        |(model, payload, force, moment, gravity, (q, qd, qdd))| Case {
            model,
            payload: held(&payload),
            contact: Wrench { force, moment },
            gravity,
            q,
            qd,
            qdd,
        },
    )
}

impl<const N: usize> Case<N> {
    /// Scene with gravity and payload.
    fn scene(&self) -> Scene<f64, N> {
        Scene { gravity: Term::Constant(self.gravity), payload: Term::Constant(self.payload), ..Scene::free_space() }
    }

    /// Sine and cosine by libm, which gives the same bits on every machine; the platform's sine does not.
    fn turn(&self) -> [SinCos<f64>; N] {
        Libm.sin_cos_all(&self.q)
    }

    fn posture(&self) -> Posture<f64, N> {
        self.posture_at(&self.q)
    }

    fn posture_at(&self, q: &[f64; N]) -> Posture<f64, N> {
        Chain::new(&self.model, &self.payload).posture(&Libm.sin_cos_all(q), q)
    }

    fn transforms(&self) -> Transforms<f64, N> {
        Transforms::new(&Chain::new(&self.model, &self.payload), &self.turn(), &self.q)
    }

    fn demand(&self) -> Demand<N> {
        Demand { qd: self.qd, qdd: self.qdd, gravity: self.gravity }
    }

    /// The contact in base axes.
    fn contact_in_base(&self) -> Wrench<f64> {
        let tip = self.posture().tip.rotation;
        Wrench { force: tip * self.contact.force, moment: tip * self.contact.moment }
    }
}

impl<const N: usize> Method<N> {
    fn mass_matrix_of(&self, case: &Case<N>) -> SMatrix<f64, N, N> {
        if let Some(own) = self.mass_matrix {
            return own(case);
        }
        let columns: [SVector<f64, N>; N] = core::array::from_fn(|j| {
            let qdd = core::array::from_fn(|i| if i == j { 1.0 } else { 0.0 });
            (self.torque)(case, &Demand { qd: [0.0; N], qdd, gravity: Vector3::zeros() }).into()
        });
        SMatrix::from_columns(&columns)
    }

    fn gravity_of(&self, case: &Case<N>) -> [f64; N] {
        let rest = Demand { qd: [0.0; N], qdd: [0.0; N], gravity: case.gravity };
        self.gravity.map_or_else(|| (self.torque)(case, &rest), |own| own(case))
    }
}

/// Pairs of the methods, in the order of the table.
const PAIRS: [(usize, usize); 6] = [(0, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 3)];

/// Errors of each pair: torque, inertia matrix, gravity torques.
struct Pairs;

const COMPARED: usize = 3 * PAIRS.len();

impl Check<COMPARED> for Pairs {
    fn off<const N: usize>(case: &Case<N>) -> [f64; COMPARED] {
        let all: Vec<_> = methods::<N>()
            .iter()
            .map(|m| ((m.torque)(case, &case.demand()), m.mass_matrix_of(case), m.gravity_of(case)))
            .collect();
        let pairs = PAIRS.map(|(a, b)| {
            let (a, b) = (&all[a], &all[b]);
            [relative_error(&b.0, &a.0), relative_error(b.1.as_slice(), a.1.as_slice()), relative_error(&b.2, &a.2)]
        });
        core::array::from_fn(|k| pairs[k / 3][k % 3])
    }
}

#[test]
fn every_method_gives_the_same_torques_matrix_and_weight() {
    let table = methods::<1>();
    assert_eq!(PAIRS.len(), table.len() * (table.len() - 1) / 2, "a pair is missing");
    let names: Vec<String> = PAIRS
        .iter()
        .flat_map(|&(a, b)| ["tau", "D", "G"].map(|what| format!("{what}, {} and {}", table[a].name, table[b].name)))
        .collect();
    let measured = [
        2.852e-15, 1.347e-15, 3.859e-15, // recursive and Lagrange
        2.852e-15, 8.841e-16, 4.898e-15, // recursive and trace form
        4.382e-15, 1.366e-15, 2.434e-15, // Lagrange and trace form
        1.813e-15, 1.347e-15, 3.265e-15, // recursive and assembled system; its G is from statics
        1.509e-15, 4.655e-16, 5.937e-16, // Lagrange and assembled system
        3.778e-15, 1.195e-15, 1.861e-15, // trace form and assembled system
    ];
    assert_measured(&worst::<Pairs, COMPARED>(), &names, &measured);
}

/// A contact at the tip, compared with eq. 12.236.
struct Contact;

impl Check<2> for Contact {
    fn off<const N: usize>(case: &Case<N>) -> [f64; 2] {
        let scene = Scene { tip_wrench: Term::Constant(case.contact), ..case.scene() };
        let dynamics = Dynamics::new(case.model, scene);
        let recursive = dynamics.inverse_dynamics(&case.turn(), &case.q, &case.qd, &case.qdd, &Live::zero());
        let (posture, push) = (case.posture(), case.contact_in_base());
        let found = lagrange::inverse_dynamics(&posture, &case.qd, &case.qdd, &case.gravity, &push);
        let free = lagrange::inverse_dynamics(&posture, &case.qd, &case.qdd, &case.gravity, &Wrench::zero());
        let balance = lagrange::generalized_force(&posture, &recursive, &push);
        let contact = lagrange::tip_jacobian(&posture).transposed(&push);
        let direct = dynamics_core::kinematics::tip_jacobian(&case.model, &case.turn(), &case.q).transposed(&push);
        assert!(relative_error(&direct, &contact) < 1e-13, "{direct:?} {contact:?}");
        let added: [f64; N] = core::array::from_fn(|i| recursive[i] + contact[i]);
        assert!(relative_error(&balance, &added) < 1e-16);
        [relative_error(&found, &recursive), relative_error(&balance, &free)]
    }
}

#[test]
fn a_contact_acts_by_the_transposed_jacobian() {
    let names = ["tau in contact", "generalized force"].map(str::to_owned);
    assert_measured(&worst::<Contact, 2>(), &names, &[4.327e-15, 3.993e-15]);
}

/// Kinetic and potential energy compared with [`energy`], and the kinetic one also with the trace form's matrix.
struct Energies;

impl Check<3> for Energies {
    fn off<const N: usize>(case: &Case<N>) -> [f64; 3] {
        let dynamics = Dynamics::new(case.model, case.scene());
        let wanted = energy::kinetic(&dynamics, &case.turn(), &case.q, &case.qd, &Live::zero());
        let height = energy::potential(&dynamics, &case.turn(), &case.q, &Live::zero());
        let posture = case.posture();
        let qd = SVector::from(case.qd);
        let by_trace = 0.5 * qd.dot(&(case.transforms().mass_matrix() * qd));
        let kinetic = lagrange::kinetic_energy(&posture, &case.qd);
        let potential = lagrange::potential_energy(&posture, &case.gravity);
        assert_eq!(lagrange::lagrangian(&posture, &case.qd, &case.gravity).to_bits(), (kinetic - potential).to_bits());
        // The weights above and below the base may cancel.
        let length = |v: &Vector3<f64>| v.dot(v).sqrt();
        let weights = posture.links.iter().map(|link| link.mass * length(&case.gravity) * length(&link.centre));
        let size: f64 = weights.sum();
        [
            relative_error(&[kinetic], &[wanted]),
            relative_error(&[by_trace], &[wanted]),
            (potential - height).abs() / size,
        ]
    }
}

#[test]
fn energies_by_jacobians_are_those_by_the_composite_matrix() {
    let names = ["K by Jacobians", "K by traces", "V"].map(str::to_owned);
    assert_measured(&worst::<Energies, 3>(), &names, &[2.251e-15, 2.484e-15, 2.693e-16]);
}

/// Lagrange's equation with every derivative taken numerically: the source of all the formulas.
struct Equation;

impl Check<1> for Equation {
    fn off<const N: usize>(case: &Case<N>) -> [f64; 1] {
        let lagrangian = |q: &[f64; N], qd: &[f64; N]| lagrange::lagrangian(&case.posture_at(q), qd, &case.gravity);
        let wanted = lagrange_equation(lagrangian, &case.q, &case.qd, &case.qdd);
        let found = lagrange::inverse_dynamics(&case.posture(), &case.qd, &case.qdd, &case.gravity, &Wrench::zero());
        [relative_error(&found, &wanted)]
    }
}

#[test]
fn torques_are_what_lagranges_equation_takes_from_the_energies() {
    let [off] = worst::<Equation, 1>();
    println!("tau and differentiated energies: {off:.3e}");
    assert!(off < 1e-8, "{off:e}");
}

/// Christoffel symbols by three methods, relative to the largest; `H` by 12.238 and by `C`.
struct Symbols;

impl Check<4> for Symbols {
    fn off<const N: usize>(case: &Case<N>) -> [f64; 4] {
        let posture = case.posture();
        let symbols = lagrange::christoffel(&posture);
        let flat = |all: &[[[f64; N]; N]; N]| all.as_flattened().as_flattened().to_vec();
        // Arms with a constant matrix have no symbols: the rounding error is measured relative to the matrix.
        let size = symbols
            .as_flattened()
            .as_flattened()
            .iter()
            .fold(lagrange::mass_matrix(&posture).amax(), |m, x| m.max(x.abs()));
        let off = |found: &[[[f64; N]; N]; N]| {
            let pairs = flat(found).into_iter().zip(flat(&symbols));
            pairs.fold(0.0, |m, (a, b)| f64::max(m, (a - b).abs())) / size
        };
        let (coupling, recursive) = (case.transforms().coupling(), by_polarisation(case));
        let h = lagrange::velocity_coupling(&posture, &case.qd);
        let c: [f64; N] = (lagrange::coriolis_matrix(&posture, &case.qd) * SVector::from(case.qd)).into();
        let contracted = h.iter().zip(&c).fold(0.0, |m, (a, b)| f64::max(m, (a - b).abs())) / (size * 9.0);
        let slopes = lagrange::mass_matrix_slopes(&posture);
        let numeric: [[[f64; N]; N]; N] = core::array::from_fn(|i| {
            core::array::from_fn(|j| {
                core::array::from_fn(|k| {
                    derivative(|step| {
                        lagrange::mass_matrix(&case.posture_at(&crate::common::stepped(&case.q, k, step)))[(i, j)]
                    })
                })
            })
        });
        let differenced =
            flat(&slopes).iter().zip(flat(&numeric)).fold(0.0, |m, (a, b)| f64::max(m, (a - b).abs())) / size;
        [off(&coupling), off(&recursive), contracted, differenced]
    }
}

/// The recursion's velocity terms are a quadratic form in `qd`, so three evaluations give each symbol without truncation error.
fn by_polarisation<const N: usize>(case: &Case<N>) -> [[[f64; N]; N]; N] {
    let terms = |j: usize, k: usize| -> [f64; N] {
        let qd = core::array::from_fn(|i| f64::from(u8::from(i == j)) + f64::from(u8::from(i == k)));
        (methods::<N>()[0].torque)(case, &Demand { qd, qdd: [0.0; N], gravity: Vector3::zeros() })
    };
    // H(e_j + e_k) counts the diagonal twice if j = k.
    let own: [[f64; N]; N] = core::array::from_fn(|j| terms(j, j).map(|x| x / 4.0));
    core::array::from_fn(|i| {
        core::array::from_fn(|j| {
            core::array::from_fn(|k| if j == k { own[j][i] } else { (terms(j, k)[i] - own[j][i] - own[k][i]) / 2.0 })
        })
    })
}

#[test]
fn trace_form_terms_are_christoffel_symbols_one_by_one() {
    let [coupling, recursive, contracted, differenced] = worst::<Symbols, 4>();
    let names = ["H_ijk of the trace form", "velocity terms of the recursion", "C qd and H"].map(str::to_owned);
    println!("slopes and differences of D: {differenced:.3e}");
    assert!(differenced < 1e-9, "{differenced:e}");
    assert_measured(&[coupling, recursive, contracted], &names, &[7.347e-16, 1.041e-15, 6.239e-16]);
}

/// The symmetric part of `dD/dt - 2 C`, relative to `|D| |qd|`, with `C` by Jacobians and by traces. `dD/dt` is taken from the slopes, from the
/// symbols, and numerically from the composite bodies' matrix.
struct Skew;

impl Check<4> for Skew {
    fn off<const N: usize>(case: &Case<N>) -> [f64; 4] {
        let posture = case.posture();
        let (symbols, slopes) = (lagrange::christoffel(&posture), lagrange::mass_matrix_slopes(&posture));
        let traces = case.transforms().coupling();
        let contract = |all: &dyn Fn(usize, usize, usize) -> f64| {
            SMatrix::<f64, N, N>::from_fn(|i, j| (0..N).map(|k| all(i, j, k) * case.qd[k]).sum())
        };
        let c = lagrange::coriolis_matrix(&posture, &case.qd);
        let c_traces = contract(&|i, j, k| traces[i][j][k]);
        let by_slopes = contract(&|i, j, k| slopes[i][j][k]);
        let by_symbols = contract(&|i, j, k| symbols[i][j][k] + symbols[j][i][k]);
        let dynamics = Dynamics::new(case.model, case.scene());
        let numeric = SMatrix::<f64, N, N>::from_fn(|i, j| {
            derivative(|t| {
                let (q, _) = crate::common::along(&case.q, &case.qd, &[0.0; N], t);
                mass_matrix(&dynamics, &Libm.sin_cos_all(&q), &q, &Live::zero())[(i, j)]
            })
        });
        let size = lagrange::mass_matrix(&posture).amax() * SVector::from(case.qd).amax();
        let symmetric_part = |rate: &SMatrix<f64, N, N>, c: &SMatrix<f64, N, N>| {
            let rest = rate - c * 2.0;
            (rest + rest.transpose()).amax() / (2.0 * size)
        };
        [
            symmetric_part(&by_slopes, &c),
            symmetric_part(&by_slopes, &c_traces),
            symmetric_part(&by_symbols, &c),
            symmetric_part(&numeric, &c),
        ]
    }
}

#[test]
fn the_rate_of_the_matrix_less_twice_c_is_skew_symmetric() {
    let [slopes, traces, symbols, numeric] = worst::<Skew, 4>();
    println!("with a numeric rate: {numeric:.3e}");
    assert!(numeric < 1e-8, "{numeric:e}");
    let names = ["slopes", "slopes, C by traces", "symbols"].map(str::to_owned);
    assert_measured(&[slopes, traces, symbols], &names, &[2.610e-16, 1.138e-15, 2.610e-16]);
}

/// Two slender rods of 1 kg and 1 m in a plane at `q = (0.4, 0.9)`: the arm on which printed and corrected forms are compared.
fn two_rods() -> Posture<f64, 2> {
    let rod = JointSpec {
        kind: JointKind::Revolute,
        frame: Frame::ClassicalDh(Dh { a: 1.0, ..Dh::default() }),
        body: Body {
            mass: 1.0,
            com: Vector3::new(-0.5, 0.0, 0.0),
            inertia: Matrix3::from_diagonal(&Vector3::new(0.0, 1.0 / 12.0, 1.0 / 12.0)),
        },
        rotor: Rotor::default(),
        limits: Limits::none(),
    };
    let model = Model::new(&[rod, rod], &Tool::default()).unwrap();
    let q = [0.4, 0.9];
    Chain::new(&model, &Inertia::zero()).posture(&Libm.sin_cos_all(&q), &q)
}

/// Asserts the relative error to six digits.
fn assert_wrong_by(found: &[f64], right: &[f64], wanted: f64) {
    let off = relative_error(found, right);
    assert!((off / wanted - 1.0).abs() < 1e-6, "{off} instead of {wanted}");
}

#[test]
fn half_the_rotational_inertia_is_not_the_inertia_of_two_rods() {
    let posture = two_rods();
    let right = lagrange::mass_matrix(&posture);
    let whole =
        [[5.0 / 3.0 + 0.9_f64.cos(), 1.0 / 3.0 + 0.5 * 0.9_f64.cos()], [1.0 / 3.0 + 0.5 * 0.9_f64.cos(), 1.0 / 3.0]];
    assert!(relative_error(right.as_slice(), whole.as_flattened()) < 1e-15);
    // 12.219 as printed: 1/2 J_R^T I J_R.
    let mut printed = SMatrix::<f64, 2, 2>::zeros();
    for (link, jacobian) in posture.links.iter().zip(lagrange::link_jacobians(&posture)) {
        let [linear, angular] =
            [jacobian.linear, jacobian.angular].map(|columns| SMatrix::<f64, 3, 2>::from_columns(&columns));
        printed += linear.transpose() * linear * link.mass + angular.transpose() * link.inertia * angular * 0.5;
    }
    // Half of 2/12 of the 2.2883 kg m^2: 3.6 %.
    assert_wrong_by(printed.as_slice(), right.as_slice(), (1.0 / 12.0) / (5.0 / 3.0 + 0.9_f64.cos()));
    assert_wrong_by(printed.as_slice(), right.as_slice(), 0.036_417_5);
}

#[test]
fn weight_with_the_printed_sign_is_the_other_way_round() {
    let (posture, g) = (two_rods(), Vector3::new(0.0, -9.81, 0.0));
    let right = lagrange::gravity(&posture, &g);
    let closed = [9.81 * (1.5 * 0.4_f64.cos() + 0.5 * 1.3_f64.cos()), 9.81 * 0.5 * 1.3_f64.cos()];
    assert!(relative_error(&right, &closed) < 1e-15);
    // 12.221 as printed: + sum m g^T J_D.
    let mut printed = [0.0; 2];
    for (link, jacobian) in posture.links.iter().zip(lagrange::link_jacobians(&posture)) {
        for i in 0..2 {
            printed[i] += link.mass * g.dot(&jacobian.linear[i]);
        }
    }
    assert_wrong_by(&printed, &right, 2.0);
}

#[test]
fn the_printed_coupling_read_as_a_matrix_is_not_skew_compatible() {
    let (posture, qd) = (two_rods(), [1.0, 2.0]);
    let slopes = lagrange::mass_matrix_slopes(&posture);
    // 12.220 as printed, one symbol for each i, j, k; 12.282 calls it the Christoffel symbol.
    let printed: [[[f64; 2]; 2]; 2] = core::array::from_fn(|i| {
        core::array::from_fn(|j| core::array::from_fn(|k| slopes[i][j][k] - 0.5 * slopes[j][k][i]))
    });
    let symbols = lagrange::christoffel(&posture);
    // The error is as large as the largest symbol, 1/2 sin(q2).
    assert_wrong_by(printed.as_flattened().as_flattened(), symbols.as_flattened().as_flattened(), 1.0);
    let c = SMatrix::<f64, 2, 2>::from_fn(|i, j| printed[i][j][0] * qd[0] + printed[i][j][1] * qd[1]);
    let rate = SMatrix::<f64, 2, 2>::from_fn(|i, j| slopes[i][j][0] * qd[0] + slopes[i][j][1] * qd[1]);
    // After contraction with the velocities it is correct, which is why it goes unnoticed...
    let coupled: [f64; 2] = (c * SVector::from(qd)).into();
    assert!(relative_error(&coupled, &lagrange::velocity_coupling(&posture, &qd)) < 1e-15);
    // ...but the symmetric part of dD/dt - 2 C is not zero: up to sin(q2) qd2 = 1.57 kg m^2/s, as large as dD/dt itself.
    let rest = rate - c * 2.0;
    let symmetric = (rest + rest.transpose()) * 0.5;
    assert!((symmetric[(0, 0)] - 0.9_f64.sin() * qd[1]).abs() < 1e-15);
    assert!((symmetric[(1, 1)] + 0.5 * 0.9_f64.sin() * qd[0]).abs() < 1e-15);
    assert_wrong_by(symmetric.as_slice(), &[0.0; 4], 0.9_f64.sin() * qd[1]);
}
