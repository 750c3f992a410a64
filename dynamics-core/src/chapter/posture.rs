//! The chapter's description of an arm: axes, points, mass centres and motion of every link in the base frame.
//!
//! The recursion of [`crate::newton_euler`] never forms these quantities, because it has cheaper methods. The methods of the
//! book need them: per-link equations in the base frame, Jacobians, statics. Correspondence with the chapter, where
//! `B_{i-1}` carries joint `i`:
//!
//! | chapter | here |
//! |---|---|
//! | `k_{i-1}`, axis of joint `i` | `links[i - 1].axis` |
//! | `d_{i-1}`, its origin | `links[i - 1].origin`; for a prismatic joint the point on link `i` that slides along |
//! | `d_i`, where the next link begins | [`Posture::end`] of `i - 1` |
//! | `r_i`, mass centre | `links[i - 1].centre` |
//! | `n_i`, `m_i` (eq. 12.7-12.8) | [`Posture::inner_arm`], [`Posture::outer_arm`] |
//! | `0I_i = 0R_i iI_i 0R_i^T` (eq. 12.227) | `links[i - 1].inertia` |

use crate::geometry::{apply, compose};
use crate::inertia::{Inertia, cast_matrix, cast_vector};
use crate::joint::JointKind;
use crate::kinematics::link_poses;
use crate::model::{Model, Placement};
use crate::scalar::Scalar;
use crate::trig::SinCos;
use nalgebra::{Matrix3, Vector3};

/// A body by its mass centre, in the frame of its link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CentredBody<S> {
    /// Mass, kg.
    pub mass: S,
    /// Mass centre, m; the origin for a body without mass.
    pub centre: Vector3<S>,
    /// Inertia tensor about the mass centre, kg m^2.
    pub inertia: Matrix3<S>,
}

impl CentredBody<f64> {
    /// `c = h / m`, `I_C = J - m (c.c 1 - c c^T)`.
    #[must_use]
    pub fn of(body: &Inertia<f64>) -> Self {
        if body.mass == 0.0 {
            return Self { mass: 0.0, centre: Vector3::zeros(), inertia: body.about_origin };
        }
        let centre = body.first_moment / body.mass;
        let moved = Inertia::from_mass_centre(body.mass, &centre, &Matrix3::zeros());
        Self { mass: body.mass, centre, inertia: body.about_origin - moved.about_origin }
    }
}

/// An arm with its bodies given by mass centres, as in the chapter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chain<S, const N: usize> {
    model: Model<S, N>,
    bodies: [CentredBody<S>; N],
}

impl<S: Scalar, const N: usize> Chain<S, N> {
    /// Converts the bodies to mass centres, once. `payload` is in the tip frame, [`Inertia::zero`] for none.
    #[must_use]
    pub fn new(model: &Model<f64, N>, payload: &Inertia<f64>) -> Self {
        let held = payload.in_parent(&model.tip().rotation, &model.tip().translation);
        let bodies = core::array::from_fn(|i| {
            let own = model.links()[i].inertia;
            let body = CentredBody::of(&if i + 1 == N { own + held } else { own });
            CentredBody {
                mass: S::literal(body.mass),
                centre: cast_vector(&body.centre),
                inertia: cast_matrix(&body.inertia),
            }
        });
        Self { model: model.cast(), bodies }
    }

    /// The arm.
    #[must_use]
    pub const fn model(&self) -> &Model<S, N> {
        &self.model
    }

    /// Its bodies, in their links' frames.
    #[must_use]
    pub const fn bodies(&self) -> &[CentredBody<S>; N] {
        &self.bodies
    }

    /// Poses and bodies of all links in the base frame. Inputs as [`crate::InverseDynamics::inverse_dynamics`].
    #[must_use]
    pub fn posture(&self, turn: &[SinCos<S>; N], q: &[S; N]) -> Posture<S, N> {
        let poses = link_poses(&self.model, turn, q);
        let links = core::array::from_fn(|i| {
            let (pose, body) = (&poses[i], &self.bodies[i]);
            LinkPosture {
                kind: self.model.links()[i].kind,
                axis: pose.rotation.column(2).into(),
                origin: pose.translation,
                rotation: pose.rotation,
                mass: body.mass,
                centre: pose.translation + apply(&pose.rotation, &body.centre),
                inertia: compose(&compose(&pose.rotation, &body.inertia), &pose.rotation.transpose()),
            }
        });
        let (last, tip) = (&poses[N - 1], self.model.tip());
        let tip = Placement {
            rotation: compose(&last.rotation, &tip.rotation),
            translation: last.translation + apply(&last.rotation, &tip.translation),
        };
        Posture { links, tip }
    }
}

