//! The time of a push is counted from the start of the simulated arm, both in `run` and on the board of `connect`, even while brakes hold the arm.

use board::session::operate::device::{Device as _, Pace};
use board::session::operate::simulated_board::{Places, SimulatedBoard};
use board::session::operate::wire::Disturbance;
use indicatif::ProgressBar;
use link::{Frame, Pacing, Parts, Request, SensedLines, Status, Watch};
use nalgebra::Vector3;
use robot_compiler::SceneFile;
use robot_compiler::scene::Push;
use sim::run::scene_world;
use sim::run::simulation;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Start of the push, s.
const AT: f64 = 0.3;

/// Two rods with brakes, with or without a push.
fn scene(pushed: bool) -> SceneFile {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/planar2r_swing.toml");
    let mut scene = SceneFile::load(&path).unwrap();
    scene.duration = Some(2.0 * AT);
    let wrench = dynamics_core::Wrench { force: Vector3::new(0.0, 20.0, 0.0), moment: Vector3::zeros() };
    scene.plant.push = pushed.then_some(Push { at: AT, duration: 0.05, wrench });
    scene
}

/// The tick in which the push begins in `run`, which drives the arm from its first tick on. Its effect is visible a tick later.
fn in_run() -> Option<usize> {
    let [free, pushed] = [false, true].map(|pushed| {
        let (stop, bar) = (AtomicBool::new(false), ProgressBar::hidden());
        simulation::run(&scene(pushed), &stop, &bar).unwrap().record
    });
    let seen =
        |tick: usize| [&free, &pushed].map(|record| record.tick(tick).iter().map(|joint| joint.q).collect::<Vec<_>>());
    let shows = (0..free.ticks()).find(|&tick| {
        let [free, pushed] = seen(tick);
        free != pushed
    });
    shows.map(|tick| tick - 1)
}

/// Measurements of the board of `connect` in each of its ticks. The brakes hold the arm until it is armed, in tick `arm`.
fn measured(pushed: bool, arm: u32) -> Vec<(u32, SensedLines)> {
    let scene = scene(pushed);
    let model = scene.robot.model::<2>().unwrap();
    let (world, nowhere) = (scene_world::world::<2>(&scene).unwrap(), Places { host: false, buses: false });
    let mut board = SimulatedBoard::new((&scene, &model), world, Disturbance::default(), nowhere, Pace::default());
    board.send(&Frame::Hello(board::chip::hello(&scene, &model, Pacing::Live))).unwrap();
    board.send(&Frame::Watch(Watch { every: 1, parts: Parts::SENSED })).unwrap();
    let mut measured = Vec::new();
    let mut driven = false;
    for tick in 1..=(2.0 * AT * scene.control.rate) as u32 {
        let request = match tick {
            3 => Some((1, Request::Home)),
            5 => Some((2, Request::Confirm)),
            tick if tick == arm => Some((3, Request::Arm)),
            _ => None,
        };
        if let Some((number, request)) = request {
            board.send(&Frame::request(number, request)).unwrap();
        }
        for frame in board.pass().unwrap() {
            if let Frame::Status(Status { tick, state, sensed: Some(sensed), .. }) = frame {
                measured.push((tick, sensed));
                driven |= state == link::StateCode::Armed;
            }
        }
    }
    assert!(driven, "it was never armed");
    measured
}

/// As [`in_run`], on the board of `connect`.
fn on_the_board(arm: u32) -> Option<usize> {
    let [free, pushed] = [false, true].map(|pushed| measured(pushed, arm));
    let shows = free.iter().zip(&pushed).find(|(free, pushed)| free != pushed);
    // The board counts its ticks from 1, and the effect of the push is visible a tick later.
    shows.map(|((tick, _), _)| *tick as usize - 2)
}

#[test]
fn a_push_begins_at_its_time_in_run_and_on_a_board_whenever_it_is_armed() {
    let begins = (AT * scene(true).control.rate).round() as usize;
    assert_eq!(in_run(), Some(begins));
    for arm in [10, 100, 250] {
        assert_eq!(on_the_board(arm), Some(begins), "armed in tick {arm}");
    }
}
