//! The arm as a checked, immutable serial chain with every joint about (or along) its own z.

use crate::geometry::{about_x, about_z, apply, compose, snap};
use crate::inertia::{Inertia, cast_matrix, cast_vector};
use crate::joint::{Body, Dh, Frame, JointKind, JointSpec, Limits, Tool};
use crate::scalar::Scalar;
use nalgebra::{Matrix3, Vector3};

mod check;

pub use check::{Impossible, ModelError, Place};

/// One joint and its link, in the joint's own frame: origin on the joint axis, z along it.
///
/// The frame at joint variable `q` follows from the parent's by `rotation`, `translation`, then a turn about or a slide
/// along its z: for a revolute joint `parent_from_link = rotation Rz(q)`, origin at `translation`; for a prismatic one
/// `parent_from_link = rotation`, origin at `translation + rotation (0, 0, q)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Link<S> {
    /// Turns or slides.
    pub kind: JointKind,
    /// `parent_from_link` at `q = 0`.
    pub rotation: Matrix3<S>,
    /// Origin in the parent's frame at `q = 0`, m.
    pub translation: Vector3<S>,
    /// The link's body about the joint frame's origin.
    pub inertia: Inertia<S>,
    /// Reflected rotor inertia, `gear^2 * inertia`, kg m^2 (kg for a prismatic joint).
    pub rotor: S,
    /// Limits of the joint.
    pub limits: Limits<S>,
}

/// A fixed frame on a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement<S> {
    /// `parent_from_frame`.
    pub rotation: Matrix3<S>,
    /// Origin in the parent's frame, m.
    pub translation: Vector3<S>,
}

/// A serial arm of `N` joints. Immutable: payloads and loads belong to the scene.
///
/// Guaranteed for `N` from 1 to 6; larger `N` work too.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model<S, const N: usize> {
    links: [Link<S>; N],
    tip: Placement<S>,
}

impl<const N: usize> Model<f64, N> {
    /// Checks a description and aligns every joint's axis with z.
    ///
    /// A body that no mass distribution could have is rejected; see [`Impossible`] for the list.
    ///
    /// # Errors
    /// [`ModelError`] names the joint (counted from 0) or the tool, and the reason why it is impossible.
    pub fn new(joints: &[JointSpec; N], tool: &Tool) -> Result<Self, ModelError> {
        Self::build(joints, tool, true)
    }

    /// As [`Model::new`], but an inertia tensor need only be finite and symmetric. Published parameter sets that were identified
    /// from motion often break the triangle inequality, or leave out parameters that no joint can feel.
    ///
    /// # Errors
    /// As [`Model::new`], except that inertia tensors of no possible body are accepted, with or without mass.
    pub fn new_unphysical(joints: &[JointSpec; N], tool: &Tool) -> Result<Self, ModelError> {
        Self::build(joints, tool, false)
    }

    fn build(joints: &[JointSpec; N], tool: &Tool, physical: bool) -> Result<Self, ModelError> {
        const { assert!(N > 0, "an arm has at least one joint") };
        for (index, joint) in joints.iter().enumerate() {
            check::joint(joint, physical).map_err(|what| ModelError { place: Place::Joint(index), what })?;
        }
        check::tool(tool, physical).map_err(|what| ModelError { place: Place::Tool, what })?;

        // The frame that the next joint's placement refers to, seen from the current link's own frame.
        let mut parent_from_description = Placement { rotation: Matrix3::identity(), translation: Vector3::zeros() };
        let links = core::array::from_fn(|i| {
            let joint = &joints[i];
            let (description_from_joint, link_from_body) = split(&joint.frame);
            let place = parent_from_description.then(&description_from_joint);
            parent_from_description = link_from_body;
            Link {
                kind: joint.kind,
                rotation: snap(&place.rotation),
                translation: place.translation,
                inertia: body_inertia(&joint.body).in_parent(&link_from_body.rotation, &link_from_body.translation),
                rotor: joint.rotor.reflected(),
                limits: joint.limits,
            }
        });
        let tip = parent_from_description.then(&Placement { rotation: tool.rotation, translation: tool.translation });
        let mut model = Self { links, tip };
        let tool_body = body_inertia(&tool.body).in_parent(&tip.rotation, &tip.translation);
        model.links[N - 1].inertia = model.links[N - 1].inertia + tool_body;
        Ok(model)
    }

