//! Random motions that the controller follows without a fault or an active limit.
//!
//! Independent random states would be jumps, which are faults. So every joint oscillates through its range at its own speed, and the reference is
//! drawn at random near this motion in every tick. The desk's controller tries the whole motion first.

use crate::budget::Failure;
use dynamics_core::{Command, Measurement, Reference, Sensed};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};
use robot_compiler::SceneFile;
use sim::run::simulate;

/// Inputs of one tick.
pub type Tick<const N: usize> = (Reference<f32, N>, Measurement<f32, N>);

/// Half the range (rad, m) of a joint without position limits.
const FREE: f64 = 2.0;

/// Greatest speed (rad/s, m/s) of a joint without a velocity limit.
const FREE_SPEED: f64 = 1.0;

/// Scales of the motion, the fastest first. Each applies to the speed, and to the distance between reference and state.
pub(crate) const PACES: [f64; 8] = [1.0, 0.7, 0.5, 0.35, 0.25, 0.15, 0.08, 0.03];

/// Returns the first `ticks` ticks of the fastest motion that the scene's controller follows undisturbed. The same seed gives the same motion.
///
/// # Errors
/// The scene has another number of joints, or its controller brakes or limits even in the slowest motion.
pub fn undisturbed<const N: usize>(scene: &SceneFile, seed: u64, ticks: usize) -> Result<Vec<Tick<N>>, Failure> {
    let mut why = String::new();
    for pace in PACES {
        let motion = at_pace::<N>(scene, seed, ticks, pace)?;
        match first_disturbance(scene, &motion)? {
            None => return Ok(motion),
            Some(found) => why = format!("at pace {pace}: {found}"),
        }
    }
    Err(Failure::NoSwing { scene: scene.name.clone(), why })
}

/// The first tick in which the desk's controller brakes or reaches a limit, and the reason; `None` if there is none.
fn first_disturbance<const N: usize>(scene: &SceneFile, motion: &[Tick<N>]) -> Result<Option<String>, Failure> {
    let model = scene.robot.model::<N>().map_err(|error| Failure::Scene(error.to_string()))?;
    let mut desk = simulate::desk::<f32, N>(scene, &model);
    *desk.live_mut() = simulate::live_inputs(scene, &model);
    for (number, (reference, measurement)) in motion.iter().enumerate() {
        match desk.tick(reference, measurement) {
            Command::Brake(fault) => return Ok(Some(format!("tick {number}: {fault}"))),
            Command::Drive { limits, .. } => {
                if let Some(joint) = limits.iter().position(|limit| limit.bits() != 0) {
                    return Ok(Some(format!("tick {number}: limits of joint {}: {:?}", joint + 1, limits[joint])));
                }
            }
        }
    }
    Ok(None)
}

fn at_pace<const N: usize>(scene: &SceneFile, seed: u64, ticks: usize, pace: f64) -> Result<Vec<Tick<N>>, Failure> {
    swung(scene, seed, ticks, pace, pace)
}

/// The motion at one scale, with its reference equal to the state.
pub(crate) fn smooth<const N: usize>(
    scene: &SceneFile,
    seed: u64,
    ticks: usize,
    pace: f64,
) -> Result<Vec<Tick<N>>, Failure> {
    swung(scene, seed, ticks, pace, 0.0)
}

