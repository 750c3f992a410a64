//! Split of a joint's wrench between its actuator and its bearings.
//!
//! The actuator of joint `i` carries the component along the joint's axis, `k_{i-1} . M_{i-1}` of a revolute joint and
//! `k_{i-1} . F_{i-1}` of a prismatic one (eq. 12.212-12.213 and 12.503-12.504, which print the wrench of the next
//! joint, index `i`); the joint's bearings carry everything else.

use crate::geometry::apply;
use crate::inertia::Wrench;
use crate::joint::JointKind;
use crate::kinematics::link_poses;
use crate::newton_euler::joint_wrenches;
use crate::scalar::{Real, Scalar};
use crate::scene::{Dynamics, Live};
use crate::trig::SinCos;
use nalgebra::Vector3;

/// Frame in whose axes the vectors of a [`Reaction`] are given. Moments are about the joint's own origin in both cases.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axes {
    /// The link's: z along the joint.
    Link,
    /// The base frame's.
    Base,
}

/// Wrench of the link before on a link, at their joint, split between actuator and bearings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reaction<S> {
    /// Unit vector along the joint.
    pub axis: Vector3<S>,
    /// The whole wrench, about the joint's origin, N and N m: `actuator` along the axis and `bearing`.
    pub wrench: Wrench<S>,
    /// Component that the actuator carries: N m for a revolute joint, N for a prismatic one. Without the rotor's own
    /// acceleration.
    pub actuator: S,
    /// Part that the bearings carry, N and N m: no moment along a revolute axis, no force along a prismatic one.
    pub bearing: Wrench<S>,
}

/// Magnitudes of a bearing's load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BearingLoad<S> {
    /// Force across the axis, N.
    pub radial: S,
    /// Force along the axis, with its sign, N; zero, to rounding, for a prismatic joint.
    pub axial: S,
    /// Moment across the axis, N m.
    pub tilting: S,
    /// Moment along the axis, with its sign, N m; zero, to rounding, for a revolute joint.
    pub twisting: S,
}

impl<S: Scalar> Reaction<S> {
    /// Splits a joint's wrench; `axis` is the joint's unit vector in the same axes.
    #[must_use]
    pub fn of(kind: JointKind, axis: &Vector3<S>, wrench: &Wrench<S>) -> Self {
        let mut bearing = *wrench;
        let carried = match kind {
            JointKind::Revolute => &mut bearing.moment,
            JointKind::Prismatic => &mut bearing.force,
        };
        let actuator = axis.dot(carried);
        *carried -= axis * actuator;
        Self { axis: *axis, wrench: *wrench, actuator, bearing }
    }
}

impl<S: Real> Reaction<S> {
    /// Magnitudes of the bearings' load.
    #[must_use]
    pub fn bearing_load(&self) -> BearingLoad<S> {
        let Wrench { force, moment } = &self.bearing;
        let (axial, twisting) = (self.axis.dot(force), self.axis.dot(moment));
        let size = |v: Vector3<S>| v.dot(&v).sqrt();
        let radial = size(force - self.axis * axial);
        BearingLoad { radial, axial, tilting: size(moment - self.axis * twisting), twisting }
    }
}

/// Wrench of every joint, base first, split between actuator and bearings.
///
/// Inputs as [`crate::InverseDynamics::inverse_dynamics`], whose torques are the actuators' shares plus, if the scene counts
/// rotors, `gear^2 inertia qdd`. O(N); no branch on data, no division.
pub fn joint_reactions<S: Scalar, const N: usize>(
    dynamics: &Dynamics<S, N>,
    turn: &[SinCos<S>; N],
    q: &[S; N],
    qd: &[S; N],
    qdd: &[S; N],
    live: &Live<S, N>,
    axes: Axes,
) -> [Reaction<S>; N] {
    let wrench = joint_wrenches(dynamics, turn, q, qd, qdd, live);
    let poses = link_poses(dynamics.model(), turn, q);
    let z = Vector3::new(S::zero(), S::zero(), S::one());
    core::array::from_fn(|i| {
        let kind = dynamics.model().links()[i].kind;
        match axes {
            Axes::Link => Reaction::of(kind, &z, &wrench[i]),
            Axes::Base => {
                let into_base = |v: &Vector3<S>| apply(&poses[i].rotation, v);
                let turned = Wrench { force: into_base(&wrench[i].force), moment: into_base(&wrench[i].moment) };
                Reaction::of(kind, &into_base(&z), &turned)
            }
        }
    })
}