/// One link in the base frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinkPosture<S> {
    /// Turns or slides.
    pub kind: JointKind,
    /// Unit vector along the link's own joint.
    pub axis: Vector3<S>,
    /// The link's origin, on the axis of its joint, m.
    pub origin: Vector3<S>,
    /// `base_from_link`.
    pub rotation: Matrix3<S>,
    /// Mass, kg.
    pub mass: S,
    /// Mass centre, m.
    pub centre: Vector3<S>,
    /// Inertia tensor about the mass centre, in base axes, kg m^2.
    pub inertia: Matrix3<S>,
}

/// All links in the base frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Posture<S, const N: usize> {
    /// Base first.
    pub links: [LinkPosture<S>; N],
    /// `base_from_tip`.
    pub tip: Placement<S>,
}

/// Motion of one link, in the base frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseFrameMotion<S> {
    /// Angular velocity, rad/s.
    pub omega: Vector3<S>,
    /// Angular acceleration, rad/s^2.
    pub alpha: Vector3<S>,
    /// Velocity of the mass centre, m/s.
    pub velocity: Vector3<S>,
    /// Acceleration of the mass centre, m/s^2; gravity is not in it.
    pub acceleration: Vector3<S>,
}

impl<S: Scalar, const N: usize> Posture<S, N> {
    /// `d_i`: where link `i` (counted from 0) ends, the origin of the next link or the tip, m.
    #[must_use]
    pub fn end(&self, i: usize) -> Vector3<S> {
        self.links.get(i + 1).map_or(self.tip.translation, |next| next.origin)
    }

    /// `n_i = d_{i-1} - r_i`, from the mass centre to the link's own joint, m (eq. 12.7).
    #[must_use]
    pub fn inner_arm(&self, i: usize) -> Vector3<S> {
        self.links[i].origin - self.links[i].centre
    }

    /// `m_i = d_i - r_i`, from the mass centre to where the link ends, m (eq. 12.8).
    #[must_use]
    pub fn outer_arm(&self, i: usize) -> Vector3<S> {
        self.end(i) - self.links[i].centre
    }

    /// Velocities and accelerations of all links (eq. 12.507-12.508, with those of the origins, which the chapter
    /// leaves out).
    ///
    /// Revolute: `omega_i = omega + qd k`, `alpha_i = alpha + qdd k + omega x qd k`. Prismatic: both stay, and the origin gains
    /// `qd k` in velocity and `qdd k + 2 omega x qd k` in acceleration. A point at `s` from the origin has
    /// `v + omega x s` and `a + alpha x s + omega x (omega x s)`.
    #[must_use]
    pub fn motion(&self, qd: &[S; N], qdd: &[S; N]) -> [BaseFrameMotion<S>; N] {
        let zero = Vector3::zeros();
        let (mut omega, mut alpha, mut velocity, mut acceleration, mut origin) = (zero, zero, zero, zero, zero);
        core::array::from_fn(|i| {
            let link = &self.links[i];
            let step = link.origin - origin;
            velocity += omega.cross(&step);
            acceleration += alpha.cross(&step) + omega.cross(&omega.cross(&step));
            origin = link.origin;
            let (speed, start) = (link.axis * qd[i], link.axis * qdd[i]);
            let across = omega.cross(&speed);
            match link.kind {
                JointKind::Revolute => {
                    alpha += start + across;
                    omega += speed;
                }
                JointKind::Prismatic => {
                    velocity += speed;
                    acceleration += start + across + across;
                }
            }
            let arm = link.centre - origin;
            BaseFrameMotion {
                omega,
                alpha,
                velocity: velocity + omega.cross(&arm),
                acceleration: acceleration + alpha.cross(&arm) + omega.cross(&omega.cross(&arm)),
            }
        })
    }
}
