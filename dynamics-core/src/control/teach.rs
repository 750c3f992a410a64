//! Hand guiding: a torque per joint that compensates friction, keeps a released arm in position, and ends at soft walls.

use crate::fields::record;
use crate::scalar::Real;

record! {
    /// Behaviour of one joint of a hand-guided arm, in addition to the torque that carries its weight.
    ///
    /// ```text
    /// tau = -[K (q - a) + D qd] in +-b               kept, until |q - a| > b / K and |qd| > 2 s
    ///     or c ([qd / s] in +-2 - [qd / s] in +-1)   free, until |qd| < s: friction compensated
    ///     - d qd                                     drag
    ///     - D (qd - [qd] in +-v)                     braked above v
    ///     - h K p - D qd e                           walls, p = q - [q] in wall
    /// a <- the nearest to a within b / K of q, while the joint is kept; q when it is kept again
    /// ```
    ///
    /// A joint that is kept is held by a spring to `a`, which yields at the torque `b`. So the arm does not sink if its weight is misjudged by
    /// less than `b` and the joint's stiction. A hand that moves the joint breaks it away. Its friction is then compensated until it comes to
    /// rest. Between the speeds `s` and `2 s` its state does not change, so that velocity noise does not make it chatter.
    ///
    /// A wall resists with its whole stiffness while the joint moves into it, `h = 1` and `e = [|p| / w] in 1`. While the joint comes out, the wall
    /// returns a tenth of the force, `h = 0.1` and `e = 1`. A joint that runs into it stops there and does not rebound.
    ///
    /// The law [`ControlLaw::Teach`](super::ControlLaw::Teach) itself lets a joint slow down by the arm's own inertia, `qdd = -qd / T`: released at
    /// a speed `u` it coasts `u T`, in every posture.
    ///
    /// The springs and dampers `K = M0 Kp` and `D = M0 Kd` are those of the law that holds the arm before and after.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Teach<S> {
        /// `c`: Coulomb torque that is compensated, N m or N.
        pub friction: S,
        /// `1 / s`, s/rad or s/m.
        pub per_still_speed: S,
        /// `b`, N m or N.
        pub breakaway: S,
        /// `b / K`, rad or m.
        pub slip: S,
        /// `d`, less the viscous friction that is compensated, N m s/rad or N s/m.
        pub drag: S,
        /// `v`, rad/s or m/s.
        pub speed: S,
        /// Positions at which the lower and the upper wall begin, rad or m.
        pub wall: (S, S),
        /// `1 / w`, 1/rad or 1/m: `w` is the depth at which a wall's damper acts fully.
        pub per_wall: S,
        /// `K`, N m/rad or N/m.
        pub stiffness: S,
        /// `D`, N m s/rad or N s/m.
        pub damping: S,
        /// `1 / T`, 1/s.
        pub slowing: S,
    }
}

impl<S: Real> Teach<S> {
    /// Torque in addition to those of the weight and of the slowing at this state, N m or N; NaN for NaN. `anchor` is the position at which the
    /// joint is kept, rad or m, and `None` while it is free; it is updated for the next tick.
    ///
    /// Cost: about 30 operations.
    #[inline]
    pub fn torque(&self, q: S, qd: S, anchor: &mut Option<S>) -> S {
        let one = S::one();
        let paced = qd * self.per_still_speed;
        let own = if let Some(kept_at) = *anchor {
            let away = q - kept_at;
            let stretch = away.clamp_symmetric(self.slip);
            let broken = away != stretch && paced.abs() > one + one;
            *anchor = if broken { None } else { Some(q - stretch) };
            -(self.stiffness * stretch + self.damping * qd).clamp_symmetric(self.breakaway)
        } else {
            if paced.abs() < one {
                *anchor = Some(q);
            }
            self.friction * (paced.clamp_symmetric(one + one) - paced.clamp_symmetric(one))
        };
        let (below, above) = self.wall;
        let into = q - q.clamp_to(below, above);
        let deep = (into.abs() * self.per_wall).clamp_symmetric(one);
        // Speed into the wall, as a multiple of the still speed: 1 going in, -1 coming out.
        let inward = if into >= S::zero() { paced } else { -paced };
        let share = S::literal(0.55) + S::literal(0.45) * inward.clamp_symmetric(one);
        let damped = if inward > S::zero() || into == S::zero() { deep } else { one };
        let wall = self.stiffness * into * share + damped * self.damping * qd;
        let fast = qd - qd.clamp_symmetric(self.speed);
        own - self.drag * qd - self.damping * fast - wall
    }
}
