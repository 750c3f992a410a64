//! Collisions of the Puma: what the observer sees in free motion, how soon it sees a push, and what is done then.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use dynamics_core::control::{LimitFlags, Reaction};
use dynamics_core::{Command, Fault, Live, Measurement, Reference, Wrench};
use host_sim::simulate::{self, Desk, Run};
use host_sim::target::{Ticked, Torques};
use indicatif::ProgressBar;
use nalgebra::Vector3;
use robot_compiler::SceneFile;
use robot_compiler::scene::{MotionSpec, PushSpec};
use std::path::Path;
use std::sync::atomic::AtomicBool;

fn scene(name: &str) -> SceneFile {
    SceneFile::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../scenes/{name}.toml"))).unwrap()
}

/// The desk's controller, and what its observer has seen.
struct Watched {
    desk: Desk<f32, 6>,
    /// Largest residual of each joint, N m.
    worst: [f64; 6],
    /// The first tick in which something was done about a collision.
    collided: Option<(usize, Option<Fault>)>,
    ticks: usize,
}

impl Torques<f32, 6> for Watched {
    fn set_live(&mut self, live: &Live<f32, 6>) -> miette::Result<()> {
        self.desk.set_live(live)
    }

    fn tick(
        &mut self,
        reference: &Reference<f32, 6>,
        measurement: &Measurement<f32, 6>,
    ) -> miette::Result<Ticked<f32, 6>> {
        let ticked = Torques::tick(&mut self.desk, reference, measurement)?;
        for (worst, residual) in self.worst.iter_mut().zip(self.desk.protection().as_ref().unwrap().residual()) {
            *worst = worst.max(f64::from(residual.abs()));
        }
        let seen = match &ticked.command {
            Command::Brake(fault) => Some(Some(*fault)),
            Command::Drive { limits, .. } => {
                limits.iter().any(|flags| flags.contains(LimitFlags::COLLISION)).then_some(None)
            }
        };
        self.collided = self.collided.or(seen.map(|fault| (self.ticks, fault)));
        self.ticks += 1;
        Ok(ticked)
    }
}

fn run(scene: &SceneFile) -> (Watched, Run) {
    let model = scene.robot.model::<6>().unwrap();
    let desk = simulate::desk(scene, &model);
    let mut target = Watched { desk, worst: [0.0; 6], collided: None, ticks: 0 };
    let (stop, bar) = (AtomicBool::new(false), ProgressBar::hidden());
    let run = simulate::with::<f32, 6, _>(scene, "desk", &mut target, &stop, &bar).unwrap();
    (target, run)
}

/// Each joint's largest residual as a share of the threshold of `puma560_collision.toml`, and whether that scene's watch did
/// anything about it.
fn free(name: &str) -> ([f64; 6], bool) {
    let mut scene = scene(name);
    scene.collision = self::scene("puma560_collision").collision;
    scene.plant.push = None;
    let (watched, _) = run(&scene);
    let threshold = scene.collision.unwrap().threshold;
    (core::array::from_fn(|i| watched.worst[i] / threshold[i]), watched.collided.is_some())
}

#[test]
fn free_motion_of_the_shipped_puma_scenes_is_no_collision() {
    for name in [
        "puma560_collision",
        "puma560_pick",
        "puma560_ideal",
        "puma560_pd_gravity",
        "puma560_slow_model",
        "puma560_wrong_payload",
        "puma560_elastic",
        "puma560_auto",
    ] {
        let (shares, collided) = free(name);
        println!("{name}: {shares:.2?} {collided}");
    }
}

/// `puma560_collision.toml`, this much slower, pushed at the tip with this force (N, tip axes) from a share of the motion on.
fn pushed(slower: f64, at: f64, force: Vector3<f64>, reaction: Reaction) -> SceneFile {
    let mut scene = scene("puma560_collision");
    if let MotionSpec::Quintic { points, .. } = &mut scene.motion {
        for duration in points.iter_mut().filter_map(|point| point.duration.as_mut()) {
            *duration *= slower;
        }
    }
    let at = at * 2.1 * slower;
    scene.plant.push = Some(PushSpec { at, duration: 0.5, wrench: Wrench { force, moment: Vector3::zeros() } });
    scene.collision.as_mut().unwrap().reaction = reaction;
    scene
}

/// Time from the begin of a push to the fault, s.
fn detected(slower: f64, at: f64, force: Vector3<f64>) -> Option<f64> {
    let scene = pushed(slower, at, force, Reaction::Stop);
    let begin = (scene.plant.push.unwrap().at * scene.control.rate).round();
    let (tick, fault) = run(&scene).0.collided?;
    assert!(matches!(fault, Some(Fault::Collision { .. })), "{fault:?}");
    assert!(tick as f64 > begin, "before the push");
    Some((tick as f64 - begin) / scene.control.rate)
}

const AXES: [Vector3<f64>; 3] = [Vector3::new(1.0, 0.0, 0.0), Vector3::new(0.0, 1.0, 0.0), Vector3::new(0.0, 0.0, 1.0)];

#[test]
fn pushes_are_detected_in_the_times_that_are_documented() {
    for (motion, slower) in [("fast", 1.0), ("slow", 4.0)] {
        for newtons in [30.0, 50.0, 75.0, 100.0, 150.0, 200.0] {
            let mut times = Vec::new();
            for axis in AXES {
                for sign in [1.0, -1.0] {
                    for at in [0.1, 0.25, 0.4, 0.65, 0.8] {
                        times.push(detected(slower, at, axis * (sign * newtons)));
                    }
                }
            }
            let mut found: Vec<f64> = times.iter().flatten().copied().collect();
            found.sort_by(f64::total_cmp);
            let middle = found.get(found.len() / 2);
            println!(
                "{motion} {newtons} N: {} of {}, {:?} {middle:?} {:?} ms",
                found.len(),
                times.len(),
                found.first(),
                found.last()
            );
        }
    }
}
