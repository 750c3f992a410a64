//! Backward recursive Newton-Euler: joint torques and joint wrenches from the motion.
//!
//! Outward, from base to tip, each link's angular velocity, angular acceleration and the acceleration of its joint's
//! origin follow from its parent's (eq. 12.515-12.516, with the recursion of the origins that the chapter leaves out);
//! inward, from tip to base, the wrench that each joint carries (eq. 12.157-12.162) and its component along the joint
//! (eq. 12.212-12.213, with index `i - 1` where the chapter prints `i`).
//!
//! Three choices keep the work low. Each link's frame has its origin on the joint axis and z along it, so a joint's turn
//! is 4 multiplications and 2 additions a vector. The body is mass, first moment `h` and inertia `J` about that origin, so
//! nothing is moved to mass centres. Gravity enters as an acceleration `-g` of the base (a uniform field and an
//! accelerating base are indistinguishable). With `U = [alpha]x + [omega]x [omega]x`, shared by both uses:
//!
//! ```text
//! a_next = a + U p                    acceleration of a point p fixed to the link
//! F      = m a + U h                  force that the link's own motion needs
//! M      = J alpha + omega x (J omega) + h x a      its moment about the joint origin
//! ```
//!
//! A quantity that is zero by construction (no velocity terms, no gravity on the first link, no turning after prismatic
//! joints) is `None` and costs no arithmetic: the model and the scene decide this, never the data.

use crate::control::FrictionTerms;
use crate::geometry::{apply, apply_transposed};
use crate::inertia::{Inertia, Wrench};
use crate::joint::JointKind;
use crate::model::Link;
use crate::scalar::{Label, Scalar};
use crate::scene::{Dynamics, Live};
use crate::trig::SinCos;
use nalgebra::{Matrix3, Vector3};

/// Joint torques for a wanted motion. Implemented by [`Dynamics`] and by every generated kernel.
pub trait InverseDynamics<S, const N: usize> {
    /// Actuator torques (forces, for prismatic joints) that give the arm the accelerations `qdd`.
    ///
    /// `tau = D(q) qdd + C(q, qd) qd + G(q) - J^T w`    (chapter 12, eq. 12.157-12.162, 12.213 with the index corrected)
    ///
    /// | name | quantity | unit | shape |
    /// |---|---|---|---|
    /// | `turn` | sine and cosine of each joint (prismatic: not read) | - | N |
    /// | `q` | joint position (revolute: not read) | rad, m | N |
    /// | `qd` | joint velocity | rad/s, m/s | N |
    /// | `qdd` | joint acceleration | rad/s^2, m/s^2 | N |
    /// | `live` | the scene's live inputs | | |
    /// | return | actuator torque or force | N m, N | N |
    ///
    /// O(N); no branch on data, no division.
    fn inverse_dynamics(
        &self,
        turn: &[SinCos<S>; N],
        q: &[S; N],
        qd: &[S; N],
        qdd: &[S; N],
        live: &Live<S, N>,
    ) -> [S; N];

    /// Torques that hold the arm at rest: [`InverseDynamics::inverse_dynamics`] at zero velocity and acceleration. For gravity compensation.
    #[inline]
    fn gravity_torque(&self, turn: &[SinCos<S>; N], q: &[S; N], live: &Live<S, N>) -> [S; N]
    where
        S: Scalar,
    {
        let still = [S::zero(); N];
        self.inverse_dynamics(turn, q, &still, &still, live)
    }

    /// As [`InverseDynamics::inverse_dynamics`], called once in every tick of a controller. An implementation with
    /// memory updates it here.
    ///
    /// Sine and cosine are requested only if they are needed.
    #[inline]
    fn tick(
        &mut self,
        turn: impl FnOnce() -> [SinCos<S>; N],
        q: &[S; N],
        qd: &[S; N],
        qdd: &[S; N],
        live: &Live<S, N>,
    ) -> [S; N]
    where
        Self: Sized,
    {
        self.inverse_dynamics(&turn(), q, qd, qdd, live)
    }

