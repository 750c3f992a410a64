//! External reference data: robots and states from `robots/golden/*.json`.
#![allow(dead_code, reason = "shared by test programs, of which each reads some of it")]

use dynamics_core::{Body, Dh, Frame, JointKind, JointSpec, Limits, Rotor, Tool, Wrench};
use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;
use sim::plant::Arm;

#[derive(Deserialize)]
pub(crate) struct Golden {
    pub(crate) gravity: [f64; 3],
    joints: Vec<PlacedJoint>,
    tip_in_last_joint: Place,
    dh: Option<Vec<DhJoint>>,
    pub(crate) states: Vec<Reference>,
}

#[derive(Deserialize)]
struct PlacedJoint {
    r#type: char,
    axis: [f64; 3],
    #[serde(rename = "placement_R")]
    rotation: [[f64; 3]; 3],
    #[serde(rename = "placement_p")]
    translation: [f64; 3],
    mass: f64,
    com: [f64; 3],
    inertia_com: [[f64; 3]; 3],
}

#[derive(Deserialize)]
struct Place {
    #[serde(rename = "R")]
    rotation: [[f64; 3]; 3],
    p: [f64; 3],
}

#[derive(Deserialize)]
struct DhJoint {
    r#type: char,
    theta: f64,
    d: f64,
    a: f64,
    alpha: f64,
    offset: f64,
    mass: f64,
    com: [f64; 3],
    inertia_com: [[f64; 3]; 3],
    #[serde(rename = "motor_inertia_Jm")]
    motor_inertia: f64,
    #[serde(rename = "gear_ratio_G")]
    gear: f64,
}

#[derive(Deserialize)]
pub(crate) struct Reference {
    pub(crate) q: Vec<f64>,
    pub(crate) qd: Vec<f64>,
    pub(crate) qdd: Vec<f64>,
    pub(crate) tau_in: Vec<f64>,
    pub(crate) wrench_tip: [f64; 6],
    pub(crate) tau: Vec<f64>,
    pub(crate) gravity: Vec<f64>,
    pub(crate) coriolis_qd: Vec<f64>,
    #[serde(rename = "M")]
    pub(crate) mass_matrix: Vec<Vec<f64>>,
    pub(crate) qdd_fd: Vec<f64>,
    pub(crate) tau_wrench: Vec<f64>,
    pub(crate) qdd_fd_wrench: Vec<f64>,
    #[serde(rename = "tip_R")]
    pub(crate) tip_rotation: [[f64; 3]; 3],
    pub(crate) tip_p: [f64; 3],
    pub(crate) kinetic: f64,
    pub(crate) potential: f64,
    pub(crate) rotor: Option<WithRotor>,
}

/// Results for the same state with rotors.
#[derive(Deserialize)]
pub(crate) struct WithRotor {
    pub(crate) tau: Vec<f64>,
    #[serde(rename = "M")]
    pub(crate) mass_matrix: Vec<Vec<f64>>,
    pub(crate) qdd_fd: Vec<f64>,
}

/// Largest difference, relative to the largest entry of the reference.
pub(crate) fn relative(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    // f64::max drops a NaN, so it must be rejected here.
    assert!(found.iter().all(|x| x.is_finite()), "{found:?}");
    let scale = expected.iter().fold(0.0_f64, |m, x| m.max(x.abs())).max(1e-12);
    found.iter().zip(expected).fold(0.0, |m, (a, b)| f64::max(m, (a - b).abs())) / scale
}

pub(crate) fn matrix(rows: &[[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

fn kind(letter: char) -> JointKind {
    if letter == 'R' { JointKind::Revolute } else { JointKind::Prismatic }
}

impl Golden {
    pub(crate) fn load(robot: &str) -> Self {
        // Two packages at different folder depths include this file.
        let above = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).ancestors();
        let folder = above.map(|folder| folder.join("robots/golden")).find(|folder| folder.is_dir()).unwrap();
        serde_json::from_str(&std::fs::read_to_string(folder.join(format!("{robot}.json"))).unwrap()).unwrap()
    }

    /// The arm from its placements, without rotors.
    pub(crate) fn placed<const N: usize>(&self) -> Arm<N> {
        let joints = core::array::from_fn(|i| {
            let joint = &self.joints[i];
            JointSpec {
                kind: kind(joint.r#type),
                frame: Frame::Placement {
                    rotation: matrix(&joint.rotation),
                    translation: joint.translation.into(),
                    axis: joint.axis.into(),
                },
                body: Body { mass: joint.mass, com: joint.com.into(), inertia: matrix(&joint.inertia_com) },
                rotor: Rotor::default(),
                limits: Limits::none(),
            }
        });
        let tip = &self.tip_in_last_joint;
        let tool = Tool { rotation: matrix(&tip.rotation), translation: tip.p.into(), body: Body::massless() };
        self.arm(joints, tool)
    }

    /// The arm from its classical Denavit-Hartenberg table, with or without rotors.
    pub(crate) fn classical<const N: usize>(&self, rotors: bool) -> Arm<N> {
        let rows = self.dh.as_ref().unwrap();
        let joints = core::array::from_fn(|i| {
            let row = &rows[i];
            let kind = kind(row.r#type);
            let (theta, d) = match kind {
                JointKind::Revolute => (row.theta + row.offset, row.d),
                JointKind::Prismatic => (row.theta, row.d + row.offset),
            };
            JointSpec {
                kind,
                frame: Frame::ClassicalDh(Dh { a: row.a, alpha: row.alpha, d, theta }),
                body: Body { mass: row.mass, com: row.com.into(), inertia: matrix(&row.inertia_com) },
                rotor: if rotors { Rotor { inertia: row.motor_inertia, gear: row.gear } } else { Rotor::default() },
                limits: Limits::none(),
            }
        });
        self.arm(joints, Tool::default())
    }

    fn arm<const N: usize>(&self, joints: [JointSpec; N], tool: Tool) -> Arm<N> {
        Arm { joints, tool, payload: None, gravity: Vector3::from(self.gravity), tip_wrench: None }
    }
}

pub(crate) fn wrench(w: &[f64; 6]) -> Wrench<f64> {
    Wrench { force: Vector3::new(w[0], w[1], w[2]), moment: Vector3::new(w[3], w[4], w[5]) }
}
