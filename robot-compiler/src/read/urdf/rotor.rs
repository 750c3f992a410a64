//! Rotors, which URDF itself does not have: Drake's `drake:rotor_inertia` and `drake:gear_ratio` in a `<transmission>`.

use super::markup::{Markup, child};
use crate::describe::diagnostics::FileError;
use dynamics_core::Rotor;
use roxmltree::Node;

/// The rotor of a joint; none if no transmission of the joint gives one.
///
/// A rotor inertia without a gear ratio has the ratio 1, as in Drake. A gear without an inertia is no rotor.
pub(super) fn rotor(markup: &Markup<'_>, joint: &str, label: &str) -> Result<Rotor, FileError> {
    let transmissions = markup.robot.children().filter(|node| node.has_tag_name("transmission"));
    let of_joint = transmissions.filter(|node| child(node, "joint").and_then(|it| it.attribute("name")) == Some(joint));
    let mut found: Option<Rotor> = None;
    for actuator in of_joint.filter_map(|node| child(&node, "actuator")) {
        let Some(element) = of_drake(&actuator, "rotor_inertia") else { continue };
        let [inertia] = markup.required(&element, "value", label)?;
        let gear = of_drake(&actuator, "gear_ratio").map(|it| markup.required(&it, "value", label)).transpose()?;
        let ([gear], field) = (gear.unwrap_or([1.0]), format!("{label}.rotor_inertia"));
        if inertia < 0.0 {
            return Err(markup.error(&element, field, format!("found {inertia}"), "zero or more, kg m^2"));
        }
        if found.replace(Rotor { inertia, gear }).is_some() {
            return Err(markup.error(&element, field, "given twice", "one rotor for the joint"));
        }
    }
    Ok(found.unwrap_or_default())
}

/// A child element in any namespace, which is assumed to be Drake's, whatever its address.
fn of_drake<'a>(actuator: &Node<'a, 'a>, name: &str) -> Option<Node<'a, 'a>> {
    actuator.children().find(|node| {
        let tag = node.tag_name();
        tag.name() == name && tag.namespace().is_some_and(|address| address.contains("drake"))
    })
}

/// The reduction that a transmission of a joint gives, and the transmission's name; ROS 1 and ROS 2 write it differently.
pub(super) fn reduction(markup: &Markup<'_>, joint: &str) -> Option<(f64, String)> {
    let mut all = markup.robot.descendants().filter(|node| node.has_tag_name("transmission"));
    all.find_map(|node| {
        let of_joint = node.children().any(|it| it.has_tag_name("joint") && it.attribute("name") == Some(joint));
        let words = ["mechanicalReduction", "mechanical_reduction", "reduction"];
        let element = node.descendants().filter(|_| of_joint).find(|it| words.contains(&it.tag_name().name()))?;
        let gear: f64 = element.text()?.trim().parse().ok()?;
        (gear.is_finite() && gear != 0.0).then(|| (gear, node.attribute("name").unwrap_or_default().to_owned()))
    })
}