    /// Clears the memory of [`InverseDynamics::tick`]: the next tick is the first.
    #[inline]
    fn forget(&mut self) {}

    /// Terms of each joint's friction in addition to viscous and Coulomb friction; `None` for none.
    ///
    /// In a firmware they are constants of the program: the controller of an arm without such terms contains no instruction for them.
    #[inline]
    fn friction_terms(&self) -> Option<&[FrictionTerms<S>; N]> {
        None
    }
}

impl<S: Scalar, const N: usize> InverseDynamics<S, N> for Dynamics<S, N> {
    fn inverse_dynamics(
        &self,
        turn: &[SinCos<S>; N],
        q: &[S; N],
        qd: &[S; N],
        qdd: &[S; N],
        live: &Live<S, N>,
    ) -> [S; N] {
        let wrench = joint_wrenches(self, turn, q, qd, qdd, live);
        let rotor = self.scene().rotor.value(&live.rotor);
        core::array::from_fn(|i| {
            let along = match self.model().links()[i].kind {
                JointKind::Revolute => wrench[i].moment.z,
                JointKind::Prismatic => wrench[i].force.z,
            };
            match rotor {
                Some(rotor) => along + rotor[i] * qdd[i],
                None => along,
            }
        })
    }
}

/// The whole wrench that each joint carries: the wrench of link `i - 1` on link `i`.
///
/// The chapter's `F_{i-1}`, `M_{i-1}` (eq. 12.157-12.158 with the external moment about the mass centre), without the
/// reflected rotor inertia, which acts between motor and link. Inputs as [`InverseDynamics::inverse_dynamics`].
///
/// | return | quantity | unit | frame |
/// |---|---|---|---|
/// | `[i].force` | force on link `i` | N | link `i` (z along the joint) |
/// | `[i].moment` | moment on link `i` about the joint's origin | N m | link `i` |
///
/// O(N); no branch on data, no division.
pub fn joint_wrenches<S: Scalar, const N: usize>(
    dynamics: &Dynamics<S, N>,
    turn: &[SinCos<S>; N],
    q: &[S; N],
    qd: &[S; N],
    qdd: &[S; N],
    live: &Live<S, N>,
) -> [Wrench<S>; N] {
    let links = dynamics.model().links();
    let scene = dynamics.scene();
    let velocity = scene.coriolis.value(qd);

    let mut wrench = [Wrench::zero(); N];
    let mut motion = LinkMotion::new(None, None, scene.gravity.value(&live.gravity).map(|g| -g));
    for i in 0..N {
        let joint = JointMotion { turn: turn[i], q: q[i], qd: velocity.map(|v| v[i]), qdd: qdd[i] };
        motion = motion.next(&links[i], &joint).labelled(i + 1);
        wrench[i] = motion.wrench_of(&dynamics.inertia(i, live));
    }

    if let Some(contact) = scene.tip_wrench.value(&live.tip_wrench) {
        let tip = dynamics.model().tip();
        wrench[N - 1] = wrench[N - 1] - contact.in_parent(&tip.rotation, &tip.translation);
    }
    for i in (1..N).rev() {
        let carried = wrench[i - 1] + to_parent(&links[i], turn[i], q[i], &wrench[i]);
        wrench[i - 1] =
            Wrench { force: Label::vector("f", i, carried.force), moment: Label::vector("n", i, carried.moment) };
    }
    wrench
}

/// A joint's own motion; `qd` is `None` if the scene has no velocity terms.
pub(crate) struct JointMotion<S> {
    pub(crate) turn: SinCos<S>,
    pub(crate) q: S,
    pub(crate) qd: Option<S>,
    pub(crate) qdd: S,
}

