//! Terms of the equations of motion.

use nalgebra::SMatrix;

/// The parts of the equations of motion at one state.
#[derive(Clone, Debug)]
pub struct Terms<const N: usize, S = f64> {
    /// Joint-space inertia with rotors, kg m^2, kg m, kg.
    pub mass_matrix: SMatrix<S, N, N>,
    /// Centrifugal and Coriolis torques `h`, N m or N.
    pub coriolis: [S; N],
    /// Torques `G` that hold the arm against gravity, N m or N.
    pub gravity: [S; N],
    /// Torques `J^T w` with which the tip wrench drives the joints, N m or N.
    pub tip: [S; N],
}
