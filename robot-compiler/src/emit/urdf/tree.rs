//! Links and joints of an arm with the names and frames of its URDF.

use crate::describe::robot::Robot;
use dynamics_core::geometry::about_x;
use dynamics_core::model::Placement;
use dynamics_core::{Frame, JointKind, SinCos};
use nalgebra::{Matrix3, Vector3};

/// An arm in URDF's structure: the base link, and joints each of which carries the next link.
///
/// The frame of a moving link lies on its joint's axis, as URDF requires, and moves with the joint. For modified
/// Denavit-Hartenberg rows and placements it is the frame of the robot file. For classical rows, the robot file's frame is at the far
/// end of the link; [`Self::link_from_body`] leads there.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkTree {
    /// Name of the base link.
    pub base: String,
    /// Moving joints, base first; then the fixed one that carries the tip.
    pub joints: Vec<TreeJoint>,
    /// Frame of each moving link's data in the link's frame.
    pub link_from_body: Vec<Placement<f64>>,
}

/// A joint and the link that it carries.
#[derive(Clone, Debug, PartialEq)]
pub struct TreeJoint {
    /// Name of the joint.
    pub name: String,
    /// Name of the parent link.
    pub parent: String,
    /// Name of the link that it carries.
    pub child: String,
    /// `parent_from_child` at `q = 0`, m.
    pub origin: Placement<f64>,
    /// Motion and its unit axis in the child's frame; `None` for a fixed joint.
    pub motion: Option<(JointKind, Vector3<f64>)>,
}

impl LinkTree {
    /// The tree of an arm. Links are `base`, `NAME_link` for the joint `NAME`, and `tip`.
    #[must_use]
    pub fn new(robot: &Robot) -> Self {
        let base = "base".to_owned();
        let mut links = vec![base.clone()];
        let mut joints: Vec<TreeJoint> = Vec::new();
        let mut link_from_body = Vec::new();
        let mut above = here();
        for joint in &robot.joints {
            let (before, axis, after) = around_motion(&joint.spec.frame);
            let child = unused(format!("{}_link", joint.name), &links);
            let origin = above.then(&before);
            let parent = links.last().cloned().unwrap_or_default();
            links.push(child.clone());
            joints.push(TreeJoint {
                name: joint.name.clone(),
                parent,
                child,
                origin,
                motion: Some((joint.spec.kind, axis)),
            });
            link_from_body.push(after);
            above = after;
        }
        let tool = Placement { rotation: robot.tool.rotation, translation: robot.tool.translation };
        let names: Vec<String> = joints.iter().map(|joint| joint.name.clone()).collect();
        joints.push(TreeJoint {
            name: unused("tip_joint".to_owned(), &names),
            parent: links.last().cloned().unwrap_or_default(),
            child: unused("tip".to_owned(), &links),
            origin: above.then(&tool),
            motion: None,
        });
        Self { base, joints, link_from_body }
    }
}

impl TreeJoint {
    /// `parent_from_child` at joint position `q`, rad or m.
    #[must_use]
    pub fn place(&self, q: f64) -> Placement<f64> {
        let Placement { rotation, translation } = self.origin;
        match self.motion {
            None => self.origin,
            Some((JointKind::Prismatic, axis)) => {
                Placement { rotation, translation: translation + rotation * (axis * q) }
            }
            Some((JointKind::Revolute, axis)) => {
                let (sin, cos) = libm::sincos(q);
                Placement { rotation: rotation * about(&axis, SinCos { sin, cos }), translation }
            }
        }
    }
}

/// Turn about a unit axis: `1 + sin K + (1 - cos) K^2`, with `K` the axis' cross-product matrix.
fn about(axis: &Vector3<f64>, turn: SinCos<f64>) -> Matrix3<f64> {
    let k = axis.cross_matrix();
    Matrix3::identity() + k * turn.sin + k * k * (1.0 - turn.cos)
}

/// The identity placement.
pub(super) fn here() -> Placement<f64> {
    Placement { rotation: Matrix3::identity(), translation: Vector3::zeros() }
}

/// The placements before and after a joint's motion, and the motion's axis.
fn around_motion(frame: &Frame) -> (Placement<f64>, Vector3<f64>, Placement<f64>) {
    match frame {
        Frame::ClassicalDh(_) => (here(), Vector3::z(), frame.link_from_body()),
        // `Rz(theta) Tz(d)` commutes with the motion and is applied before it here.
        Frame::ModifiedDh(dh) => {
            let along_x = Placement { rotation: about_x(dh.alpha), translation: Vector3::new(dh.a, 0.0, 0.0) };
            (along_x.then(&frame.link_from_body()), Vector3::z(), here())
        }
        Frame::Placement { rotation, translation, axis } => {
            (Placement { rotation: *rotation, translation: *translation }, *axis, here())
        }
    }
}

/// The name, followed by underscores if another has it already.
fn unused(mut name: String, taken: &[String]) -> String {
    while taken.contains(&name) {
        name.push('_');
    }
    name
}
