//! The poses of the links and the tip, and the tip's Jacobian.

use crate::geometry::{apply, compose};
use crate::inertia::Wrench;
use crate::joint::JointKind;
use crate::mass_matrix::link_placement;
use crate::model::{Model, Placement};
use crate::scalar::Scalar;
use crate::trig::SinCos;
use nalgebra::Vector3;

/// Pose of every link frame in the base frame, base first.
///
/// `base_from_link_i = base_from_link_{i-1} * parent_from_link_i(q_i)`. Inputs as
/// [`crate::InverseDynamics::inverse_dynamics`]; rotation without unit, origin in m.
#[must_use]
pub fn link_poses<S: Scalar, const N: usize>(
    model: &Model<S, N>,
    turn: &[SinCos<S>; N],
    q: &[S; N],
) -> [Placement<S>; N] {
    let mut poses = [Placement { rotation: nalgebra::Matrix3::identity(), translation: Vector3::zeros() }; N];
    for i in 0..N {
        let (rotation, translation) = link_placement(&model.links()[i], turn[i], q[i]);
        poses[i] = if i == 0 {
            Placement { rotation, translation }
        } else {
            beyond(&poses[i - 1], &Placement { rotation, translation })
        };
    }
    poses
}

/// Pose of the tip frame in the base frame.
#[must_use]
pub fn tip_pose<S: Scalar, const N: usize>(model: &Model<S, N>, turn: &[SinCos<S>; N], q: &[S; N]) -> Placement<S> {
    beyond(&link_poses(model, turn, q)[N - 1], model.tip())
}

/// Jacobian of a point of the arm and of the link that carries it (eq. 12.223), in the base frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jacobian<S, const N: usize> {
    /// Columns of `J_D`: velocity of the point per joint velocity, m/rad or without unit.
    pub linear: [Vector3<S>; N],
    /// Columns of `J_R`: angular velocity of the link per joint velocity, without unit; zero for a prismatic joint.
    pub angular: [Vector3<S>; N],
}

impl<S: Scalar, const N: usize> Jacobian<S, N> {
    /// Velocity of the point, m/s: `J_D qd`.
    #[must_use]
    pub fn velocity(&self, qd: &[S; N]) -> Vector3<S> {
        combine(&self.linear, qd)
    }

    /// Angular velocity of the link, rad/s: `J_R qd`.
    #[must_use]
    pub fn angular_velocity(&self, qd: &[S; N]) -> Vector3<S> {
        combine(&self.angular, qd)
    }

    /// Joint torques that do the same work as a wrench on the link, N m or N: `J^T w`.
    ///
    /// | name | quantity | unit | frame |
    /// |---|---|---|---|
    /// | `wrench` | force on the link, and its moment about the point | N, N m | base |
    #[must_use]
    pub fn transposed(&self, wrench: &Wrench<S>) -> [S; N] {
        core::array::from_fn(|i| self.linear[i].dot(&wrench.force) + self.angular[i].dot(&wrench.moment))
    }
}

/// Jacobian of the tip's origin: its linear and angular velocity in the base frame per joint velocity (eq. 12.223-12.225).
///
/// `v = J_v qd`, `omega = J_w qd`; columns in m/rad and 1 for a revolute joint, 1 and 0 for a prismatic one. Inputs as
/// [`crate::InverseDynamics::inverse_dynamics`]. [`Jacobian::transposed`] turns a wrench at the tip into joint torques. O(N).
#[must_use]
pub fn tip_jacobian<S: Scalar, const N: usize>(
    model: &Model<S, N>,
    turn: &[SinCos<S>; N],
    q: &[S; N],
) -> Jacobian<S, N> {
    let poses = link_poses(model, turn, q);
    let tip = beyond(&poses[N - 1], model.tip()).translation;
    let mut columns = Jacobian { linear: [Vector3::zeros(); N], angular: [Vector3::zeros(); N] };
    for (i, pose) in poses.iter().enumerate() {
        let axis = pose.rotation.column(2).into_owned();
        match model.links()[i].kind {
            JointKind::Revolute => {
                columns.linear[i] = axis.cross(&(tip - pose.translation));
                columns.angular[i] = axis;
            }
            JointKind::Prismatic => columns.linear[i] = axis,
        }
    }
    columns
}

fn beyond<S: Scalar>(first: &Placement<S>, next: &Placement<S>) -> Placement<S> {
    Placement {
        rotation: compose(&first.rotation, &next.rotation),
        translation: first.translation + apply(&first.rotation, &next.translation),
    }
}

fn combine<S: Scalar, const N: usize>(columns: &[Vector3<S>; N], factors: &[S; N]) -> Vector3<S> {
    columns.iter().zip(factors).fold(Vector3::zeros(), |sum, (column, factor)| sum + column * *factor)
}
