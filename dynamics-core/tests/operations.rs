//! Cost of each scene term in the generic recursion, counted by a counting scalar.
//!
//! The counts are exact and the same for every state, because a recursion over [`Scalar`] cannot branch on data. They are pinned
//! with `==`, so a saving must be entered here as well as a loss.
#![allow(clippy::unwrap_used, reason = "a broken data file should stop the test")]
#![allow(clippy::suspicious_arithmetic_impl, reason = "counting is an addition inside every operator")]

use crate::common::{Golden, numbers};
use core::cell::Cell;
use core::ops::{Add, Mul, Neg, Sub};
use dynamics_core::chapter::lagrange;
use dynamics_core::chapter::posture::Chain;
use dynamics_core::chapter::trace_form::Transforms;
use dynamics_core::{
    Dynamics, Inertia, InverseDynamics, Live, Model, Scalar, Scene, SinCos, Term, Wrench, assign_by_operators,
};
use nalgebra::{Matrix3, Vector3};
use num_traits::{One, Zero};

thread_local! {
    static COUNT: Cell<Operations> = const { Cell::new(Operations { mul: 0, add: 0, neg: 0 }) };
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Operations {
    mul: u32,
    add: u32,
    neg: u32,
}

fn count(f: impl FnOnce(&mut Operations)) {
    COUNT.with(|cell| {
        let mut operations = cell.get();
        f(&mut operations);
        cell.set(operations);
    });
}

/// A double that counts its operations; a subtraction counts as an addition.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Counted(f64);

impl Add for Counted {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        count(|n| n.add += 1);
        Self(self.0 + other.0)
    }
}
impl Sub for Counted {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        count(|n| n.add += 1);
        Self(self.0 - other.0)
    }
}
impl Mul for Counted {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        count(|n| n.mul += 1);
        Self(self.0 * other.0)
    }
}
impl Neg for Counted {
    type Output = Self;
    fn neg(self) -> Self {
        count(|n| n.neg += 1);
        Self(-self.0)
    }
}
assign_by_operators!(Counted);
impl Zero for Counted {
    fn zero() -> Self {
        Self(0.0)
    }
    fn is_zero(&self) -> bool {
        self.0 == 0.0
    }
}
impl One for Counted {
    fn one() -> Self {
        Self(1.0)
    }
}
impl Scalar for Counted {
    fn literal(x: f64) -> Self {
        Self(x)
    }
}

/// Operations of one inverse dynamics of the Puma, at one of the golden states.
fn cost(scene: impl FnOnce(&Model<f64, 6>) -> Scene<f64, 6>, state: usize) -> Operations {
    let golden = Golden::load("puma560");
    let model = golden.classical::<6>();
    let scene = scene(&model);
    let dynamics = Dynamics::new(model.cast::<Counted>(), scene.cast());
    let state = golden.states().nth(state).unwrap();
    let [q, qd, qdd] = ["q", "qd", "qdd"].map(|key| numbers::<6>(&state[key]).map(Counted));
    let turn = q.map(|Counted(x)| SinCos { sin: Counted(x.sin()), cos: Counted(x.cos()) });
    counted(|| {
        let _tau = dynamics.inverse_dynamics(&turn, &q, &qd, &qdd, &Live::zero());
    })
}

fn counted(work: impl FnOnce()) -> Operations {
    COUNT.set(Operations { mul: 0, add: 0, neg: 0 });
    work();
    COUNT.get()
}

fn full(model: &Model<f64, 6>) -> Scene<f64, 6> {
    Scene {
        payload: Term::Constant(Inertia::from_mass_centre(2.0, &Vector3::new(0.0, 0.0, 0.1), &Matrix3::identity())),
        tip_wrench: Term::Constant(Wrench { force: Vector3::x(), moment: Vector3::y() }),
        ..Scene::with_gravity(Vector3::new(0.0, 0.0, -9.81), model)
    }
}

fn operations(mul: u32, add: u32, neg: u32) -> Operations {
    Operations { mul, add, neg }
}

#[test]
fn the_count_does_not_depend_on_the_state() {
    let first = cost(full, 0);
    // State 50 is all zero, 51 is at rest, 52 has every velocity one.
    for state in [1, 7, 50, 51, 52] {
        assert_eq!(cost(full, state), first);
    }
}

