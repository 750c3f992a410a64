//! Units of the figures of a study.

use super::{Figure, Metric};
use dynamics_core::JointKind;

impl Figure {
    /// Unit for a joint of this kind; empty if there is none.
    #[must_use]
    pub const fn unit(self, joint: JointKind) -> &'static str {
        let [turning, sliding] = match self {
            Self::TrackingRms | Self::TrackingMax | Self::RestError | Self::Drift => ["rad", "m"],
            Self::TorqueRms | Self::TorquePeak | Self::TorqueChatter | Self::ExternalRms => ["N m", "N"],
            Self::SpeedMax => ["rad/s", "m/s"],
            Self::SettlingTime => ["s"; 2],
            Self::LimitedTicks => ["ticks"; 2],
            Self::Faults | Self::OutOfReach => [""; 2],
        };
        match joint {
            JointKind::Revolute => turning,
            JointKind::Prismatic => sliding,
        }
    }
}

impl Metric {
    /// Unit of the figure for an arm with these joints: `rad or m` for the largest over joints of both kinds.
    #[must_use]
    pub fn unit(&self, joints: &[JointKind]) -> String {
        let of = |joint: usize| joints.get(joint - 1).map(|kind| self.figure.unit(*kind));
        match self.joint {
            Some(joint) => of(joint).unwrap_or_default().to_owned(),
            None => {
                let mut units: Vec<&str> = joints.iter().map(|kind| self.figure.unit(*kind)).collect();
                // Angles before lengths.
                units.sort_by_key(|unit| !(unit.contains("rad") || unit.contains("N m")));
                units.dedup();
                units.join(" or ")
            }
        }
    }
}