    /// The same arm in another scalar, each number through [`Scalar::literal`].
    #[must_use]
    pub fn cast<T: Scalar>(&self) -> Model<T, N> {
        Model {
            links: self.links.map(|link| Link {
                kind: link.kind,
                rotation: cast_matrix(&link.rotation),
                translation: cast_vector(&link.translation),
                inertia: link.inertia.cast(),
                rotor: T::literal(link.rotor),
                limits: link.limits.cast(),
            }),
            tip: Placement {
                rotation: cast_matrix(&self.tip.rotation),
                translation: cast_vector(&self.tip.translation),
            },
        }
    }
}

impl<S, const N: usize> Model<S, N> {
    /// From links that [`Model::new`] has checked before, for example on the desk at build time.
    #[must_use]
    pub const fn from_checked(links: [Link<S>; N], tip: Placement<S>) -> Self {
        Self { links, tip }
    }

    /// The joints and links, base first.
    #[must_use]
    pub const fn links(&self) -> &[Link<S>; N] {
        &self.links
    }

    /// The tip frame in the last link's frame.
    #[must_use]
    pub const fn tip(&self) -> &Placement<S> {
        &self.tip
    }
}

impl Placement<f64> {
    /// The parent's placement in this frame: the inverse of this placement.
    #[must_use]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.transpose();
        Self { rotation, translation: -apply(&rotation, &self.translation) }
    }

    /// `self` followed by `next`: `parent_from_frame * frame_from_next`.
    #[must_use]
    pub fn then(&self, next: &Self) -> Self {
        Self {
            rotation: snap(&compose(&self.rotation, &next.rotation)),
            translation: self.translation + apply(&self.rotation, &next.translation),
        }
    }
}

impl Frame {
    /// The frame of a link's data, placed in the link's own frame with z along the joint: `link_from_body`.
    #[must_use]
    pub fn link_from_body(&self) -> Placement<f64> {
        split(self).1
    }
}

fn body_inertia(body: &Body) -> Inertia<f64> {
    Inertia::from_mass_centre(body.mass, &body.com, &body.inertia)
}

/// The fixed placements before and after the joint's motion: `(description_from_joint, link_from_body)`.
///
/// `Rz(theta + q) Tz(d)` commutes, so the constant offset may be applied on either side. Applied after the motion, it leaves the
/// joint frame on the previous link simple, with its origin at the chapter's `O_{i-1}`.
fn split(frame: &Frame) -> (Placement<f64>, Placement<f64>) {
    let identity = Placement { rotation: Matrix3::identity(), translation: Vector3::zeros() };
    let along_z = |dh: &Dh| Placement { rotation: about_z(dh.theta), translation: Vector3::new(0.0, 0.0, dh.d) };
    let along_x = |dh: &Dh| Placement { rotation: about_x(dh.alpha), translation: Vector3::new(dh.a, 0.0, 0.0) };
    match frame {
        Frame::ClassicalDh(dh) => (identity, along_z(dh).then(&along_x(dh))),
        Frame::ModifiedDh(dh) => (along_x(dh), along_z(dh)),
        Frame::Placement { rotation, translation, axis } => {
            let joint_from_link = z_onto(&unit(axis));
            let place = Placement { rotation: *rotation, translation: *translation };
            let turn = |rotation| Placement { rotation, translation: Vector3::zeros() };
            (place.then(&turn(joint_from_link)), turn(joint_from_link.transpose()))
        }
    }
}

/// A rotation that carries z onto the unit vector `axis`; a signed permutation when `axis` is a coordinate axis.
fn z_onto(axis: &Vector3<f64>) -> Matrix3<f64> {
    let axis = axis.map(|x| if x.abs() < 1e-15 { 0.0 } else { x });
    let along = |k: usize| axis[(k + 1) % 3] == 0.0 && axis[(k + 2) % 3] == 0.0;
    if let Some(k) = (0..3).find(|&k| along(k)) {
        let sign = axis[k].signum();
        let e = |j: usize| Vector3::from_fn(|i, _| if i == j % 3 { 1.0 } else { 0.0 });
        // Cyclic (k+1, k+2, k) is right-handed; a negative axis also turns the second column over.
        return Matrix3::from_columns(&[e(k + 1), e(k + 2) * sign, e(k) * sign]);
    }
    // The coordinate axis least along `axis` gives the best-conditioned cross product.
    let least = axis.iamin();
    let x = unit(&axis.cross(&Vector3::from_fn(|i, _| if i == least { 1.0 } else { 0.0 })));
    let y = axis.cross(&x);
    Matrix3::from_columns(&[x, y, axis])
}

fn unit(v: &Vector3<f64>) -> Vector3<f64> {
    v / libm::sqrt(v.dot(v))
}
