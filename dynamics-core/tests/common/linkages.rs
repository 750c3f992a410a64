//! Random closed loops and their states.

use dynamics_core::SinCos;
use dynamics_core::linkage::{Branch, Linkage, LinkagePosture, PlanarBody, PlanarMotion};
use nalgebra::Vector2;
use proptest::prelude::{Strategy, any};
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;

/// A loop in some state, away from its dead points, near which every number is divided by a small one.
#[derive(Clone, Debug)]
pub struct Case<L> {
    pub linkage: L,
    /// The crank's angle, rad.
    pub angle: f64,
    pub branch: Branch,
    /// Speed and acceleration of the crank, rad/s and rad/s^2.
    pub speed: f64,
    pub acceleration: f64,
    pub gravity: Vector2<f64>,
}

impl<L: Linkage<f64>> Case<L> {
    /// The posture with the crank turned further by `more`, rad.
    pub fn posture_at(&self, more: f64) -> LinkagePosture<f64> {
        self.linkage.posture(&turn(self.angle + more), self.branch).unwrap()
    }

    pub fn posture(&self) -> LinkagePosture<f64> {
        self.posture_at(0.0)
    }

    pub fn motion(&self) -> [PlanarMotion<f64>; 3] {
        self.posture().coefficients().unwrap().map(|k| k.motion(self.speed, self.acceleration))
    }
}

/// The same `count` random loops in every run; `linkage` makes a loop, or none if the numbers do not fit.
pub fn cases<L, P>(count: usize, parts: P, linkage: impl Fn(P::Value) -> Option<L>) -> Vec<Case<L>>
where
    L: Linkage<f64>,
    P: Strategy,
{
    let mut runner = TestRunner::deterministic();
    let state = (signed(3.2), any::<bool>(), signed(20.0), signed(100.0), signed(12.0), signed(12.0));
    let strategy = (parts, state);
    let mut found = Vec::new();
    while found.len() < count {
        let (parts, (angle, open, speed, acceleration, x, y)) = strategy.new_tree(&mut runner).unwrap().current();
        let branch = if open { Branch::Open } else { Branch::Crossed };
        let Some(linkage) = linkage(parts) else { continue };
        let case = Case { linkage, angle, branch, speed, acceleration, gravity: Vector2::new(x, y) };
        // Two loops in three do not close at a random angle.
        if case.linkage.posture(&turn(angle), branch).is_ok_and(|posture| posture.transmission().abs() > 0.2) {
            found.push(case);
        }
    }
    found
}

/// Bodies of three links: the mass centres may be anywhere, also off the line between the joints.
pub fn bodies() -> impl Strategy<Value = [PlanarBody<f64>; 3]> {
    let body = (0.1..5.0, signed(0.5), signed(0.5), 0.001..0.5).prop_map(|(mass, x, y, inertia)| PlanarBody {
        mass,
        centre: Vector2::new(x, y),
        inertia,
    });
    [body.clone(), body.clone(), body]
}

/// Between `-size` and `size`.
pub fn signed(size: f64) -> impl Strategy<Value = f64> + Clone {
    -size..size
}

pub fn turn(angle: f64) -> SinCos<f64> {
    SinCos { sin: angle.sin(), cos: angle.cos() }
}

/// Largest error of a loop's forces in Newton's and Euler's equations of its three links (12.37-12.42 with 12.41 corrected):
/// relative to the largest joint force, and for moments to that force at the ends of the link.
pub fn missed<L: Linkage<f64>>(case: &Case<L>) -> f64 {
    let (posture, motion) = (case.posture(), case.motion());
    let forces = posture.forces(&motion, &case.gravity).unwrap();
    let largest = forces.joints.iter().map(|f| length(*f)).fold(0.0, f64::max);
    let couples = [forces.driving_moment, 0.0, -forces.guide_moment];
    let mut worst = 0.0_f64;
    for (i, (link, motion)) in posture.links.iter().zip(&motion).enumerate() {
        let (before, after) = (forces.joints[i], forces.joints[i + 1]);
        let force = before - after + case.gravity * link.mass - motion.acceleration * link.mass;
        let (n, m) = (link.inner_arm(), link.outer_arm());
        let moment = couples[i] + cross(&n, &before) - cross(&m, &after) - link.inertia * motion.alpha;
        worst = worst.max(length(force) / largest).max(moment.abs() / (largest * (length(n) + length(m))));
    }
    worst
}

