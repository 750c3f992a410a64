//! The data that all runs of a scene share.

use board::chip::hello;
use dynamics_core::safety::Rules;
use dynamics_core::{ControllerConfig, JointSpec, Live};
use link::{Frame, Hello};
use robot_compiler::SceneFile;
use sim::failure::Failure;
use sim::run::simulate;
use sim::run::world::World;
use std::path::PathBuf;

/// Data shared by all runs of a scene.
pub struct Stage<const N: usize> {
    /// Name of the scene, and the path of its file.
    pub(super) scene: (String, PathBuf),
    pub(super) world: World<N>,
    pub(super) hello: Hello,
    pub(super) config: ControllerConfig<f64, N>,
    pub(super) rules: Rules<f64, N>,
    pub(super) live: Frame,
    /// The live inputs as they should be.
    pub(super) truth: Live<f32, N>,
    pub(super) scales: [JointScale; N],
    /// Normal supply voltage, V, and temperature, degrees Celsius.
    pub(super) calm: (Option<f32>, Option<f32>),
}

impl<const N: usize> Stage<N> {
    /// Prepares the runs of a scene.
    ///
    /// # Errors
    /// The scene cannot be run.
    pub fn new(scene: &SceneFile) -> Result<Self, Failure> {
        let model = scene.robot.model::<N>().map_err(Failure::input)?;
        let (config, rules) = (scene.controller_config(&model), scene.safety_rules(&model));
        let arm = simulate::arm::<N>(scene)?;
        let scale = |i: usize| {
            let per_count = if scene.sensors.encoder { config.encoder[i].per_count } else { 0.0 };
            JointScale::new(&arm.joints[i], rules.joints[i].jump_step, per_count)
        };
        let truth = simulate::live_inputs(scene, &model);
        let live = link::Live::new(&truth)
            .map_err(|error| Failure::Input(miette::miette!("{}: {error}", scene.path.display())))?;
        let middle = |(low, high): (f64, f64), or: f32| {
            let middle = (0.5 * (low + high)) as f32;
            Some(if middle.is_finite() { middle } else { or })
        };
        Ok(Self {
            scene: (scene.name.clone(), scene.path.clone()),
            // Simulated drives would come between the injected readings and the machine.
            world: simulate::ideal_world(scene)?,
            hello: hello(scene, &model, link::Pacing::LockStep),
            live: Frame::Live(live),
            truth,
            scales: core::array::from_fn(scale),
            calm: (middle(rules.supply, 24.0), middle(rules.temperature, 30.0)),
            config,
            rules,
        })
    }
}

/// Quantities of a joint that determine the size of faults.
#[derive(Clone, Copy, Debug)]
pub(super) struct JointScale {
    /// Largest allowed change of a reading in a tick, rad or m.
    pub(super) jump_step: f64,
    /// Position per encoder count, rad or m; 0 if positions are measured directly.
    pub(super) per_count: f64,
    /// Greatest speed, rad/s or m/s.
    pub(super) velocity: f64,
    /// Lowest and highest position, rad or m.
    pub(super) position: (f64, f64),
}

impl JointScale {
    /// Creates the scales of a joint. Missing limits are replaced by typical values.
    fn new(spec: &JointSpec, jump_step: f64, per_count: f64) -> Self {
        let finite = |x: f64, or: f64| if x.is_finite() { x } else { or };
        let (low, high) = spec.limits.position;
        Self {
            jump_step: finite(jump_step, 0.01),
            per_count,
            velocity: finite(spec.limits.velocity, 3.0),
            position: (finite(low, -6.0), finite(high, 6.0)),
        }
    }
}
