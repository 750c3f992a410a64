//! The operations of an operator that depend on the number of joints.

use super::motion_queue::way;
use super::planned_motion::PlannedMotion;
use dynamics_core::control::Encoder;
use dynamics_core::control::trajectory::{Bounds, MotionError};
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, Inertia, InverseDynamics as _, Live, Reference, Trig as _};
use identification::arm::Chain;
use identification::identify::TORQUE_CUTOFF;
use identification::log::Log;
use identification::payload::{Known, Payload};
use identification::prepare::Filters;
use link::Sensed;
use link::convert::{AsymmetricInertia, array};
use robot_compiler::scene::joints;
use sim::run::wrench::tip_wrench;
use std::fmt;
use std::rc::Rc;

/// Standard deviation of a drive's torque, relative to the commanded torque.
const TORQUE_DEVIATION: f64 = 0.02;

/// Operations that depend on the number of joints.
pub(super) trait ArmModel: fmt::Debug {
    /// Positions in rad or m; `None` for another number of joints.
    fn positions(&self, sensed: &Sensed) -> Option<Vec<f64>>;

    /// Reference at rest at these positions.
    fn at_rest(&self, q: &[f64]) -> link::Reference;

    /// Plans a motion from rest to rest in the given time, s; without one, as fast as the bounds allow.
    fn way(&self, from: &[f64], to: &[f64], time: Option<f64>) -> Result<Rc<dyn PlannedMotion>, MotionError>;

    /// Live inputs of the arm, with another payload (in the tip frame) if one is given. Only this function moves a payload from the tip frame to the
    /// last link's frame, which the board uses.
    fn live(&self, payload: Option<Inertia<f32>>) -> Result<link::Live, AsymmetricInertia>;

    /// Payload of the scene, in the tip frame.
    fn payload(&self) -> Inertia<f32>;

    /// Converts a body from the tip frame to the last link's frame.
    fn in_last_link(&self, in_tip: &Inertia<f64>) -> Inertia<f64>;

    /// Converts a body from the last link's frame to the tip frame.
    fn in_tip(&self, in_last_link: &Inertia<f64>) -> Inertia<f64>;

    /// Torques of a motion by the controller's model, N m or N. The payload is in the tip frame.
    fn inverse_dynamics(&self, q: &[f64], qd: &[f64], qdd: &[f64], payload: Option<Inertia<f32>>) -> Vec<f64>;

    /// Torques that hold the arm at a position, N m or N.
    fn gravity(&self, q: &[f64], payload: Option<Inertia<f32>>) -> Vec<f64> {
        let still = vec![0.0; q.len()];
        self.inverse_dynamics(q, &still, &still, payload)
    }

    /// Estimates the payload from a log, with the model as known. The payload is in the last link's frame. `friction`: viscous and Coulomb
    /// coefficients of each joint.
    fn weigh(&self, log: &Log, friction: &[(f64, f64)]) -> Payload;

    /// Force (N) and moment (N m) at the tip, in base axes, that are equivalent to these external torques; the smallest of several. `None` if the arm
    /// is singular.
    fn tip_wrench(&self, q: &[f64], external: &[f32]) -> Option<[f64; 6]>;
}

#[derive(Debug)]
pub(super) struct SceneArm<const N: usize> {
    /// Live inputs of the arm, as sent to the board: the payload is in the last link's frame.
    pub(super) live: Live<f32, N>,
    /// The scene's payload, in the tip frame.
    pub(super) payload: Inertia<f32>,
    /// Bounds of the operator's own motions.
    pub(super) bounds: Bounds<f64, N>,
    pub(super) encoder: [Encoder<f64>; N],
    pub(super) dynamics: Dynamics<f64, N>,
}

