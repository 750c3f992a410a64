//! Where everything is: 4 x 4 homogeneous products, and joint axes in the base frame.

use dynamics_core::{Dh, Frame, JointKind, JointSpec, Tool};
use nalgebra::{Matrix3, Matrix4, Vector3};

/// A joint's axis as seen from the base.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    pub(super) kind: JointKind,
    /// Unit vector along the axis.
    pub(super) direction: Vector3<f64>,
    /// A point on the axis that is fixed to the link before (revolute joints; m).
    pub(super) point: Vector3<f64>,
}

/// The arm at one position, everything in the base frame.
#[derive(Clone, Debug)]
pub(super) struct Pose<const N: usize> {
    pub(super) axes: [Axis; N],
    /// `base_from_link`, in the frame that the link's data are given in.
    pub(super) links: [Matrix4<f64>; N],
    /// `base_from_tip`.
    pub(super) tip: Matrix4<f64>,
}

impl<const N: usize> Pose<N> {
    /// `base_from_link_i = base_from_link_{i-1} A_i(q_i)`, with `A_i` as the joint's own convention has it.
    pub(super) fn new(joints: &[JointSpec; N], tool: &Tool, q: &[f64; N]) -> Self {
        let mut base_from_link = Matrix4::identity();
        let mut axes = [Axis { kind: JointKind::Revolute, direction: Vector3::z(), point: Vector3::zeros() }; N];
        let links = core::array::from_fn(|i| {
            let (before, axis_in_joint, moved) = joint(&joints[i], q[i]);
            let base_from_joint = base_from_link * before;
            base_from_link = base_from_joint * moved;
            axes[i] = Axis {
                kind: joints[i].kind,
                direction: rotation(&base_from_joint) * axis_in_joint,
                point: origin(&base_from_joint),
            };
            base_from_link
        });
        Self { axes, links, tip: base_from_link * homogeneous(&tool.rotation, &tool.translation) }
    }
}

/// `(link_before_from_joint, axis in the joint frame, joint_from_link)`; the last holds the motion.
fn joint(joint: &JointSpec, q: f64) -> (Matrix4<f64>, Vector3<f64>, Matrix4<f64>) {
    match &joint.frame {
        Frame::ClassicalDh(dh) => (Matrix4::identity(), Vector3::z(), along_z(joint.kind, dh, q) * along_x(dh)),
        Frame::ModifiedDh(dh) => (along_x(dh), Vector3::z(), along_z(joint.kind, dh, q)),
        Frame::Placement { rotation, translation, axis } => {
            let moved = match joint.kind {
                JointKind::Revolute => homogeneous(&about(axis, q), &Vector3::zeros()),
                JointKind::Prismatic => homogeneous(&Matrix3::identity(), &(axis * q)),
            };
            (homogeneous(rotation, translation), *axis, moved)
        }
    }
}

/// `Rz(theta) Tz(d)`, the joint variable added to the one or the other.
fn along_z(kind: JointKind, dh: &Dh, q: f64) -> Matrix4<f64> {
    let (theta, d) = match kind {
        JointKind::Revolute => (dh.theta + q, dh.d),
        JointKind::Prismatic => (dh.theta, dh.d + q),
    };
    homogeneous(&about(&Vector3::z(), theta), &Vector3::new(0.0, 0.0, d))
}

/// `Rx(alpha) Tx(a)`; the two commute.
fn along_x(dh: &Dh) -> Matrix4<f64> {
    homogeneous(&about(&Vector3::x(), dh.alpha), &Vector3::new(dh.a, 0.0, 0.0))
}

/// Rodrigues: `1 + sin K + (1 - cos) K^2`, with `K` the cross-product matrix of the unit axis.
fn about(axis: &Vector3<f64>, angle: f64) -> Matrix3<f64> {
    let (sin, cos) = libm::sincos(angle);
    let k = axis.cross_matrix();
    Matrix3::identity() + k * sin + k * k * (1.0 - cos)
}

fn homogeneous(rotation: &Matrix3<f64>, translation: &Vector3<f64>) -> Matrix4<f64> {
    let mut m = rotation.to_homogeneous();
    m.fixed_view_mut::<3, 1>(0, 3).copy_from(translation);
    m
}

pub(super) fn rotation(m: &Matrix4<f64>) -> Matrix3<f64> {
    m.fixed_view::<3, 3>(0, 0).into_owned()
}

pub(super) fn origin(m: &Matrix4<f64>) -> Vector3<f64> {
    m.fixed_view::<3, 1>(0, 3).into_owned()
}
