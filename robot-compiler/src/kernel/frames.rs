//! Level `regrouped`: the choice of the frame for each link's quantities.
//!
//! The position and orientation of a link's frame are only a convention. Two choices leave every joint torque unchanged, and
//! cost or save operations:
//!
//! - **The position of the origin.** A revolute joint's origin may be anywhere on its axis, a prismatic joint's anywhere at all.
//!   If two axes meet, or an offset along one axis can be moved to another, components of the step from link to link
//!   vanish.
//! - **Whether the frame turns with its link.** A frame may be fixed while its joint turns, and passes the turn on to the next
//!   step. Then the link's own constants (first moment, inertia, position of the next joint) are turned instead of the
//!   vectors. After parallel axes the turns add up to one angle, and velocities and accelerations are not turned at all.
//!
//! The cheapest choice depends on every zero of the arm. A search that counts the kernel's operations finds it.

use super::arena::Expr;
use super::regroup::{Across, without_dust};
use dynamics_core::geometry::{apply, compose};
use dynamics_core::model::{Link, Model, Placement};
use dynamics_core::{Inertia, JointKind, Scalar, SinCos};
use nalgebra::{Matrix3, Vector3};
use num_traits::{One, Zero};

/// The choice for every link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frames<const N: usize> {
    /// Shift of the origin from the model's, in the link's frame, m; along z for a revolute joint.
    pub(super) shift: [Vector3<f64>; N],
    /// True if the frame does not turn with its joint.
    pub(super) still: [bool; N],
    /// Part of the inertia across its axis that each link passes to its parent.
    pub(super) across: [Across; N],
}

impl<const N: usize> Frames<N> {
    /// The frames of the model.
    #[must_use]
    pub(super) fn of_the_model() -> Self {
        Self { shift: [Vector3::zeros(); N], still: [false; N], across: [Across::Iyy; N] }
    }

    /// The same arm with its origins moved. Torques stay equal in exact arithmetic; wrenches refer to other points.
    #[must_use]
    pub(super) fn shifted(&self, model: &Model<f64, N>) -> Model<f64, N> {
        let mut before = Vector3::zeros();
        let links = core::array::from_fn(|i| {
            let link = &model.links()[i];
            let shift = self.shift[i];
            let translation = differing(&(link.translation + link.rotation * shift - before), &link.translation);
            before = shift;
            Link { translation, inertia: link.inertia.in_parent(&Matrix3::identity(), &-shift), ..*link }
        });
        let tip = model.tip();
        let translation = differing(&(tip.translation - before), &tip.translation);
        Model::from_checked(links, Placement { translation, ..*tip })
    }

    /// The cheapest choice that can be reached by changing one link at a time, or two neighbours at once.
    ///
    /// `free[i]` is true if link `i` may be changed.
    #[must_use]
    pub(super) fn cheapest(model: &Model<f64, N>, free: &[bool; N], mut cost: impl FnMut(&Self) -> usize) -> Self {
        let mut best = Self::of_the_model();
        let mut least = cost(&best);
        loop {
            let before = least;
            for i in (0..N).filter(|&i| free[i]) {
                let mut candidates: Vec<Self> = Vec::new();
                let mut flipped = best;
                flipped.still[i] = !flipped.still[i];
                candidates.push(flipped);
                candidates.extend(Across::ALL.map(|across| {
                    let mut other = best;
                    other.across[i] = across;
                    other
                }));
                if i + 1 < N && free[i + 1] {
                    flipped.still[i + 1] = flipped.still[i];
                    candidates.push(flipped);
                }
                for shift in best.worth_trying(model, i) {
                    let mut moved = best;
                    moved.shift[i] = shift;
                    candidates.push(moved);
                    // An offset is often best moved between axes that are parallel or meet.
                    if i + 1 < N && free[i + 1] {
                        for next in moved.worth_trying(model, i + 1) {
                            let mut both = moved;
                            both.shift[i + 1] = next;
                            candidates.push(both);
                        }
                    }
                }
                for candidate in candidates {
                    let found = cost(&candidate);
                    if found < least {
                        (best, least) = (candidate, found);
                    }
                }
            }
            if least == before {
                return best;
            }
        }
    }

    /// Shifts of one link that may save operations: those that make a component of the step to it, or from it, zero.
    ///
    /// Shifts beyond the arm's own reach are excluded. Axes that nearly meet, or are nearly parallel, would send the origin
    /// far away, where moments of inertia are large and cancel.
    #[must_use]
    fn worth_trying(&self, model: &Model<f64, N>, i: usize) -> Vec<Vector3<f64>> {
        let links = model.links();
        let (here, before) = (&links[i], if i == 0 { Vector3::zeros() } else { self.shift[i - 1] });
        // The steps to this link, in its own axes, and from it, without a shift of this link.
        let step_to = here.rotation.transpose() * (here.translation - before);
        let step_from = match links.get(i + 1) {
            Some(next) => next.translation + next.rotation * self.shift[i + 1],
            None => model.tip().translation,
        };
        let mut found = vec![Vector3::zeros()];
        match here.kind {
            JointKind::Prismatic => found.extend([-step_to, step_from]),
            JointKind::Revolute => {
                let axis = here.rotation.column(2);
                let step = here.translation - before;
                let along = (0..3).filter(|&k| axis[k] != 0.0).map(|k| -step[k] / axis[k]);
                found.extend(along.chain([step_from.z]).map(|z| Vector3::new(0.0, 0.0, z)));
            }
        }
        let reach = links.iter().map(|link| link.translation.norm()).sum::<f64>() + model.tip().translation.norm();
        found.retain(|shift| shift.norm() <= reach);
        found
    }

