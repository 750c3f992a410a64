//! Torques that reflected rotor inertia omits, compared with the energy from which they are derived, over random arms.
#![allow(clippy::unwrap_used, reason = "a random arm that cannot be built should stop the test")]

use crate::common::arms::{arm, joints};
use crate::common::moving::for_every_arm;
use crate::common::{along, derivative, lagrange_equation, relative_error};
use dynamics_core::chapter::posture::{Chain, Posture};
use dynamics_core::chapter::rotor_coupling::{Carried, Rotors};
use dynamics_core::trig::Libm;
use dynamics_core::{Dh, Frame, Inertia, JointKind, JointSpec, Limits, Model, Rotor, Tool, Trig};
use proptest::prelude::{Strategy, prop_assert, proptest};
use proptest::test_runner::TestCaseError;

type Checked = Result<(), TestCaseError>;

#[derive(Debug)]
struct Case<const N: usize> {
    model: Model<f64, N>,
    rotors: Rotors<f64, N>,
    q: [f64; N],
    qd: [f64; N],
    qdd: [f64; N],
}

fn case<const N: usize>() -> impl Strategy<Value = Case<N>> {
    let positive = proptest::array::uniform::<_, N>(1e-5..1e-2);
    (arm(), positive, joints(100.0), joints(3.2), joints(3.0), joints(10.0))
        .prop_map(|(model, inertia, gear, q, qd, qdd)| Case { model, rotors: Rotors { inertia, gear }, q, qd, qdd })
}

fn posture<const N: usize>(model: &Model<f64, N>, q: &[f64; N]) -> Posture<f64, N> {
    Chain::new(model, &Inertia::zero()).posture(&Libm.sin_cos_all(q), q)
}

impl<const N: usize> Case<N> {
    /// The energy that the usual model omits, as a difference of whole energies.
    fn dropped(&self, carried: Carried, q: &[f64; N], qd: &[f64; N]) -> f64 {
        let posture = posture(&self.model, q);
        let all = self.rotors.complete_energy(&posture, qd) - self.rotors.reflected_energy(qd);
        // With a gear ratio of zero the rotor only turns with the link.
        let with_link = Rotors { gear: [0.0; N], ..self.rotors }.complete_energy(&posture, qd);
        match carried {
            Carried::ByLink => all - with_link,
            Carried::ByNone => all,
        }
    }

    fn extra(&self, carried: Carried) -> [f64; N] {
        self.rotors.extra_torque(&posture(&self.model, &self.q), carried, &self.qd, &self.qdd)
    }

    /// Reference for rounding errors in differences of these energies: their size, and the work of the torques.
    fn size(&self, torque: &[f64; N]) -> f64 {
        let energy = self.rotors.complete_energy(&posture(&self.model, &self.q), &self.qd);
        torque.iter().fold(energy + self.rotors.reflected_energy(&[1.0; N]), |m, x| m.max(x.abs()))
    }
}

fn torque_is_that_of_lagranges_equation<const N: usize>(case: &Case<N>) -> Checked {
    for carried in [Carried::ByLink, Carried::ByNone] {
        let found = case.extra(carried);
        let wanted = lagrange_equation(|q, qd| case.dropped(carried, q, qd), &case.q, &case.qd, &case.qdd);
        for i in 0..N {
            let off = (found[i] - wanted[i]).abs() / case.size(&wanted);
            prop_assert!(off < 1e-9, "{carried:?} {off:e}: {found:?} {wanted:?}");
        }
    }
    Ok(())
}

fn power_is_the_rate_of_the_energy<const N: usize>(case: &Case<N>) -> Checked {
    for carried in [Carried::ByLink, Carried::ByNone] {
        let found = case.extra(carried);
        let power: f64 = found.iter().zip(&case.qd).map(|(torque, speed)| torque * speed).sum();
        let rate = derivative(|t| {
            let (q, qd) = along(&case.q, &case.qd, &case.qdd, t);
            case.dropped(carried, &q, &qd)
        });
        let off = (power - rate).abs() / case.size(&found);
        prop_assert!(off < 1e-9, "{carried:?} {off:e}: {power} {rate}");
    }
    Ok(())
}

/// The coupling is odd in the gear ratio, unlike the reflected inertia; the first rotor, on the base, has no coupling.
fn turning_the_gear_round_turns_the_coupling_round<const N: usize>(case: &Case<N>) -> Checked {
    let back = Rotors { gear: case.rotors.gear.map(|n| -n), ..case.rotors };
    let place = posture(&case.model, &case.q);
    let found = back.extra_torque(&place, Carried::ByLink, &case.qd, &case.qdd);
    prop_assert!(relative_error(&found, &case.extra(Carried::ByLink).map(|x| -x)) < 1e-15);
    let mut first = Rotors { inertia: [0.0; N], gear: case.rotors.gear };
    first.inertia[0] = 1.0;
    for carried in [Carried::ByLink, Carried::ByNone] {
        let none = first.extra_torque(&place, carried, &case.qd, &case.qdd);
        prop_assert!(none.iter().all(|x| x.abs() < f64::MIN_POSITIVE), "{none:?}");
    }
    Ok(())
}

for_every_arm!(
    torque_is_that_of_lagranges_equation,
    power_is_the_rate_of_the_energy,
    turning_the_gear_round_turns_the_coupling_round,
);

/// With parallel axes `k . omega` is `qd1`: the energy is `I N qd1 qd2`, so each joint feels the other's acceleration.
#[test]
fn parallel_axes_couple_by_inertia_times_gear() {
    let link = JointSpec {
        kind: JointKind::Revolute,
        frame: Frame::ClassicalDh(Dh { a: 1.0, ..Dh::default() }),
        body: dynamics_core::Body::massless(),
        rotor: Rotor::default(),
        limits: Limits::none(),
    };
    let model = Model::new(&[link, link], &Tool::default()).unwrap();
    let rotors = Rotors { inertia: [3.0, 0.25], gear: [5.0, 100.0] };
    let torque = |carried| rotors.extra_torque(&posture(&model, &[0.3, 0.7]), carried, &[1.0, 2.0], &[4.0, 6.0]);
    assert!(relative_error(&torque(Carried::ByLink), &[25.0 * 6.0, 25.0 * 4.0]) < 1e-15);
    assert!(relative_error(&torque(Carried::ByNone), &[25.0 * 6.0 + 0.25 * 4.0, 25.0 * 4.0]) < 1e-15);
}
