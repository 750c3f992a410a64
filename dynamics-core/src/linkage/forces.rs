//! Forces in the joints of a loop and the moment of its motor: nine equations for nine unknowns.

use super::plane::cross;
use super::{GroundJoint, LinkageError, LinkagePosture, PlanarMotion};
use crate::dynamics::solve::solve;
use crate::scalar::Real;
use nalgebra::Vector2;

/// `[A] x = b` (eq. 12.44).
///
/// Rows: the force balance along x and along y and the moment balance about the mass centre, of link 1, then 2, then 3. The moments
/// of links 1, 2, 3 are eq. 12.38, 12.40 and 12.42; the forces 12.37, 12.39 and 12.41, the last one with the mass and acceleration of
/// link 3 on its right-hand side (the chapter prints those of link 2).
///
/// | unknown | four-bar (eq. 12.43) | slider-crank |
/// |---|---|---|
/// | 0 to 5 | `F_0x, F_0y, F_1x, F_1y, F_2x, F_2y` | the same |
/// | 6, 7 | `F_3x, F_3y` | the guide's normal force `F_3y` and its couple `M_3` |
/// | 8 | `M_0` | `M_0` |
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkageSystem<S> {
    /// Coefficients, from the geometry (eq. 12.45), rows.
    pub a: [[S; 9]; 9],
    /// Right-hand side, from the motion (eq. 12.46): `m a - m g` and `I alpha`. With gravity as a vector, `(0, -9.81)`
    /// on the ground, weight needs 9.81 added in the chapter's rows, not taken away.
    pub b: [S; 9],
}

/// Joint forces and the driving moment of a loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkageForces<S> {
    /// `M_0`, moment of the motor between ground and crank, N m.
    pub driving_moment: S,
    /// `F_0` to `F_3`, N: `F_i` acts through joint `i` on the link after it, `F_0` of the ground on the crank, `F_3` of
    /// the last link on the ground.
    pub joints: [Vector2<S>; 4],
    /// `M_3`, couple of the slider on its guide, N m; zero at a pin.
    pub guide_moment: S,
    /// Point at which `F_3` acts, m: joint 3, or the slider's pin.
    pub last_joint: Vector2<S>,
}

impl<S: Real> LinkagePosture<S> {
    /// The system for this motion under this gravity (m/s^2).
    #[must_use]
    pub fn system(&self, motion: &[PlanarMotion<S>; 3], gravity: &Vector2<S>) -> LinkageSystem<S> {
        let (zero, one) = (S::zero(), S::one());
        let mut a = [[zero; 9]; 9];
        let mut b = [zero; 9];
        for (i, (link, motion)) in self.links.iter().zip(motion).enumerate() {
            let (n, m) = (link.inner_arm(), link.outer_arm());
            let (x, y, moment) = (3 * i, 3 * i + 1, 3 * i + 2);
            let (before, after) = (2 * i, 2 * i + 2);
            a[x][before] = one;
            a[y][before + 1] = one;
            a[moment][before] = -n.y;
            a[moment][before + 1] = n.x;
            if i < 2 || self.ground == GroundJoint::Pin {
                a[x][after] = -one;
                a[y][after + 1] = -one;
                a[moment][after] = m.y;
                a[moment][after + 1] = -m.x;
            } else {
                a[y][after] = -one;
                a[moment][after] = -m.x;
                a[moment][after + 1] = -one;
            }
            let force = (motion.acceleration - gravity) * link.mass;
            b[x] = force.x;
            b[y] = force.y;
            b[moment] = link.inertia * motion.alpha;
        }
        a[2][8] = one;
        LinkageSystem { a, b }
    }

    /// Joint forces and driving moment for this motion under this gravity (m/s^2). A 9 by 9 elimination.
    ///
    /// # Errors
    /// [`LinkageError::Dead`]: no moment drives the crank there. `|det A|` is `l2 l3` times the sine between coupler and follower.
    pub fn forces(
        &self,
        motion: &[PlanarMotion<S>; 3],
        gravity: &Vector2<S>,
    ) -> Result<LinkageForces<S>, LinkageError<S>> {
        if let Some(point) = self.dead_point() {
            return Err(LinkageError::Dead(point));
        }
        let LinkageSystem { a, b } = self.system(motion, gravity);
        let x = solve(a, b).ok_or(LinkageError::Dead(self.ground.dead_point()))?;
        let (last, guide_moment) = match self.ground {
            GroundJoint::Pin => (Vector2::new(x[6], x[7]), S::zero()),
            GroundJoint::Guide => (Vector2::new(S::zero(), x[6]), x[7]),
        };
        let at = |i: usize| Vector2::new(x[2 * i], x[2 * i + 1]);
        Ok(LinkageForces {
            driving_moment: x[8],
            joints: [at(0), at(1), at(2), last],
            guide_moment,
            last_joint: self.links[2].outer,
        })
    }
}

impl<S: Real> LinkageForces<S> {
    /// `F_s = F_3 - F_0`, force of the linkage on the ground, weight included, N (eq. 12.47).
    #[must_use]
    pub fn shaking_force(&self) -> Vector2<S> {
        self.joints[3] - self.joints[0]
    }

    /// Moment of the linkage and its motor on the ground, about joint 0, N m: `d_3 x F_3 + M_3 - M_0`.
    #[must_use]
    pub fn shaking_moment(&self) -> S {
        cross(&self.last_joint, &self.joints[3]) + self.guide_moment - self.driving_moment
    }
}
