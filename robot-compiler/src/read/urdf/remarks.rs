//! Assumptions about an arm that was cut out of a URDF file.

use super::chain::Chain;
use super::description::{Description, UrdfJointKind};
use super::markup::{Markup, child};
use super::{merge, names};
use crate::describe::draft::{Remark, RemarkKind};
use crate::read::shown::short;

/// Misspelt names, held joints, a base that floats, and parts of bodies that are missing.
pub(super) fn all(markup: &Markup<'_>, urdf: &Description<'_>, chain: &Chain) -> Vec<Remark> {
    let mut found = Vec::new();
    for i in 0..chain.moving.len() {
        for link in merge::parts(chain, i) {
            let part = &urdf.links[link];
            found.extend(names::unknown(markup, &part.node, &format!("link {}", part.name)));
            if let Some(joint) = chain.above[link].map(|joint| &urdf.joints[joint]) {
                found.extend(names::unknown(markup, &joint.node, &format!("joint {}", joint.name)));
            }
            if let Some(gap) = &part.gap {
                let place = markup.place(&part.node, "inertial", format!("link {}.inertial", part.name));
                let advice =
                    "weigh the part; take its tensor from the CAD model, or of a cylinder of its size".to_owned();
                found.push(Remark { kind: RemarkKind::Gap, place, problem: gap.reason.clone(), advice });
            }
        }
    }
    for &index in &chain.held {
        let (joint, q) = (&urdf.joints[index], chain.position[index]);
        let place = |element| markup.place(&joint.node, element, format!("joint {}.{element}", joint.name));
        let unit = if joint.kind == UrdfJointKind::Prismatic { "m" } else { "rad" };
        if let Some(leader) = child(&joint.node, "mimic").and_then(|mimic| mimic.attribute("joint"))
            && chain.moving.iter().any(|&moving| urdf.joints[moving].name == leader)
        {
            found.push(Remark {
                kind: RemarkKind::Held,
                place: place("mimic"),
                problem: format!(
                    "{} follows {leader}, a joint of the arm, and is held at {} {unit}",
                    joint.name,
                    short(q)
                ),
                advice: "end the chain before it with --tip, or accept that its link does not move by itself"
                    .to_owned(),
            });
        }
        let limit = joint.limit.as_ref().filter(|_| joint.kind != UrdfJointKind::Continuous);
        let Some((low, high)) = limit.and_then(|limit| Some((limit.lower?, limit.upper?))) else { continue };
        if low < high && !(low..=high).contains(&q) {
            found.push(Remark {
                kind: RemarkKind::Held,
                place: place("limit"),
                problem: format!(
                    "{} is held at {} {unit}, outside its own limits {} to {} {unit}",
                    joint.name,
                    short(q),
                    short(low),
                    short(high)
                ),
                advice: "shift its zero, or correct the limits: the mass that it carries is elsewhere on the real arm"
                    .to_owned(),
            });
        }
    }
    let mut link = chain.base;
    while let Some(above) = chain.above[link] {
        let joint = &urdf.joints[above];
        if matches!(joint.kind, UrdfJointKind::Floating | UrdfJointKind::Planar | UrdfJointKind::Spherical) {
            found.push(Remark {
                kind: RemarkKind::Base,
                place: markup.place(&joint.node, "origin", format!("joint {}", joint.name)),
                problem: format!(
                    "the base {} can move on joint {}: it is taken as it stands at zero",
                    urdf.links[chain.base].name, joint.name
                ),
                advice: "write how the base is turned when the arm works: mounting = { rpy = [roll, pitch, yaw] }"
                    .to_owned(),
            });
        }
        link = chain.parent[above];
    }
    found
}
