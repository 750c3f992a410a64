//! Positions of the links of a loop, and their motion with the crank.

use super::plane::{cross, dot, quarter_turn};
use super::{DeadPoint, LinkageError};
use crate::dynamics::solve::rounding;
use crate::scalar::Real;
use nalgebra::Vector2;

/// Joint between the last link and the ground.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GroundJoint {
    /// A pin, joint 3: the link turns about it.
    Pin,
    /// A guide along x: the link slides in it.
    Guide,
}

/// One link in the plane of the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarLink<S> {
    /// Unit vector along x of the link's frame: cosine and sine of its angle.
    pub direction: Vector2<S>,
    /// Joint `i - 1` of link `i`, m.
    pub inner: Vector2<S>,
    /// Joint `i` of link `i`, m; for a slider its pin again: the guide's force is taken to act there.
    pub outer: Vector2<S>,
    /// Mass centre, m.
    pub centre: Vector2<S>,
    /// Mass, kg.
    pub mass: S,
    /// Moment of inertia about the mass centre, kg m^2.
    pub inertia: S,
}

/// All links in the plane of the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkagePosture<S> {
    /// Crank, coupler (rod), follower (slider).
    pub links: [PlanarLink<S>; 3],
    /// Joint between the last link and the ground.
    pub ground: GroundJoint,
}

/// Kinematic coefficients of a link: first and second derivatives by the crank's angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients<S> {
    /// Of the link's angle, rad/rad.
    pub turn: S,
    /// Of the link's angle, second, rad/rad^2.
    pub turn_second: S,
    /// Of the mass centre, m/rad.
    pub centre: Vector2<S>,
    /// Of the mass centre, second, m/rad^2.
    pub centre_second: Vector2<S>,
}

/// Motion of a link in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanarMotion<S> {
    /// Angular velocity, rad/s.
    pub omega: S,
    /// Angular acceleration, rad/s^2.
    pub alpha: S,
    /// Velocity of the mass centre, m/s.
    pub velocity: Vector2<S>,
    /// Acceleration of the mass centre, m/s^2; gravity is not in it.
    pub acceleration: Vector2<S>,
}

impl GroundJoint {
    /// The dead point of a loop whose last link is held by this joint.
    #[must_use]
    pub const fn dead_point(self) -> DeadPoint {
        match self {
            Self::Pin => DeadPoint::CouplerAndFollower,
            Self::Guide => DeadPoint::RodAcrossGuide,
        }
    }
}

impl<S: Real> PlanarLink<S> {
    /// `n_i`, from the mass centre to joint `i - 1`, m.
    #[must_use]
    pub fn inner_arm(&self) -> Vector2<S> {
        self.inner - self.centre
    }

    /// `m_i`, from the mass centre to joint `i`, m.
    #[must_use]
    pub fn outer_arm(&self) -> Vector2<S> {
        self.outer - self.centre
    }
}

impl<S: Real> Coefficients<S> {
    /// The motion at this crank speed (rad/s) and acceleration (rad/s^2).
    ///
    /// `omega_i = k_i omega`, `alpha_i = k_i alpha + k_i' omega^2`, and the same for the mass centre.
    #[must_use]
    pub fn motion(&self, speed: S, acceleration: S) -> PlanarMotion<S> {
        let square = speed * speed;
        PlanarMotion {
            omega: self.turn * speed,
            alpha: self.turn * acceleration + self.turn_second * square,
            velocity: self.centre * speed,
            acceleration: self.centre * acceleration + self.centre_second * square,
        }
    }
}

impl<S: Real> LinkagePosture<S> {
    /// Sine of the angle between coupler and follower (rod and the guide's normal): a measure of how well the crank drives the loop.
    ///
    /// Its magnitude is the sine of the transmission angle. It is zero at a dead point.
    #[must_use]
    pub fn transmission(&self) -> S {
        match self.ground {
            GroundJoint::Pin => cross(&self.links[1].direction, &self.links[2].direction),
            GroundJoint::Guide => self.links[1].direction.x,
        }
    }

    /// The dead point of this posture, if it is one: the sine of the angle is within its rounding error (1.2e-7
    /// in double precision, 2.8e-3 in single).
    #[must_use]
    pub fn dead_point(&self) -> Option<DeadPoint> {
        let sine = self.transmission();
        let moves = sine * sine > dead_sine_squared();
        (!moves).then_some(self.ground.dead_point())
    }

    /// Kinematic coefficients of every link.
    ///
    /// The loop `a + c = f + const`, with the crank `a`, the coupler `c` and the follower `f` (for a slider-crank, the slider's displacement
    /// along x), is differentiated twice by the crank's angle. With `J` a quarter turn, `w = J f` (or the unit vector along x, and then no
    /// `f`):
    ///
    /// ```text
    /// k2  J c - k3  w = -J a
    /// k2' J c - k3' w =  a + k2^2 c - k3^2 f
    /// ```
    ///
    /// Two equations each with the same matrix, solved by Cramer's rule: one division.
    ///
    /// # Errors
    /// [`LinkageError::Dead`]: the matrix is singular relative to its columns.
    pub fn coefficients(&self) -> Result<[Coefficients<S>; 3], LinkageError<S>> {
        if let Some(point) = self.dead_point() {
            return Err(LinkageError::Dead(point));
        }
        let [crank, coupler, last] = &self.links;
        let (zero, one) = (S::zero(), S::one());
        let (a, c) = (crank.outer - crank.inner, coupler.outer - coupler.inner);
        let (f, w) = match self.ground {
            GroundJoint::Pin => {
                let follower = last.inner - last.outer;
                (follower, quarter_turn(&follower))
            }
            GroundJoint::Guide => (Vector2::zeros(), Vector2::x()),
        };
        let column = quarter_turn(&c);
        let inverse = -one / cross(&column, &w);
        let solve = |right: &Vector2<S>| (-cross(right, &w) * inverse, cross(&column, right) * inverse);
        let pin = quarter_turn(&a);
        let (k2, k3) = solve(&-pin);
        let (k2_second, k3_second) = solve(&(a + c * (k2 * k2) - f * (k3 * k3)));

        // Derivatives of a point at `arm` from a point with derivatives (first, second).
        let about = |first: Vector2<S>, second: Vector2<S>, arm: Vector2<S>, k: S, k_second: S| Coefficients {
            turn: k,
            turn_second: k_second,
            centre: first + quarter_turn(&arm) * k,
            centre_second: second + quarter_turn(&arm) * k_second - arm * (k * k),
        };
        let still = Vector2::zeros();
        let third = match self.ground {
            GroundJoint::Pin => about(still, still, last.centre - last.outer, k3, k3_second),
            GroundJoint::Guide => about(w * k3, w * k3_second, still, zero, zero),
        };
        Ok([
            about(still, still, crank.centre - crank.inner, one, zero),
            about(pin, -a, coupler.centre - coupler.inner, k2, k2_second),
            third,
        ])
    }

    /// `V = -sum_i m_i g . r_i`, J, zero for masses at the crank's pivot.
    #[must_use]
    pub fn potential_energy(&self, gravity: &Vector2<S>) -> S {
        self.links.iter().fold(S::zero(), |sum, link| sum - link.mass * dot(gravity, &link.centre))
    }
}

/// Square of the sine of an angle between links, below which the sine is only rounding error: near a dead point it is
/// the square root of a difference of lengths, so half of its digits are gone.
fn dead_sine_squared<S: Real>() -> S {
    rounding(64)
}
