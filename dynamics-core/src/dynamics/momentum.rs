//! Generalised momentum and its rate of change: the basis of an observer of external torques.
//!
//! With `T = 1/2 qd^T D qd`, Lagrange's equation in the momentum `p = dT/dqd` needs no acceleration:
//!
//! ```text
//! p     = D(q) qd
//! dp/dt = tau + dT/dq - G + J^T w + tau_ext
//! dT/dq = C^T qd            where C is made of Christoffel symbols, because then dD/dt = C + C^T and C qd = dD/dt qd - dT/dq
//! ```
//!
//! Neither `D` nor `C` is formed. The outward pass computes the links' angular velocity `w` and the velocity `v` of their origins, each in the
//! link's own frame. The inward pass computes the momentum `P`, `H` (about the joint's origin) of everything beyond a joint:
//!
//! ```text
//! w' = R^T w + qd z,  v' = R^T (v + w x p)                                    turning joint
//! w' = R^T w,         v' = R^T (v + w x p) + w' x (0, 0, q) + qd z            sliding joint
//! P  = m v + w x h,   H  = J w + h x v                                        of one body
//! ```
//!
//! The momentum of a joint is `H . z` (turning) or `P . z` (sliding). For `dT/dq_i` only the joint's own transform is
//! varied. The velocity `V = (w, v)` of the link after the joint varies by `(w x z, v x z)` for a turn and by `(0, w x z)`
//! for a slide. Every body beyond moves along rigidly, and
//! `dT = sum (momentum of a body) . (variation of its velocity)`. So
//!
//! ```text
//! (C^T qd)_i = H . (w x z) + P . (v x z) = Hx wy - Hy wx + Px vy - Py vx      turning joint
//! (C^T qd)_i = P . (w x z)               = Px wy - Py wx                      sliding joint
//! ```
//!
//! Weight needs no wrenches: with mass `M` and first moment `c` of everything beyond the joint, `-G_i` is `cx gy - cy gx` or
//! `M gz`. (The observer: De Luca, Albu-Schaeffer, Haddadin, Hirzinger, *Collision detection and safe reaction with the DLR-III
//! lightweight manipulator arm*, IROS 2006; Haddadin, De Luca, Albu-Schaeffer, *Robot collisions: a survey*, T-RO 2017, section IV.
//! The recursion is derived above.)

use crate::geometry::apply;
use crate::inertia::{Inertia, Wrench};
use crate::joint::JointKind;
use crate::newton_euler::{into_link, out_of_link, to_parent};
use crate::scalar::Scalar;
use crate::scene::{Dynamics, Live};
use crate::trig::SinCos;
use nalgebra::Vector3;

/// Generalised momentum and its rate without actuators and friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Momentum<S, const N: usize> {
    /// `p = D(q) qd`, kg m^2/s or kg m/s.
    pub momentum: [S; N],
    /// `C(q, qd)^T qd - G(q) + J^T w`, N m or N.
    pub rate: [S; N],
}

/// Generalised momentum of an arm. Implemented by [`Dynamics`] and by every generated kernel of it.
pub trait GeneralizedMomentum<S, const N: usize> {
    /// Momentum, and its rate without actuators, friction and unknown forces.
    ///
    /// `p = D(q) qd`, `dp/dt - tau = C(q, qd)^T qd - G(q) + J^T w`, with `C` of Christoffel symbols (eq. 12.217, 12.281)
    ///
    /// | name | quantity | unit | shape |
    /// |---|---|---|---|
    /// | `turn` | sine and cosine of each joint (prismatic: not read) | - | N |
    /// | `q` | joint position (revolute: not read) | rad, m | N |
    /// | `qd` | joint velocity | rad/s, m/s | N |
    /// | `live` | the scene's live inputs | | |
    /// | return | momentum; rate | kg m^2/s, kg m/s; N m, N | N each |
    ///
    /// The velocity terms are always computed at `qd`, even if the scene omits them: a detector needs terms that a control law
    /// may leave out.
    ///
    /// O(N); no branch on data, no division.
    fn momentum(&self, turn: &[SinCos<S>; N], q: &[S; N], qd: &[S; N], live: &Live<S, N>) -> Momentum<S, N>;
}

