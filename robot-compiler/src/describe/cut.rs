//! An arm cut out of a tree of links.

use crate::describe::robot::Robot;

/// XML namespace of this project's additions to URDF.
pub(crate) const NAMESPACE: &str = "urn:newtau";

/// Links at the two ends of the chain that is taken from a URDF file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ends<'a> {
    /// The base link, whose frame is the base frame; `None` takes the root.
    pub base: Option<&'a str>,
    /// The last link of the chain, whose frame is the tip frame; `None` takes the only chain.
    pub tip: Option<&'a str>,
}

impl<'a> Ends<'a> {
    /// The chain from the root to a link.
    #[must_use]
    pub const fn tip(link: &'a str) -> Self {
        Self { base: None, tip: Some(link) }
    }
}

/// An arm from a URDF file, with names from the file that the arm itself does not keep.
#[derive(Clone, Debug, PartialEq)]
pub struct UrdfArm {
    /// The arm.
    pub robot: Robot,
    /// Name of the base link.
    pub base: String,
    /// Name of the link whose frame is the tip frame.
    pub tip: String,
    /// Links that each joint moves, base first: its own link, then those merged into it.
    pub links: Vec<Vec<String>>,
    /// Moving joints outside the chain. They are held at zero; a joint that follows another is held at its position for zero of the other.
    pub held: Vec<String>,
    /// Gaps of the URDF, joint by joint.
    pub gaps: Vec<JointGaps>,
    /// Remarks: misspelt names, held joints outside their limits, a base that floats.
    pub remarks: Vec<String>,
}

/// Reasons why numbers of a joint and its link are missing; `None` if the file gives the number.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointGaps {
    /// Reason for the mass and the inertia tensor.
    pub body: Option<String>,
    /// Reason for the position limits.
    pub position: Option<String>,
    /// Reason for the velocity limit.
    pub velocity: Option<String>,
    /// Reason for the torque limit.
    pub torque: Option<String>,
    /// Reduction and name of a `<transmission>` that gives a gear but no rotor.
    pub gear: Option<(f64, String)>,
}
