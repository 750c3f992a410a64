//! Masses, inertia tensors and mass centres of the links.

use super::amount::{amount, digits, percent};
use super::{CheckRule, Finding, Severity};
use crate::describe::draft::{Draft, DraftBody, FileKind};
use crate::describe::robot::physical_body;
use dynamics_core::{Body, JointKind};
use nalgebra::{Matrix3, Vector3};

/// Mass below which a moved link is light, kg: a bearing and its seat weigh more, except in toys.
const LIGHT: f64 = 0.02;
/// Share of the arm's mass below which a link is light. It excludes toys, in which every link weighs only grams.
const LIGHT_SHARE: f64 = 0.01;
/// Margin around the joints, as a share of the arm's length: motors and covers extend beyond the line from joint to joint.
const ROOM: f64 = 0.1;
/// Multiple of the link's size and margin at which a radius of gyration is wrong. The radius of gyration of a body of
/// greatest width D is at most D / sqrt(3), so this is more than three times what the link could have.
const GYRATION_WRONG: f64 = 2.0;
/// Share of the arm's length that a radius of gyration must also exceed to be wrong; a uniform rod as long as the whole arm has 0.29.
const GYRATION_ARM: f64 = 0.3;
/// Share of the link's size below which its radius of gyration counts as a point's; a uniform rod has 1 / sqrt(12) = 0.29.
const GYRATION_POINT: f64 = 0.05;
/// Share of the link's size below which a radius of gyration is too small for a link whose mass centre is far from its joints. Such a link
/// extends from joint to joint, so one heavy motor cannot be the explanation.
const GYRATION_SUM: f64 = 0.1;
/// Least distance of such a mass centre from the joints, as a share of the link's size.
const MID_LINK: f64 = 0.3;
/// Range in which a tensor counts as only the parallel-axis term, in units of m c^2: its difference from that term. A uniform rod's tensor
/// differs by -2/3 if it is about its centre, and by 1/3 if it is about its end.
const AT_JOINT: (f64, f64) = (-0.1, 0.5);
/// Margin around the joints for a mass centre, as a share of the arm's length: grippers extend this far beyond the last joint.
const CENTRE_ROOM: f64 = 0.25;
/// Multiple of the arm's length at which a mass centre is wrong: it is out of reach in any posture of the arm.
const CENTRE_WRONG: f64 = 2.0;

pub(super) fn findings(draft: &Draft) -> Vec<Finding> {
    let mut found: Vec<Finding> = (0..draft.robot.dof()).filter_map(|joint| mass(draft, joint)).collect();
    for body in &draft.bodies {
        // An impossible body makes all other rules about it meaningless.
        if let Some(impossible) = impossible(draft, body) {
            found.push(impossible);
            continue;
        }
        found.extend([empty_part(draft, body), at_joint(draft, body), centre(draft, body)].into_iter().flatten());
        found.extend(gyration(draft, body).into_iter().chain(swapped(draft, body)));
    }
    found
}

/// A body that no mass distribution can have.
///
/// `m >= 0`, principal moments `0 <= a <= b <= c` with `a + b >= c`, because `a = int (y^2 + z^2) dm` and so on.
fn impossible(draft: &Draft, body: &DraftBody) -> Option<Finding> {
    let (problem, expected) = physical_body(&body.body).err()?;
    let place = if body.body.mass <= 0.0 { &body.mass } else { &body.inertia };
    let accepted = draft.robot.allow_unphysical.is_some() && body.body.mass >= 0.0;
    let (severity, problem) = match accepted {
        true => (Severity::Doubt, format!("{problem}; `allow_unphysical` accepts it")),
        false => (Severity::Wrong, problem),
    };
    let advice =
        format!("write {expected}: from the CAD model with true densities, or of a cylinder of the link's size");
    Some(Finding::new(draft, (CheckRule::ImpossibleBody, severity), place, problem, advice))
}

