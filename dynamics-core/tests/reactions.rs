//! The split of a joint's wrench between actuator and bearings.

use crate::common::moving::{Moving, worst, worst_over_arms};
use crate::common::{pinned, pinned_rounding, relative_error, torque, turns};
use dynamics_core::chapter::reactions::{Axes, Reaction, joint_reactions};
use dynamics_core::{JointKind, Live, Wrench};

fn reactions<const N: usize>(case: &Moving<N>, axes: Axes) -> [Reaction<f64>; N] {
    joint_reactions(&case.dynamics(), &turns(&case.q), &case.q, &case.qd, &case.qdd, &Live::zero(), axes)
}

/// Largest force and moment of all joints, as the reference for rounding errors.
fn size<const N: usize>(reactions: &[Reaction<f64>; N]) -> f64 {
    reactions.iter().fold(0.0, |most, r| most.max(r.wrench.force.amax()).max(r.wrench.moment.amax()))
}

/// The actuators' shares are the torques without the rotors', in axes of either frame.
fn shares<const N: usize>(case: &Moving<N>) -> f64 {
    let tau = torque::<f64, N>(&case.dynamics(), &case.q, &case.qd, &case.qdd);
    let link = reactions(case, Axes::Link);
    let base = reactions(case, Axes::Base);
    let scale = size(&link);
    (0..N).fold(0.0, |worst: f64, i| {
        let wanted = tau[i] - case.model.links()[i].rotor * case.qdd[i];
        worst.max((link[i].actuator - wanted).abs() / scale).max((base[i].actuator - wanted).abs() / scale)
    })
}

/// Both shares add up to the wrench, the bearing has no component along the actuator's, and magnitudes are the same in axes of either frame.
fn bearings<const N: usize>(case: &Moving<N>) -> f64 {
    let (link, base) = (reactions(case, Axes::Link), reactions(case, Axes::Base));
    let scale = size(&link);
    let mut worst = 0.0_f64;
    for (i, reaction) in base.iter().enumerate() {
        let kind = case.model.links()[i].kind;
        let along = match kind {
            JointKind::Revolute => Wrench { moment: reaction.axis * reaction.actuator, ..Wrench::zero() },
            JointKind::Prismatic => Wrench { force: reaction.axis * reaction.actuator, ..Wrench::zero() },
        };
        let left = along + reaction.bearing - reaction.wrench;
        worst = worst.max(left.force.amax()).max(left.moment.amax());
        let (load, same) = (reaction.bearing_load(), link[i].bearing_load());
        let none = if kind == JointKind::Revolute { load.twisting } else { load.axial };
        worst = worst.max(none.abs());
        let pairs = [
            (load.radial, same.radial),
            (load.axial, same.axial),
            (load.tilting, same.tilting),
            (load.twisting, same.twisting),
        ];
        worst = pairs.iter().fold(worst, |worst, (a, b)| worst.max((a - b).abs()));
        // The squares of the parts, including the actuator's, add up to the square of the whole.
        let whole =
            reaction.wrench.force.dot(&reaction.wrench.force) + reaction.wrench.moment.dot(&reaction.wrench.moment);
        let parts = [load.radial, load.axial, load.tilting, load.twisting, reaction.actuator];
        let sum: f64 = parts.iter().map(|x| x * x).sum();
        worst = worst.max((whole - sum).abs() / scale);
    }
    worst / scale
}

#[test]
fn actuators_and_bearings_share_every_wrench() {
    pinned_rounding("actuators", worst_over_arms!(shares), 8.37e-16);
    pinned_rounding("bearings", worst_over_arms!(bearings), 1.20e-15);
}

/// 12.212-12.213 as printed use the next joint's wrench along this joint's axis.
#[test]
fn the_printed_index_gives_another_torque() {
    let error = |case: &Moving<6>| {
        let found = reactions(case, Axes::Base);
        let (mut printed, mut right) = ([0.0; 5], [0.0; 5]);
        for i in 0..5 {
            let next = Reaction::of(case.model.links()[i].kind, &found[i].axis, &found[i + 1].wrench);
            (printed[i], right[i]) = (next.actuator, found[i].actuator);
        }
        relative_error(&printed, &right)
    };
    pinned("index as printed", worst(error), 2.03);
}
