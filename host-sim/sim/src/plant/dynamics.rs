//! The arm's equations of motion, by moving bodies in base axes.
//!
//! The simulation must not repeat the controller's mistakes, so nothing here shares a line with the controller's
//! recursion: every vector is in base axes, every body is described by its mass centre and its inertia about it, and
//! weight is a force. With `d` from one joint's origin to the next, `r` from a joint's origin to a mass centre, and `z`
//! the axes:
//!
//! ```text
//! w_i = w + z qd,  alpha_i = alpha + w x z qd,  a_i = a + alpha x d + w x (w x d)      outward, at qdd = 0
//! F = m (a + alpha x r + w x (w x r)),  M = I alpha + w x I w + r x F                  of each body (Euler's laws)
//! ```
//!
//! (a prismatic joint adds `2 w x z qd` to `a` and nothing to the others). Inward, sums over all bodies beyond a joint
//! are moved from origin to origin: mass, first moment `h` and inertia `J` about the origin, `F` and `M`. Then
//!
//! ```text
//! D_ij = z_i . (load of J and h under a unit acceleration about z_j, moved to i), i <= j;  rotors on the diagonal
//! h_i  = z_i . M,   G_i = -z_i . (h x g)          (prismatic joint: forces instead of moments)
//! D qdd = drive - friction + tip - h - G
//! ```
//!
//! The source is generic in its scalar and has no data-dependent branch, so that it can be traced.

pub use super::factors::{HeldSolution, Solution};
use super::factors::{solve, solve_held};
use super::kinematics::{Chain, Pose, Solid};
use super::rotor_coupling;
pub use super::terms::Terms;
use dynamics_core::trig::Polynomial;
use dynamics_core::{Body, Field, JointKind, JointSpec, Scalar, SinCos, Tool, Trig, Wrench};
use nalgebra::{Matrix3, SMatrix, Vector3};

/// The simulated arm and all its loads, as opposed to the controller's model of them.
#[derive(Clone, Debug)]
pub struct Arm<const N: usize> {
    /// Joints and links, base first.
    pub joints: [JointSpec; N],
    /// Tool on the last link.
    pub tool: Tool,
    /// A body held at the tip, in the tip frame.
    pub payload: Option<Body>,
    /// Gravitational acceleration in the base frame, m/s^2.
    pub gravity: Vector3<f64>,
    /// Wrench of the environment on the arm at the tip's origin, in tip axes.
    pub tip_wrench: Option<Wrench<f64>>,
}

/// An arm prepared for simulation: all constants are computed once.
#[derive(Clone, Debug)]
pub struct Mechanism<const N: usize, S = f64> {
    chain: Chain<S, N>,
    gravity: Vector3<S>,
    tip_wrench: Option<Wrench<S>>,
    /// Gear ratio times rotor inertia of each joint, if their coupling acts.
    rotor_coupling: Option<[S; N]>,
}

impl<const N: usize> Arm<N> {
    /// The arm prepared for simulation.
    #[must_use]
    pub fn mechanism(&self) -> Mechanism<N> {
        Mechanism {
            chain: Chain::new(&self.joints, &self.tool, self.payload.as_ref()),
            gravity: self.gravity,
            tip_wrench: self.tip_wrench,
            rotor_coupling: None,
        }
    }

    /// Every term of the equations of motion at a state.
    #[must_use]
    pub fn terms(&self, q: &[f64; N], qd: &[f64; N]) -> Terms<N> {
        self.mechanism().terms(&Polynomial.sin_cos_all(q), q, qd)
    }

    /// Joint accelerations under joint torques `drive`; `None` if the inertia matrix is not positive definite.
    #[must_use]
    pub fn acceleration(&self, q: &[f64; N], qd: &[f64; N], drive: &[f64; N]) -> Option<[f64; N]> {
        self.mechanism().acceleration(q, qd, drive)
    }

