//! Random arms in motion, the same in every run, and the worst of a measure over them.
#![allow(unused_macros, unused_imports, reason = "each test binary uses its part")]

use super::arms::{arm, body, joints, vector};
use super::turns;
use dynamics_core::chapter::posture::{Chain, Posture};
use dynamics_core::{Dynamics, Inertia, Model, Scene, Term, Wrench};
use nalgebra::Vector3;
use proptest::prelude::Strategy;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;

/// A random arm in motion, with a payload and a wrench at its tip.
#[derive(Clone, Copy, Debug)]
pub struct Moving<const N: usize> {
    pub model: Model<f64, N>,
    pub gravity: Vector3<f64>,
    /// Payload in the tip frame.
    pub payload: Inertia<f64>,
    /// Wrench on the arm, in tip axes.
    pub contact: Wrench<f64>,
    pub q: [f64; N],
    pub qd: [f64; N],
    pub qdd: [f64; N],
}

impl<const N: usize> Moving<N> {
    /// The dynamics with every term constant.
    pub fn dynamics(&self) -> Dynamics<f64, N> {
        let scene = Scene {
            payload: Term::Constant(self.payload),
            tip_wrench: Term::Constant(self.contact),
            ..Scene::with_gravity(self.gravity, &self.model)
        };
        Dynamics::new(self.model, scene)
    }

    pub fn chain(&self) -> Chain<f64, N> {
        Chain::new(&self.model, &self.payload)
    }

    pub fn posture(&self) -> Posture<f64, N> {
        self.chain().posture(&turns(&self.q), &self.q)
    }

    /// Wrench that pushes at the tip, in base axes.
    pub fn push(&self) -> Wrench<f64> {
        self.contact.in_parent(&self.posture().tip.rotation, &Vector3::zeros())
    }
}

pub fn moving<const N: usize>() -> impl Strategy<Value = Moving<N>> {
    let motion = (joints(3.2), joints(3.0), joints(10.0));
    (arm(), vector(12.0), body(), vector(30.0), vector(5.0), motion).prop_map(
        |(model, gravity, held, force, moment, (q, qd, qdd))| Moving {
            model,
            gravity,
            payload: Inertia::from_mass_centre(held.mass, &held.com, &held.inertia),
            contact: Wrench { force, moment },
            q,
            qd,
            qdd,
        },
    )
}

/// The worst of a measure over the same random arms of one to seven joints in every run.
macro_rules! worst_over_arms {
    ($error:ident) => {
        [
            $crate::common::moving::worst::<1>($error),
            $crate::common::moving::worst::<2>($error),
            $crate::common::moving::worst::<3>($error),
            $crate::common::moving::worst::<4>($error),
            $crate::common::moving::worst::<5>($error),
            $crate::common::moving::worst::<6>($error),
            $crate::common::moving::worst::<7>($error),
        ]
        .into_iter()
        .fold(0.0, f64::max)
    };
}
pub(crate) use worst_over_arms;

/// Number of arms of each length.
const ARMS: usize = 64;

/// The worst of a measure over the same random arms in every run.
pub fn worst<const N: usize>(error: impl Fn(&Moving<N>) -> f64) -> f64 {
    let each = fixed(moving::<N>(), ARMS).map(|case| error(&case));
    // f64::max drops a NaN; a test must not.
    each.fold(0.0, |worst, error| if error > worst || error.is_nan() { error } else { worst })
}

/// The same values in every run.
pub fn fixed<T: Strategy>(strategy: T, count: usize) -> impl Iterator<Item = T::Value> {
    let mut runner = TestRunner::deterministic();
    (0..count).map(move |_| strategy.new_tree(&mut runner).unwrap().current())
}

/// A property test of each function for one to seven joints; the file has a strategy `case`.
macro_rules! for_every_arm {
    ($($property:ident),* $(,)?) => {
        $(mod $property {
            use super::{case, proptest};
            proptest! {
                #![proptest_config(proptest::test_runner::Config::with_cases(64))]
                #[test]
                fn one_joint(case in case::<1>()) { super::$property(&case)?; }
                #[test]
                fn two_joints(case in case::<2>()) { super::$property(&case)?; }
                #[test]
                fn three_joints(case in case::<3>()) { super::$property(&case)?; }
                #[test]
                fn four_joints(case in case::<4>()) { super::$property(&case)?; }
                #[test]
                fn five_joints(case in case::<5>()) { super::$property(&case)?; }
                #[test]
                fn six_joints(case in case::<6>()) { super::$property(&case)?; }
                #[test]
                fn seven_joints(case in case::<7>()) { super::$property(&case)?; }
            }
        })*
    };
}
pub(crate) use for_every_arm;
