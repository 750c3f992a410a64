//! Links and joints of a URDF file, as far as dynamics and kinematics need them.
//!
//! Shapes, colours and simulator extensions are not read: an arm with an unknown texture is still an arm.

use super::markup::Markup;
use super::pose::origin;
use crate::describe::diagnostics::{FileError, one_of};
use dynamics_core::Body;
use dynamics_core::model::Placement;
use nalgebra::{Matrix3, Vector3};
use roxmltree::Node;

/// Most links: some checks compare each with every other.
const LINKS_MAX: usize = 10_000;

/// Links and joints in the order of the file.
pub(super) struct Description<'a> {
    pub(super) name: &'a str,
    pub(super) links: Vec<Link<'a>>,
    pub(super) joints: Vec<UrdfJoint<'a>>,
}

pub(super) struct Link<'a> {
    pub(super) node: Node<'a, 'a>,
    pub(super) name: &'a str,
    /// The body in the link's frame; massless without an `<inertial>`.
    pub(super) body: Body,
    /// Gap of its `<inertial>`.
    pub(super) gap: Option<MissingNumber>,
}

/// A number that is missing from an `<inertial>`.
pub(super) struct MissingNumber {
    /// The element or attribute, and the value that is used instead.
    pub(super) reason: String,
    /// The same as an error, for commands that compute with the number.
    pub(super) error: FileError,
}

pub(super) struct UrdfJoint<'a> {
    pub(super) node: Node<'a, 'a>,
    pub(super) name: &'a str,
    pub(super) kind: UrdfJointKind,
    /// `parent_from_joint` at `q = 0`.
    pub(super) origin: Placement<f64>,
    pub(super) parent: &'a str,
    pub(super) child: &'a str,
    /// The axis, of any length.
    pub(super) axis: Vector3<f64>,
    pub(super) limit: Option<Limit>,
    /// Viscous and Coulomb friction; zero if the file gives none.
    pub(super) damping: f64,
    pub(super) friction: f64,
}

impl UrdfJoint<'_> {
    /// `parent_from_child` at a position, rad or m.
    pub(super) fn at(&self, q: f64) -> Placement<f64> {
        let Some(axis) = self.axis.try_normalize(f64::MIN_POSITIVE).filter(|_| q != 0.0) else { return self.origin };
        let Placement { rotation, translation } = self.origin;
        match self.kind {
            UrdfJointKind::Prismatic => Placement { rotation, translation: translation + rotation * axis * q },
            UrdfJointKind::Revolute | UrdfJointKind::Continuous => {
                let (sin, cos) = libm::sincos(q);
                let k = axis.cross_matrix();
                Placement { rotation: rotation * (Matrix3::identity() + k * sin + k * k * (1.0 - cos)), translation }
            }
            _ => self.origin,
        }
    }
}

/// A `<limit>`; `None` means a missing attribute.
pub(super) struct Limit {
    pub(super) lower: Option<f64>,
    pub(super) upper: Option<f64>,
    pub(super) effort: Option<f64>,
    pub(super) velocity: Option<f64>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum UrdfJointKind {
    Revolute,
    Continuous,
    Prismatic,
    Fixed,
    Floating,
    Planar,
    Spherical,
}

const KINDS: [(&str, UrdfJointKind); 7] = [
    ("revolute", UrdfJointKind::Revolute),
    ("continuous", UrdfJointKind::Continuous),
    ("prismatic", UrdfJointKind::Prismatic),
    ("fixed", UrdfJointKind::Fixed),
    ("floating", UrdfJointKind::Floating),
    ("planar", UrdfJointKind::Planar),
    ("spherical", UrdfJointKind::Spherical),
];

impl<'a> Description<'a> {
    pub(super) fn read(markup: &Markup<'a>) -> Result<Self, FileError> {
        let named = |name: &'static str| markup.robot.children().filter(move |node| node.has_tag_name(name));
        let count = named("link").count();
        if count > LINKS_MAX {
            let (problem, expected) = (format!("found {count} links"), format!("at most {LINKS_MAX} links"));
            return Err(markup.error(&markup.robot, "robot", problem, expected));
        }
        Ok(Self {
            name: markup.printable(&markup.robot, markup.robot.attribute("name").unwrap_or_default(), "robot")?,
            links: named("link").map(|node| link(markup, node)).collect::<Result<_, _>>()?,
            joints: named("joint").map(|node| joint(markup, node)).collect::<Result<_, _>>()?,
        })
    }
}

fn link<'a>(markup: &Markup<'a>, node: Node<'a, 'a>) -> Result<Link<'a>, FileError> {
    let name = markup.name(&node, "link")?;
    let label = format!("link {name}");
    let inertial = markup.only_child(&node, "inertial", &label)?;
    let (body, gap) = inertial.map_or(Ok((Body::massless(), None)), |inertial| body(markup, &inertial, &label))?;
    Ok(Link { node, name, body, gap })
}

/// Square of a radius of gyration, m^2, that counts as zero: a smaller tensor is an exporter's rounding error, and the body a point mass.
const NOTHING: f64 = 1e-12;