    /// Pose of the tip in the base frame: rotation and origin (m).
    #[must_use]
    pub fn tip_pose(&self, q: &[f64; N]) -> (Matrix3<f64>, Vector3<f64>) {
        let chain = self.mechanism().chain;
        let tip = chain.places(&Polynomial.sin_cos_all(q), q)[N - 1].then(&chain.tip);
        (tip.rotation, tip.origin)
    }

    /// `1/2 qd^T D qd`, J.
    #[must_use]
    pub fn kinetic(&self, q: &[f64; N], qd: &[f64; N]) -> f64 {
        let qd = nalgebra::SVector::<f64, N>::from(*qd);
        0.5 * qd.dot(&(self.terms(q, &qd.into()).mass_matrix * qd))
    }

    /// `-sum m g.c`, J; zero for masses at the base origin.
    #[must_use]
    pub fn potential(&self, q: &[f64; N]) -> f64 {
        let chain = self.mechanism().chain;
        let places = chain.places(&Polynomial.sin_cos_all(q), q);
        let bodies = chain.joints.iter().zip(&places).flat_map(|(joint, place)| {
            joint.bodies.iter().map(|body| -body.mass * self.gravity.dot(&place.at(&body.com)))
        });
        bodies.sum()
    }
}

impl<const N: usize> Mechanism<N> {
    /// The same arm under another wrench, with every other number through `f`, always in the same order.
    pub(super) fn map<S: Scalar>(&self, mut f: impl FnMut(f64) -> S, tip_wrench: Option<Wrench<S>>) -> Mechanism<N, S> {
        Mechanism {
            chain: self.chain.map(&mut f),
            gravity: self.gravity.map(&mut f),
            tip_wrench,
            rotor_coupling: self.rotor_coupling.map(|coupling| coupling.map(f)),
        }
    }

    /// The same arm in another scalar.
    #[must_use]
    pub fn cast<S: Scalar>(&self) -> Mechanism<N, S> {
        let literal = |v: Vector3<f64>| v.map(S::literal);
        let wrench = self.tip_wrench.map(|it| Wrench { force: literal(it.force), moment: literal(it.moment) });
        self.map(S::literal, wrench)
    }

    /// Kind of each joint, with the number of bodies that it moves.
    pub(super) fn joints(&self) -> [(JointKind, usize); N] {
        self.chain.joints.each_ref().map(|joint| (joint.kind, joint.bodies.len()))
    }

    /// Wrench of the environment on the tip.
    pub(crate) fn tip_wrench(&self) -> Option<Wrench<f64>> {
        self.tip_wrench
    }

    /// True if the coupling of the rotors' spin acts.
    pub(super) fn has_rotor_coupling(&self) -> bool {
        self.rotor_coupling.is_some()
    }

    /// Set the wrench of the environment on the tip.
    pub(super) fn push(&mut self, wrench: Option<Wrench<f64>>) {
        self.tip_wrench = wrench;
    }

    /// The same arm, with the coupling of its rotors' spin with the links that carry them.
    #[must_use]
    pub fn with_rotor_coupling(self, joints: &[JointSpec; N]) -> Self {
        Self { rotor_coupling: Some(rotor_coupling::gear_times_inertia(joints)), ..self }
    }

    /// Remove the rotors from the arm. Returns their reflected inertias, kg m^2 or kg.
    pub(super) fn take_rotors(&mut self) -> [f64; N] {
        self.chain.joints.each_mut().map(|joint| core::mem::take(&mut joint.rotor))
    }

    /// Joint accelerations under joint torques `drive`; `None` if the inertia matrix is not positive definite, or a
    /// position is beyond [`Polynomial::LIMIT_F64`].
    #[must_use]
    pub fn acceleration(&self, q: &[f64; N], qd: &[f64; N], drive: &[f64; N]) -> Option<[f64; N]> {
        let Solution { qdd, pivot } = self.solution(&Polynomial.sin_cos_all(q), q, qd, drive);
        definite(&pivot).then_some(qdd)
    }

