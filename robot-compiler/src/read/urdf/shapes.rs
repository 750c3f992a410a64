//! Collision shapes: `<collision>` elements of the links that each joint moves, and of the base.

use super::chain::Chain;
use super::description::Description;
use super::markup::{Markup, child};
use super::pose::{here, origin};
use crate::describe::diagnostics::FileError;
use crate::describe::link_shape::{Geometry, LinkShape};
use crate::describe::robot::Robot;
use nalgebra::Vector3;
use roxmltree::Node;

/// Shapes of the base, then of each moving link with what is fixed to it.
pub(super) fn shapes<'a>(
    markup: &Markup<'a>,
    urdf: &Description<'a>,
    chain: &Chain,
    robot: &Robot,
) -> Result<Vec<LinkShape>, FileError> {
    let mut found = Vec::new();
    for frame in 0..=chain.moving.len() {
        let start = match frame.checked_sub(1) {
            None => (chain.base, here()),
            Some(i) => (chain.child[chain.moving[i]], robot.joints[i].spec.frame.link_from_body()),
        };
        let mut open = vec![start];
        while let Some((link, place)) = open.pop() {
            let node = &urdf.links[link].node;
            for element in node.children().filter(|node| node.has_tag_name("collision")) {
                let name = urdf.links[link].name;
                let label = format!("link {name}.collision");
                let at = origin(markup, markup.only_child(&element, "origin", &label)?.as_ref(), name)?;
                let geometry = geometry(markup, &element, &label)?;
                found.push(LinkShape { link: name.to_owned(), frame, place: place.then(&at), geometry });
            }
            for &joint in chain.below[link].iter().filter(|joint| !chain.moving.contains(joint)) {
                open.push((chain.child[joint], place.then(&urdf.joints[joint].origin)));
            }
        }
    }
    Ok(found)
}

fn geometry<'a>(markup: &Markup<'a>, collision: &Node<'a, 'a>, label: &str) -> Result<Geometry, FileError> {
    const KINDS: &str = "one of <box>, <sphere>, <cylinder> and <mesh>";
    let label = format!("{label}.geometry");
    let Some(parent) = child(collision, "geometry") else {
        return Err(markup.error(collision, label, "missing", "<geometry>"));
    };
    let Some(form) = parent.children().find(Node::is_element) else {
        return Err(markup.error(&parent, label, "empty", KINDS));
    };
    let above_zero = |attribute: &str| {
        let [x] = markup.required::<1>(&form, attribute, &label)?;
        if x > 0.0 {
            return Ok(x);
        }
        let field = format!("{label}.{}.{attribute}", form.tag_name().name());
        Err(markup.error(&form, field, format!("found {x}"), "a length above zero, m"))
    };
    match form.tag_name().name() {
        "box" => {
            let size: [f64; 3] = markup.required(&form, "size", &label)?;
            if size.iter().any(|edge| *edge <= 0.0) {
                let problem = format!("found {size:?}");
                return Err(markup.error(&form, format!("{label}.box.size"), problem, "three lengths above zero, m"));
            }
            Ok(Geometry::Box(Vector3::from(size)))
        }
        "sphere" => Ok(Geometry::Sphere(above_zero("radius")?)),
        "cylinder" => Ok(Geometry::Cylinder { radius: above_zero("radius")?, length: above_zero("length")? }),
        "mesh" => {
            let Some(file) = form.attribute("filename").filter(|file| !file.is_empty()) else {
                return Err(markup.error(&form, format!("{label}.mesh.filename"), "missing", "the path of a mesh"));
            };
            let scale = markup.finite(&form, "scale", &label)?.unwrap_or([1.0; 3]);
            Ok(Geometry::Mesh { file: file.to_owned(), scale: Vector3::from(scale) })
        }
        other => Err(markup.error(&form, label, format!("found <{other}>"), KINDS)),
    }
}
