//! Kinematics: the constant transforms of the robot file, multiplied out once, and joint axes in the base frame.

use dynamics_core::{Body, Dh, Frame, JointKind, JointSpec, Scalar, SinCos, Tool};
use nalgebra::{Matrix3, Matrix4, Vector3};

/// Rotation and origin (m) of a frame, relative to another frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place<S> {
    pub(super) rotation: Matrix3<S>,
    pub(super) origin: Vector3<S>,
}

/// A body: mass, mass centre, and inertia about it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solid<S> {
    pub(super) mass: S,
    pub(super) com: Vector3<S>,
    pub(super) inertia: Matrix3<S>,
}

/// A joint, given in the frame that moves with the joint before it. The constant transform comes before the motion, and
/// the motion is about or along z.
#[derive(Clone, Debug)]
pub(super) struct Joint<S> {
    pub(super) kind: JointKind,
    pub(super) place: Place<S>,
    /// Bodies that the joint moves, rigidly joined, in the frame that moves with it.
    pub(super) bodies: Vec<Solid<S>>,
    pub(super) rotor: S,
}

/// The joints of an arm, and its tip in the frame that moves with the last joint.
#[derive(Clone, Debug)]
pub(super) struct Chain<S, const N: usize> {
    pub(super) joints: [Joint<S>; N],
    pub(super) tip: Place<S>,
}

impl<const N: usize> Chain<f64, N> {
    /// Multiplies out `base_from_link_i = base_from_link_{i-1} A_i(q_i)`, with `A_i` by the convention that the joint uses.
    pub(super) fn new(joints: &[JointSpec; N], tool: &Tool, payload: Option<&Body>) -> Self {
        // Transform from the frame that moves with a joint to the link frame, in which the link's data and the next
        // joint are given.
        let mut moved_from_link = Matrix4::identity();
        let mut chain = joints.each_ref().map(|joint| {
            let (before, after) = constant_parts(joint);
            let place = place(&(moved_from_link * before));
            moved_from_link = after;
            let bodies = vec![Solid::moved(&joint.body, &after)];
            Joint { kind: joint.kind, place, bodies, rotor: joint.rotor.reflected() }
        });
        let tip = moved_from_link * homogeneous(&tool.rotation, &tool.translation);
        if let Some(last) = chain.last_mut() {
            last.bodies.extend(core::iter::once(&tool.body).chain(payload).map(|body| Solid::moved(body, &tip)));
        }
        for joint in &mut chain {
            joint.bodies.retain(|body| body.mass > 0.0 || body.inertia != Matrix3::zeros());
        }
        Self { joints: chain, tip: place(&tip) }
    }

    /// The same chain with every number mapped by `f`, always in the same order.
    pub(super) fn map<S: Scalar>(&self, mut f: impl FnMut(f64) -> S) -> Chain<S, N> {
        let joints = self.joints.each_ref().map(|Joint { kind, place, bodies, rotor }| Joint {
            kind: *kind,
            place: place.map(&mut f),
            bodies: bodies.iter().map(|body| body.map(&mut f)).collect(),
            rotor: f(*rotor),
        });
        Chain { joints, tip: self.tip.map(f) }
    }
}

impl<S: Scalar, const N: usize> Chain<S, N> {
    /// Every joint and the frame that moves with it, in base axes.
    pub(super) fn pose(&self, turn: &[SinCos<S>; N], q: &[S; N]) -> [Pose<S>; N] {
        let mut before: Option<Matrix3<S>> = None;
        core::array::from_fn(|i| {
            let joint = &self.joints[i];
            let Place { rotation, origin } = joint.place;
            let (rotation, mut offset) = before.map_or((rotation, origin), |r| (r * rotation, r * origin));
            let column = |k: usize| rotation.column(k).into_owned();
            let (x, y, axis) = (column(0), column(1), column(2));
            let rotation = match joint.kind {
                JointKind::Revolute => {
                    let SinCos { sin, cos } = turn[i];
                    Matrix3::from_columns(&[x * cos + y * sin, y * cos - x * sin, axis])
                }
                JointKind::Prismatic => {
                    offset += axis * q[i];
                    rotation
                }
            };
            before = Some(rotation);
            Pose { kind: joint.kind, axis, offset, rotation }
        })
    }

