//! The arm's equations of motion, by moving bodies in base axes.
//!
//! The simulation must not repeat the controller's mistakes, so nothing here shares a line with the controller's recursion. Every vector is in base
//! axes. Every body is described by its mass centre and its inertia about it. Gravity is a force. With `d` from one joint's origin to the next, `r`
//! from a joint's origin to a mass centre, and `z` the axes:
//!
//! ```text
//! w_i = w + z qd,  alpha_i = alpha + w x z qd,  a_i = a + alpha x d + w x (w x d)      outward, at qdd = 0
//! F = m (a + alpha x r + w x (w x r)),  M = I alpha + w x I w + r x F                  of each body (Euler's laws)
//! ```
//!
//! A prismatic joint adds `2 w x z qd` to `a`, and nothing to the others. Inward, the sums over all bodies beyond a joint are moved from origin to
//! origin: mass, first moment `h` and inertia `J` about the origin, `F` and `M`. Then
//!
//! ```text
//! D_ij = z_i . (load of J and h under a unit acceleration about z_j, moved to i), i <= j;  rotors on the diagonal
//! h_i  = z_i . M,   G_i = -z_i . (h x g)          (prismatic joint: forces instead of moments)
//! D qdd = drive - friction + tip - h - G
//! ```
//!
//! The source is generic in its scalar and has no data-dependent branch, so it can be traced.

pub use super::factors::{HeldSolution, Solution};
use super::factors::{solve, solve_held};
use super::kinematics::{Chain, Pose};
use super::moving_bodies::{Bodies, Load, Motion, Turned};
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
    /// Gear ratio times rotor inertia of each joint, kg m^2 or kg m, if the rotor coupling acts.
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
    /// The same arm under another wrench, with every other number mapped by `f`, always in the same order.
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

    /// True if the coupling of the rotors' spin is included.
    pub(super) fn has_rotor_coupling(&self) -> bool {
        self.rotor_coupling.is_some()
    }

    /// Sets the wrench of the environment on the tip.
    pub(super) fn push(&mut self, wrench: Option<Wrench<f64>>) {
        self.tip_wrench = wrench;
    }

    /// The same arm, with the coupling between the spin of its rotors and the links that carry them.
    #[must_use]
    pub fn with_rotor_coupling(self, joints: &[JointSpec; N]) -> Self {
        Self { rotor_coupling: Some(rotor_coupling::gear_times_inertia(joints)), ..self }
    }

    /// Removes the rotors from the arm. Returns their reflected inertias, kg m^2 or kg.
    pub(super) fn take_rotors(&mut self) -> [f64; N] {
        self.chain.joints.each_mut().map(|joint| core::mem::take(&mut joint.rotor))
    }

    /// Joint accelerations under joint torques `drive`. `None` if the inertia matrix is not positive definite, or a position is beyond
    /// [`Polynomial::LIMIT_F64`].
    #[must_use]
    pub fn acceleration(&self, q: &[f64; N], qd: &[f64; N], drive: &[f64; N]) -> Option<[f64; N]> {
        let Solution { qdd, pivot } = self.solution(&Polynomial.sin_cos_all(q), q, qd, drive);
        definite(&pivot).then_some(qdd)
    }

    /// As [`Mechanism::acceleration`], with the joints held for which `free` is zero. Also returns the torques on the held joints, N m or N.
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
    /// As [`Mechanism::acceleration`], but returns the pivots without checking them.
    #[must_use]
    pub fn solution(&self, turn: &[SinCos<S>; N], q: &[S; N], qd: &[S; N], drive: &[S; N]) -> Solution<S, N> {
        let (matrix, rest) = self.equations(turn, q, qd, drive);
        solve(&matrix, &rest)
    }

    /// As [`Mechanism::solution`], with the joints held for which `free` is zero; `free` is one for the others.
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

    /// Inertia matrix, and the torques that accelerate the arm.
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

    /// Bodies that each joint moves directly, and the load of their motion at `qdd = 0`; both about the joint's origin.
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
