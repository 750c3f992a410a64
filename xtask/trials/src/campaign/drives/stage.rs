//! The data that all runs of a scene with drives share, and the stops of its joints.

use super::judge::Known;
use crate::campaign::stage::Stage;
use dynamics_core::Reference;
use dynamics_core::safety::SafeAction;
use robot_compiler::SceneFile;
use sim::failure::Failure;
use sim::plant::{Arm, Diverged};
use sim::run::simulate;
use sim::run::world::World;

/// Depth to which a joint's greatest torque presses it into its stop, rad.
const STOP_DEPTH: f64 = 0.02;

/// Longest time in which an arm without brakes comes to rest on its stops before a run, s, and the speed that counts as rest, rad/s.
const SETTLING: f64 = 10.0;
const RESTING: f64 = 1e-3;

/// Time that the simulated brakes need to engage after they lose power, s; they open at once.
pub const BRAKES_ENGAGE: f64 = 0.08;

/// Time in which the host blends from the arm's position into the scene's motion, s.
const BLEND: f64 = 0.2;

/// Data shared by all runs of a scene.
pub struct DrivesStage<const N: usize> {
    pub(super) stage: Stage<N>,
    pub(super) world: World<N>,
    pub(super) arm: Arm<N>,
    pub(super) known: [Known; N],
    /// Turns of a drive's shaft per turn of its joint.
    pub(super) ratios: [f64; N],
    pub(super) tells_state: bool,
    pub(super) brakes: bool,
    pub(super) stops: [JointStop; N],
    /// Ticks of arming, and the most ticks of lowering.
    pub(super) arming: u32,
    pub(super) lowering: u32,
}

/// Stops at the ends of a joint's range.
#[derive(Clone, Copy, Debug)]
pub(super) struct JointStop {
    range: (f64, f64),
    stiffness: f64,
    damping: f64,
}

impl JointStop {
    /// True if the joint is at a stop or close to it.
    fn is_near(&self, q: f64) -> bool {
        q < self.range.0 + STOP_DEPTH || q > self.range.1 - STOP_DEPTH
    }

    /// Torque of the stops, N m. They push and never pull.
    fn torque(&self, q: f64, qd: f64) -> f64 {
        let Self { range: (low, high), stiffness, damping } = *self;
        if q < low {
            (stiffness * (low - q) - damping * qd).max(0.0)
        } else if q > high {
            (stiffness * (high - q) - damping * qd).min(0.0)
        } else {
            0.0
        }
    }
}

impl<const N: usize> DrivesStage<N> {
    /// Creates the data before the ticks of arming are known.
    ///
    /// # Errors
    /// The scene cannot be run, or its robot has no drives on CAN.
    pub(super) fn unarmed(scene: &SceneFile) -> Result<Self, Failure> {
        let stage = Stage::<N>::new(scene)?;
        let Some((specs, wires)) = scene.simulated_drives::<N>() else {
            return Err(Failure::Input(miette::miette!(
                help = "expected a robot with [joint.drive] on CAN at every joint, and no `actuators.ideal`",
                "{}: no drives to simulate",
                scene.path.display()
            )));
        };
        let frictions = if scene.plant.friction { Some(simulate::friction_laws::<N>(scene)) } else { None };
        let known = |i: usize| {
            let ratio = specs[i].ratio.abs();
            let friction = frictions.map_or((0.0, 0.0), |frictions| (frictions[i].viscous, frictions[i].coulomb));
            Known { damping: ratio * ratio * f64::from(wires[i].damping), torque: ratio * specs[i].torque.1, friction }
        };
        let stop = |i: usize| {
            let limits = &stage.config.limits[i];
            let stiffness = limits.torque / STOP_DEPTH;
            let inertia = stage.config.gains[i].inertia;
            JointStop { range: limits.position, stiffness, damping: 1.4 * (stiffness * inertia).sqrt() }
        };
        let mut world = simulate::world::<N>(scene)?;
        world.ask();
        let brakes = scene.safety.safe_action == SafeAction::Brake;
        let stops = core::array::from_fn(stop);
        if !brakes {
            // The drives are off.
            for tick in 0..(SETTLING / world.period) as u32 {
                if tick > 100 && world.plant.state().qd.iter().all(|qd| qd.abs() < RESTING) {
                    break;
                }
                pass(&mut world, &stops).map_err(|diverged| Failure::Input(miette::miette!("{diverged}")))?;
            }
        }
        let far = |i: usize| {
            let rest = stage.rules.rest.map_or(0.0, |rest| rest[i]);
            let points = (0..=10).map(|k| world.reference(0.1 * f64::from(k) * world.motion.duration()).q[i]);
            points.map(|q| (q - rest).abs()).fold(0.0, f64::max) / stage.rules.joints[i].lowering_speed
        };
        let lowering = stage.rules.rest.map_or(0.0, |_| 1.2) * (0..N).map(far).fold(0.0, f64::max) + 0.3;
        Ok(Self {
            arm: simulate::arm(scene)?,
            known: core::array::from_fn(known),
            ratios: specs.map(|spec| spec.ratio),
            tells_state: scene.protocol().is_none_or(|protocol| protocol.facts().reports_state),
            brakes,
            stops,
            arming: 0,
            lowering: (lowering / world.period) as u32,
            stage,
            world,
        })
    }
}

/// Advances the simulation by one period without brakes.
pub(super) fn pass<const N: usize>(world: &mut World<N>, stops: &[JointStop; N]) -> Result<(), Diverged> {
    let World { plant, drives: Some(drives), .. } = world else { return Ok(()) };
    let q = plant.state().q;
    let near = (0..N).any(|i| stops[i].is_near(q[i]));
    let turns = if near { drives.turns().max(10) } else { drives.turns() };
    plant.drive_renewed(turns, |state, dt| {
        let torque = drives.torque(state, dt);
        core::array::from_fn(|i| torque[i] + stops[i].torque(state.q[i], state.qd[i]))
    })
}

/// The scene's motion, blended in from an arm that starts at `offset` (rad) from its beginning.
pub(super) fn blended<const N: usize>(world: &World<N>, ticks: u32, offset: &[f64; N]) -> Reference<f64, N> {
    let t = f64::from(ticks) * world.period;
    let mut reference = world.reference(t);
    let x = t / BLEND;
    if x < 1.0 {
        let left = 1.0 - x * x * x * (10.0 - 15.0 * x + 6.0 * x * x);
        let speed = -30.0 * x * x * (1.0 - 2.0 * x + x * x) / BLEND;
        let acceleration = -60.0 * x * (1.0 - 3.0 * x + 2.0 * x * x) / (BLEND * BLEND);
        for i in 0..N {
            reference.q[i] += left * offset[i];
            reference.qd[i] += speed * offset[i];
            reference.qdd[i] += acceleration * offset[i];
        }
    }
    reference
}