/// Motion of a link in its own frame; a field that is `None` is zero by construction.
pub(crate) struct LinkMotion<S> {
    /// Angular velocity, rad/s.
    omega: Option<Vector3<S>>,
    /// Angular acceleration, rad/s^2.
    alpha: Option<Vector3<S>>,
    /// Acceleration of the frame's origin, less gravity, m/s^2.
    a: Option<Vector3<S>>,
    /// `U`, 1/s^2.
    spin: Option<Spin<S>>,
}

impl<S: Scalar> LinkMotion<S> {
    #[inline]
    pub(crate) fn new(omega: Option<Vector3<S>>, alpha: Option<Vector3<S>>, a: Option<Vector3<S>>) -> Self {
        Self { omega, alpha, a, spin: Spin::new(omega.as_ref(), alpha.as_ref()) }
    }

    /// The motion of the link after this one (eq. 12.515-12.516).
    ///
    /// Revolute: `omega' = R^T omega + qd z`, `alpha' = R^T alpha + qdd z + R^T omega x qd z`, `a' = R^T (a + U p)`.
    /// Prismatic: `omega' = R^T omega`, `alpha' = R^T alpha`, `a' = R^T (a + U p) + U' (0, 0, q) + 2 omega' x qd z + qdd z`.
    #[inline]
    pub(crate) fn next(&self, link: &Link<S>, joint: &JointMotion<S>) -> Self {
        let into = |v: Vector3<S>| into_link(link, joint.turn, &v);
        let omega = self.omega.map(into);
        let alpha = self.alpha.map(into);
        let a = sum(self.a, self.spin.as_ref().map(|u| u.apply(&link.translation))).map(into);
        let z = |x: S| Vector3::new(S::zero(), S::zero(), x);
        match link.kind {
            JointKind::Revolute => {
                let turned = match (omega, joint.qd) {
                    (Some(w), Some(qd)) => Some(Vector3::new(w.x, w.y, w.z + qd)),
                    (None, Some(qd)) => Some(z(qd)),
                    (w, None) => w,
                };
                Self::new(turned, Some(turning_acceleration(omega, alpha, joint.qd, joint.qdd)), a)
            }
            JointKind::Prismatic => {
                let here = Self::new(omega, alpha, None);
                let sliding = here.spin.as_ref().map(|u| u.column_z() * joint.q);
                let a = sum(a, sliding);
                let a = match (omega, joint.qd) {
                    (Some(w), Some(qd)) => {
                        let twice = qd + qd;
                        sum(a, Some(Vector3::new(w.y * twice, -(w.x * twice), S::zero())))
                    }
                    _ => a,
                };
                let a = a.map_or_else(|| z(joint.qdd), |a| Vector3::new(a.x, a.y, a.z + joint.qdd));
                Self { a: Some(a), ..here }
            }
        }
    }

    /// The same, with every component labelled for a scalar that records its operations: `w`, `al` and `a` of link
    /// `link`.
    #[inline]
    fn labelled(self, link: usize) -> Self {
        Self {
            omega: self.omega.map(|w| Label::vector("w", link, w)),
            alpha: self.alpha.map(|al| Label::vector("al", link, al)),
            a: self.a.map(|a| Label::vector("a", link, a)),
            ..self
        }
    }

    /// Wrench about the frame's origin that gives a body on this link its motion.
    ///
    /// `F = m a + U h`, `M = J alpha + omega x (J omega) + h x a` (eq. 12.157-12.158 about the origin instead of the mass centre).
    #[inline]
    pub(crate) fn wrench_of(&self, body: &Inertia<S>) -> Wrench<S> {
        let h = &body.first_moment;
        let force = sum(self.a.map(|a| a * body.mass), self.spin.as_ref().map(|u| u.apply(h)));
        let moment = sum(self.moment_of_turning(&body.about_origin), self.a.map(|a| h.cross(&a)));
        Wrench { force: force.unwrap_or_else(Vector3::zeros), moment: moment.unwrap_or_else(Vector3::zeros) }
    }

