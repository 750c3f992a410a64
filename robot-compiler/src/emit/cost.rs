//! A program with the controllers of many scenes, which measures the cost of a tick of each.
//!
//! All controllers get the same ticks, [`inputs`]. The desk computes these too, so that both can be compared bit by bit.

use super::arm::arm_module_in;
use super::dynamics::dynamics_module_in;
use super::expression::{Float, Item, call, integer, list, number, record, word};
use super::items::{inertia_item, numbers, vector, wrench_item};
use super::modules::Modules;
use crate::describe::diagnostics::Message;
use crate::describe::scene::{ScalarChoice, SceneFile};
use crate::with_dof;
use dynamics_core::control::trajectory::{Motion, MotionError};
use dynamics_core::inertia::cast_vector;
use dynamics_core::{Live, Measurement, Model, Real, Reference, Sensed};
use std::error::Error;
use std::path::{Path, PathBuf};

/// Ticks before the counted ones, in which the observer and the limits on a step settle.
pub const RUN_UP: usize = 32;

/// Number of counted ticks.
pub const COUNTED: usize = 32;

/// Inputs of a controller in one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Input<const N: usize> {
    /// Reference of the arm; its measured state is equal to it.
    pub reference: Reference<f64, N>,
    /// The encoders' counts at that state, if the scene measures in counts.
    pub counts: Option<[i32; N]>,
}

impl<const N: usize> Input<N> {
    /// Sensor readings, in the controller's scalar.
    #[must_use]
    pub fn measurement<S: Real>(&self) -> Measurement<S, N> {
        let Reference { q, qd, .. } = self.reference.cast::<S>();
        let sensed = self.counts.map_or(Sensed::State { q, qd }, Sensed::Counts);
        Measurement { sensed, age_ticks: 0 }
    }
}

/// [`RUN_UP`] and [`COUNTED`] consecutive ticks of the scene's motion, followed without error. They end where the motion is
/// fastest: where the sum of the squares of all joints' velocities, each as a share of its limit, is greatest.
///
/// Position and velocity are measured exactly, or as whole counts if the scene has encoders; no noise, no delay. If the
/// motion is fastest too early for this number of ticks, they begin at its start. If it is shorter, they stay at its end.
///
/// # Errors
/// [`MotionError`] if the motion is not possible.
pub fn inputs<const N: usize>(scene: &SceneFile, model: &Model<f64, N>) -> Result<Vec<Input<N>>, MotionError> {
    let motion = scene.trajectory(model)?;
    let duration = scene.duration.unwrap_or(motion.duration());
    let ticks = (duration * scene.control.rate).round().max(1.0) as usize;
    let sample = |tick: usize| at(&motion, scene.motion.repeats(), tick as f64 * scene.period());
    let speed = |tick: usize| -> f64 {
        let velocity = sample(tick).qd;
        let limits = model.links().iter().map(|link| link.limits.velocity);
        let shares = velocity.iter().zip(limits).map(|(v, limit)| if limit.is_finite() { v / limit } else { *v });
        shares.map(|share| share * share).sum()
    };
    let mut fastest = (0, 0.0);
    for tick in 0..ticks {
        let speed = speed(tick);
        if speed > fastest.1 {
            fastest = (tick, speed);
        }
    }
    let first = (fastest.0 + 1).saturating_sub(RUN_UP + COUNTED);
    let encoder = scene.controller_config(model).encoder;
    let counts = |q: &[f64; N]| std::array::from_fn(|i| (q[i] / encoder[i].per_count).round() as i32 + encoder[i].zero);
    let input = |tick: usize| {
        let reference = sample(tick);
        Input { reference, counts: scene.sensors.encoder.then(|| counts(&reference.q)) }
    };
    Ok((first..first + RUN_UP + COUNTED).map(input).collect())
}

fn at<const N: usize>(motion: &Motion<f64, N>, repeat: bool, t: f64) -> Reference<f64, N> {
    motion.sample(if repeat { t % motion.duration() } else { t })
}

/// First difference between two scenes that prevents a common table of inputs: arm, rate, motion, duration or sensors.
#[must_use]
pub fn difference(one: &SceneFile, other: &SceneFile) -> Option<&'static str> {
    let differs = [
        ("robot", one.robot.joints != other.robot.joints || one.robot.tool != other.robot.tool),
        ("control.rate", one.control.rate.to_bits() != other.control.rate.to_bits()),
        ("motion", one.motion != other.motion),
        ("duration", one.duration != other.duration),
        ("sensors", one.sensors != other.sensors),
    ];
    differs.into_iter().find(|(_, differs)| *differs).map(|(name, _)| name)
}

