//! The arm's equations of motion, by geometric Jacobians in the base frame.
//!
//! The simulation must not confirm the controller's mistakes, so nothing here shares a line with the controller's
//! recursion: no link frames on joint axes, no first moments, no accelerating base. For every body `b`, with its mass
//! centre `c`, its Jacobians `Jv`, `Jw` and its inertia `I` turned into base axes (Kane's form of the equations):
//!
//! ```text
//! D  = sum_b  m Jv^T Jv + Jw^T I Jw  +  diag(rotors)
//! h  = sum_b  m Jv^T a  + Jw^T (I alpha + w x I w)       a, alpha: accelerations of the body at qdd = 0
//! G  = -sum_b m Jv^T g                                    the gradient of the potential -m g.c
//! D qdd = drive - friction + J_tip^T wrench - h - G
//! ```
//!
//! `a` and `alpha` come from the time derivative of the Jacobian's columns: `d/dt [z x (c - o)] = z' x (c - o) +
//! z x (c' - o')`, `z' = w_before x z`.

use super::kinematics::{Axis, Pose, origin, rotation};
use dynamics_core::{Body, JointKind, JointSpec, Tool, Wrench};
use nalgebra::{Matrix3, SMatrix, Vector3};

/// An arm and what acts on it, as nature has it.
#[derive(Clone, Debug)]
pub struct Arm<const N: usize> {
    /// Joints and links, base first.
    pub joints: [JointSpec; N],
    /// What is mounted on the last link.
    pub tool: Tool,
    /// A body held at the tip, in the tip frame.
    pub payload: Option<Body>,
    /// Gravitational acceleration in the base frame, m/s^2.
    pub gravity: Vector3<f64>,
    /// Wrench of the environment on the arm at the tip's origin, in tip axes.
    pub tip_wrench: Option<Wrench<f64>>,
}

/// The parts of the equations of motion at one state.
#[derive(Clone, Debug)]
pub struct Terms<const N: usize> {
    /// Joint-space inertia with rotors, kg m^2, kg m, kg.
    pub mass_matrix: SMatrix<f64, N, N>,
    /// Centrifugal and Coriolis torques `h`, N m or N.
    pub coriolis: [f64; N],
    /// Torques `G` that hold the arm against gravity, N m or N.
    pub gravity: [f64; N],
    /// Torques `J^T w` with which the tip wrench drives the joints, N m or N.
    pub tip: [f64; N],
}

/// How fast a joint's axis moves.
#[derive(Clone, Copy)]
struct AxisRate {
    direction: Vector3<f64>,
    point: Vector3<f64>,
}

impl<const N: usize> Arm<N> {
    /// Every term of the equations of motion at a state; O(N^2) vector products per body.
    #[must_use]
    pub fn terms(&self, q: &[f64; N], qd: &[f64; N]) -> Terms<N> {
        let pose = Pose::new(&self.joints, &self.tool, q);
        let rates = axis_rates(&pose.axes, qd);
        let mut terms = Terms {
            mass_matrix: SMatrix::zeros(),
            coriolis: [0.0; N],
            gravity: [0.0; N],
            tip: self.tip_torques(&pose),
        };
        for i in 0..N {
            terms.mass_matrix[(i, i)] = self.joints[i].rotor.reflected();
        }
        self.for_each_body(&pose, |link, mass, centre, inertia| {
            add_body(&mut terms, &self.gravity, &pose.axes[..=link], &rates, qd, mass, centre, inertia);
        });
        terms.mass_matrix.fill_upper_triangle_with_lower_triangle();
        terms
    }

    /// Joint accelerations under joint torques `drive`; `None` when the inertia matrix is not positive definite.
    #[must_use]
    pub fn acceleration(&self, q: &[f64; N], qd: &[f64; N], drive: &[f64; N]) -> Option<[f64; N]> {
        let terms = self.terms(q, qd);
        let rest = core::array::from_fn(|i| drive[i] + terms.tip[i] - terms.coriolis[i] - terms.gravity[i]);
        cholesky_solve(&terms.mass_matrix, &rest)
    }

    /// Pose of the tip in the base frame: rotation and origin (m).
    #[must_use]
    pub fn tip_pose(&self, q: &[f64; N]) -> (Matrix3<f64>, Vector3<f64>) {
        let tip = Pose::new(&self.joints, &self.tool, q).tip;
        (rotation(&tip), origin(&tip))
    }

    /// `1/2 qd^T D qd`, J.
    #[must_use]
    pub fn kinetic(&self, q: &[f64; N], qd: &[f64; N]) -> f64 {
        let qd = nalgebra::SVector::<f64, N>::from(*qd);
        0.5 * qd.dot(&(self.terms(q, &qd.into()).mass_matrix * qd))
    }

    /// `-sum m g.c`, J; zero for masses at the base origin.
    #[must_use]
    pub fn potential(&self, q: &[f64; N]) -> f64 {
        let mut energy = 0.0;
        self.for_each_body(&Pose::new(&self.joints, &self.tool, q), |_, mass, centre, _| {
            energy -= mass * self.gravity.dot(&centre);
        });
        energy
    }

