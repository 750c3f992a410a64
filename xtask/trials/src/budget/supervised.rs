//! The chip under its safety state machine: homed, armed, and run along a trajectory through the arm's range.
//!
//! A tick then costs the same as on an arm, because trajectory, safety state machine and controller run in each one.

use crate::budget::Failure;
use crate::budget::random_motion::{self, Tick};
use crate::budget::report::Supervised;
use ::board::session::dry_run::{DryRun, OnChip, OnDesk};
use link::{Actuation, Cost, Frame, Lines, Point, Request, StateCode, Status, TickCost};
use robot_compiler::SceneFile;
use sim::run::simulate;

/// Ticks before the arm runs: home, confirm, full range, arm, and the rise of torque while the brakes are still engaged.
pub const TICKS_BEFORE: usize = 4 + ARMING;

/// Ticks from the request to arm until the arm is armed.
const ARMING: usize = 100;

/// Ticks from one point of the trajectory to the next.
const WAY: u16 = 4;

/// Number of points that are sent in advance.
const AHEAD: usize = 8;

/// Returns the first `ticks` ticks of the fastest motion that the desk's own session follows without leaving its running state.
///
/// # Errors
/// The scene has another number of joints, or its state machine holds or brakes even in the slowest motion.
pub fn undisturbed<const N: usize>(scene: &SceneFile, seed: u64, ticks: usize) -> Result<Vec<Tick<N>>, Failure> {
    let model = scene.robot.model::<N>().map_err(|error| Failure::Scene(error.to_string()))?;
    let mut why = String::new();
    for pace in random_motion::PACES {
        let motion = random_motion::smooth::<N>(scene, seed, ticks, pace)?;
        match drive(&mut OnDesk::start(scene, &model), scene, &motion, |_| ()) {
            Ok(()) => return Ok(motion),
            Err(Failure::NotSeen(found)) => why = format!("at pace {pace}: {found}"),
            Err(other) => return Err(other),
        }
    }
    Err(Failure::NoSwing { scene: scene.name.clone(), why })
}

/// Homes, confirms, lifts the limits of the first motion, arms, and runs a target along a motion; every tick of the motion must drive.
///
/// # Errors
/// [`Failure::NotSeen`] if a tick does not drive. Also if the chip is unusable.
pub fn drive<const N: usize>(
    target: &mut impl DryRun,
    scene: &SceneFile,
    motion: &[Tick<N>],
    mut seen: impl FnMut(&Status),
) -> Result<(), Failure> {
    let model = scene.robot.model::<N>().map_err(|error| Failure::Scene(error.to_string()))?;
    let Some(first) = motion.first() else { return Err(Failure::NotSeen("a tick: the motion has none".into())) };
    let lines = Lines::CALM;
    target.send(&Frame::Lines(lines))?;
    let live = simulate::live_inputs::<f32, N>(scene, &model);
    target.send(&Frame::Live(link::Live::new(&live).map_err(|error| Failure::Scene(error.to_string()))?))?;
    let mut number = 0;
    let mut tick = |target: &mut dyn DryRun, of: &Tick<N>| {
        number += 1;
        let mut answers = target.tick(&link::Measurement::new(number, &of.1))?;
        answers.retain(|frame| !matches!(frame, Frame::Answer(_)));
        match answers.as_slice() {
            [Frame::Status(status)] if status.refused.is_none() => Ok(status.clone()),
            other => {
                Err(Failure::NotSeen(format!("a tick that is granted and answered alone in tick {number}: {other:?}")))
            }
        }
    };
    for (number, request) in [Request::Home, Request::Confirm, Request::FullRange, Request::Arm].into_iter().enumerate()
    {
        target.send(&Frame::request(number as u8, request))?;
        tick(target, first)?;
    }
    for _ in 0..ARMING {
        tick(target, first)?;
    }
    let (last, way) = (motion.len() - 1, usize::from(WAY));
    let mut sent = None;
    for (k, of) in motion.iter().enumerate() {
        while sent.is_none_or(|sent| sent < last.min(k + AHEAD * way)) {
            let at = sent.map_or(0, |sent| last.min(sent + way));
            let ticks = u16::try_from(at - sent.unwrap_or(0)).unwrap_or(WAY);
            target.send(&Frame::Point(Point { ticks, reference: link::Reference::new(&motion[at].0) }))?;
            sent = Some(at);
        }
        if k == 0 {
            target.send(&Frame::request(u8::MAX, Request::Run))?;
        }
        let status = tick(target, of)?;
        if status.state != StateCode::Running || !matches!(status.actuation, Some(Actuation::Drive { .. })) {
            let Status { state, cause, joint, .. } = status;
            return Err(Failure::NotSeen(format!("a running tick {k}: state {state}, cause {cause}, joint {joint:?}")));
        }
        seen(&status);
    }
    Ok(())
}

/// Counts the instructions of each running tick, as reported by the chip.
///
/// # Errors
/// Those of [`drive`], or the chip returns no count.
pub fn count<const N: usize>(chip: &mut OnChip, scene: &SceneFile, motion: &[Tick<N>]) -> Result<Supervised, Failure> {
    let mut counts = Vec::new();
    drive(chip, scene, motion, |status| {
        if let Some(TickCost { all: Cost::Instructions(count), .. }) = status.cost {
            counts.push(u64::from(count));
        }
    })?;
    match counts.as_slice() {
        [granting, running @ ..] if !running.is_empty() && counts.len() == motion.len() => Ok(Supervised {
            ticks: running.len() as u64,
            min: running.iter().copied().min().unwrap_or_default(),
            max: running.iter().copied().max().unwrap_or_default(),
            granting: *granting,
        }),
        _ => Err(Failure::NotSeen("a count of instructions of every supervised tick".into())),
    }
}
