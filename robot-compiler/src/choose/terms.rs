//! Torque error from dropping terms of a scene's model, and the fewest terms that a tolerance allows.

use super::loop_gain::{Feedback, LoopGain};
use crate::describe::friction::FrictionPart;
use crate::describe::scene::{ModelSpec, ModelTerm, SceneFile};
use crate::kernel::{Function, Level, Operations, Precision, compile};
use dynamics_core::control::trajectory::MotionError;
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, InverseDynamics, Live, Model, Reference, SinCos, Trig};

/// Operations of the friction feedforward of one joint: `tau += b qd + x (1.5 c - 0.5 c x^2)` with `x = qd / v`, the
/// constants folded. Clamping `x` to `[-1, 1]` is not counted.
const FRICTION_OPERATIONS: Operations = Operations { mul: 5, add: 2, sub: 1, div: 0, neg: 0 };

/// Operations of one friction term of one joint, counted in [`dynamics_core::control::Friction::torque_with`]. The load's count assumes a rise.
#[must_use]
pub const fn operations_of(part: FrictionPart) -> Operations {
    let (mul, add, sub) = match part {
        FrictionPart::Breakaway => (10, 1, 3),
        FrictionPart::Load => (3, 3, 0),
        FrictionPart::Asymmetry => (2, 1, 0),
        FrictionPart::Offset => (0, 1, 0),
    };
    Operations { mul, add, sub, div: 0, neg: 0 }
}

/// Torque that a model leaves out along a reference motion. Each list holds one number per joint.
#[derive(Clone, Debug, PartialEq)]
pub struct TorqueError {
    /// Greatest magnitude, N m or N.
    pub max: Vec<f64>,
    /// Root mean square, N m or N.
    pub rms: Vec<f64>,
    /// Greatest magnitude divided by the joint's torque limit; `None` if the joint has no limit.
    pub of_limit: Vec<Option<f64>>,
    /// Greatest magnitude divided by the joint's torque limit, or by the full model's greatest torque along the motion
    /// if the joint has no limit.
    pub share: Vec<f64>,
}

impl TorqueError {
    /// Greatest of the joints' shares.
    #[must_use]
    pub fn worst_share(&self) -> f64 {
        self.share.iter().fold(0.0, |worst, share| f64::max(worst, *share))
    }
}

/// The smallest set of terms that keeps a tolerance.
#[derive(Clone, Debug, PartialEq)]
pub struct FewestTerms {
    /// The dropped terms, in the order of [`ModelTerm::ALL`].
    pub given_up: Vec<ModelTerm>,
    /// Torque error of dropping all of them together.
    pub error: TorqueError,
    /// Loop gain of the remaining model.
    pub loop_gain: LoopGain,
}

/// The scene's reference motion, along which models are compared.
///
/// One instant per control period, at most [`Along::INSTANTS_MAX`] of them, evenly spaced from start to end.
#[derive(Clone, Debug)]
pub struct Along<'a, const N: usize> {
    file: &'a SceneFile,
    model: &'a Model<f64, N>,
    live: Live<f64, N>,
    instants: Vec<(Reference<f64, N>, [SinCos<f64>; N])>,
    /// Torques of the full model at each instant.
    full: Vec<[f64; N]>,
    /// Torque of which the error is a share, for each joint, N m or N.
    scale: [f64; N],
}

impl<'a, const N: usize> Along<'a, N> {
    /// Most instants at which models are compared.
    pub const INSTANTS_MAX: u32 = 4000;

    /// Most postures at which loop gains are compared: inertia depends on the posture, which changes slowly.
    pub const POSTURES_MAX: usize = 400;

    /// Least torque (N m or N) of which an error is a share: smaller torques are rounding errors.
    const SCALE_MIN: f64 = 1e-6;