/// A link without mass, or of a few grams, that a joint moves.
///
/// Wrong if the joint moves no mass at all, because then `qdd = tau / 0`. A doubt if links beyond it have mass, or if the mass is below
/// [`LIGHT`] and [`LIGHT_SHARE`].
fn mass(draft: &Draft, joint: usize) -> Option<Finding> {
    const WEIGH: &str = "weigh the link with its motor and covers, or add up the masses of its parts";
    let own = draft.bodies.iter().find(|body| body.joint == joint && !body.fixed)?;
    let of = |i: usize| {
        let tool = if i + 1 == draft.robot.dof() { draft.robot.tool.body.mass } else { 0.0 };
        draft.robot.joints.get(i).map_or(0.0, |joint| joint.spec.body.mass) + tool
    };
    let (mass, beyond) = (of(joint), (joint..draft.robot.dof()).map(of).sum::<f64>());
    let spec = &draft.robot.joints.get(joint)?.spec;
    let name = &draft.robot.joints.get(joint)?.name;
    if mass == 0.0 && spec.body.inertia == Matrix3::zeros() {
        let nothing = beyond == 0.0 && spec.rotor.reflected() == 0.0;
        let (severity, problem) = if nothing {
            let problem = format!("joint {name} moves no mass and no inertia: any torque accelerates it without bound");
            (Severity::Wrong, problem)
        } else if draft.kind == FileKind::Urdf && !own.mass.given {
            (Severity::Wrong, format!("missing: joint {name} moves the link, and every other command refuses it"))
        } else {
            let kg = amount(beyond, "kg");
            (Severity::Doubt, format!("the link has no mass: joint {name} moves {kg}, all beyond the next joint"))
        };
        return Some(Finding::new(draft, (CheckRule::Mass, severity), &own.mass, problem, WEIGH.to_owned()));
    }
    let share = mass / draft.mass();
    let light = mass > 0.0 && mass < LIGHT && share < LIGHT_SHARE;
    light.then(|| {
        let all = amount(draft.mass(), "kg");
        let problem = format!("{} kg on joint {name}, {} of the {all} that move", digits(mass), percent(share));
        Finding::new(draft, (CheckRule::Mass, Severity::Doubt), &own.mass, problem, WEIGH.to_owned())
    })
}

/// A part with a mass of zero: a frame needs no `<inertial>`, a gripper has a mass.
fn empty_part(draft: &Draft, body: &DraftBody) -> Option<Finding> {
    (body.fixed && body.mass.given && body.body.mass == 0.0).then(|| {
        let problem = "a part of 0 kg".to_owned();
        let advice = "weigh it, if it is a part; a frame has no mass to give".to_owned();
        Finding::new(draft, (CheckRule::Mass, Severity::Note), &body.mass, problem, advice)
    })
}

/// A radius of gyration that is too large for the link, or nearly zero.
///
/// `k = sqrt(I_max / m)`, compared with the link's size: the greatest distance between its joints and its mass centre, plus [`ROOM`]
/// around them. A point mass counts only if a revolute joint turns it.
fn gyration(draft: &Draft, body: &DraftBody) -> Option<Finding> {
    const ADVICE: &str = "write the tensor about the mass centre: from the CAD model, or m L^2 / 12 across a rod, m r^2 / 2 \
                          along a cylinder";
    let Body { mass, inertia, .. } = &body.body;
    let turned = draft.robot.joints.iter().take(body.joint + 1).any(|joint| joint.spec.kind == JointKind::Revolute);
    if *mass <= 0.0 || !turned {
        return None;
    }
    let size = spread(body.points.iter().chain([&body.centre]));
    let room = size + ROOM * draft.length();
    let radius = (inertia.symmetric_eigenvalues().max().max(0.0) / mass).sqrt();
    let (severity, problem) = if radius == 0.0 {
        let given = body.inertia.given && draft.kind == FileKind::Urdf;
        let severity = if given { Severity::Doubt } else { Severity::Note };
        (severity, format!("a point mass: {} kg without extent", digits(*mass)))
    } else if radius > room && room > 0.0 {
        let problem = format!(
            "radius of gyration {} with a mass of {}, on a link of {}",
            amount(radius, "m"),
            amount(*mass, "kg"),
            amount(size, "m")
        );
        let problem =
            problem + &super::units::inertia(mass * radius * radius, mass * (0.3 * size.max(0.3 * room)).powi(2));
        let beyond = radius > GYRATION_WRONG * room && radius > GYRATION_ARM * draft.length();
        (if beyond { Severity::Wrong } else { Severity::Doubt }, problem)
    } else if radius < GYRATION_POINT * size {
        let share = percent(radius / size);
        let (radius, size) = (amount(radius, "m"), amount(size, "m"));
        (Severity::Doubt, format!("radius of gyration {radius} on a link of {size}, {share}: nearly a point"))
    } else if radius < GYRATION_SUM * size && mid_link(body, size) {
        let share = percent(radius / size);
        let (radius, size) = (amount(radius, "m"), amount(size, "m"));
        let cause = "were the tensors of its parts added up without their parallel-axis terms?";
        (Severity::Doubt, format!("radius of gyration {radius} on a link of {size}, {share}: {cause}"))
    } else {
        return None;
    };
    Some(Finding::new(draft, (CheckRule::Gyration, severity), &body.inertia, problem, ADVICE.to_owned()))
}

/// True if the mass centre is far from every joint of the link.
fn mid_link(body: &DraftBody, size: f64) -> bool {
    body.points.len() > 1 && body.points.iter().all(|point| (body.centre - point).norm() > MID_LINK * size)
}