    /// `J alpha + omega x (J omega)`, written with the entries of `U` and the products in them, which other links' origins and
    /// the force need anyway: 15 multiplications instead of 24, and two an axis if `J` is diagonal.
    #[inline]
    fn moment_of_turning(&self, j: &Matrix3<S>) -> Option<Vector3<S>> {
        let (Spin::Starting(al) | Spin::Turning { alpha: al, .. }) = self.spin.as_ref()?;
        let Some(Spin::Turning { u, xy, xz, yz, .. }) = self.spin.as_ref() else {
            return Some(moment_of_starting(j, al));
        };
        // Each product of inertia is multiplied by an entry of U, or by a difference of two: `u22 - u33 = wy^2 - wz^2`.
        Some(Vector3::new(
            j.m11 * al.x + (j.m33 - j.m22) * *yz - j.m12 * u.m31 + j.m13 * u.m21 + j.m23 * (u.m22 - u.m33),
            j.m22 * al.y + (j.m11 - j.m33) * *xz - j.m23 * u.m12 + j.m12 * u.m32 + j.m13 * (u.m33 - u.m11),
            j.m33 * al.z + (j.m22 - j.m11) * *xy - j.m13 * u.m23 + j.m23 * u.m13 + j.m12 * (u.m11 - u.m22),
        ))
    }
}

/// `J alpha`, summed in the order of [`LinkMotion::moment_of_turning`]: a scene without velocity terms and one with velocities of
/// zero give the same bits.
#[inline]
fn moment_of_starting<S: Scalar>(j: &Matrix3<S>, al: &Vector3<S>) -> Vector3<S> {
    Vector3::new(
        j.m11 * al.x + j.m12 * al.y + j.m13 * al.z,
        j.m22 * al.y + j.m23 * al.z + j.m12 * al.x,
        j.m33 * al.z + j.m13 * al.x + j.m23 * al.y,
    )
}

/// Acceleration of points fixed to a turning link.
enum Spin<S> {
    /// No angular velocity: `alpha x p`.
    Starting(Vector3<S>),
    /// Both: `U p`.
    Turning {
        /// Angular acceleration, rad/s^2.
        alpha: Vector3<S>,
        /// `U = [alpha]x + [omega]x [omega]x`, 1/s^2.
        u: Matrix3<S>,
        /// `omega_x omega_y`, 1/s^2.
        xy: S,
        /// `omega_x omega_z`, 1/s^2.
        xz: S,
        /// `omega_y omega_z`, 1/s^2.
        yz: S,
    },
}

impl<S: Scalar> Spin<S> {
    /// `U` as far as it is not zero: 6 multiplications, 9 additions, 3 negations.
    #[inline]
    fn new(omega: Option<&Vector3<S>>, alpha: Option<&Vector3<S>>) -> Option<Self> {
        let w = match (omega, alpha) {
            (Some(w), _) => w,
            (None, Some(alpha)) => return Some(Self::Starting(*alpha)),
            (None, None) => return None,
        };
        let al = alpha.copied().unwrap_or_else(Vector3::zeros);
        let (xx, yy, zz) = (w.x * w.x, w.y * w.y, w.z * w.z);
        let (xy, xz, yz) = (w.x * w.y, w.x * w.z, w.y * w.z);
        let u = Matrix3::new(
            -(yy + zz),
            xy - al.z,
            xz + al.y,
            xy + al.z,
            -(xx + zz),
            yz - al.x,
            xz - al.y,
            yz + al.x,
            -(xx + yy),
        );
        Some(Self::Turning { alpha: al, u, xy, xz, yz })
    }

    #[inline]
    fn apply(&self, p: &Vector3<S>) -> Vector3<S> {
        match self {
            Self::Starting(alpha) => alpha.cross(p),
            Self::Turning { u, .. } => apply(u, p),
        }
    }