    /// Calls `visit(link, mass, mass centre, inertia)` for every link, the tool and the payload, in base axes.
    fn for_each_body(&self, pose: &Pose<N>, mut visit: impl FnMut(usize, f64, Vector3<f64>, Matrix3<f64>)) {
        let links = self.joints.iter().zip(&pose.links).enumerate().map(|(i, (joint, frame))| (i, &joint.body, frame));
        let held = [Some(&self.tool.body), self.payload.as_ref()].into_iter().flatten();
        for (link, body, frame) in links.chain(held.map(|body| (N - 1, body, &pose.tip))) {
            let r = rotation(frame);
            visit(link, body.mass, r * body.com + origin(frame), r * body.inertia * r.transpose());
        }
    }

    fn tip_torques(&self, pose: &Pose<N>) -> [f64; N] {
        let Some(wrench) = &self.tip_wrench else {
            return [0.0; N];
        };
        let (r, at) = (rotation(&pose.tip), origin(&pose.tip));
        let (force, moment) = (r * wrench.force, r * wrench.moment);
        pose.axes.map(|axis| column(&axis, &at).dot(&force) + turn_column(&axis).dot(&moment))
    }
}

/// Add one body's inertia (below and on the diagonal), velocity torques and weight; `axes` are those of the joints that
/// move it.
#[allow(
    clippy::too_many_arguments,
    reason = "the quantities of one line of Kane's equations; a struct would only rename them"
)]
fn add_body<const N: usize>(
    terms: &mut Terms<N>,
    gravity: &Vector3<f64>,
    axes: &[Axis],
    rates: &[AxisRate; N],
    qd: &[f64; N],
    mass: f64,
    centre: Vector3<f64>,
    inertia: Matrix3<f64>,
) {
    let mut linear = [Vector3::zeros(); N];
    let mut angular = [Vector3::zeros(); N];
    let (mut velocity, mut turning) = (Vector3::zeros(), Vector3::zeros());
    for (j, axis) in axes.iter().enumerate() {
        linear[j] = column(axis, &centre);
        angular[j] = turn_column(axis);
        velocity += linear[j] * qd[j];
        turning += angular[j] * qd[j];
    }
    let (mut acceleration, mut angular_acceleration) = (Vector3::zeros(), Vector3::zeros());
    for (j, axis) in axes.iter().enumerate() {
        let rate = &rates[j];
        match axis.kind {
            JointKind::Revolute => {
                let spread = rate.direction.cross(&(centre - axis.point));
                acceleration += (spread + axis.direction.cross(&(velocity - rate.point))) * qd[j];
                angular_acceleration += rate.direction * qd[j];
            }
            // A slide's column is its direction, once for its own turning and once for the body carried along it.
            JointKind::Prismatic => acceleration += rate.direction * qd[j],
        }
    }
    let force = acceleration * mass;
    let moment = inertia * angular_acceleration + turning.cross(&(inertia * turning));
    for j in 0..axes.len() {
        terms.coriolis[j] += linear[j].dot(&force) + angular[j].dot(&moment);
        terms.gravity[j] -= mass * gravity.dot(&linear[j]);
        let turned = inertia * angular[j];
        for k in 0..=j {
            terms.mass_matrix[(j, k)] += mass * linear[j].dot(&linear[k]) + turned.dot(&angular[k]);
        }
    }
}

/// The joint's column of the Jacobian of a point: velocity of the point per unit of joint velocity.
fn column(axis: &Axis, at: &Vector3<f64>) -> Vector3<f64> {
    match axis.kind {
        JointKind::Revolute => axis.direction.cross(&(at - axis.point)),
        JointKind::Prismatic => axis.direction,
    }
}

/// The joint's column of the Jacobian of the angular velocity.
fn turn_column(axis: &Axis) -> Vector3<f64> {
    match axis.kind {
        JointKind::Revolute => axis.direction,
        JointKind::Prismatic => Vector3::zeros(),
    }
}

/// Velocity of each axis: its direction turns with the link before, its point moves with it.
fn axis_rates<const N: usize>(axes: &[Axis; N], qd: &[f64; N]) -> [AxisRate; N] {
    core::array::from_fn(|j| {
        let (mut turning, mut velocity) = (Vector3::zeros(), Vector3::zeros());
        for k in 0..j {
            turning += turn_column(&axes[k]) * qd[k];
            velocity += column(&axes[k], &axes[j].point) * qd[k];
        }
        AxisRate { direction: turning.cross(&axes[j].direction), point: velocity }
    })
}

/// `x` with `A x = b` by Cholesky's `A = L L^T`; `None` when a pivot is not above zero.
pub(super) fn cholesky_solve<const N: usize>(a: &SMatrix<f64, N, N>, b: &[f64; N]) -> Option<[f64; N]> {
    let mut l = SMatrix::<f64, N, N>::zeros();
    for j in 0..N {
        for i in j..N {
            let sum: f64 = (0..j).map(|k| l[(i, k)] * l[(j, k)]).sum();
            let rest = a[(i, j)] - sum;
            if i > j {
                l[(i, j)] = rest / l[(j, j)];
            } else if rest > 0.0 && rest.is_finite() {
                l[(j, j)] = rest.sqrt();
            } else {
                return None;
            }
        }
    }
    let mut x = *b;
    for i in 0..N {
        let sum: f64 = (0..i).map(|k| l[(i, k)] * x[k]).sum();
        x[i] = (x[i] - sum) / l[(i, i)];
    }
    for i in (0..N).rev() {
        let sum: f64 = (i + 1..N).map(|k| l[(k, i)] * x[k]).sum();
        x[i] = (x[i] - sum) / l[(i, i)];
    }
    Some(x)
}
