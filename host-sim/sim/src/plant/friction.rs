//! Joint friction of the simulated arm: the friction model of the robot file, with an exact sign function.
//!
//! The sign function is not smoothed. A joint that comes to rest is held without any motion while the rest of the arm loads it by at most the level
//! at rest; `stiction` has the details. The holding torque lies between the torques of both directions, `offset + asymmetry - level` and `offset +
//! asymmetry + level`.

use super::dynamics::Arm;
pub use robot_compiler::{Breakaway, JointFriction};

/// True if the level depends on torque or velocity.
pub(super) fn varies(friction: &JointFriction) -> bool {
    friction.breakaway.is_some() || friction.coulomb_load != 0.0
}

/// Mean of the friction in both directions, N m or N: a constant torque on a joint that slides or is held.
pub(super) fn middle(friction: &JointFriction) -> f64 {
    friction.asymmetry + friction.offset
}

/// Dry friction of a joint, as [`JointFriction::level`].
#[inline]
pub(super) fn level(friction: &JointFriction, drive: f64, qd: f64) -> f64 {
    #[cfg(test)]
    {
        super::calls::count(super::calls::Effect::Friction);
        if friction.breakaway.is_some() {
            super::calls::count(super::calls::Effect::Breakaway);
        }
    }
    friction.level(drive, qd)
}

/// Acceleration of each joint per unit of torque on it at `q`, with the others free: the diagonal of the inverse inertia matrix.
#[must_use]
pub fn mobility<const N: usize>(arm: &Arm<N>, q: &[f64; N]) -> [f64; N] {
    let matrix = arm.terms(q, &[0.0; N]).mass_matrix;
    core::array::from_fn(|i| {
        let mut unit = [0.0; N];
        unit[i] = 1.0;
        let found = super::factors::solve(&matrix, &unit);
        if found.pivot.iter().all(|&pivot| pivot > 0.0 && pivot.is_finite()) {
            found.qdd[i]
        } else {
            // The first step will report the singular matrix. Until then, only the rotor limits the acceleration.
            arm.joints[i].rotor.reflected().recip().min(1.0)
        }
    })
}