    /// The arm on the tape with the chosen frames, and the turn of each joint in its frame.
    ///
    /// `turn` holds the sines and cosines of the joints. The ordinary recursion runs on the result. A frame that does not turn
    /// appears there as a joint that does not turn, with inertia and steps that do.
    pub(super) fn on_tape(
        &self,
        model: &Model<f64, N>,
        turn: &[SinCos<Expr>; N],
        how: &Turning,
    ) -> (Model<Expr, N>, [SinCos<Expr>; N]) {
        let tape = model.cast::<Expr>();
        let step = |carried: Option<SinCos<Expr>>, v: &Vector3<Expr>| carried.map_or(*v, |carry| (how.step)(carry, v));
        let mut carried: Option<SinCos<Expr>> = None;
        let mut seen = *turn;
        let links = core::array::from_fn(|i| {
            let (mut link, constant) = (tape.links()[i], &model.links()[i].rotation);
            link.translation = step(carried, &link.translation);
            let own = (link.kind == JointKind::Revolute).then_some(turn[i]);
            let parallel = along_z(constant).filter(|_| self.still[i] || own.is_some());
            let inner = match (carried, parallel) {
                // `Rz(a) R = R Rz(a)` for a turn R about z, `R Rz(-a)` for one that turns z over.
                (Some(carry), Some(sign)) => {
                    let carry = SinCos { sin: carry.sin * Expr::literal(sign), ..carry };
                    Some(own.map_or(carry, |own| (how.both)(carry, own)))
                }
                (Some(carry), None) => {
                    link.rotation = compose(&about_z(carry), &link.rotation);
                    own
                }
                (None, _) => own,
            };
            carried = None;
            if self.still[i] {
                seen[i] = no_turn();
                link.inertia = inner.map_or(link.inertia, |inner| (how.inertia)(inner, &link.inertia));
                carried = inner;
            } else if let Some(inner) = inner {
                seen[i] = inner;
            }
            link
        });
        let tip = tape.tip();
        let rotation = carried.map_or(tip.rotation, |carry| compose(&about_z(carry), &tip.rotation));
        let tip = Placement { rotation, translation: step(carried, &tip.translation) };
        (Model::from_checked(links, tip), seen)
    }
}

/// Operations that a frame that does not turn passes on. A test replaces some by wrong ones.
pub(super) struct Turning {
    /// The step to the next link.
    pub(super) step: fn(SinCos<Expr>, &Vector3<Expr>) -> Vector3<Expr>,
    /// The link's own body.
    pub(super) inertia: fn(SinCos<Expr>, &Inertia<Expr>) -> Inertia<Expr>,
    /// Two turns in sequence about the same direction.
    pub(super) both: fn(SinCos<Expr>, SinCos<Expr>) -> SinCos<Expr>,
}

/// The correct operations.
pub(super) const TURNING: Turning = Turning {
    step: |turn, v| apply(&about_z(turn), v),
    inertia: |turn, body| body.in_parent(&about_z(turn), &Vector3::from_element(Expr::zero())).symmetric(),
    both: |a, b| SinCos { sin: a.sin * b.cos + a.cos * b.sin, cos: a.cos * b.cos - a.sin * b.sin },
};

/// Returns 1 if a rotation keeps the z axis, -1 if it reverses it.
fn along_z(rotation: &Matrix3<f64>) -> Option<f64> {
    let z = rotation.m33;
    // Rotations of the model have exact zeros and ones at right angles.
    (rotation.m13 == 0.0 && rotation.m23 == 0.0).then_some(z)
}

fn no_turn() -> SinCos<Expr> {
    SinCos { sin: Expr::zero(), cos: Expr::one() }
}

fn about_z(turn: SinCos<Expr>) -> Matrix3<Expr> {
    let (zero, one, SinCos { sin, cos }) = (Expr::zero(), Expr::one(), turn);
    Matrix3::new(cos, -sin, zero, sin, cos, zero, zero, zero, one)
}

/// A step computed from another by differences; components that cancel are set to zero instead of their rounding error.
fn differing(step: &Vector3<f64>, from: &Vector3<f64>) -> Vector3<f64> {
    let size = from.amax().max(step.amax());
    step.map(|x| without_dust(x, size))
}
