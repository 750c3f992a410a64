//! An arm cut out of a tree of links.

use crate::describe::robot::Robot;

/// XML namespace of what we add to URDF.
pub(crate) const NAMESPACE: &str = "urn:newtau";

/// Links at the two ends of the chain that is taken from a URDF file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Ends<'a> {
    /// The link that the arm stands on, whose frame is the base frame; `None` takes the root.
    pub base: Option<&'a str>,
    /// The link that the chain ends at, whose frame is the tip frame; `None` takes the only chain.
    pub tip: Option<&'a str>,
}

impl<'a> Ends<'a> {
    /// The chain from the root to a link.
    #[must_use]
    pub const fn tip(link: &'a str) -> Self {
        Self { base: None, tip: Some(link) }
    }
}

/// An arm from a URDF file, with names of the file that the arm itself does not keep.
#[derive(Clone, Debug, PartialEq)]
pub struct UrdfArm {
    /// The arm.
    pub robot: Robot,
    /// The link that it stands on.
    pub base: String,
    /// The link whose frame is the tip frame.
    pub tip: String,
    /// Links whose bodies each joint moves, base first: its own link, then those merged into it.
    pub links: Vec<Vec<String>>,
    /// Moving joints beside the chain, held at zero, or where they are when the joint that they follow is at zero.
    pub held: Vec<String>,
    /// Gaps of the URDF, joint by joint.
    pub gaps: Vec<JointGaps>,
    /// Remarks: misspelt names, held joints outside their limits, a base that floats.
    pub remarks: Vec<String>,
}

/// Reasons why numbers of a joint and its link are missing; `None`: the file gives the number.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointGaps {
    /// Of the mass and the inertia tensor.
    pub body: Option<String>,
    /// Of the position limits.
    pub position: Option<String>,
    /// Of the velocity limit.
    pub velocity: Option<String>,
    /// Of the torque limit.
    pub torque: Option<String>,
    /// The gear that a `<transmission>` names for a rotor that it does not name: reduction and name.
    pub gear: Option<(f64, String)>,
}