/// An `<inertial>`, converted to the link's frame: its own origin has a position and an orientation.
fn body<'a>(
    markup: &Markup<'a>,
    inertial: &Node<'a, 'a>,
    link: &str,
) -> Result<(Body, Option<MissingNumber>), FileError> {
    let label = format!("{link}.inertial");
    let mut gap = None;
    let mut missing = |reason: String, node: &Node<'a, 'a>, field: String, expected: &str| {
        let error = || markup.error(node, field, "missing", expected);
        gap.get_or_insert_with(|| MissingNumber { reason, error: error() });
    };
    let place = origin(markup, markup.only_child(inertial, "origin", &label)?.as_ref(), link)?;
    let mass = markup.only_child(inertial, "mass", &label)?;
    let value = mass.map_or(Ok(None), |mass| markup.finite(&mass, "value", link))?;
    match (mass, value) {
        (_, Some(_)) => {}
        (Some(mass), None) => {
            missing(
                format!("the mass of {link} has no value"),
                &mass,
                format!("{link}.mass.value"),
                "one finite number",
            );
        }
        (None, _) => missing(format!("{link} has no <mass>"), inertial, format!("{label}.mass"), "<mass>"),
    }
    let tensor = markup.only_child(inertial, "inertia", &label)?;
    let mut entries = [0.0; 6];
    if let Some(tensor) = tensor {
        for (entry, key) in entries.iter_mut().zip(["ixx", "iyy", "izz", "ixy", "ixz", "iyz"]) {
            match markup.finite(&tensor, key, link)? {
                Some([x]) => *entry = x,
                None => {
                    let reason = format!("the inertia of {link} lacks {key}, 0 is taken");
                    missing(reason, &tensor, format!("{link}.inertia.{key}"), "one finite number");
                }
            }
        }
    } else {
        missing(
            format!("{link} has no <inertia>, a point is taken"),
            inertial,
            format!("{label}.inertia"),
            "<inertia>",
        );
    }
    let [mut xx, mut yy, mut zz, mut xy, mut xz, mut yz] = entries;
    // Without a mass a tensor has no meaning, and without one of its moments it is incomplete.
    let [mass] = value.unwrap_or([0.0]);
    let lacks_moment = tensor.is_some_and(|tensor| ["ixx", "iyy", "izz"].iter().any(|key| !tensor.has_attribute(*key)));
    if value.is_none() || lacks_moment {
        [xx, yy, zz, xy, xz, yz] = [0.0; 6];
    }
    let about_com = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    if mass == 0.0 && about_com.amax() == 0.0 {
        return Ok((Body::massless(), gap));
    }
    if about_com.amax() <= mass * NOTHING {
        return Ok((Body { mass, com: place.translation, inertia: Matrix3::zeros() }, gap));
    }
    let turned = place.rotation * about_com * place.rotation.transpose();
    Ok((Body { mass, com: place.translation, inertia: (turned + turned.transpose()) * 0.5 }, gap))
}

fn joint<'a>(markup: &Markup<'a>, node: Node<'a, 'a>) -> Result<UrdfJoint<'a>, FileError> {
    let name = markup.name(&node, "joint")?;
    let label = format!("joint {name}");
    let part = |name: &str| markup.only_child(&node, name, &label);
    let kind = kind(markup, &node, &label)?;
    let end = |name: &str| {
        part(name)?.and_then(|end| end.attribute("link")).ok_or_else(|| {
            let expected = format!("<{name} link=\"...\"/>");
            markup.error_in(&node, name, format!("{label}.{name}"), "missing", expected)
        })
    };
    let (parent, child) = (end("parent")?, end("child")?);
    let axis = part("axis")?.map(|axis| markup.required(&axis, "xyz", &label)).transpose()?;
    let limit = part("limit")?.map(|element| limit(markup, &element, &label)).transpose()?;
    let (mut damping, mut friction) = (0.0, 0.0);
    if let Some(dynamics) = part("dynamics")? {
        let coefficient = |key| Ok::<f64, FileError>(markup.finite(&dynamics, key, &label)?.map_or(0.0, |[x]| x));
        (damping, friction) = (coefficient("damping")?, coefficient("friction")?);
    }
    part("mimic")?;
    let origin = origin(markup, part("origin")?.as_ref(), &label)?;
    let axis = Vector3::from(axis.unwrap_or([1.0, 0.0, 0.0]));
    Ok(UrdfJoint { node, name, kind, origin, parent, child, axis, limit, damping, friction })
}

fn kind<'a>(markup: &Markup<'a>, node: &Node<'a, 'a>, label: &str) -> Result<UrdfJointKind, FileError> {
    let words = KINDS.map(|(word, _)| word);
    let Some(found) = node.attribute_node("type") else {
        return Err(markup.error(node, format!("{label}.type"), "missing", one_of("", &words)));
    };
    let known = KINDS.iter().find(|(word, _)| *word == found.value());
    known.map(|(_, kind)| *kind).ok_or_else(|| {
        let problem = format!("found {:?}", found.value());
        markup.error_at(found.range(), format!("{label}.type"), problem, one_of(found.value(), &words))
    })
}

fn limit<'a>(markup: &Markup<'a>, element: &Node<'a, 'a>, label: &str) -> Result<Limit, FileError> {
    let bound = |key| markup.bound(element, key, label);
    let (lower, upper) = (bound("lower")?, bound("upper")?);
    Ok(Limit { lower, upper, effort: bound("effort")?, velocity: bound("velocity")? })
}