    /// Samples the scene's own motion.
    ///
    /// # Errors
    /// [`MotionError`] if the motion is not possible.
    pub fn new(file: &'a SceneFile, model: &'a Model<f64, N>) -> Result<Self, MotionError> {
        let motion = file.trajectory(model)?;
        let steps = (motion.duration() / file.period()).ceil().clamp(1.0, f64::from(Self::INSTANTS_MAX)) as u32;
        let at = |step: u32| motion.sample(motion.duration() * f64::from(step) / f64::from(steps));
        let instants = (0..=steps).map(at).map(|reference| (reference, Libm.sin_cos_all(&reference.q))).collect();
        let mut along = Self { file, model, live: file.live(model), instants, full: Vec::new(), scale: [0.0; N] };
        along.full = along.torques(file.model.full()).collect();
        let greatest =
            |i: usize| along.full.iter().fold(Self::SCALE_MIN, |most, torque| f64::max(most, torque[i].abs()));
        let limits = model.links().map(|link| link.limits.torque);
        let scale = |i: usize| if limits[i].is_finite() { limits[i] } else { greatest(i) };
        along.scale = core::array::from_fn(scale);
        Ok(along)
    }

    /// Torques of a model at every instant, N m or N.
    fn torques(&self, spec: &ModelSpec) -> impl Iterator<Item = [f64; N]> + use<'_, N> {
        let dynamics = Dynamics::new(*self.model, spec.scene(self.model));
        let friction = spec.friction.then(|| core::array::from_fn::<_, N, _>(|i| self.file.friction(i)));
        let terms = self.file.robot_friction_terms::<N>();
        self.instants.iter().map(move |(Reference { q, qd, qdd }, turn)| {
            let mut torque = dynamics.inverse_dynamics(turn, q, qd, qdd, &self.live);
            for (i, friction) in friction.iter().flatten().enumerate() {
                torque[i] += match &terms {
                    None => friction.torque(qd[i]),
                    Some(terms) => friction.torque_with(&terms[i], qd[i], torque[i]),
                };
            }
            torque
        })
    }

    /// Least loop gain without these terms along the motion, taken at one instant per control period, at most
    /// [`Along::POSTURES_MAX`] of them.
    #[must_use]
    pub fn loop_gain_without(&self, terms: &[ModelTerm]) -> LoopGain {
        if !terms.iter().any(|term| term.is_inertia()) {
            return LoopGain::FULL;
        }
        let full = self.file.model.full();
        let less = full.without(terms);
        let [full, less] = [full, &less].map(|spec| Feedback::new(self.file, self.model, spec));
        let stride = self.instants.len().div_ceil(Self::POSTURES_MAX).max(1);
        let at = |(Reference { q, .. }, turn): &(Reference<f64, N>, [SinCos<f64>; N])| {
            LoopGain::of(&full.matrix(turn, q, &self.live), &less.matrix(turn, q, &self.live))
        };
        self.instants.iter().step_by(stride).map(at).fold(LoopGain::FULL, LoopGain::weaker)
    }

    /// Torques of the full model minus those of the model without these terms.
    fn missing(&self, terms: &[ModelTerm]) -> impl Iterator<Item = [f64; N]> + use<'_, N> {
        let without = self.torques(&self.file.model.full().without(terms));
        self.full.iter().zip(without).map(|(full, less)| core::array::from_fn(|i| full[i] - less[i]))
    }

    /// Torque error of the full model without these terms.
    #[must_use]
    pub fn error_without(&self, terms: &[ModelTerm]) -> TorqueError {
        self.error(self.missing(terms))
    }

    /// Largest, and root mean square, of the missing torques of every instant.
    fn error(&self, missing: impl Iterator<Item = [f64; N]>) -> TorqueError {
        let (mut max, mut squares) = ([0.0; N], [0.0; N]);
        for missing in missing {
            for i in 0..N {
                max[i] = f64::max(max[i], missing[i].abs());
                squares[i] += missing[i] * missing[i];
            }
        }
        let count = self.instants.len() as f64;
        let limits = self.model.links().map(|link| link.limits.torque);
        TorqueError {
            max: max.to_vec(),
            rms: squares.iter().map(|sum| libm::sqrt(sum / count)).collect(),
            share: max.iter().zip(self.scale).map(|(max, scale)| max / scale).collect(),
            of_limit: max.iter().zip(limits).map(|(max, limit)| limit.is_finite().then(|| max / limit)).collect(),
        }
    }

    /// Torque error of friction feedforward without one of its terms.
    #[must_use]
    pub fn error_without_part(&self, part: FrictionPart) -> TorqueError {
        let mut file = self.file.clone();
        for joint in &mut file.robot.joints {
            joint.friction = joint.friction.map(|friction| friction.without(part));
        }
        let less = Along { file: &file, ..self.clone() };
        let spec = self.file.model.full();
        self.error(self.torques(spec).zip(less.torques(spec)).map(|(a, b)| core::array::from_fn(|i| a[i] - b[i])))
    }

    /// True if the full model without these terms stays within a share of every torque limit, or of the greatest torque
    /// along the motion of a joint without a limit.
    fn keeps(&self, tolerance: f64, terms: &[ModelTerm]) -> bool {
        let allowed = self.scale.map(|scale| tolerance * scale);
        // NaN fails the comparison.
        self.missing(terms).all(|missing| (0..N).all(|i| missing[i].abs() <= allowed[i]))
    }

    /// The fewest terms of the full model that keep the torque within a share of each joint's torque limit (of its greatest
    /// torque along the motion if it has none), and the loop gain at [`LoopGain::LEAST`] or above, everywhere on the motion.
    ///
    /// A set of terms may be dropped if its error is within the tolerance, its loop gain suffices, and every subset may be
    /// dropped too. The last condition excludes two large errors that merely cancel on this motion. Among the sets to which
    /// no further term can be added, the set is chosen that leaves the fewest operations. Among equals the choice is the
    /// set with more terms, then the one that keeps the earlier of [`ModelTerm::ALL`].
    #[must_use]
    pub fn fewest_terms(&self, tolerance: f64) -> FewestTerms {
        self.fewest_terms_without(tolerance, &self.file.model.full().terms())
    }

    /// As [`Along::fewest_terms`], if only some terms of the full model may be dropped.
    #[must_use]
    pub fn fewest_terms_without(&self, tolerance: f64, droppable: &[ModelTerm]) -> FewestTerms {
        let present = self.file.model.full().terms();
        let terms = |set: usize| -> Vec<ModelTerm> {
            present.iter().enumerate().filter(|(bit, _)| set & (1 << bit) != 0).map(|(_, term)| *term).collect()
        };
        let sets = 1_usize << present.len();
        let bits = |set: usize| (0..present.len()).map(|bit| 1 << bit).filter(move |bit| set & bit != 0);
        let mut may_go = vec![false; sets];
        may_go[0] = true;
        // Bit order visits a set after all of its subsets.
        for set in 1..sets {
            may_go[set] = bits(set).all(|bit| may_go[set & !bit]) && {
                let terms = terms(set);
                terms.iter().all(|term| droppable.contains(term)) && {
                    // Only inertia terms change the loop gain. A set with other terms passes if its subset of inertia terms
                    // passes, which is checked as a subset.
                    let felt = terms.iter().all(|term| term.is_inertia());
                    self.keeps(tolerance, &terms) && !(felt && self.loop_gain_without(&terms).is_too_weak())
                }
            };
        }
        let full = |set: usize| bits(!set & (sets - 1)).all(|bit| !may_go[set | bit]);
        let largest: Vec<usize> = (0..sets).filter(|&set| may_go[set] && full(set)).collect();
        let goes = match largest[..] {
            [only] => only,
            _ => {
                let rank = |set: &usize| {
                    let kept = present.len() - set.count_ones() as usize;
                    (self.operations_without(&terms(*set)).total(), kept, sets - set)
                };
                largest.iter().copied().min_by_key(rank).unwrap_or(0)
            }
        };
        let given_up = terms(goes);
        FewestTerms { error: self.error_without(&given_up), loop_gain: self.loop_gain_without(&given_up), given_up }
    }

    /// Operations per tick of inverse dynamics and friction feedforward, in the full model without these terms. They are
    /// those of the kernel at the scene's level (exact for the recursion), in single precision.
    #[must_use]
    pub fn operations_without(&self, terms: &[ModelTerm]) -> Operations {
        let spec = self.file.model.full().without(terms);
        let level = self.file.control.kernel.level().unwrap_or(Level::Exact);
        let scene = spec.scene(self.model);
        let mut count = compile(Function::InverseDynamics, self.model, &scene, level, Precision::Single).operations();
        if spec.friction {
            count.mul += N * FRICTION_OPERATIONS.mul;
            count.add += N * FRICTION_OPERATIONS.add;
            count.sub += N * FRICTION_OPERATIONS.sub;
        }
        count
    }
}
