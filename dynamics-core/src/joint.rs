//! The user's description of a joint and the link that moves with it, before it is checked.

use crate::fields::record;
use nalgebra::{Matrix3, Vector3};

/// Motion that a joint allows its link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointKind {
    /// Turns about its axis; the joint variable is an angle in rad.
    Revolute,
    /// Slides along its axis; the joint variable is a length in m.
    Prismatic,
}

/// One row of a Denavit-Hartenberg table, in m and rad.
///
/// The joint variable adds to `theta` (revolute) or to `d` (prismatic).
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Dh {
    /// Link length, along x, m.
    pub a: f64,
    /// Twist, about x, rad.
    pub alpha: f64,
    /// Offset, along z, m.
    pub d: f64,
    /// Angle, about z, rad.
    pub theta: f64,
}

/// Location of a joint on its parent link, and the frame in which the link's data are given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Frame {
    /// The chapter's convention: `A_i = Rz(theta) Tz(d) Tx(a) Rx(alpha)` leads from `B_{i-1}` to `B_i`; joint `i` acts
    /// about `z_{i-1}`; the link's data are in `B_i`, at the link's distal end.
    ClassicalDh(Dh),
    /// Craig's convention: `A_i = Rx(alpha) Tx(a) Rz(theta) Tz(d)`, with `alpha`, `a` of the link before; joint `i` acts
    /// about `z_i`; the link's data are in frame `i`, at the joint.
    ModifiedDh(Dh),
    /// A fixed placement followed by a motion about or along `axis`, as in URDF; the link's data are in the moved frame.
    Placement {
        /// `parent_from_joint` at `q = 0`. Orthonormal, right-handed.
        rotation: Matrix3<f64>,
        /// Origin of the joint frame in the parent link's frame, m.
        translation: Vector3<f64>,
        /// Unit axis of the joint in the joint frame.
        axis: Vector3<f64>,
    },
}

/// A rigid body: mass, mass centre, inertia tensor about the mass centre, in the link's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Mass, kg.
    pub mass: f64,
    /// Mass centre, m.
    pub com: Vector3<f64>,
    /// Inertia tensor about the mass centre, kg m^2; off-diagonals are the tensor's own entries, `I_xy = -int x y dm`.
    pub inertia: Matrix3<f64>,
}

impl Body {
    /// No mass and no inertia.
    #[must_use]
    pub fn massless() -> Self {
        Self { mass: 0.0, com: Vector3::zeros(), inertia: Matrix3::zeros() }
    }
}

/// A motor's rotor, seen from the joint through its gear as `gear^2 * inertia`.
///
/// The usual model: only the rotor's spin about the joint axis counts. Its mass is part of the link that carries it.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Rotor {
    /// Rotor inertia about its own axis, kg m^2.
    pub inertia: f64,
    /// Rotor turns per joint turn (or rad per m); the sign has no effect here.
    pub gear: f64,
}

impl Rotor {
    /// Inertia that the joint feels, `gear^2 * inertia`, kg m^2 (kg for a prismatic joint).
    #[must_use]
    pub fn reflected(&self) -> f64 {
        self.gear * self.gear * self.inertia
    }
}

record! {
    /// Limits of a joint. Infinity means "no limit".
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Limits<S> {
        /// Lowest and highest position, rad or m.
        pub position: (S, S),
        /// Greatest speed, rad/s or m/s.
        pub velocity: S,
        /// Greatest actuator torque or force, N m or N.
        pub torque: S,
        /// Greatest rate of change of the commanded torque, N m/s or N/s.
        pub torque_rate: S,
    }
}

impl Limits<f64> {
    /// No limits.
    #[must_use]
    pub fn none() -> Self {
        let free = f64::INFINITY;
        Self { position: (-free, free), velocity: free, torque: free, torque_rate: free }
    }

    /// Distance between the position limits, rad or m; infinite if one is missing.
    #[must_use]
    pub fn range(&self) -> f64 {
        self.position.1 - self.position.0
    }
}

/// One joint and the link that moves with it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointSpec {
    /// Motion that the joint allows.
    pub kind: JointKind,
    /// Location of the joint on its parent link.
    pub frame: Frame,
    /// The link's mass properties.
    pub body: Body,
    /// The motor's rotor.
    pub rotor: Rotor,
    /// Limits of the joint.
    pub limits: Limits<f64>,
}

/// A tool on the last link: a fixed body, and the tip frame that wrenches and payloads refer to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tool {
    /// `link_from_tip`, with the link's frame as in [`Frame`].
    pub rotation: Matrix3<f64>,
    /// Origin of the tip frame in the link's frame, m.
    pub translation: Vector3<f64>,
    /// The tool's body, in the tip frame.
    pub body: Body,
}

impl Default for Tool {
    fn default() -> Self {
        Self { rotation: Matrix3::identity(), translation: Vector3::zeros(), body: Body::massless() }
    }
}
