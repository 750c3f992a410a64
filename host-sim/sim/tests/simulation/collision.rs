//! Collisions of the Puma: the observer's residuals in free motion, the delay until it detects a push, and the reaction.

use dynamics_core::control::{CollisionReaction, LimitFlags};
use dynamics_core::{Command, Fault, Live, Measurement, Reference, Wrench};
use indicatif::ProgressBar;
use nalgebra::Vector3;
use robot_compiler::SceneFile;
use robot_compiler::scene::{MotionSpec, Push};
use sim::run::simulate::{self, Desk, Run, RunOptions};
use sim::run::target::{Ticked, Torques};
use std::path::Path;
use std::sync::atomic::AtomicBool;

fn scene(name: &str) -> SceneFile {
    SceneFile::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../scenes/{name}.toml"))).unwrap()
}

/// The desk's controller, and a record of its observer.
struct Watched {
    desk: Desk<f32, 6>,
    /// Largest residual of each joint, N m.
    worst: [f64; 6],
    /// First tick with a reaction to a collision.
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
    let (stop, progress) = (&AtomicBool::new(false), &ProgressBar::hidden());
    let run = simulate::with(&RunOptions { scene, target: "desk", stop, progress }, &mut target).unwrap();
    (target, run)
}

/// Asserts that a value is within a relative tolerance of the measured one.
fn assert_near(found: f64, measured: f64, share: f64, what: &str) {
    println!("{what}: {found:.4e}");
    assert!((found / measured - 1.0).abs() <= share, "{what}: {found:.4e}, measured before: {measured:.4e}");
}

/// Largest residual of each joint without a push, relative to its threshold in `puma560_collision.toml`. The observer must detect nothing.
fn free(name: &str) -> [f64; 6] {
    let mut scene = scene(name);
    scene.collision = self::scene("puma560_collision").collision;
    scene.plant.push = None;
    let (watched, run) = run(&scene);
    assert_eq!(watched.collided, None, "{name}");
    assert!(run.summary.faults.is_empty() && watched.ticks as f64 >= 0.9 * scene.control.rate, "{name}");
    let threshold = scene.collision.unwrap().threshold;
    core::array::from_fn(|i| watched.worst[i] / threshold[i])
}

