//! Elements and attributes that URDF does not have: likely misspelt.

use super::markup::Markup;
use crate::describe::diagnostics::nearest;
use crate::describe::draft::{Place, Remark, RemarkKind};
use roxmltree::Node;

/// Known children and attributes of an element. Unknown children are reported only if they resemble a known name, because simulators add
/// their own.
struct Known {
    element: &'static str,
    children: &'static [&'static str],
    attributes: &'static [&'static str],
}

const KNOWN: [Known; 12] = [
    Known { element: "link", children: &["inertial", "visual", "collision"], attributes: &["name", "type"] },
    Known {
        element: "joint",
        children: &[
            "origin",
            "parent",
            "child",
            "axis",
            "limit",
            "dynamics",
            "mimic",
            "calibration",
            "safety_controller",
        ],
        attributes: &["name", "type"],
    },
    Known { element: "inertial", children: &["origin", "mass", "inertia"], attributes: &[] },
    Known { element: "origin", children: &[], attributes: &["xyz", "rpy", "quat_xyzw"] },
    Known { element: "mass", children: &[], attributes: &["value"] },
    Known { element: "inertia", children: &[], attributes: &["ixx", "ixy", "ixz", "iyy", "iyz", "izz"] },
    Known { element: "parent", children: &[], attributes: &["link"] },
    Known { element: "child", children: &[], attributes: &["link"] },
    Known { element: "axis", children: &[], attributes: &["xyz"] },
    Known {
        element: "limit",
        children: &[],
        attributes: &["lower", "upper", "effort", "velocity", "acceleration", "deceleration", "jerk"],
    },
    Known { element: "dynamics", children: &[], attributes: &["damping", "friction"] },
    Known { element: "mimic", children: &[], attributes: &["joint", "multiplier", "offset"] },
];

/// Words of other formats, and their URDF equivalents.
const ALIKE: [(&str, &str); 22] = [
    ("pos", "xyz"),
    ("position", "xyz"),
    ("translation", "xyz"),
    ("offset", "xyz"),
    ("rot", "rpy"),
    ("euler", "rpy"),
    ("rotation", "rpy"),
    ("orientation", "rpy"),
    ("pose", "origin"),
    ("com", "origin"),
    ("kg", "value"),
    ("min", "lower"),
    ("low", "lower"),
    ("max", "upper"),
    ("high", "upper"),
    ("torque", "effort"),
    ("force", "effort"),
    ("speed", "velocity"),
    ("viscous", "damping"),
    ("coulomb", "friction"),
    ("limits", "limit"),
    ("inertias", "inertia"),
];

/// Parts of a link or joint that are not read.
pub(super) fn unknown<'a>(markup: &Markup<'a>, node: &Node<'a, 'a>, label: &str) -> Vec<Remark> {
    let Some(known) = KNOWN.iter().find(|known| node.has_tag_name(known.element)) else { return Vec::new() };
    let mut found = Vec::new();
    let ours = |name: roxmltree::ExpandedName<'_, '_>| name.namespace().is_none();
    for attribute in node.attributes().filter(|it| it.namespace().is_none() && !known.attributes.contains(&it.name())) {
        let place = Place { span: attribute.range(), field: format!("{label}.{}", attribute.name()), given: true };
        found.push(remark("attribute", attribute.name(), known.attributes, place));
    }
    for part in node.children().filter(|it| it.is_element() && ours(it.tag_name())) {
        let name = part.tag_name().name();
        let inside = format!("{label}.{name}");
        if known.children.contains(&name) {
            found.extend(unknown(markup, &part, &inside));
        } else if guess(name, known.children).is_some() || known.element == "inertial" {
            let place = Place { span: markup.tag(&part), field: inside, given: true };
            found.push(remark("element", name, known.children, place));
        }
    }
    found
}

fn guess<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    let alike = ALIKE.iter().find(|(alike, _)| *alike == word).map(|(_, ours)| *ours);
    alike.and_then(|ours| known.iter().copied().find(|known| *known == ours)).or_else(|| nearest(word, known))
}

fn remark(what: &str, word: &str, known: &[&str], place: Place) -> Remark {
    let guess = guess(word, known);
    let list = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
    let advice = match guess {
        Some(guess) => format!("did you mean `{guess}`? URDF has {list} here"),
        None => format!("take it out, or write one of URDF's: {list}"),
    };
    let kind = RemarkKind::Unknown { misspelt: guess.is_some() };
    Remark { kind, place, problem: format!("unknown {what} `{word}`: it is not read"), advice }
}