    /// As [`Mechanism::acceleration`], with the joints held for which `free` is zero. The second list has the torques on the held joints.
    #[must_use]
    pub fn acceleration_held(
        &self,
        (q, qd): (&[f64; N], &[f64; N]),
        drive: &[f64; N],
        free: &[f64; N],
    ) -> Option<([f64; N], [f64; N])> {
        let found = self.solution_held(&Polynomial.sin_cos_all(q), (q, qd), drive, free);
        definite(&found.pivot).then_some((found.qdd, found.load))
    }

    /// Torques `J^T w` of the wrench at the tip, N m or N; `None` without a wrench.
    #[must_use]
    pub fn contact(&self, q: &[f64; N]) -> Option<[f64; N]> {
        self.tip_wrench.map(|_| self.terms(&Polynomial.sin_cos_all(q), q, &[0.0; N]).tip)
    }
}

/// True if all pivots are those of a positive definite matrix.
fn definite<const N: usize>(pivot: &[f64; N]) -> bool {
    pivot.iter().all(|&pivot| pivot > 0.0 && pivot.is_finite())
}

impl<S: Field, const N: usize> Mechanism<N, S> {
    /// As [`Mechanism::acceleration`]; returns the pivots and does not judge them.
    #[must_use]
    pub fn solution(&self, turn: &[SinCos<S>; N], q: &[S; N], qd: &[S; N], drive: &[S; N]) -> Solution<S, N> {
        let (matrix, rest) = self.equations(turn, q, qd, drive);
        solve(&matrix, &rest)
    }

    /// As [`Mechanism::solution`], with the joints held for which `free` is zero; it is one for the others.
    #[must_use]
    pub fn solution_held(
        &self,
        turn: &[SinCos<S>; N],
        (q, qd): (&[S; N], &[S; N]),
        drive: &[S; N],
        free: &[S; N],
    ) -> HeldSolution<S, N> {
        let (matrix, rest) = self.equations(turn, q, qd, drive);
        solve_held(&matrix, &rest, free)
    }

    /// Inertia matrix, and the torques that accelerate it.
    fn equations(&self, turn: &[SinCos<S>; N], q: &[S; N], qd: &[S; N], drive: &[S; N]) -> (SMatrix<S, N, N>, [S; N]) {
        let terms = self.terms(turn, q, qd);
        let rest = core::array::from_fn(|i| drive[i] + terms.tip[i] - terms.coriolis[i] - terms.gravity[i]);
        (terms.mass_matrix, rest)
    }
}

impl<S: Scalar, const N: usize> Mechanism<N, S> {
    /// Every term of the equations of motion at a state.
    #[must_use]
    pub fn terms(&self, turn: &[SinCos<S>; N], q: &[S; N], qd: &[S; N]) -> Terms<N, S> {
        let pose = self.chain.pose(turn, q);
        let gravity = self.gravity;
        let (bodies, loads) = self.outward(&pose, qd);
        let zero = [S::zero(); N];
        let mut terms =
            Terms { mass_matrix: SMatrix::zeros(), coriolis: zero, gravity: zero, tip: self.tip_torques(&pose) };
        let (mut beyond, mut load) = (bodies[N - 1], loads[N - 1]);
        for j in (0..N).rev() {
            if j + 1 < N {
                beyond = bodies[j].and(&beyond.moved(&pose[j + 1].offset));
                load = loads[j].and(&load.moved(&pose[j + 1].offset));
            }
            terms.coriolis[j] = load.along(&pose[j]);
            let weight = Load { force: gravity * beyond.mass, moment: beyond.first_moment.cross(&gravity) };
            terms.gravity[j] = -weight.along(&pose[j]);
            let mut taken = beyond.taken(&pose[j]);
            for i in (0..=j).rev() {
                let along = taken.along(&pose[i]);
                terms.mass_matrix[(i, j)] = along;
                terms.mass_matrix[(j, i)] = along;
                if i > 0 {
                    taken = taken.moved(&pose[i].offset);
                }
            }
            terms.mass_matrix[(j, j)] += self.chain.joints[j].rotor;
        }
        if let Some(coupling) = &self.rotor_coupling {
            rotor_coupling::add(&mut terms, &pose, qd, coupling);
        }
        terms
    }