#[test]
fn free_motion_of_the_shipped_puma_scenes_is_no_collision() {
    let measured = [
        ("puma560_pick", [0.57, 0.50, 0.51, 0.52, 0.52, 0.53]),
        // Without friction and encoder counts, only rounding and sampling errors remain.
        ("puma560_ideal", [0.00, 0.00, 0.00, 0.00, 0.00, 0.00]),
        ("puma560_pd_gravity", [0.50, 0.26, 0.37, 0.49, 0.42, 0.28]),
        ("puma560_slow_model", [0.58, 0.50, 0.49, 0.53, 0.54, 0.54]),
        ("puma560_wrong_payload", [0.50, 0.35, 0.43, 0.47, 0.43, 0.28]),
        ("puma560_elastic", [0.45, 0.48, 0.59, 0.56, 0.50, 0.53]),
        ("puma560_auto", [0.61, 0.32, 0.46, 0.57, 0.47, 0.35]),
    ];
    let (mut largest, mut wrong) = ([0.0_f64; 6], Vec::new());
    for (name, measured) in measured {
        let found = free(name);
        println!("(\"{name}\", {found:.2?}),");
        for joint in 0..6 {
            largest[joint] = largest[joint].max(found[joint]);
            let off = (found[joint] - measured[joint]).abs();
            if off >= 0.005 + 0.05 * measured[joint] {
                wrong.push((name, joint + 1, found[joint]));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
    // The margin for which the thresholds were chosen.
    assert!(largest.iter().all(|share| (0.5..0.63).contains(share)), "{largest:?}");
}

/// `puma560_collision.toml`, slowed down, with a push at the tip (force in N, tip axes) that starts at this fraction of the motion.
fn pushed(slower: f64, share: f64, force: Vector3<f64>, reaction: CollisionReaction) -> SceneFile {
    let mut scene = scene("puma560_collision");
    if let MotionSpec::Quintic { points, .. } = &mut scene.motion {
        for duration in points.iter_mut().filter_map(|point| point.duration.as_mut()) {
            *duration *= slower;
        }
    }
    let at = share * 2.1 * slower;
    scene.plant.push = Some(Push { at, duration: 0.5, wrench: Wrench { force, moment: Vector3::zeros() } });
    scene.duration = Some(at + 0.5);
    scene.collision.as_mut().unwrap().reaction = reaction;
    scene
}

/// Number of ticks from the start of a push to the fault; a tick is 1 ms.
fn detected(slower: f64, share: f64, force: Vector3<f64>) -> Option<usize> {
    let scene = pushed(slower, share, force, CollisionReaction::Stop);
    let begin = (scene.plant.push.unwrap().at * scene.control.rate).round() as usize;
    let (tick, fault) = run(&scene).0.collided?;
    assert!(matches!(fault, Some(Fault::Collision { .. })), "{fault:?}");
    assert!(tick > begin, "before the push");
    Some(tick - begin)
}

#[test]
fn pushes_are_detected_in_the_times_that_are_documented() {
    // Number of detections in 30 pushes, and the shortest, median and longest delay, ms.
    let measured = [
        ("fast", 1.0, 30.0, 2, [47, 341, 341]),
        ("fast", 1.0, 50.0, 25, [14, 36, 434]),
        ("fast", 1.0, 75.0, 30, [11, 16, 31]),
        ("fast", 1.0, 100.0, 30, [9, 12, 18]),
        ("fast", 1.0, 200.0, 30, [7, 8, 10]),
        ("slow", 4.0, 30.0, 2, [208, 349, 349]),
        ("slow", 4.0, 50.0, 20, [14, 25, 397]),
        ("slow", 4.0, 75.0, 30, [10, 16, 32]),
        ("slow", 4.0, 100.0, 30, [9, 12, 18]),
        ("slow", 4.0, 200.0, 30, [7, 8, 10]),
    ];
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let mut wrong = 0;
    for (motion, slower, newtons, count, times) in measured {
        let mut found = Vec::new();
        for force in axes.iter().flat_map(|axis| [axis * newtons, axis * -newtons]) {
            found.extend([0.1, 0.25, 0.4, 0.65, 0.8].into_iter().filter_map(|share| detected(slower, share, force)));
        }
        found.sort_unstable();
        let ends = |list: &[usize]| {
            if list.is_empty() { [0; 3] } else { [list[0], list[list.len() / 2], list[list.len() - 1]] }
        };
        let (found, number) = (ends(&found), found.len());
        println!("(\"{motion}\", {slower:.1}, {newtons:.1}, {number}, {found:?}),");
        // Within a millisecond or a tenth, because different rounding may shift a tick.
        let near = found.iter().zip(times).all(|(&a, b)| a.abs_diff(b) <= 1 + b / 10);
        wrong += usize::from(number != count || !near);
    }
    assert_eq!(wrong, 0, "measured before: {measured:?}");
}

#[test]
fn a_hold_stands_against_the_push_and_what_complies_gives_way() {
    // Distance of the farthest joint from its position at detection, at the end of the push, mrad.
    let measured = [(CollisionReaction::Hold, 5.91), (CollisionReaction::Comply, 72.06)];
    for (reaction, measured) in measured {
        let scene = pushed(1.0, 0.4, Vector3::new(0.0, 0.0, -100.0), reaction);
        let (watched, run) = run(&scene);
        let (tick, fault) = watched.collided.unwrap();
        assert_eq!((fault, run.summary.faults.len()), (None, 0));
        let moved = (0..6).map(|joint| {
            let q: Vec<f64> = run.record.joint(joint).map(|sample| sample.q).collect();
            (q[q.len() - 1] - q[tick]).abs()
        });
        let moved = 1e3 * moved.fold(0.0, f64::max);
        println!("{reaction:?}: {moved:.2} mrad");
        assert_near(moved, measured, 0.05, &format!("{reaction:?}"));
        let flagged: u64 = run.summary.limits.iter().map(|limits| limits.collision).sum();
        assert_eq!(flagged, (watched.ticks - tick) as u64);
    }
}
