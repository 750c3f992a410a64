//! Would a physicist believe a robot file? The rules are the robot compiler's; the loads that they compare with are searched here.

mod report;

use super::numbers::finite;
use super::parallel::in_parallel;
use super::posture_search::{ROUGH, minimise_to, positions};
use crate::failure::Failure;
use dynamics_core::chapter::posture::Chain;
use dynamics_core::chapter::statics::holding_torque;
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, Inertia, Live, Rotor, Scene, Trig, Wrench};
use nalgebra::Vector3;
use robot_compiler::check::{Draft, Finding, JointLoad, Severity, findings};
use robot_compiler::{Robot, with_dof};

/// The findings about an arm.
#[derive(Debug)]
pub struct Answer {
    /// The arm.
    pub draft: Draft,
    /// Gravitational acceleration in the base frame, m/s^2.
    pub gravity: Vector3<f64>,
    /// Loads of the joints; `None` for an arm that cannot be put into postures.
    pub loads: Option<Vec<JointLoad>>,
    /// The worst first.
    pub findings: Vec<Finding>,
}

impl Answer {
    /// Number of findings of this severity.
    #[must_use]
    pub fn count(&self, severity: Severity) -> usize {
        self.findings.iter().filter(|finding| finding.severity == severity).count()
    }
}

/// Look at an arm under this gravity.
///
/// # Errors
/// [`Failure::Input`]: gravity is not three finite numbers.
pub fn answer(draft: Draft, gravity: &[f64]) -> Result<Answer, Failure> {
    let gravity = finite::<3>("--gravity", gravity, "gx, gy, gz")
        .map_err(|problem| Failure::Input(miette::miette!(help = "see `host-sim check --help`", "{problem}")))?
        .into();
    let loads = draft.arm().and_then(|arm| with_dof!(arm.dof(), N => loads::<N>(arm, &gravity)));
    let findings = findings(&draft, loads.as_deref());
    Ok(Answer { draft, gravity, loads, findings })
}

/// The load of every joint, each in its worst posture; `None` for an arm that makes no model.
///
/// The postures are those inside the limits, one turn of a joint without; a slide without limits stays at zero.
fn loads<const N: usize>(mut arm: Robot, gravity: &Vector3<f64>) -> Option<Vec<JointLoad>> {
    for joint in &mut arm.joints {
        joint.spec.rotor = Rotor::default();
    }
    let model = arm.model::<N>().ok()?;
    let (chain, dynamics) = (Chain::new(&model, &Inertia::zero()), Dynamics::new(model, Scene::free_space()));
    let bounds: [(f64, f64); N] = core::array::from_fn(|i| {
        let link = &model.links()[i];
        positions(link.kind, link.limits.position).unwrap_or((0.0, 0.0))
    });
    let middle = bounds.map(|(low, high)| low + (high - low) / 2.0);
    let torque = |q: &[f64; N]| {
        let posture = chain.posture(&Libm.sin_cos_all(q), q);
        holding_torque(&posture, gravity, &Wrench::zero())
    };
    let inertia = |q: &[f64; N], i: usize| mass_matrix(&dynamics, &Libm.sin_cos_all(q), q, &Live::zero())[(i, i)];
    let load = |i: usize| {
        let worst = minimise_to(ROUGH, &bounds, &middle, |q| -torque(q)[i].powi(2));
        // The inertia that a joint feels depends on the joints beyond it alone.
        let beyond = core::array::from_fn(|j| if j > i { bounds[j] } else { (middle[j], middle[j]) });
        let least = minimise_to(ROUGH, &beyond, &middle, |q| inertia(q, i)).value;
        let most = -minimise_to(ROUGH, &beyond, &middle, |q| -inertia(q, i)).value;
        JointLoad { holding: torque(&worst.q)[i].abs(), posture: worst.q.to_vec(), inertia: (least, most) }
    };
    Some(in_parallel(N, load))
}
