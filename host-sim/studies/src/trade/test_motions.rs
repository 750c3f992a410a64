//! The three test motions of a trade-off: slow, fast, and through a nearly singular inertia matrix.

use crate::posture_search::minimise;
use dynamics_core::control::trajectory::{Bounds, Motion, Timing, TorqueLimits, Waypoint};
use dynamics_core::mass_matrix::mass_matrix;
use dynamics_core::trig::{Libm, Trig};
use dynamics_core::{Dynamics, Model};
use nalgebra::SMatrix;
use robot_compiler::SceneFile;
use robot_compiler::scene::MotionSpec;
use serde::Serialize;
use sim::failure::Failure;
use sim::run::scene_world;

/// Share of the velocity limits that the slow motion uses.
const SLOW: f64 = 0.1;
/// Longest duration of the slow motion in one direction, s.
const LONGEST: f64 = 6.0;
/// Distance to each side of the posture with the nearly singular inertia matrix, rad or m.
const BESIDE: f64 = 0.3;
/// Share of the torque limits for the fast motions; the rest is left for friction and feedback.
const TORQUE: f64 = 0.7;

/// A motion on which points are measured.
#[derive(Clone, Debug)]
pub struct TestMotion<const N: usize> {
    /// `slow`, `fast` or `singular`.
    pub name: &'static str,
    /// The motion, from rest to rest.
    pub motion: Motion<f64, N>,
}

/// Properties of a test motion, for the report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TestMotionReport {
    /// Name of the test motion.
    pub name: &'static str,
    /// Duration, s.
    pub duration: f64,
    /// Greatest speed as a share of a joint's limit.
    pub speed: f64,
    /// Smallest eigenvalue of the mass matrix along the motion, scaled to a unit diagonal.
    pub least_eigenvalue: f64,
}

/// The three test motions of a scene.
///
/// - *Slow* and *fast*: from the start of the scene's motion to its farthest point and back. Distances are measured in shares of the joints' ranges.
///   Slow uses a tenth of the velocity limits; fast is as fast as velocity and torque limits allow.
/// - *Singular*: as fast as the limits allow, through the posture in which the scaled mass matrix is nearest to singular.
///
/// # Errors
/// The scene's motion is invalid.
pub fn test_motions<const N: usize>(file: &SceneFile, model: &Model<f64, N>) -> Result<[TestMotion<N>; 3], Failure> {
    let own = scene_world::world::<N>(file)?.motion;
    let ranges = ranges(model);
    let (near, far) = ends(file, &own, &ranges);
    let posture = nearly_singular(file, model, &ranges);
    let beside = |side: f64| {
        core::array::from_fn(|i| {
            let (lo, hi) = ranges[i];
            (posture[i] + side * BESIDE).clamp(lo, hi)
        })
    };
    let make = |name, a, b, slow| {
        let motion = back_and_forth(file, model, a, b, slow).map_err(|error| {
            Failure::Input(miette::miette!("{}: the {name} motion cannot be: {error}", file.path.display()))
        })?;
        Ok(TestMotion { name, motion })
    };
    Ok([
        make("slow", near, far, true)?,
        make("fast", near, far, false)?,
        make("singular", beside(-1.0), beside(1.0), false)?,
    ])
}

impl<const N: usize> TestMotion<N> {
    /// Properties of the test motion.
    #[must_use]
    pub fn report(&self, file: &SceneFile, model: &Model<f64, N>) -> TestMotionReport {
        const INSTANTS: u32 = 400;
        let (mut speed, mut least) = (0.0_f64, f64::INFINITY);
        for k in 0..=INSTANTS {
            let at = self.motion.sample(self.motion.duration() * f64::from(k) / f64::from(INSTANTS));
            for (qd, link) in at.qd.iter().zip(model.links()) {
                speed = speed.max(qd.abs() / link.limits.velocity);
            }
            least = least.min(least_eigenvalue(file, model, &at.q));
        }
        TestMotionReport { name: self.name, duration: self.motion.duration(), speed, least_eigenvalue: least }
    }
}

/// Ranges for the joints: slightly inside their limits; one turn or one metre without limits.
fn ranges<const N: usize>(model: &Model<f64, N>) -> [(f64, f64); N] {
    model.links().map(|link| {
        let (lo, hi) = link.limits.position;
        match (lo.is_finite(), hi.is_finite()) {
            (true, true) => {
                let inside = 0.01 * (hi - lo);
                (lo + inside, hi - inside)
            }
            (true, false) => (lo, lo + 1.0),
            (false, true) => (hi - 1.0, hi),
            (false, false) => (-core::f64::consts::PI, core::f64::consts::PI),
        }
    })
}