/// A motion with references drawn near it; `about` scales their distance from it.
fn swung<const N: usize>(
    scene: &SceneFile,
    seed: u64,
    ticks: usize,
    pace: f64,
    about: f64,
) -> Result<Vec<Tick<N>>, Failure> {
    let model = scene.robot.model::<N>().map_err(|error| Failure::Scene(error.to_string()))?;
    let config = scene.controller_config(&model);
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let range = config.limits.map(|limit| bounded(limit.position));
    let middle = range.map(|(low, high)| f64::midpoint(low, high));
    // Amplitude: in a random direction, 95 % of half the range.
    let reach: [f64; N] = std::array::from_fn(|i| {
        let side = if rng.next_u32().is_multiple_of(2) { 1.0 } else { -1.0 };
        side * 0.95 * (range[i].1 - range[i].0) / 2.0
    });
    // Speed: 50 % to 80 % of the greatest speed at full scale.
    let omega: [f64; N] = std::array::from_fn(|i| {
        let speed = if config.limits[i].velocity.is_finite() { config.limits[i].velocity } else { FREE_SPEED };
        2.0 * pace * (0.65 + within(&mut rng, 0.15)) * speed / reach[i].abs()
    });
    let motion = (0..ticks).map(|tick| {
        let t = tick as f64 * scene.period();
        let q: [f64; N] = std::array::from_fn(|i| middle[i] + reach[i] * (1.0 - (omega[i] * t).cos()) / 2.0);
        let qd: [f64; N] = std::array::from_fn(|i| reach[i] * omega[i] * (omega[i] * t).sin() / 2.0);
        let qdd: [f64; N] = std::array::from_fn(|i| reach[i] * omega[i].powi(2) * (omega[i] * t).cos() / 2.0);
        let mut near = |of: [f64; N], width: f64| of.map(|x| (x + within(&mut rng, width * about)) as f32);
        let reference = Reference { q: near(q, 2e-3), qd: near(qd, 0.05), qdd: near(qdd, 1.0) };
        let sensed = if scene.sensors.encoder {
            let counts = |i: usize| {
                let encoder = &config.encoder[i];
                (q[i] / encoder.per_count).round() as i32
            };
            Sensed::Counts(std::array::from_fn(counts))
        } else {
            Sensed::State { q: q.map(|x| x as f32), qd: qd.map(|x| x as f32) }
        };
        (reference, Measurement { sensed, age_ticks: 0 })
    });
    Ok(motion.collect())
}

/// A joint's range, with a default for missing limits.
fn bounded((low, high): (f64, f64)) -> (f64, f64) {
    match (low.is_finite(), high.is_finite()) {
        (true, true) => (low, high),
        (true, false) => (low, low + 2.0 * FREE),
        (false, true) => (high - 2.0 * FREE, high),
        (false, false) => (-FREE, FREE),
    }
}

/// Uniform in `[-width, width)`.
fn within(rng: &mut ChaCha8Rng, width: f64) -> f64 {
    width * (f64::from(rng.next_u32()) / f64::from(1_u32 << 31) - 1.0)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

    use super::{at_pace, bounded, first_disturbance, undisturbed};
    use robot_compiler::SceneFile;
    use std::path::Path;

    fn scene(name: &str) -> SceneFile {
        SceneFile::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name)).unwrap()
    }

    #[test]
    fn a_motion_is_one_for_one_seed_and_another_for_another() {
        let scene = scene("puma560_pick.toml");
        let motion = |seed| undisturbed::<6>(&scene, seed, 50).unwrap();
        assert_eq!(motion(1), motion(1));
        assert_ne!(motion(1), motion(2));
    }

    #[test]
    fn what_disturbs_is_named_with_its_tick() {
        let scene = scene("puma560_pick.toml");
        // Twenty times the speed: the guard or a limit must detect it.
        let wild = at_pace::<6>(&scene, 1, 200, 20.0).unwrap();
        assert!(first_disturbance(&scene, &wild).unwrap().unwrap().starts_with("tick "));
    }

    #[test]
    fn a_joint_without_limits_gets_a_range() {
        let infinite = f64::INFINITY;
        assert_eq!(bounded((-1.0, 3.0)), (-1.0, 3.0));
        assert_eq!(bounded((-infinite, infinite)), (-2.0, 2.0));
        assert_eq!(bounded((1.0, infinite)), (1.0, 5.0));
        assert_eq!(bounded((-infinite, 1.0)), (-3.0, 1.0));
    }
}