#[test]
fn each_term_costs_what_is_written_here() {
    let table = [
        ("all", cost(full, 0)),
        ("no gravity", cost(|m| Scene { gravity: Term::Absent, ..full(m) }, 0)),
        ("no payload", cost(|m| Scene { payload: Term::Absent, ..full(m) }, 0)),
        ("no contact", cost(|m| Scene { tip_wrench: Term::Absent, ..full(m) }, 0)),
        ("no rotors", cost(|m| Scene { rotor: Term::Absent, ..full(m) }, 0)),
        ("no velocity terms", cost(|m| Scene { coriolis: Term::Absent, ..full(m) }, 0)),
        ("nothing", cost(|_| Scene { coriolis: Term::Absent, ..Scene::free_space() }, 0)),
        ("live payload", cost(|m| Scene { payload: Term::Live, ..full(m) }, 0)),
    ];
    let wanted = [
        ("all", operations(687, 615, 21)),
        ("no gravity", operations(665, 595, 18)),
        ("no payload", operations(687, 615, 21)),
        ("no contact", operations(663, 591, 21)),
        ("no rotors", operations(681, 609, 21)),
        ("no velocity terms", operations(507, 401, 3)),
        ("nothing", operations(455, 351, 0)),
        ("live payload", operations(687, 628, 21)),
    ];
    assert_eq!(table.as_slice(), wanted.as_slice());
}

#[test]
fn an_absent_term_costs_no_operation() {
    let all = cost(full, 0);
    let without = |scene: fn(&Model<f64, 6>) -> Scene<f64, 6>| cost(scene, 0);
    // A constant payload is merged into the link when the scene is made.
    assert_eq!(without(|m| Scene { payload: Term::Absent, ..full(m) }), all);
    // The rotors cost one product and one sum a joint. The contact costs two rotations, a cross product, and two differences.
    let no_rotor = without(|m| Scene { rotor: Term::Absent, ..full(m) });
    assert_eq!((all.mul - no_rotor.mul, all.add - no_rotor.add), (6, 6));
    let no_contact = without(|m| Scene { tip_wrench: Term::Absent, ..full(m) });
    assert_eq!((all.mul - no_contact.mul, all.add - no_contact.add), (9 + 9 + 6, 6 + 6 + 3 + 3 + 6));
}

/// Lagrange's equations for six revolute joints with gravity and velocity terms: the work that the recursion saves.
#[test]
fn lagranges_equations_cost_what_is_written_here() {
    let golden = Golden::load("puma560");
    let chain = Chain::<Counted, 6>::new(&golden.classical::<6>(), &Inertia::zero());
    let state = golden.states().next().unwrap();
    let [q, qd, qdd] = ["q", "qd", "qdd"].map(|key| numbers::<6>(&state[key]).map(Counted));
    let turn = q.map(|Counted(x)| SinCos { sin: Counted(x.sin()), cos: Counted(x.cos()) });
    let g = Vector3::new(0.0, 0.0, -9.81).map(Counted);
    let traces = counted(|| {
        let _tau = Transforms::new(&chain, &turn, &q).inverse_dynamics(&qd, &qdd, &g);
    });
    let jacobians = counted(|| {
        let posture = chain.posture(&turn, &q);
        let _tau = lagrange::inverse_dynamics(&posture, &qd, &qdd, &g, &Wrench::zero());
    });
    // 80 for each of 91 and 441 traces; two more products for each second derivative.
    let transforms = Transforms::new(&chain, &turn, &q);
    let matrix = counted(|| {
        let _d = transforms.mass_matrix();
    });
    let coupling = counted(|| {
        let _h = transforms.coupling();
    });
    assert_eq!([matrix.mul, coupling.mul], [91 * 80, 441 * 80 + 91 * 128]);
    let recursion = cost(|model| Scene::with_gravity(Vector3::new(0.0, 0.0, -9.81), model), 0);
    assert_eq!(
        [traces, jacobians, recursion],
        [operations(59_306, 47_081, 154), operations(7_470, 7_047, 0), operations(663, 591, 21)]
    );
}
