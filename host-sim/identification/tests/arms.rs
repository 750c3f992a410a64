//! The project's arms, for identification tests.

use dynamics_core::Inertia;
use identification::arm::{Arm, Chain};
use identification::consistent::Maker;
use nalgebra::Vector3;
use robot_compiler::{Robot, with_dof};
use std::path::Path;

/// An arm and its true parameters.
pub(crate) struct Known {
    pub(crate) arm: Box<dyn Arm>,
    pub(crate) parameters: Vec<f64>,
    pub(crate) names: Vec<String>,
}

/// A column, a boom and a stick: the smallest arm with gravity, coupling and a vertical axis.
const ELBOW: &str = r#"
    name = "elbow"
    source = "made up for these tests"
    [[joint]]
    name = "column"
    type = "revolute"
    dh = { a = 0.04, alpha = 1.5707963267948966, d = 0.25, theta = 0.0 }
    mass = 3.0
    com = [-0.03, -0.05, 0.01]
    inertia = { xx = 0.02, yy = 0.012, zz = 0.018, xy = 0.001, xz = -0.0004, yz = 0.0006 }
    [[joint]]
    name = "boom"
    type = "revolute"
    dh = { a = 0.32, alpha = 0.0, d = 0.0, theta = 0.0 }
    mass = 1.6
    com = [-0.17, 0.01, 0.02]
    inertia = { xx = 0.003, yy = 0.017, zz = 0.016, xy = 0.0005, xz = 0.0003, yz = 0.0001 }
    [[joint]]
    name = "stick"
    type = "revolute"
    dh = { a = 0.25, alpha = 0.0, d = 0.0, theta = 0.0 }
    mass = 1.1
    com = [-0.12, 0.006, -0.01]
    inertia = { xx = 0.001, yy = 0.007, zz = 0.0068, xy = 0.0002, xz = 0.0, yz = 0.0001 }
"#;

/// A robot file of the project, or `elbow.toml`: a small arm made up here.
pub(crate) fn load(name: &str) -> Known {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots").join(name);
    let robot = match name {
        "elbow.toml" => Robot::from_toml_str(ELBOW, name).unwrap(),
        _ => Robot::load(&path).unwrap(),
    };
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
