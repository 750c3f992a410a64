//! The control loop: reference, sensors, controller (on any target), actuators, arm; once per control period.

use crate::plant::Diverged;
use crate::plant::solver::{Solver, now};
use crate::run::record::{JointSample, Record};
use crate::run::target::{Ticked, Torques};
pub use crate::run::world::World;
use crate::run::wrench::tip_wrench;
use dynamics_core::control::LimitFlags;
use dynamics_core::{Command, Fault, Real};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Reason why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The run lasted its whole duration.
    Complete,
    /// The caller set the stop flag.
    Interrupted,
    /// The simulation of the arm diverged.
    Diverged(Diverged),
    /// The target failed or sent an invalid answer.
    TargetFailed,
}

/// Outcome of a run.
#[derive(Debug)]
pub struct Closed {
    /// Reason why the run ended.
    pub end: End,
    /// Time that the run took.
    pub timing: Timing,
    /// Error of the target, if it failed.
    pub failure: Option<miette::Report>,
}

/// Wall-clock time of a run.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Timing {
    /// The whole loop.
    pub whole: Duration,
    /// The controller's ticks alone.
    pub ticks: Duration,
}

/// Runs `ticks` control periods, or until `stop` is set. Calls `after_tick` with the number of completed ticks.
///
/// Simulated drives are on and have replied when the run begins. A fault of the controller or of a drive latches: the arm brakes, or simulated drives
/// do the safe action. The run then goes on to its end, because that motion is part of the result. A target that fails ends the run; `record` keeps
/// all ticks before the failure.
pub fn run<S: Real, const N: usize>(
    world: &mut World<N>,
    controller: &mut impl Torques<S, N>,
    ticks: u64,
    stop: &AtomicBool,
    record: &mut Record,
    after_tick: impl FnMut(u64),
) -> Closed {
    now(run_with(Solver::AtOnce, world, controller, ticks, stop, record, after_tick))
}

/// As [`run`], with this solver.
pub(crate) async fn run_with<S: Real, const N: usize>(
    solver: Solver<'_, N>,
    world: &mut World<N>,
    controller: &mut (impl Torques<S, N> + ?Sized),
    ticks: u64,
    stop: &AtomicBool,
    record: &mut Record,
    mut after_tick: impl FnMut(u64),
) -> Closed {
    let start = Instant::now();
    let mut timing = Timing::default();
    let (mut end, mut failure) = (End::Complete, None);
    let mut latched = None;
    world.switch_on();
    for tick in 0..ticks {
        if stop.load(Ordering::Relaxed) {
            end = End::Interrupted;
            break;
        }
        let t = tick as f64 * world.period;
        let reference = world.reference(t);
        let state = *world.plant.state();
        let sensing = world.sense::<S>();
        latched = latched.or_else(|| world.fault(&sensing));
        let input = reference.cast::<S>();
        let before = solver.alone().then(Instant::now);
        let ticked = controller.tick(&input, &sensing.measurement);
        timing.ticks += before.map_or(Duration::ZERO, |before| before.elapsed());
        let Ticked { command, .. } = match ticked {
            Ok(ticked) => ticked,
            Err(report) => {
                (end, failure) = (End::TargetFailed, Some(report));
                break;
            }
        };
        let (torque, limits, fault) = outcome(&latched.map_or(command, Command::Brake));
        let sample = |i: usize| JointSample {
            q_reference: reference.q[i],
            q: state.q[i],
            qd_reference: reference.qd[i],
            qd: state.qd[i],
            torque: torque[i],
            limits: limits[i],
        };
        record.push::<N>(t, core::array::from_fn(sample), fault);
        if let Some(external) = controller.external() {
            record.push_external(external, tip_wrench(&world.model, &state.q, &external));
        }
        let passed =
            if fault.is_some() { world.stop_with(solver).await } else { world.drive_with(solver, &torque).await };
        if let Err(diverged) = passed {
            end = End::Diverged(diverged);
            break;
        }
        after_tick(tick + 1);
    }
    timing.whole = start.elapsed();
    Closed { end, timing, failure }
}

/// Torques (N m or N), limits that acted, fault.
fn outcome<S: Real, const N: usize>(command: &Command<S, N>) -> ([f64; N], [LimitFlags; N], Option<Fault>) {
    match command {
        Command::Drive { torque, limits } => (torque.map(|x| x.to_f64()), *limits, None),
        Command::Brake(fault) => ([0.0; N], [LimitFlags::NONE; N], Some(*fault)),
    }
}
