//! Arms of the project as identification sees them.

use dynamics_core::Inertia;
use identification::arm::{Arm, Chain};
use identification::consistent::Maker;
use nalgebra::Vector3;
use robot_compiler::{Robot, with_dof};
use std::path::Path;

/// An arm and its own numbers.
pub(crate) struct Known {
    pub(crate) arm: Box<dyn Arm>,
    pub(crate) parameters: Vec<f64>,
    pub(crate) names: Vec<String>,
}

pub(crate) fn load(name: &str) -> Known {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots").join(name);
    let robot = Robot::load(&path).unwrap();
    let (arm, parameters): (Box<dyn Arm>, Vec<f64>) = with_dof!(robot.dof(), N => {
        let chain = Chain::new(robot.model::<N>().unwrap(), Vector3::new(0.0, 0.0, -9.81));
        let parameters = chain.parameters();
        (Box::new(chain), parameters)
    });
    Known { arm, parameters, names: robot.joints.iter().map(|joint| joint.name.clone()).collect() }
}

impl Known {
    pub(crate) fn joints(&self) -> usize {
        self.arm.joints()
    }

    /// The maker's numbers, none of them fixed.
    pub(crate) fn maker(&self) -> Maker {
        let n = self.joints();
        Maker {
            links: (0..n).map(|link| core::array::from_fn(|k| self.parameters[10 * link + k])).collect(),
            fixed: vec![[0.0; 10]; n],
            rotors: self.parameters[10 * n..].to_vec(),
            deviation: 0.15,
        }
    }
}

/// Ten parameters of a body of this mass (kg), at `com` (m), of this radius of gyration (m).
pub(crate) fn ball(mass: f64, com: Vector3<f64>, radius: f64) -> [f64; 10] {
    let round = nalgebra::Matrix3::from_diagonal_element(mass * radius * radius);
    Inertia::from_mass_centre(mass, &com, &round).parameters()
}
