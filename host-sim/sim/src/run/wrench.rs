//! Conversion of joint torques to an equivalent wrench at the tip.

use dynamics_core::chapter::lagrange::tip_jacobian;
use dynamics_core::chapter::posture::Chain;
use dynamics_core::trig::Libm;
use dynamics_core::{Inertia, Model, Trig as _};
use nalgebra::{SMatrix, SVector};

/// Least pivot of `J^T J` relative to the largest: below it, the arm counts as singular.
const PIVOT_MIN: f64 = 1e-6;

/// The smallest wrench at the tip with `J^T w = tau`: `w = J (J^T J)^-1 tau`, force (N) and moment (N m) in base axes.
///
/// `None` if the arm is singular: there some torques have no equivalent wrench, and near it the wrench grows without bound.
pub fn tip_wrench<const N: usize>(model: &Model<f64, N>, q: &[f64; N], torque: &[f64; N]) -> Option<[f64; 6]> {
    let jacobian = tip_jacobian(&Chain::new(model, &Inertia::zero()).posture(&Libm.sin_cos_all(q), q));
    let column = |i: usize| {
        let unit: [f64; N] = std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 });
        let (v, omega) = (jacobian.velocity(&unit), jacobian.angular_velocity(&unit));
        [v.x, v.y, v.z, omega.x, omega.y, omega.z]
    };
    let columns: [[f64; 6]; N] = std::array::from_fn(column);
    let product = SMatrix::<f64, N, N>::from_fn(|i, j| columns[i].iter().zip(&columns[j]).map(|(a, b)| a * b).sum());
    let factored = product.cholesky()?;
    let pivots = factored.l_dirty().diagonal().map(|pivot| pivot * pivot);
    if pivots.min() < PIVOT_MIN * pivots.max() {
        return None;
    }
    let share = factored.solve(&SVector::from(*torque));
    Some(std::array::from_fn(|axis| columns.iter().zip(&share).map(|(column, x)| column[axis] * x).sum()))
}

#[cfg(test)]
mod tests {
    use super::tip_wrench;
    use dynamics_core::chapter::lagrange::tip_jacobian;
    use dynamics_core::chapter::posture::Chain;
    use dynamics_core::trig::Libm;
    use dynamics_core::{Inertia, Trig as _, Wrench};
    use nalgebra::Vector3;
    use robot_compiler::Robot;
    use std::path::Path;

    #[test]
    #[allow(clippy::unwrap_used, reason = "a test that fails should stop there")]
    fn a_wrench_at_the_tip_is_found_again_from_its_torques_and_a_stretched_arm_has_none() {
        let robot = Robot::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/puma560.toml")).unwrap();
        let model = robot.model::<6>().unwrap();
        let q = [0.3, -0.6, 0.9, 0.4, 0.7, -0.2];
        let posture = Chain::new(&model, &Inertia::zero()).posture(&Libm.sin_cos_all(&q), &q);
        let wrench = Wrench { force: Vector3::new(3.0, -5.0, 7.0), moment: Vector3::new(0.4, 0.2, -0.3) };
        let torque = tip_jacobian(&posture).transposed(&wrench);
        let found = tip_wrench(&model, &q, &torque).unwrap();
        let told = [3.0, -5.0, 7.0, 0.4, 0.2, -0.3];
        for (found, told) in found.iter().zip(told) {
            assert!((found - told).abs() < 1e-9, "{found} {told}");
        }
        // A straight wrist: the axes 4 and 6 coincide.
        let straight = [0.3, -0.6, 0.9, 0.4, 0.0, -0.2];
        assert_eq!(tip_wrench(&model, &straight, &torque), None);
    }
}