/// A tensor with the shape of a rod across the link: the mass centre lies along the link, but the tensor is that of a rod along another axis.
///
/// With `u` the direction of the link and `v` the axis of the least moment: `I_min < 0.3 I_mid`, `|u.v| < 0.3`, `|u.c| > 0.9 |c|`, and
/// `k > 0.2` of the link's size.
fn swapped(draft: &Draft, body: &DraftBody) -> Option<Finding> {
    let Body { mass, com, inertia } = &body.body;
    let size = spread(&body.points);
    if *mass <= 0.0 || size == 0.0 || com.norm() < 0.2 * size {
        return None;
    }
    let along = com.normalize();
    // In the frame of the points, the mass centre has the same direction from the link's own joint.
    let own = body.points.first()?;
    let far = body.points.iter().map(|point| point - own).max_by(|a, b| a.norm().total_cmp(&b.norm()))?;
    let straight = (body.centre - own).normalize().dot(&far.normalize()).abs() > 0.9;
    let eigen = inertia.symmetric_eigen();
    let mut order: Vec<usize> = vec![0, 1, 2];
    order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
    let [least, middle, most] = order.as_slice() else { return None };
    let moments = &eigen.eigenvalues;
    let rod = moments[*least] < 0.3 * moments[*middle] && (moments[*most] / mass).sqrt() > 0.2 * size;
    let axis = eigen.eigenvectors.column(*least).into_owned();
    // Exchanged axes leave the rod along an axis of the frame. A tensor at an angle in between has another cause.
    (straight && rod && axis.amax() > 0.95 && axis.dot(&along).abs() < 0.3).then(|| {
        let name = |v: &Vector3<f64>| ["x", "y", "z"].get(v.iamax()).copied().unwrap_or("?");
        let problem = format!(
            "the tensor is that of a rod along {}, and the link lies along {}: axes exchanged?",
            name(&axis),
            name(&along)
        );
        let advice = "write the tensor in the axes of the link's frame, xx being the moment about x".to_owned();
        Finding::new(draft, (CheckRule::SwappedAxes, Severity::Doubt), &body.inertia, problem, advice)
    })
}

/// An inertia tensor about the origin of the link's frame instead of the mass centre.
///
/// There it would be `I_C + P`, with the parallel-axis term `P = m (c.c 1 - c c^T)`. A tensor that is almost only `P`
/// ([`AT_JOINT`]), taken about the mass centre, would mean two masses at the ends of the link and nothing between them.
fn at_joint(draft: &Draft, body: &DraftBody) -> Option<Finding> {
    let Body { mass, com, inertia } = &body.body;
    let scale = mass * com.norm_squared();
    if scale == 0.0 {
        return None;
    }
    let parallel = (Matrix3::identity() * com.norm_squared() - com * com.transpose()) * *mass;
    let left = inertia - parallel;
    let rest = left.symmetric_eigenvalues() / scale;
    if rest.min() < AT_JOINT.0 || rest.max() > AT_JOINT.1 {
        return None;
    }
    let problem = format!(
        "largest moment {} beside m c^2 = {}: as if about the origin of the link's frame, not about the mass centre {} away",
        amount(inertia.symmetric_eigenvalues().max(), "kg m^2"),
        amount(scale, "kg m^2"),
        amount(com.norm(), "m")
    );
    let [xx, yy, zz] = [left.m11, left.m22, left.m33].map(digits);
    let shifted = "if it is, take m (c.c 1 - c c^T) off";
    let advice = match physical_body(&Body { inertia: left, ..body.body }) {
        Ok(()) => format!("{shifted}: xx, yy, zz = {xx}, {yy}, {zz} kg m^2 are left"),
        Err(_) => format!("{shifted}; too little is left for a body: take the tensor from the CAD model"),
    };
    Some(Finding::new(draft, (CheckRule::InertiaAtJoint, Severity::Doubt), &body.inertia, problem, advice))
}

/// A mass centre far from all joints of the link.
///
/// `min |c - p| > max |p - p'| + margin` over the origins `p` of the joints on it; the margin is [`CENTRE_ROOM`] of the arm's
/// length. Beyond [`CENTRE_WRONG`] lengths of the arm it is wrong.
fn centre(draft: &Draft, body: &DraftBody) -> Option<Finding> {
    let length = draft.length();
    let far = body.points.iter().map(|point| (body.centre - point).norm()).fold(f64::INFINITY, f64::min);
    let size = spread(&body.points);
    if body.body.mass <= 0.0 || length == 0.0 || far <= size + CENTRE_ROOM * length {
        return None;
    }
    let severity = if far > CENTRE_WRONG * length { Severity::Wrong } else { Severity::Doubt };
    let problem = format!(
        "the mass centre is {} from the nearest joint of a link of {}, on an arm of {}",
        amount(far, "m"),
        amount(size, "m"),
        amount(length, "m")
    ) + &super::units::length(far, 0.4 * size.max(0.3 * length));
    let advice = "write it in m, in the link's own frame; balance the link on an edge to measure it".to_owned();
    Some(Finding::new(draft, (CheckRule::MassCentre, severity), &body.com, problem, advice))
}

/// Greatest distance between two points, m.
fn spread<'a>(points: impl IntoIterator<Item = &'a Vector3<f64>>) -> f64 {
    let points: Vec<_> = points.into_iter().collect();
    points.iter().flat_map(|a| points.iter().map(move |b| (*a - *b).norm())).fold(0.0, f64::max)
}
