//! Teaching by hand: a torque per joint that makes up for friction, keeps an arm that is let go, and ends at soft walls.

use crate::fields::record;
use crate::scalar::Real;

record! {
    /// Behaviour of one joint of an arm that is led by hand, beside the torque that carries its weight.
    ///
    /// ```text
    /// tau = c m                                      friction made up for
    ///     - (1 - |m|) [K (q - a) + D qd] in +-b      kept where it was let go
    ///     - d qd                                     drag
    ///     - D (qd - [qd] in +-v)                     no faster than v
    ///     - K p - D qd where p != 0                  walls, p = q - [q] in wall
    /// m = [qd / s] in +-2 - [qd / s] in +-1          0 below the speed s, the sign of qd from 2 s on
    /// a <- the nearest to a within b / K of q
    /// ```
    ///
    /// Below `s` nothing is made up for: noise of the velocity moves nothing, and the joint comes to rest by its own friction. There
    /// it hangs on a spring to `a`, where it came to rest, which yields at `b`: a weight that is misjudged by less than `b` and the
    /// joint's stiction does not sink. Once the hand moves it, that hold ends and friction is made up for.
    ///
    /// The springs and dampers `K = M0 Kp` and `D = M0 Kd` are those of the law that holds the arm before and after.
    /// No part of it can be made unbounded by a joint that stays inside its guard.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct Teach<S> {
        /// `c`: Coulomb torque that is made up for, N m or N.
        pub friction: S,
        /// `1 / s`, s/rad or s/m.
        pub per_still_speed: S,
        /// `b`, N m or N.
        pub breakaway: S,
        /// `b / K`, rad or m.
        pub slip: S,
        /// `d`, less the viscous friction that is made up for, N m s/rad or N s/m.
        pub drag: S,
        /// `v`, rad/s or m/s.
        pub speed: S,
        /// Where the walls begin, rad or m.
        pub wall: (S, S),
        /// `K`, N m/rad or N/m.
        pub stiffness: S,
        /// `D`, N m s/rad or N s/m.
        pub damping: S,
    }
}

impl<S: Real> Teach<S> {
    /// Torque beside the weight's at this state, N m or N, from the anchor `a` of the tick before; the anchor is moved. NaN for NaN.
    ///
    /// Cost: about 40 operations, one of them a branch.
    #[inline]
    pub fn torque(&self, q: S, qd: S, anchor: &mut S) -> S {
        let one = S::one();
        let paced = qd * self.per_still_speed;
        let moving = paced.clamp_symmetric(one + one) - paced.clamp_symmetric(one);
        let stretch = (q - *anchor).clamp_symmetric(self.slip);
        *anchor = q - stretch;
        let kept = (self.stiffness * stretch + self.damping * qd).clamp_symmetric(self.breakaway);
        let (below, above) = self.wall;
        let into = if q > above {
            q - above
        } else if q < below {
            q - below
        } else {
            S::zero()
        };
        let wall = self.stiffness * into + if into == S::zero() { S::zero() } else { self.damping * qd };
        let fast = qd - qd.clamp_symmetric(self.speed);
        self.friction * moving - (one - moving.abs()) * kept - self.drag * qd - self.damping * fast - wall
    }
}
