//! The interface through which identification uses an arm.

use dynamics_core::regressor::{PARAMETER_NAMES, PARAMETERS, inverse_dynamics_regressor};
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, Live, Model, Scene, Term, Trig};
use nalgebra::Vector3;

/// Torque as a linear function of inertial parameters, for any number of joints.
///
/// The parameters of an arm of `n` joints are the ten of each link in the order of [`PARAMETER_NAMES`], base first, then the reflected inertia of
/// each rotor: `11 n` in total.
pub trait Arm: Send + Sync {
    /// Number of joints.
    fn joints(&self) -> usize;

    /// `d tau_i / d pi` of the links, `10 n` numbers for each joint in turn.
    ///
    /// | name | quantity | unit | shape |
    /// |---|---|---|---|
    /// | `q`, `qd`, `qdd` | position, velocity, acceleration | rad, m, s | n |
    /// | `out` | torque per parameter | N m (N) per kg, kg m, kg m^2 | n x 10 n |
    fn columns(&self, q: &[f64], qd: &[f64], qdd: &[f64], out: &mut [f64]);

    /// Gravitational acceleration in the base frame, m/s^2.
    fn gravity(&self) -> Vector3<f64>;

    /// The same arm under another gravity, m/s^2 in the base frame.
    fn under(&self, gravity: Vector3<f64>) -> Box<dyn Arm>;
}

/// Number of parameters of an arm with `joints` joints.
#[must_use]
pub const fn parameter_count(joints: usize) -> usize {
    (PARAMETERS + 1) * joints
}

/// Name of a parameter: `Ixx3` belongs to the third link, `rotor3` is the inertia of the third rotor.
#[must_use]
pub fn parameter_name(index: usize, joints: usize) -> String {
    match index.checked_sub(PARAMETERS * joints) {
        Some(rotor) => format!("rotor{}", rotor + 1),
        None => format!("{}{}", PARAMETER_NAMES[index % PARAMETERS], index / PARAMETERS + 1),
    }
}

/// Unit of a parameter of a revolute arm: kg, kg m, or kg m^2.
#[must_use]
pub const fn parameter_unit(index: usize, joints: usize) -> &'static str {
    match (index >= PARAMETERS * joints, index % PARAMETERS) {
        (false, 0) => "kg",
        (false, 1..=3) => "kg m",
        _ => "kg m^2",
    }
}

/// A model of fixed size under gravity.
#[derive(Clone, Debug)]
pub struct Chain<const N: usize> {
    dynamics: Dynamics<f64, N>,
    gravity: Vector3<f64>,
}

impl<const N: usize> Chain<N> {
    /// `gravity` in the base frame, m/s^2.
    #[must_use]
    pub fn new(model: Model<f64, N>, gravity: Vector3<f64>) -> Self {
        let scene = Scene { rotor: Term::Absent, ..Scene::with_gravity(gravity, &model) };
        Self { dynamics: Dynamics::new(model, scene), gravity }
    }

    /// The parameters of the model itself.
    #[must_use]
    pub fn parameters(&self) -> Vec<f64> {
        let links = self.dynamics.model().links();
        links.iter().flat_map(|link| link.inertia.parameters()).chain(links.iter().map(|link| link.rotor)).collect()
    }
}

impl<const N: usize> Arm for Chain<N> {
    fn joints(&self) -> usize {
        N
    }

    fn columns(&self, q: &[f64], qd: &[f64], qdd: &[f64], out: &mut [f64]) {
        let fixed = |x: &[f64]| -> [f64; N] { core::array::from_fn(|i| x[i]) };
        let (q, qd, qdd) = (fixed(q), fixed(qd), fixed(qdd));
        let found = inverse_dynamics_regressor(&self.dynamics, &Libm.sin_cos_all(&q), &q, &qd, &qdd, &Live::zero());
        for (place, value) in out.iter_mut().zip(found.iter().flatten().flatten()) {
            *place = *value;
        }
    }

    fn gravity(&self) -> Vector3<f64> {
        self.gravity
    }

    fn under(&self, gravity: Vector3<f64>) -> Box<dyn Arm> {
        Box::new(Self::new(*self.dynamics.model(), gravity))
    }
}