/// Start and farthest point of the motion; for a motion at rest, those of the robot's default scene.
fn ends<const N: usize>(file: &SceneFile, motion: &Motion<f64, N>, ranges: &[(f64, f64); N]) -> ([f64; N], [f64; N]) {
    const INSTANTS: u32 = 400;
    let start = motion.sample(0.0).q;
    let away =
        |q: &[f64; N]| (0..N).map(|i| libm::pow((q[i] - start[i]) / (ranges[i].1 - ranges[i].0), 2.0)).sum::<f64>();
    let on_the_way = (0..=INSTANTS).map(|k| motion.sample(motion.duration() * f64::from(k) / f64::from(INSTANTS)).q);
    let far = on_the_way.max_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(start);
    if away(&far) > 1e-6 {
        return (start, far);
    }
    let default = SceneFile::default_for(file.robot.clone()).motion;
    let swing = match &default {
        MotionSpec::Quintic { points, .. } if points.len() > 1 => core::array::from_fn(|i| {
            points[1].q.get(i).copied().unwrap_or(0.0) - points[0].q.get(i).copied().unwrap_or(0.0)
        }),
        _ => [0.1; N],
    };
    let aside = core::array::from_fn(|i| {
        let (lo, hi) = ranges[i];
        let there = start[i] + swing[i];
        if (lo..=hi).contains(&there) { there } else { (start[i] - swing[i]).clamp(lo, hi) }
    });
    (start, aside)
}

fn back_and_forth<const N: usize>(
    file: &SceneFile,
    model: &Model<f64, N>,
    a: [f64; N],
    b: [f64; N],
    slow: bool,
) -> Result<Motion<f64, N>, dynamics_core::control::trajectory::MotionError> {
    let limits = model.links().map(|link| link.limits);
    let bounds = Bounds::from_limits(&limits);
    let points = [a, b, a].map(Waypoint::through);
    // The peak speed of a quintic from rest to rest is 15/8 of its mean speed.
    let at_share = |share: f64| {
        let times = (0..N).map(|i| 1.875 * (b[i] - a[i]).abs() / (share * limits[i].velocity));
        times.fold(0.05, f64::max)
    };
    if slow {
        let time = at_share(SLOW).clamp(0.25, LONGEST);
        return Motion::quintic(&points, Timing::Durations(&[time; 2]), &bounds);
    }
    let time = at_share(0.9).max(0.15);
    let motion = Motion::quintic(&points, Timing::Durations(&[time; 2]), &bounds)?;
    let torque = limits.map(|limits| TORQUE * limits.torque);
    if torque.iter().all(|torque| !torque.is_finite()) {
        return Ok(motion);
    }
    let dynamics = Dynamics::new(*model, file.model.full().scene(model));
    motion.scale_to_torque(&dynamics, &Libm, &file.live(model), &TorqueLimits { torque, steps: 400 })
}

/// The posture in which the scaled mass matrix has its smallest eigenvalue.
fn nearly_singular<const N: usize>(file: &SceneFile, model: &Model<f64, N>, ranges: &[(f64, f64); N]) -> [f64; N] {
    // The motion extends to both sides of the posture, so a margin is left at the ends.
    let inside = ranges.map(|(lo, hi)| if hi - lo > 2.0 * BESIDE { (lo + BESIDE, hi - BESIDE) } else { (lo, hi) });
    let middle = inside.map(|(lo, hi)| 0.5 * (lo + hi));
    minimise(&inside, &middle, |q| least_eigenvalue(file, model, q)).q
}

/// Smallest eigenvalue of `D_ij / sqrt(D_ii D_jj)`: 1 for uncoupled joints, 0 for a singular matrix.
fn least_eigenvalue<const N: usize>(file: &SceneFile, model: &Model<f64, N>, q: &[f64; N]) -> f64 {
    let dynamics = Dynamics::new(*model, file.model.full().scene(model));
    let inertia: SMatrix<f64, N, N> = mass_matrix(&dynamics, &Libm.sin_cos_all(q), q, &file.live(model));
    let scaled =
        nalgebra::DMatrix::from_fn(N, N, |i, j| inertia[(i, j)] / libm::sqrt(inertia[(i, i)] * inertia[(j, j)]));
    scaled.symmetric_eigenvalues().min()
}
