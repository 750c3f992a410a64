//! Removal of fixed joints: placements are multiplied, bodies added.

use super::chain::Chain;
use super::description::Description;
use super::pose::here;
use dynamics_core::model::Placement;
use dynamics_core::{Body, Inertia};
use nalgebra::{Matrix3, Vector3};

/// The placement of `joint` on the nearest moving link above it, or on the base.
fn above_to(chain: &Chain, joint: usize) -> Placement<f64> {
    let mut place = chain.place[joint];
    let mut link = chain.parent[joint];
    while let Some(above) = chain.above[link].filter(|_| link != chain.base) {
        if chain.moving.contains(&above) {
            break;
        }
        place = chain.place[above].then(&place);
        link = chain.parent[above];
    }
    place
}

/// Placement of the `i`-th moving joint on the moving link before it.
pub(super) fn joint_placement(chain: &Chain, i: usize) -> Placement<f64> {
    above_to(chain, chain.moving[i])
}

/// Placement of the tip link's frame on the last moving link.
pub(super) fn tip_placement(chain: &Chain) -> Placement<f64> {
    match chain.above[chain.tip] {
        Some(joint) if !chain.moving.contains(&joint) => above_to(chain, joint),
        _ => here(),
    }
}

/// Orientation of the base link in the root, whose z axis points up; the joints between them are at zero.
pub(super) fn mounting(chain: &Chain) -> Matrix3<f64> {
    let mut rotation = Matrix3::identity();
    let mut link = chain.base;
    // In a tree, no link is visited twice.
    while let Some(above) = chain.above[link] {
        rotation = chain.place[above].rotation * rotation;
        link = chain.parent[above];
    }
    rotation
}

/// The link of the `i`-th moving joint together with everything fixed to it, in its frame.
///
/// Moving joints outside the chain count as fixed at their held position.
pub(super) fn body(urdf: &Description<'_>, chain: &Chain, i: usize) -> Body {
    let link = chain.child[chain.moving[i]];
    let own = urdf.links[link].body;
    let mut sum = Inertia::from_mass_centre(own.mass, &own.com, &own.inertia);
    let mut alone = true;
    let mut open = vec![(link, here())];
    while let Some((link, link_from_part)) = open.pop() {
        for &joint in chain.below[link].iter().filter(|joint| !chain.moving.contains(joint)) {
            let place = link_from_part.then(&chain.place[joint]);
            let part = urdf.links[chain.child[joint]].body;
            if part != Body::massless() {
                let part = Inertia::from_mass_centre(part.mass, &part.com, &part.inertia);
                sum = sum + part.in_parent(&place.rotation, &place.translation);
                alone = false;
            }
            open.push((chain.child[joint], place));
        }
    }
    // A body with a single part keeps its exact numbers.
    if alone { own } else { about_mass_centre(&sum) }
}

/// The links of the `i`-th moving joint: its own, then those fixed to it.
pub(super) fn parts(chain: &Chain, i: usize) -> Vec<usize> {
    let mut parts = vec![chain.child[chain.moving[i]]];
    let mut next = 0;
    while let Some(&link) = parts.get(next) {
        parts.extend(chain.below[link].iter().filter(|joint| !chain.moving.contains(joint)).map(|&j| chain.child[j]));
        next += 1;
    }
    parts
}

/// `I_C = I_O - m (c.c 1 - c c^T)`.
fn about_mass_centre(inertia: &Inertia<f64>) -> Body {
    if inertia.mass == 0.0 {
        return Body { mass: 0.0, com: Vector3::zeros(), inertia: inertia.about_origin };
    }
    let com = inertia.first_moment / inertia.mass;
    let shift = Inertia::from_mass_centre(inertia.mass, &com, &Matrix3::zeros()).about_origin;
    Body { mass: inertia.mass, com, inertia: inertia.about_origin - shift }
}
