//! Example 345: statics of a planar arm of four revolute joints, eq. 12.475-12.496.

use super::support_b::{
    DOWN_Y, G, State, arm, assert_equal, assert_stated, body, difference, planar_link, posture, pushed, sizes,
    wrenches_in_base,
};
use crate::common::arms::joints;
use crate::common::torque;
use dynamics_core::Dynamics;
use nalgebra::Vector3;
use proptest::prelude::Strategy;

/// Masses and lengths, and the wrench of the end-effector on the environment, in base axes: `(F_x, F_y, M_z)`.
#[derive(Debug)]
struct Holding {
    m: [f64; 4],
    l: [f64; 4],
    on_environment: [f64; 3],
    q: [f64; 4],
}

const STATED: Holding = Holding {
    m: [3.0, 2.0, 1.5, 1.0],
    l: [0.7, 0.5, 0.4, 0.3],
    on_environment: [12.0, -7.0, 3.0],
    q: [0.4, 0.9, -0.5, 0.7],
};

fn draws() -> impl Strategy<Value = Holding> {
    (sizes(), sizes(), proptest::array::uniform(-20.0..20.0), joints(3.2))
        .prop_map(|(m, l, on_environment, q)| Holding { m, l, on_environment, q })
}

impl Holding {
    fn links(&self) -> Dynamics<f64, 4> {
        let link = |i: usize| {
            let inertia = self.m[i] * self.l[i] * self.l[i] / 12.0;
            planar_link(self.l[i], body(self.m[i], [-self.l[i] / 2.0, 0.0, 0.0], [0.0, inertia, inertia]))
        };
        arm(&[link(0), link(1), link(2), link(3)], [0.0; 3], 0.0, DOWN_Y)
    }

    /// 12.475 understood as `0F_4`, `0M_4`, in base axes: the wrench on the arm is its negative.
    fn dynamics(&self) -> Dynamics<f64, 4> {
        let [fx, fy, mz] = self.on_environment;
        pushed(&self.links(), &self.q, Vector3::new(-fx, -fy, 0.0), Vector3::new(0.0, 0.0, -mz))
    }

    /// `F_0` to `F_3` (eq. 12.482-12.485, the results).
    fn forces(&self) -> [Vector3<f64>; 4] {
        let [fx, fy, _] = self.on_environment;
        core::array::from_fn(|i| Vector3::new(fx, fy + G * self.m[i..].iter().sum::<f64>(), 0.0))
    }

    /// `M_0z` to `M_3z` (eq. 12.487, 12.489, 12.491, 12.493 with 12.494-12.496).
    fn moments(&self) -> [f64; 4] {
        let Self { m: [m1, m2, m3, m4], l: [l1, l2, l3, l4], on_environment: [fx, fy, mz], q } = *self;
        let angle = |n: usize| q[..n].iter().sum::<f64>();
        let ((s1, c1), (s12, c12)) = (angle(1).sin_cos(), angle(2).sin_cos());
        let ((s123, c123), (s1234, c1234)) = (angle(3).sin_cos(), angle(4).sin_cos());
        let third = mz + l4 * fy * c1234 - l4 * fx * s1234 + G * l4 * m4 * c1234 / 2.0;
        let second = third + G * l3 * m3 * c123 / 2.0 - l3 * fx * s123 + l3 * (fy + G * m4) * c123;
        let first = second + G * l2 * m2 * c12 / 2.0 - l2 * fx * s12 + l2 * c12 * (fy + G * (m3 + m4));
        let base = first + G * l1 * m1 * c1 / 2.0 - l1 * fx * s1 + l1 * c1 * (fy + G * (m2 + m3 + m4));
        [base, first, second, third]
    }

    /// Sum of the magnitudes of all terms of a moment.
    fn size(&self) -> f64 {
        let reach = self.l.iter().sum::<f64>();
        self.on_environment.iter().map(|x| x.abs()).sum::<f64>() * (1.0 + reach)
            + G * self.m.iter().sum::<f64>() * reach
    }
}

#[test]
fn joint_forces_are_12_482_to_12_485() {
    assert_equal("12.482-12.485", draws(), |holding| {
        let found = wrenches_in_base(&holding.dynamics(), &State::still(holding.q));
        let off = (0..4).map(|i| (found[i].force - holding.forces()[i]).amax()).fold(0.0, f64::max);
        off / holding.forces().iter().fold(0.0, |m, f| f.amax().max(m))
    });
}

#[test]
fn joint_moments_are_12_486_to_12_496() {
    assert_equal("12.486-12.496", draws(), |holding| {
        let dynamics = holding.dynamics();
        let found = wrenches_in_base(&dynamics, &State::still(holding.q));
        let held = torque::<f64, 4>(&dynamics, &holding.q, &[0.0; 4], &[0.0; 4]);
        let wanted = holding.moments();
        (0..4)
            .flat_map(|i| {
                let moment = found[i].moment - Vector3::new(0.0, 0.0, wanted[i]);
                [moment.amax(), (held[i] - wanted[i]).abs()]
            })
            .fold(0.0, f64::max)
            / holding.size()
    });
}

/// 12.477-12.481: mass centres at half length of each link, and the links themselves, turned into the base frame as free vectors.
#[test]
fn positions_are_12_477_to_12_481() {
    assert_equal("12.477-12.481", draws(), |holding| {
        let posture = posture(&holding.links(), &holding.q);
        let mut angle = 0.0;
        (0..4)
            .map(|i| {
                angle += holding.q[i];
                let along = Vector3::new(angle.cos(), angle.sin(), 0.0) * holding.l[i];
                let half = -posture.inner_arm(i) - along / 2.0;
                let whole = posture.end(i) - posture.links[i].origin - along;
                half.amax().max(whole.amax())
            })
            .fold(0.0, f64::max)
            / holding.l.iter().sum::<f64>()
    });
}

/// 12.475 labels the wrench with the frame `B_4` and later equations add its components to base-frame vectors.
#[test]
fn label_of_12_475_is_wrong() {
    let [fx, fy, mz] = STATED.on_environment;
    let turned = posture(&STATED.links(), &STATED.q).tip.rotation;
    let (force, moment) = (turned * Vector3::new(-fx, -fy, 0.0), Vector3::new(0.0, 0.0, -mz));
    let labelled = wrenches_in_base(&pushed(&STATED.links(), &STATED.q, force, moment), &State::still(STATED.q));
    let printed = STATED.moments();
    let found = labelled.map(|wrench| wrench.moment.z);
    assert_stated(&[difference(&printed, &found)], &[0.4877]);
}

/// The first lines of 12.483-12.485 subtract weights that the following lines add.
#[test]
fn symbolic_lines_of_12_483_to_12_485_have_the_wrong_sign() {
    let found = wrenches_in_base(&STATED.dynamics(), &State::still(STATED.q));
    let off: [f64; 3] = core::array::from_fn(|i| {
        let printed = found[i + 1].force - Vector3::new(0.0, STATED.m[i] * G, 0.0);
        difference(printed.as_slice(), found[i].force.as_slice())
    });
    assert_stated(&off, &[0.8841, 1.056, 1.679]);
}