impl<S: Scalar, const N: usize> GeneralizedMomentum<S, N> for Dynamics<S, N> {
    fn momentum(&self, turn: &[SinCos<S>; N], q: &[S; N], qd: &[S; N], live: &Live<S, N>) -> Momentum<S, N> {
        let links = self.model().links();
        let scene = self.scene();
        let nothing = Vector3::zeros();

        let mut motion = [Twist { angular: nothing, linear: nothing }; N];
        let mut gravity = [None; N];
        let mut before = Twist { angular: nothing, linear: nothing };
        let mut down = scene.gravity.value(&live.gravity).copied();
        for i in 0..N {
            let into = |v: &Vector3<S>| into_link(&links[i], turn[i], v);
            let angular = into(&before.angular);
            let linear = into(&(before.linear + before.angular.cross(&links[i].translation)));
            motion[i] = match links[i].kind {
                JointKind::Revolute => Twist { angular: Vector3::new(angular.x, angular.y, angular.z + qd[i]), linear },
                JointKind::Prismatic => Twist {
                    angular,
                    linear: Vector3::new(linear.x + angular.y * q[i], linear.y - angular.x * q[i], linear.z + qd[i]),
                },
            };
            before = motion[i];
            down = down.map(|g| into(&g));
            gravity[i] = down;
        }

        let rotor = scene.rotor.value(&live.rotor);
        let mut contact = scene
            .tip_wrench
            .value(&live.tip_wrench)
            .map(|w| w.in_parent(&self.model().tip().rotation, &self.model().tip().translation));
        let mut found = Momentum { momentum: [S::zero(); N], rate: [S::zero(); N] };
        let mut beyond: Option<Beyond<S>> = None;
        for i in (0..N).rev() {
            let body = self.inertia(i, live);
            let Twist { angular: w, linear: v } = &motion[i];
            let here = Beyond::of(&body, &motion[i]).and(beyond.as_ref());
            let Beyond { momentum: Wrench { force: p, moment: h }, mass, first_moment: c } = &here;
            let (along, mut rate) = match links[i].kind {
                JointKind::Revolute => (h.z, h.x * w.y - h.y * w.x + (p.x * v.y - p.y * v.x)),
                JointKind::Prismatic => (p.z, p.x * w.y - p.y * w.x),
            };
            if let Some(g) = &gravity[i] {
                rate += match links[i].kind {
                    JointKind::Revolute => c.x * g.y - c.y * g.x,
                    JointKind::Prismatic => *mass * g.z,
                };
            }
            if let Some(contact) = &mut contact {
                rate += match links[i].kind {
                    JointKind::Revolute => contact.moment.z,
                    JointKind::Prismatic => contact.force.z,
                };
                *contact = to_parent(&links[i], turn[i], q[i], contact);
            }
            found.rate[i] = rate;
            found.momentum[i] = rotor.map_or(along, |rotor| along + rotor[i] * qd[i]);
            beyond = (i > 0).then(|| {
                let slid = match links[i].kind {
                    JointKind::Revolute => *c,
                    JointKind::Prismatic => Vector3::new(c.x, c.y, c.z + *mass * q[i]),
                };
                Beyond {
                    momentum: to_parent(&links[i], turn[i], q[i], &here.momentum),
                    mass: *mass,
                    first_moment: out_of_link(&links[i], turn[i], &slid) + links[i].translation * *mass,
                }
            });
        }
        found
    }
}

/// Velocity of a link in its own frame.
#[derive(Clone, Copy)]
struct Twist<S> {
    /// Angular velocity, rad/s.
    angular: Vector3<S>,
    /// Velocity of the frame's origin, m/s.
    linear: Vector3<S>,
}

/// Everything that moves with a joint, in one link's frame and about its origin.
struct Beyond<S> {
    /// Linear and angular momentum, kg m/s and kg m^2/s.
    momentum: Wrench<S>,
    /// Mass, kg.
    mass: S,
    /// First moment, kg m.
    first_moment: Vector3<S>,
}

impl<S: Scalar> Beyond<S> {
    /// `P = m v + w x h`, `H = J w + h x v` of one body.
    fn of(body: &Inertia<S>, motion: &Twist<S>) -> Self {
        let Twist { angular: w, linear: v } = motion;
        let h = &body.first_moment;
        let momentum = Wrench { force: v * body.mass + w.cross(h), moment: apply(&body.about_origin, w) + h.cross(v) };
        Self { momentum, mass: body.mass, first_moment: *h }
    }

    /// Adds the bodies that move with the next joint, if there is one.
    fn and(self, next: Option<&Self>) -> Self {
        match next {
            None => self,
            Some(next) => Self {
                momentum: self.momentum + next.momentum,
                mass: self.mass + next.mass,
                first_moment: self.first_moment + next.first_moment,
            },
        }
    }
}