/// `a x b`.
pub fn cross(a: &Vector2<f64>, b: &Vector2<f64>) -> f64 {
    a.x * b.y - a.y * b.x
}

/// nalgebra without std has no norm.
pub fn length(v: Vector2<f64>) -> f64 {
    v.x.hypot(v.y)
}

/// Solution and determinant of the nine equations, by Gauss-Jordan elimination.
pub fn nine(mut a: [[f64; 9]; 9], mut b: [f64; 9]) -> ([f64; 9], f64) {
    let mut determinant = 1.0;
    for k in 0..9 {
        let pivot = (k..9).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs())).unwrap();
        if pivot != k {
            a.swap(pivot, k);
            b.swap(pivot, k);
            determinant = -determinant;
        }
        determinant *= a[k][k];
        let (row, right) = (a[k].map(|x| x / a[k][k]), b[k] / a[k][k]);
        for i in (0..9).filter(|&i| i != k) {
            let factor = a[i][k];
            b[i] -= factor * right;
            a[i] = core::array::from_fn(|j| a[i][j] - factor * row[j]);
        }
        (a[k], b[k]) = (row, right);
    }
    (b, determinant)
}

/// Eq. 12.47 and its moment, from the motion alone: the reaction of the ground to the motion and weight of the bodies.
pub fn shaking(
    posture: &LinkagePosture<f64>,
    motion: &[PlanarMotion<f64>; 3],
    gravity: &Vector2<f64>,
) -> (Vector2<f64>, f64) {
    let (mut force, mut moment) = (Vector2::zeros(), 0.0);
    for (link, motion) in posture.links.iter().zip(motion) {
        let inertial = (motion.acceleration - gravity) * link.mass;
        force -= inertial;
        moment -= cross(&link.centre, &inertial) + link.inertia * motion.alpha;
    }
    (force, moment)
}

/// `d/dt (K + V)`, W.
pub fn energy_rate(posture: &LinkagePosture<f64>, motion: &[PlanarMotion<f64>; 3], gravity: &Vector2<f64>) -> f64 {
    posture.links.iter().zip(motion).fold(0.0, |rate, (link, motion)| {
        rate + link.mass * motion.velocity.dot(&(motion.acceleration - gravity))
            + link.inertia * motion.omega * motion.alpha
    })
}

/// The work of inertia and weight against the loop's motion when the crank turns by one radian, N m: `sum_i m_i (a_i - g) . dr_i +
/// I_i alpha_i dphi_i`. Displacements are differences of positions, so the kinematic coefficients are not used.
pub fn virtual_work<L: Linkage<f64>>(case: &Case<L>) -> f64 {
    const STEP: f64 = 1e-5;
    let (before, after, motion) = (case.posture_at(-STEP), case.posture_at(STEP), case.motion());
    (0..3).fold(0.0, |work, i| {
        let (before, after) = (&before.links[i], &after.links[i]);
        let moved = (after.centre - before.centre) / (2.0 * STEP);
        let turned = cross(&before.direction, &after.direction).asin() / (2.0 * STEP);
        work + before.mass * (motion[i].acceleration - case.gravity).dot(&moved)
            + before.inertia * motion[i].alpha * turned
    })
}

/// Size of the terms of this work, as the reference for rounding errors.
pub fn work_size(posture: &LinkagePosture<f64>, motion: &[PlanarMotion<f64>; 3], gravity: &Vector2<f64>) -> f64 {
    posture.links.iter().zip(motion).fold(0.0, |size, (link, motion)| {
        size + link.mass * length(motion.velocity) * (length(motion.acceleration) + length(*gravity))
            + link.inertia * (motion.omega * motion.alpha).abs()
    })
}