    /// `U z`.
    #[inline]
    fn column_z(&self) -> Vector3<S> {
        match self {
            Self::Starting(alpha) => Vector3::new(alpha.y, -alpha.x, S::zero()),
            Self::Turning { u, .. } => Vector3::new(u.m13, u.m23, u.m33),
        }
    }
}

/// `R^T alpha + qdd z + R^T omega x qd z`, with the parent's vectors already in this frame.
#[inline]
fn turning_acceleration<S: Scalar>(
    omega: Option<Vector3<S>>,
    alpha: Option<Vector3<S>>,
    qd: Option<S>,
    qdd: S,
) -> Vector3<S> {
    let alpha =
        alpha.map_or_else(|| Vector3::new(S::zero(), S::zero(), qdd), |al| Vector3::new(al.x, al.y, al.z + qdd));
    match (omega, qd) {
        (Some(w), Some(qd)) => Vector3::new(alpha.x + w.y * qd, alpha.y - w.x * qd, alpha.z),
        _ => alpha,
    }
}

/// A vector of the parent's frame in this link's frame: `Rz(q)^T R^T v`.
#[inline]
pub(crate) fn into_link<S: Scalar>(link: &Link<S>, turn: SinCos<S>, v: &Vector3<S>) -> Vector3<S> {
    let v = apply_transposed(&link.rotation, v);
    match link.kind {
        JointKind::Revolute => {
            let SinCos { sin, cos } = turn;
            Vector3::new(cos * v.x + sin * v.y, cos * v.y - sin * v.x, v.z)
        }
        JointKind::Prismatic => v,
    }
}

/// A vector of this link's frame in the parent's frame: `R Rz(q) v`.
#[inline]
pub(crate) fn out_of_link<S: Scalar>(link: &Link<S>, turn: SinCos<S>, v: &Vector3<S>) -> Vector3<S> {
    let v = match link.kind {
        JointKind::Revolute => {
            let SinCos { sin, cos } = turn;
            Vector3::new(cos * v.x - sin * v.y, cos * v.y + sin * v.x, v.z)
        }
        JointKind::Prismatic => *v,
    };
    apply(&link.rotation, &v)
}

/// Moves a wrench about this link's origin to the parent's origin and axes (eq. 12.161-12.162).
#[inline]
pub(crate) fn to_parent<S: Scalar>(link: &Link<S>, turn: SinCos<S>, q: S, wrench: &Wrench<S>) -> Wrench<S> {
    let moment = match link.kind {
        JointKind::Revolute => wrench.moment,
        // The origin has slid by (0, 0, q): its moment arm, before the constant placement.
        JointKind::Prismatic => {
            Vector3::new(wrench.moment.x - q * wrench.force.y, wrench.moment.y + q * wrench.force.x, wrench.moment.z)
        }
    };
    let force = out_of_link(link, turn, &wrench.force);
    Wrench { force, moment: out_of_link(link, turn, &moment) + link.translation.cross(&force) }
}

/// Moves a wrench about the parent's origin and in its axes to this link's origin and axes: the inverse of [`to_parent`]
/// (eq. 12.167-12.168 with `iT_{i+1}^{-1}`).
pub(crate) fn from_parent<S: Scalar>(link: &Link<S>, turn: SinCos<S>, q: S, wrench: &Wrench<S>) -> Wrench<S> {
    let force = into_link(link, turn, &wrench.force);
    let moment = into_link(link, turn, &(wrench.moment - link.translation.cross(&wrench.force)));
    let moment = match link.kind {
        JointKind::Revolute => moment,
        JointKind::Prismatic => Vector3::new(moment.x + q * force.y, moment.y - q * force.x, moment.z),
    };
    Wrench { force, moment }
}

/// Sum of the vectors that are not zero by construction.
#[inline]
fn sum<S: Scalar>(a: Option<Vector3<S>>, b: Option<Vector3<S>>) -> Option<Vector3<S>> {
    match (a, b) {
        (Some(a), Some(b)) => Some(a + b),
        (a, None) => a,
        (None, b) => b,
    }
}