    /// The frames that move with the joints, in the base frame.
    pub(super) fn places(&self, turn: &[SinCos<S>; N], q: &[S; N]) -> [Place<S>; N] {
        let mut origin = Vector3::zeros();
        self.pose(turn, q).map(|pose| {
            origin += pose.offset;
            Place { rotation: pose.rotation, origin }
        })
    }
}

/// A joint and the frame that moves with it, in base axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pose<S> {
    pub(super) kind: JointKind,
    /// Unit vector along the joint.
    pub(super) axis: Vector3<S>,
    /// From the origin of the frame before (the base frame, for the first) to the origin of this frame, m.
    pub(super) offset: Vector3<S>,
    pub(super) rotation: Matrix3<S>,
}

impl Place<f64> {
    fn map<S: Scalar>(&self, mut f: impl FnMut(f64) -> S) -> Place<S> {
        Place { rotation: self.rotation.map(&mut f), origin: self.origin.map(f) }
    }
}

impl Solid<f64> {
    /// A body given in a frame, seen from the frame's parent.
    fn moved(body: &Body, frame: &Matrix4<f64>) -> Self {
        let Place { rotation, origin } = place(frame);
        let inertia = rotation * body.inertia * rotation.transpose();
        Self { mass: body.mass, com: rotation * body.com + origin, inertia }
    }

    fn map<S: Scalar>(&self, mut f: impl FnMut(f64) -> S) -> Solid<S> {
        Solid { mass: f(self.mass), com: self.com.map(&mut f), inertia: self.inertia.map(f) }
    }
}

impl<S: Scalar> Place<S> {
    /// Transforms `next`, given in this frame, to the parent of this frame.
    pub(super) fn then(&self, next: &Self) -> Self {
        Self { rotation: self.rotation * next.rotation, origin: self.at(&next.origin) }
    }

    /// Transforms a point of this frame to the parent of this frame.
    pub(super) fn at(&self, point: &Vector3<S>) -> Vector3<S> {
        self.rotation * point + self.origin
    }
}

/// `(link_before_from_joint, joint_from_link)` at `q = 0`, with the joint's axis along z between them.
fn constant_parts(joint: &JointSpec) -> (Matrix4<f64>, Matrix4<f64>) {
    match &joint.frame {
        Frame::ClassicalDh(dh) => (Matrix4::identity(), along_z(dh) * along_x(dh)),
        Frame::ModifiedDh(dh) => (along_x(dh), along_z(dh)),
        Frame::Placement { rotation, translation, axis } => {
            let turned = homogeneous(&z_along(axis), &Vector3::zeros());
            (homogeneous(rotation, translation) * turned, turned.transpose())
        }
    }
}

/// A rotation whose third column is the unit vector `axis`.
fn z_along(axis: &Vector3<f64>) -> Matrix3<f64> {
    let helper = if axis.x.abs() > 0.8 { Vector3::y() } else { Vector3::x() };
    let x = (helper - axis * axis.dot(&helper)).normalize();
    Matrix3::from_columns(&[x, axis.cross(&x), *axis])
}

/// `Rz(theta) Tz(d)`, which commutes with the joint's motion.
fn along_z(dh: &Dh) -> Matrix4<f64> {
    homogeneous(&about(&Vector3::z(), dh.theta), &Vector3::new(0.0, 0.0, dh.d))
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

/// Rotation and origin of a homogeneous matrix. Rounds entries within 1e-15 of an integer, such as the zeros and ones of right angles.
fn place(m: &Matrix4<f64>) -> Place<f64> {
    let whole = |x: f64| if (x - x.round()).abs() < 1e-15 { x.round() } else { x };
    Place { rotation: m.fixed_view::<3, 3>(0, 0).map(whole), origin: m.fixed_view::<3, 1>(0, 3).into_owned() }
}