    /// Own bodies of each joint, and the load of their motion at `qdd = 0`; both about the joint's origin.
    fn outward(&self, pose: &[Pose<S>; N], qd: &[S; N]) -> ([Bodies<S>; N], [Load<S>; N]) {
        let mut bodies = [Bodies::none(); N];
        let mut loads = [Load::none(); N];
        let mut motion = Motion { w: Vector3::zeros(), alpha: Vector3::zeros(), a: Vector3::zeros() };
        for i in 0..N {
            motion = motion.next(&pose[i], qd[i]);
            for body in &self.chain.joints[i].bodies {
                let body = Turned::new(body, &pose[i].rotation);
                bodies[i] = bodies[i].and(&body.about_origin());
                loads[i] = loads[i].and(&body.load(&motion));
            }
        }
        (bodies, loads)
    }

    fn tip_torques(&self, pose: &[Pose<S>; N]) -> [S; N] {
        let mut torques = [S::zero(); N];
        let Some(wrench) = &self.tip_wrench else {
            return torques;
        };
        #[cfg(test)]
        super::calls::count(super::calls::Effect::TipWrench);
        let rotation = pose[N - 1].rotation;
        let tip = &self.chain.tip;
        let in_base = |v: &Vector3<S>| rotation * (tip.rotation * v);
        let force = in_base(&wrench.force);
        let mut load = Load { force, moment: in_base(&wrench.moment) + (rotation * tip.origin).cross(&force) };
        for i in (0..N).rev() {
            torques[i] = load.along(&pose[i]);
            load = load.moved(&pose[i].offset);
        }
        torques
    }
}

/// Angular velocity and acceleration of a link, and the acceleration of its joint's origin, at `qdd = 0`.
#[derive(Clone, Copy)]
struct Motion<S> {
    w: Vector3<S>,
    alpha: Vector3<S>,
    a: Vector3<S>,
}

impl<S: Scalar> Motion<S> {
    /// Motion of the link beyond the next joint.
    fn next(&self, pose: &Pose<S>, qd: S) -> Self {
        let own = pose.axis * qd;
        let across = self.w.cross(&own);
        let a = self.at(&pose.offset);
        match pose.kind {
            JointKind::Revolute => Self { w: self.w + own, alpha: self.alpha + across, a },
            JointKind::Prismatic => Self { a: a + across + across, ..*self },
        }
    }

    /// Acceleration of a point on the link.
    fn at(&self, point: &Vector3<S>) -> Vector3<S> {
        self.a + self.alpha.cross(point) + self.w.cross(&self.w.cross(point))
    }
}

/// A body in base axes, about its own mass centre.
struct Turned<S> {
    mass: S,
    /// From the joint's origin to the mass centre.
    centre: Vector3<S>,
    inertia: Symmetric<S>,
}

impl<S: Scalar> Turned<S> {
    fn new(body: &Solid<S>, rotation: &Matrix3<S>) -> Self {
        Self { mass: body.mass, centre: rotation * body.com, inertia: Symmetric::turned(rotation, &body.inertia) }
    }

    /// `J = I + m (r.r 1 - r r^T)`.
    fn about_origin(&self) -> Bodies<S> {
        let first_moment = self.centre * self.mass;
        let along = first_moment.component_mul(&self.centre);
        let across = first_moment.component_mul(&next(&self.centre));
        Bodies { mass: self.mass, first_moment, inertia: self.inertia.moved(&along, &across) }
    }

    fn load(&self, motion: &Motion<S>) -> Load<S> {
        let Motion { w, alpha, .. } = motion;
        let force = motion.at(&self.centre) * self.mass;
        let moment = self.inertia.times(alpha) + w.cross(&self.inertia.times(w)) + self.centre.cross(&force);
        Load { force, moment }
    }
}

/// Bodies that move as one, about a joint's origin.
#[derive(Clone, Copy)]
struct Bodies<S> {
    mass: S,
    first_moment: Vector3<S>,
    inertia: Symmetric<S>,
}

