//! Fixed joints taken out: placements multiplied, bodies added.

use super::chain::Chain;
use dynamics_core::geometry::from_rpy;
use dynamics_core::model::Placement;
use dynamics_core::{Body, Inertia};
use nalgebra::{Matrix3, Vector3};

/// `parent_from_joint` of a joint, at `q = 0`.
fn origin(pose: &urdf_rs::Pose) -> Placement<f64> {
    let [roll, pitch, yaw] = pose.rpy.0;
    Placement { rotation: from_rpy(roll, pitch, yaw), translation: Vector3::from(pose.xyz.0) }
}

/// The placement of `joint` on the nearest moving link above it, or on the base.
fn above_to(urdf: &urdf_rs::Robot, chain: &Chain, joint: usize) -> Placement<f64> {
    let mut place = origin(&urdf.joints[joint].origin);
    let mut link = chain.parent[joint];
    while let Some(above) = chain.above[link] {
        if chain.moving.contains(&above) {
            break;
        }
        place = origin(&urdf.joints[above].origin).then(&place);
        link = chain.parent[above];
    }
    place
}

/// Where the `i`-th moving joint sits on the moving link before it.
pub(super) fn joint_placement(urdf: &urdf_rs::Robot, chain: &Chain, i: usize) -> Placement<f64> {
    above_to(urdf, chain, chain.moving[i])
}

/// Where the tip link's frame sits on the last moving link.
pub(super) fn tip_placement(urdf: &urdf_rs::Robot, chain: &Chain) -> Placement<f64> {
    match chain.above[chain.tip] {
        Some(joint) if !chain.moving.contains(&joint) => above_to(urdf, chain, joint),
        _ => Placement { rotation: Matrix3::identity(), translation: Vector3::zeros() },
    }
}

/// The link of the `i`-th moving joint with everything fixed to it, in its frame.
///
/// Moving joints beside the chain count as fixed, at `q = 0`.
pub(super) fn body(urdf: &urdf_rs::Robot, chain: &Chain, i: usize) -> Body {
    let link = chain.child[chain.moving[i]];
    let own = link_body(&urdf.links[link].inertial);
    let mut sum = Inertia::from_mass_centre(own.mass, &own.com, &own.inertia);
    let mut alone = true;
    let here = Placement { rotation: Matrix3::identity(), translation: Vector3::zeros() };
    let mut open = vec![(link, here)];
    while let Some((link, link_from_part)) = open.pop() {
        for &joint in chain.below[link].iter().filter(|joint| !chain.moving.contains(joint)) {
            let place = link_from_part.then(&origin(&urdf.joints[joint].origin));
            let part = link_body(&urdf.links[chain.child[joint]].inertial);
            if part != Body::massless() {
                let part = Inertia::from_mass_centre(part.mass, &part.com, &part.inertia);
                sum = sum + part.in_parent(&place.rotation, &place.translation);
                alone = false;
            }
            open.push((chain.child[joint], place));
        }
    }
    // A body of one part keeps its very numbers.
    if alone { own } else { about_mass_centre(&sum) }
}

/// A link's inertial in the link's frame: its own origin has a position and an orientation.
fn link_body(inertial: &urdf_rs::Inertial) -> Body {
    let tensor = &inertial.inertia;
    let about_com = Matrix3::new(
        tensor.ixx, tensor.ixy, tensor.ixz, tensor.ixy, tensor.iyy, tensor.iyz, tensor.ixz, tensor.iyz, tensor.izz,
    );
    let place = origin(&inertial.origin);
    let turned = place.rotation * about_com * place.rotation.transpose();
    let turned = (turned + turned.transpose()) * 0.5;
    if inertial.mass.value == 0.0 && tensor_is_zero(&about_com) {
        return Body::massless();
    }
    Body { mass: inertial.mass.value, com: place.translation, inertia: turned }
}

fn tensor_is_zero(tensor: &Matrix3<f64>) -> bool {
    tensor.amax() == 0.0
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