/// Writes `kernels.rs` and its modules into a folder, for these scene files: everything that the measuring program
/// includes.
///
/// | item | meaning |
/// |---|---|
/// | `N` | joints |
/// | `RUN_UP` | ticks before those that are counted |
/// | `INPUTS` | the ticks, of the program's type `Row` |
/// | `scene_K::{arm, dynamics}` | [`super::arm_module`] and [`super::dynamics_module`] of the scene that is K-th in the list, in its own scalar |
/// | `scene_K::live()` | its live inputs |
/// | `scene!(K, scene_K, tick_K, SCALAR);` | a call of the program's macro for each |
/// | `all(counter)` | calls `scene_K::count(counter)` for each |
///
/// # Errors
/// A file that cannot be read, with its name and line; scenes that differ in arm, rate, motion, duration or sensors; a folder that cannot
/// be written to.
// `inline`: compiled for six joint counts by the packages that use it. `newtau run`, which a new user compiles first, does not.
#[inline]
pub fn write_program_of(paths: &[PathBuf], folder: &Path) -> Result<(), Box<dyn Error>> {
    let scenes: Vec<SceneFile> = paths.iter().map(|path| SceneFile::load(path)).collect::<Result<_, _>>()?;
    let Some(first) = scenes.first() else {
        let problem = "no scene to measure: expected the path of a scene file on each line of the list";
        return Err(Message(problem.to_owned()).into());
    };
    for scene in &scenes {
        if let Some(what) = difference(first, scene) {
            return Err(Message(format!(
                "{}: {what}: not that of {}; expected scenes of one robot, rate, motion, duration and sensors",
                scene.path.display(),
                first.path.display()
            ))
            .into());
        }
    }
    with_dof!(first.robot.dof(), N => program::<N>(&scenes, folder))
}

fn program<const N: usize>(scenes: &[SceneFile], folder: &Path) -> Result<(), Box<dyn Error>> {
    let modules = Modules::new(folder.to_owned());
    let mut rest = String::new();
    let mut calls = String::new();
    for (k, scene) in scenes.iter().enumerate() {
        let model = scene.robot.model::<N>()?;
        if k == 0 {
            let rows = inputs(scene, &model).map_err(|error| Message(format!("{}: {error}", scene.path.display())))?;
            rest += &table(&rows);
        }
        let scalar = scene.control.scalar;
        let (real, live) = match scalar {
            ScalarChoice::F32 => (f32::NAME, live_item::<f32, N>(&scene.live(&model))),
            ScalarChoice::F64 => (f64::NAME, live_item::<f64, N>(&scene.live(&model))),
        };
        // Compiler messages name the file, so its name identifies the scene.
        let stem = scene.path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let arm = modules.file(&format!("{k}_{stem}_arm"), &arm_module_in(scene, &model, scalar))?;
        let dynamics = modules.file(&format!("{k}_{stem}_dynamics"), &dynamics_module_in(scene, &model, scalar))?;
        rest += &format!(
            "pub(crate) mod scene_{k} {{\n    #[path = {arm:?}]\n    pub mod arm;\n    #[path = {dynamics:?}]\n    pub mod dynamics;\n\
             \n    use dynamics_core::{{Inertia, Live, Wrench}};\n    use nalgebra::{{Matrix3, Vector3}};\n\
             \n    pub(crate) fn live() -> Live<{real}, {N}> {{\n        {}\n    }}\n\
             \n    scene!({k}, tick_{k}, {real});\n}}\n",
            live.print(8)
        );
        calls += &format!("    scene_{k}::count(counter);\n");
    }
    modules.finish(&format!("{rest}\npub(crate) fn all(counter: &Counter) {{\n{calls}}}\n"))
}

/// The ticks as the source of a constant.
fn table<const N: usize>(rows: &[Input<N>]) -> String {
    let row = |Input { reference: Reference { q, qd, qdd }, counts }: &Input<N>| {
        let counts = counts.map_or_else(
            || word("None"),
            |counts| call("Some", vec![list(counts.iter().map(|&c| integer(i64::from(c))).collect())]),
        );
        record("Row", vec![("q", numbers(q)), ("qd", numbers(qd)), ("qdd", numbers(qdd)), ("counts", counts)])
    };
    let count = rows.len();
    let rows = list(rows.iter().map(row).collect());
    format!(
        "pub(crate) const N: usize = {N};\npub(crate) const RUN_UP: usize = {RUN_UP};\n\
         pub(crate) static INPUTS: [Row; {count}] = {};\n\n",
        rows.print(0)
    )
}

pub(super) fn live_item<S: Float, const N: usize>(live: &Live<f64, N>) -> Item {
    record(
        "Live",
        vec![
            ("gravity", vector(&cast_vector::<f64, S>(&live.gravity))),
            ("payload", inertia_item(&live.payload.cast::<S>())),
            ("tip_wrench", wrench_item(&live.tip_wrench.cast::<S>())),
            ("rotor", list(live.rotor.iter().map(|x| number(S::literal(*x))).collect())),
        ],
    )
}
