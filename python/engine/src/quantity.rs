//! Functions of an arm: their inputs, their outputs, and their evaluation in any scalar.

use dynamics_core::forward_dynamics::acceleration;
use dynamics_core::kinematics::{tip_jacobian, tip_pose};
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::regressor::{PARAMETERS, inverse_dynamics_regressor};
use dynamics_core::{Dynamics, Field, InverseDynamics, Live, SinCos};

/// A function of an arm's state.
///
/// Inputs are lists with one number for each joint: the position `q`, and for some functions the velocity and a third list. Outputs
/// are numbers in row-major order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Actuator torques for `q, qd, qdd`: N numbers.
    InverseDynamics,
    /// Actuator torques that hold the arm at rest: N numbers.
    Gravity,
    /// Joint-space inertia matrix: N x N numbers.
    MassMatrix,
    /// Accelerations for `q, qd, tau`: N numbers, followed by N pivots, which are not returned.
    ForwardDynamics,
    /// Velocity of the tip frame's origin, then angular velocity, per joint velocity, in base axes: 6 x N numbers.
    Jacobian,
    /// Torque per inertial parameter for `q, qd, qdd`: N x 10 N numbers.
    Regressor,
    /// Homogeneous transformation `base_from_tip`: 4 x 4 numbers.
    TipPose,
}

impl Quantity {
    /// All functions.
    pub const ALL: [Self; 7] = [
        Self::InverseDynamics,
        Self::Gravity,
        Self::MassMatrix,
        Self::ForwardDynamics,
        Self::Jacobian,
        Self::Regressor,
        Self::TipPose,
    ];

    /// Number of input lists: 1 (`q`) or 3.
    #[must_use]
    pub const fn inputs(self) -> usize {
        match self {
            Self::InverseDynamics | Self::ForwardDynamics | Self::Regressor => 3,
            Self::Gravity | Self::MassMatrix | Self::Jacobian | Self::TipPose => 1,
        }
    }

    /// Shape of the result for one state of an arm with `n` joints.
    #[must_use]
    pub fn shape(self, n: usize) -> Vec<usize> {
        match self {
            Self::InverseDynamics | Self::Gravity | Self::ForwardDynamics => vec![n],
            Self::MassMatrix => vec![n, n],
            Self::Jacobian => vec![6, n],
            Self::Regressor => vec![n, PARAMETERS * n],
            Self::TipPose => vec![4, 4],
        }
    }

    /// Number of results for one state.
    #[must_use]
    pub fn results(self, n: usize) -> usize {
        self.shape(n).iter().product()
    }

    /// Number of outputs of `Quantity::evaluate`: the results, and for forward dynamics the pivots.
    #[must_use]
    pub fn outputs(self, n: usize) -> usize {
        if matches!(self, Self::ForwardDynamics) { 2 * n } else { self.results(n) }
    }

    /// Evaluates the function for one state; `out` has [`Quantity::outputs`] numbers. Lists that are not inputs are not read.
    pub(crate) fn evaluate<S: Field, const N: usize>(
        self,
        dynamics: &Dynamics<S, N>,
        turn: &[SinCos<S>; N],
        [q, second, third]: [&[S; N]; 3],
        out: &mut [S],
    ) {
        let live = Live::zero();
        match self {
            Self::InverseDynamics => {
                out.copy_from_slice(&dynamics.inverse_dynamics(turn, q, second, third, &live));
            }
            Self::Gravity => out.copy_from_slice(&dynamics.gravity_torque(turn, q, &live)),
            Self::MassMatrix => {
                let matrix = mass_matrix(dynamics, turn, q, &live);
                for (at, entry) in out.iter_mut().enumerate() {
                    *entry = matrix[(at / N, at % N)];
                }
            }
            Self::ForwardDynamics => {
                let found = acceleration(dynamics, turn, q, second, third, &live);
                let (accelerations, pivots) = out.split_at_mut(N);
                accelerations.copy_from_slice(&found.qdd);
                pivots.copy_from_slice(&found.pivot);
            }
            Self::Jacobian => {
                let columns = tip_jacobian(dynamics.model(), turn, q);
                for (joint, (linear, angular)) in columns.linear.iter().zip(&columns.angular).enumerate() {
                    for row in 0..3 {
                        out[row * N + joint] = linear[row];
                        out[(row + 3) * N + joint] = angular[row];
                    }
                }
            }
            Self::Regressor => {
                let columns = inverse_dynamics_regressor(dynamics, turn, q, second, third, &live);
                let entries = columns.iter().flatten().flatten();
                out.iter_mut().zip(entries).for_each(|(entry, column)| *entry = *column);
            }
            Self::TipPose => {
                let pose = tip_pose(dynamics.model(), turn, q);
                for row in 0..3 {
                    for column in 0..3 {
                        out[4 * row + column] = pose.rotation[(row, column)];
                    }
                    out[4 * row + 3] = pose.translation[row];
                }
                out[12..15].fill(S::zero());
                out[15] = S::one();
            }
        }
    }
}