impl<S: Scalar> Bodies<S> {
    fn none() -> Self {
        let inertia = Symmetric { diagonal: Vector3::zeros(), beside: Vector3::zeros() };
        Self { mass: S::zero(), first_moment: Vector3::zeros(), inertia }
    }

    fn and(&self, other: &Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            first_moment: self.first_moment + other.first_moment,
            inertia: self.inertia.plus(&other.inertia),
        }
    }

    /// The same bodies about a point from which `d` leads here: `J + 2 (d.h) 1 - d h^T - h d^T + m (d.d 1 - d d^T)`.
    fn moved(&self, d: &Vector3<S>) -> Self {
        let h = self.first_moment;
        let moved = h + d * self.mass;
        let along = d.component_mul(&(h + moved));
        let across = d.component_mul(&next(&h)) + moved.component_mul(&next(d));
        Self { mass: self.mass, first_moment: moved, inertia: self.inertia.moved(&along, &across) }
    }

    /// Load of the bodies under a unit acceleration of a joint at the origin.
    fn taken(&self, pose: &Pose<S>) -> Load<S> {
        let (z, h) = (&pose.axis, &self.first_moment);
        match pose.kind {
            JointKind::Revolute => Load { force: z.cross(h), moment: self.inertia.times(z) },
            JointKind::Prismatic => Load { force: z * self.mass, moment: h.cross(z) },
        }
    }
}

/// A symmetric matrix: xx, yy, zz, and xy, yz, zx.
#[derive(Clone, Copy)]
struct Symmetric<S> {
    diagonal: Vector3<S>,
    beside: Vector3<S>,
}

impl<S: Scalar> Symmetric<S> {
    /// `R I R^T`, as the sum over the columns of `R I` and `R` of their outer products.
    fn turned(rotation: &Matrix3<S>, inertia: &Matrix3<S>) -> Self {
        let half = rotation * inertia;
        let outer = |k: usize| {
            let (h, r) = (half.column(k).into_owned(), rotation.column(k).into_owned());
            Self { diagonal: h.component_mul(&r), beside: h.component_mul(&next(&r)) }
        };
        outer(0).plus(&outer(1)).plus(&outer(2))
    }

    fn plus(&self, other: &Self) -> Self {
        Self { diagonal: self.diagonal + other.diagonal, beside: self.beside + other.beside }
    }

    /// The matrix plus `(along.x + along.y + along.z) 1 - diag(along)`, and less `across` beside the diagonal.
    fn moved(&self, along: &Vector3<S>, across: &Vector3<S>) -> Self {
        let whole = Vector3::repeat(along.x + along.y + along.z);
        Self { diagonal: self.diagonal + (whole - along), beside: self.beside - across }
    }

    fn times(&self, v: &Vector3<S>) -> Vector3<S> {
        let back = Vector3::new(self.beside.z, self.beside.x, self.beside.y);
        let before = Vector3::new(v.z, v.x, v.y);
        self.diagonal.component_mul(v) + self.beside.component_mul(&next(v)) + back.component_mul(&before)
    }
}

/// `(y, z, x)`.
fn next<S: Scalar>(v: &Vector3<S>) -> Vector3<S> {
    Vector3::new(v.y, v.z, v.x)
}

/// A force, and a moment about a joint's origin.
#[derive(Clone, Copy)]
struct Load<S> {
    force: Vector3<S>,
    moment: Vector3<S>,
}

impl<S: Scalar> Load<S> {
    fn none() -> Self {
        Self { force: Vector3::zeros(), moment: Vector3::zeros() }
    }

    fn and(&self, other: &Self) -> Self {
        Self { force: self.force + other.force, moment: self.moment + other.moment }
    }

    /// The same load about a point from which `d` leads here.
    fn moved(&self, d: &Vector3<S>) -> Self {
        Self { force: self.force, moment: self.moment + d.cross(&self.force) }
    }

    /// Component of the load along or about the joint's axis.
    fn along(&self, pose: &Pose<S>) -> S {
        match pose.kind {
            JointKind::Revolute => pose.axis.dot(&self.moment),
            JointKind::Prismatic => pose.axis.dot(&self.force),
        }
    }
}