impl<const N: usize> SceneArm<N> {
    /// Live inputs with this payload, given in the tip frame; `None`: with the scene's payload.
    pub(super) fn live_with(&self, payload: Option<Inertia<f32>>) -> Live<f32, N> {
        // Symmetric to the bit: the link carries six entries of the tensor.
        let moved = payload.map(|payload| self.in_last_link(&payload.cast()).cast().symmetric());
        Live { payload: moved.unwrap_or(self.live.payload), ..self.live }
    }
}

impl<const N: usize> ArmModel for SceneArm<N> {
    fn positions(&self, sensed: &Sensed) -> Option<Vec<f64>> {
        match sensed {
            Sensed::State { q, .. } => array::<f32, N>(q).ok().map(|q| q.map(f64::from).to_vec()),
            Sensed::Counts(counts) => {
                let counts = array::<i32, N>(counts).ok()?;
                Some(counts.iter().zip(&self.encoder).map(|(count, encoder)| encoder.position(*count)).collect())
            }
        }
    }

    fn at_rest(&self, q: &[f64]) -> link::Reference {
        link::Reference::new(&Reference::<f64, N>::at_rest(joints(q)).cast::<f32>())
    }

    fn way(&self, from: &[f64], to: &[f64], time: Option<f64>) -> Result<Rc<dyn PlannedMotion>, MotionError> {
        let from: [f64; N] = joints(from);
        // An arm that was armed outside a limit may move back inside.
        let position = core::array::from_fn(|i| {
            let (low, high) = self.bounds.position[i];
            (low.min(from[i]), high.max(from[i]))
        });
        let inward = way::<N>(from, joints(to), time, &Bounds { position, ..self.bounds });
        Ok(Rc::new(inward.map_err(|error| match error {
            // The message names the limits of the robot file, because the user knows these.
            MotionError::PositionOutOfLimits { point, joint, position, .. } => {
                let limits = self.bounds.position.get(joint).copied().unwrap_or_default();
                MotionError::PositionOutOfLimits { point, joint, position, limits }
            }
            error => error,
        })?))
    }

    fn live(&self, payload: Option<Inertia<f32>>) -> Result<link::Live, AsymmetricInertia> {
        link::Live::new(&self.live_with(payload))
    }

    fn payload(&self) -> Inertia<f32> {
        self.payload
    }

    fn in_last_link(&self, in_tip: &Inertia<f64>) -> Inertia<f64> {
        let tip = self.dynamics.model().tip();
        in_tip.in_parent(&tip.rotation, &tip.translation)
    }

    fn in_tip(&self, in_last_link: &Inertia<f64>) -> Inertia<f64> {
        let link = self.dynamics.model().tip().inverse();
        in_last_link.in_parent(&link.rotation, &link.translation)
    }

    fn inverse_dynamics(&self, q: &[f64], qd: &[f64], qdd: &[f64], payload: Option<Inertia<f32>>) -> Vec<f64> {
        let (q, qd, qdd): ([f64; N], [f64; N], [f64; N]) = (joints(q), joints(qd), joints(qdd));
        let live = self.live_with(payload).cast();
        self.dynamics.inverse_dynamics(&Libm.sin_cos_all(&q), &q, &qd, &qdd, &live).to_vec()
    }

    fn weigh(&self, log: &Log, friction: &[(f64, f64)]) -> Payload {
        let chain = Chain::new(*self.dynamics.model(), self.live.gravity.map(f64::from));
        let filters = Filters { motion: TORQUE_CUTOFF, torque: TORQUE_CUTOFF };
        let known = Known::of_numbers(&chain, &chain.parameters(), friction, filters);
        known.payload(&chain, std::slice::from_ref(log), (1.0, TORQUE_DEVIATION))
    }

    fn tip_wrench(&self, q: &[f64], external: &[f32]) -> Option<[f64; 6]> {
        let (q, external): ([f64; N], [f64; N]) =
            (joints(q), joints(&external.iter().copied().map(f64::from).collect::<Vec<_>>()));
        tip_wrench(self.dynamics.model(), &q, &external)
    }
}
