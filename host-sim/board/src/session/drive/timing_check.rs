//! The rate that this computer holds, without an arm: the control thread with a simulated arm, as long as the caller wishes.

use super::lateness::{Quantiles, TickTimes, Times};
use crate::real_time::{self, RealTime, period, wait_until};
use crate::session::dry_run::{DryRun, OnDesk};
use link::{Frame, Joints, Measurement, Reference, Sensed};
use robot_compiler::{SceneFile, with_dof};
use serde::Serialize;
use sim::failure::Failure;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Result of the check.
#[derive(Clone, Debug)]
pub struct TimingCheck {
    /// Times of the ticks.
    pub times: TickTimes,
    /// Priority and memory that the system allowed.
    pub real_time: RealTime,
}

/// Result of the check, for programs. Times are in us, rates in Hz.
#[derive(Clone, Debug, Serialize)]
pub struct TimingReport {
    /// Rate of the scene.
    pub rate: f64,
    /// Number of ticks.
    pub ticks: u64,
    /// Ticks that ended after the next one was due.
    pub overruns: u64,
    /// From the time when a tick was due to its begin: p50, p99, p99.99, worst.
    pub late: [f64; 4],
    /// From its begin to its end: the same quantiles.
    pub took: [f64; 4],
    /// Highest rate at which 9,999 of 10,000 ticks would have ended in time.
    pub rate_p99_99: f64,
    /// Highest rate at which every tick would have ended in time.
    pub rate_worst: f64,
    /// True if the system gave real-time priority.
    pub real_time: bool,
}

impl TimingCheck {
    /// The result for programs.
    #[must_use]
    pub fn report(&self, scene: &SceneFile) -> TimingReport {
        let [late, took, ended] = [&self.times.late, &self.times.took, &self.times.ended].map(Times::quantiles);
        let us =
            |found: Quantiles| [found.p50, found.p99, found.p99_99, found.worst].map(|time| time.as_secs_f64() * 1e6);
        TimingReport {
            rate: scene.control.rate,
            ticks: self.times.late.count(),
            overruns: self.times.overruns,
            late: us(late),
            took: us(took),
            rate_p99_99: 1.0 / ended.p99_99.as_secs_f64(),
            rate_worst: 1.0 / ended.worst.as_secs_f64(),
            real_time: self.real_time.priority.is_none(),
        }
    }

    /// The result for a person. One late tick ends a session with a fault, so the rate of the worst tick is what counts.
    #[must_use]
    pub fn text(&self, scene: &SceneFile) -> String {
        let TimingReport { rate, rate_worst, rate_p99_99, overruns, .. } = self.report(scene);
        let verdict = match overruns {
            0 => format!("this computer held {rate:.0} Hz"),
            _ => format!(
                "this computer did not hold {rate:.0} Hz: each tick that ends too late is fault 6, and stops the arm"
            ),
        };
        format!(
            "{}\n{}\n{verdict}; its worst tick would have fitted {rate_worst:.0} Hz, 9,999 of 10,000 {rate_p99_99:.0} Hz, without adapter and bus\n",
            self.real_time.text(),
            self.times
        )
    }
}

/// Runs the scene's session at the scene's rate for `time`, on a thread with the control thread's priority. Ends early if `stops` is set.
///
/// # Errors
/// The scene is not possible.
pub fn check(scene: &SceneFile, time: Duration, stops: &AtomicBool) -> Result<TimingCheck, Failure> {
    with_dof!(scene.robot.dof(), N => {
        let model = scene.robot.model::<N>().map_err(Failure::input)?;
        let mut desk = OnDesk::<N>::bench(scene, &model);
        std::thread::scope(|scope| {
            let thread = scope.spawn(|| timed(scene, &mut desk, N, time, stops));
            thread.join().unwrap_or_else(|_| Err(Failure::Target(miette::miette!("the control thread ended"))))
        })
    })
}

fn timed(
    scene: &SceneFile,
    desk: &mut dyn DryRun,
    joints: usize,
    time: Duration,
    stops: &AtomicBool,
) -> Result<TimingCheck, Failure> {
    let real_time = real_time::prepare();
    let bad = |error: &dyn std::fmt::Display| Failure::Target(miette::miette!("{error}"));
    let mut times = TickTimes::new().map_err(|error| bad(&error))?;
    let period = period(scene.control.rate);
    let zeros = || Joints::from_slice(&[0.0; 6][..joints.min(6)]);
    let (Ok(q), Ok(qd), Ok(qdd)) = (zeros(), zeros(), zeros()) else { return Err(bad(&"too many joints")) };
    let reference = Frame::Reference(Reference { q: q.clone(), qd: qd.clone(), qdd });
    let begun = Instant::now();
    let mut due = begun + period;
    let mut tick = 0;
    while begun.elapsed() < time && !stops.load(Ordering::Relaxed) {
        wait_until(due);
        let woken = Instant::now();
        let sensed = Sensed::State { q: q.clone(), qd: qd.clone() };
        desk.send(&reference).map_err(|error| bad(&error))?;
        desk.tick(&Measurement { tick, sensed, age_ticks: 0 }).map_err(|error| bad(&error))?;
        let next = due + period;
        let in_time = Instant::now() < next;
        times.add(due, woken, in_time);
        due = if in_time { next } else { Instant::now() + period };
        tick += 1;
    }
    Ok(TimingCheck { times, real_time })
}
