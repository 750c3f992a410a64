//! Checks of a robot file for impossible, placeholder and missing values. The robot compiler has the rules; this module searches for the loads with
//! which they compare.

mod hazard;
mod report;

use super::numbers::finite;
use super::posture_search::{ROUGH, minimise_to, ranges};
use dynamics_core::chapter::posture::Chain;
use dynamics_core::chapter::statics::holding_torque;
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::trig::Libm;
use dynamics_core::{Dynamics, Inertia, Live, Rotor, Scene, Trig, Wrench};
pub use hazard::{CLASS_I, Hazard};
use nalgebra::Vector3;
use robot_compiler::check::{
    CheckRule, Draft, Finding, JointLoad, Severity, findings, gravity_finding, scene_findings,
};
use robot_compiler::{Robot, SceneFile, with_dof};
use sim::failure::Failure;
use sim::parallel::in_parallel;
use sim::run::trial;
use std::path::Path;

/// The findings about an arm.
#[derive(Debug)]
pub struct CheckResult {
    /// The arm as read.
    pub draft: Draft,
    /// Gravitational acceleration in the base frame, m/s^2.
    pub gravity: Vector3<f64>,
    /// Loads of the joints; `None` if no model can be made of the arm.
    pub loads: Option<Vec<JointLoad>>,
    /// Hazard figures; `None` if no model can be made of the arm.
    pub hazard: Option<Hazard>,
    /// The findings, the worst first.
    pub findings: Vec<Finding>,
}

impl CheckResult {
    /// Number of findings of this severity.
    #[must_use]
    pub fn count(&self, severity: Severity) -> usize {
        self.findings.iter().filter(|finding| finding.severity == severity).count()
    }
}

/// Checks an arm under this gravity, in its default scene.
///
/// # Errors
/// [`Failure::Input`]: gravity is not three finite numbers.
pub fn answer(draft: Draft, gravity: &[f64]) -> Result<CheckResult, Failure> {
    answer_in(draft, gravity, None)
}

/// Checks an arm under this gravity, in a scene of this robot. The scene's rest pose takes precedence over the robot file's.
///
/// # Errors
/// Those of [`answer`].
pub fn answer_in(mut draft: Draft, gravity: &[f64], scene: Option<SceneFile>) -> Result<CheckResult, Failure> {
    let gravity = finite::<3>("--gravity", gravity, "gx, gy, gz")
        .map_err(|problem| Failure::Input(miette::miette!(help = "see `newtau help check`", "{problem}")))?
        .into();
    if let Some(scene) = &scene {
        draft.robot.rest.clone_from(&scene.safety.rest);
    }
    let loads = draft.arm().and_then(|arm| with_dof!(arm.dof(), N => loads::<N>(arm, &gravity)));
    let name = scene.as_ref().map(|scene| scene.name.clone());
    let named = name.clone();
    let mut of_scene = scene.as_ref().map(scene_findings).unwrap_or_default();
    if let Some(scene) = &scene {
        of_scene.extend(oscillation(scene)?);
    }
    let file = scene.or_else(|| draft.arm().map(SceneFile::default_for));
    let hazard = file.and_then(|file| with_dof!(file.robot.dof(), N => hazard::hazard::<N>(&file, name, &gravity)));
    // Notes come last.
    let mut findings = findings(&draft, loads.as_deref());
    findings.extend(of_scene);
    if named.is_none() {
        findings.extend(gravity_finding(Path::new("the command line"), "--gravity", &gravity, None));
    }
    Ok(CheckResult { draft, gravity, loads, hazard, findings })
}

/// The finding about a loop that oscillates in a trial in the simulated arm.
fn oscillation(scene: &SceneFile) -> Result<Option<Finding>, Failure> {
    Ok(trial::oscillation(scene)?.map(|found| Finding {
        rule: CheckRule::Oscillation,
        severity: Severity::Wrong,
        place: found.error(scene),
        quote: None,
    }))
}

/// Load of every joint, each in its worst posture; `None` if no model can be made of the arm.
///
/// The postures are within the limits. A revolute joint without limits covers one turn; a prismatic joint without limits stays at zero.
fn loads<const N: usize>(mut arm: Robot, gravity: &Vector3<f64>) -> Option<Vec<JointLoad>> {
    for joint in &mut arm.joints {
        joint.spec.rotor = Rotor::default();
    }
    let model = arm.model::<N>().ok()?;
    let (chain, dynamics) = (Chain::new(&model, &Inertia::zero()), Dynamics::new(model, Scene::free_space()));
    let (bounds, middle) = ranges(&model);
    let torque = |q: &[f64; N]| {
        let posture = chain.posture(&Libm.sin_cos_all(q), q);
        holding_torque(&posture, gravity, &Wrench::zero())
    };
    let inertia = |q: &[f64; N], i: usize| mass_matrix(&dynamics, &Libm.sin_cos_all(q), q, &Live::zero())[(i, i)];
    let rest: Option<[f64; N]> = arm.rest.as_ref().and_then(|rest| rest.as_slice().try_into().ok());
    let load = |i: usize| {
        let worst = minimise_to(ROUGH, &bounds, &middle, |q| -torque(q)[i].powi(2));
        // The inertia at a joint depends only on the joints beyond it.
        let beyond = core::array::from_fn(|j| if j > i { bounds[j] } else { (middle[j], middle[j]) });
        let least = minimise_to(ROUGH, &beyond, &middle, |q| inertia(q, i)).value;
        let most = -minimise_to(ROUGH, &beyond, &middle, |q| -inertia(q, i)).value;
        let rest = rest.as_ref().map(|q| torque(q)[i]);
        JointLoad { holding: torque(&worst.q)[i].abs(), posture: worst.q.to_vec(), inertia: (least, most), rest }
    };
    Some(in_parallel(N, load))
}
