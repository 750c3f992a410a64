//! The control thread: what the timer's interrupt and the link's task are on a board.

use super::lateness::TickTimes;
use crate::real_time::{self, RealTime, wait_until};
use crate::session::dry_run::{DeskSession, Uncounted};
use crate::session::local::shared::ControlLoop;
use dynamics_core::Sensed;
use dynamics_core::safety::SafeAction;
use joint_io::{JointIo, run_tick};
use link::{Frame, Received, StateCode};
use session::black_box::Report;
use session::meter::Meter;
use session::readings::{Lines, Readings};
use session::{Reaction, State};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TryRecvError};
use std::sync::{Mutex, OnceLock};
use std::time::{Duration, Instant};

/// Longest time for which the drives damp the arm at the end, until it rests.
const DAMPED_MAX: Duration = Duration::from_secs(30);

/// Speed below which a joint rests, rad/s or m/s, and the number of ticks for which all must.
const REST: f32 = 0.02;
const REST_TICKS: u32 = 20;

/// Number of ticks without any reply after which nobody hears this program.
const SILENT_TICKS: u32 = 50;

/// Last frames of the drives: they are switched off, so that none of them finds a timeout when it is used again.
const OFF_TICKS: u32 = 5;

/// Number of times that the very last frame is sent: a drive whose timeout has expired may swallow one.
const END_TICKS: u32 = 2;

/// Longest time after the operator's part has gone for which the session may still hold or lower the arm.
const ALONE_MAX: Duration = Duration::from_secs(600);

/// Wait for a hello.
const IDLE: Duration = Duration::from_millis(20);

/// State that the thread shares with others: its times, and their requests.
#[derive(Debug)]
pub struct Shown {
    /// Times of its ticks. The thread never waits for this lock.
    pub times: Mutex<TickTimes>,
    /// Result of [`real_time::prepare`], once the thread runs.
    pub real_time: OnceLock<RealTime>,
    /// Request for an emergency stop, also after the operator's part has gone.
    pub(super) stops: AtomicBool,
}

impl Shown {
    pub(super) fn new(times: TickTimes) -> Self {
        Self { times: Mutex::new(times), real_time: OnceLock::new(), stops: AtomicBool::new(false) }
    }

    /// Result of [`real_time::prepare`]; waits until the thread runs. `None` if it does not within a second.
    #[must_use]
    pub fn real_time(&self) -> Option<&RealTime> {
        let begun = Instant::now();
        while self.real_time.get().is_none() && begun.elapsed() < Duration::from_secs(1) {
            std::thread::sleep(Duration::from_millis(1));
        }
        self.real_time.get()
    }

    /// Message of the thread's ticks; `None` before the first.
    #[must_use]
    pub fn text(&self) -> Option<String> {
        self.times.lock().ok().filter(|times| times.late.count() > 0).map(|times| times.to_string())
    }
}

impl ControlLoop for Shown {
    fn stop_at_once(&self) {
        self.stops.store(true, Ordering::Relaxed);
    }

    fn timing(&self) -> Option<String> {
        self.text()
    }
}

/// The ends of the link to the operator.
pub(super) struct Ends {
    pub(super) from_host: Receiver<Frame>,
    pub(super) to_host: SyncSender<Frame>,
}

/// The joints. Whatever ends the thread, also a panic, the drives do the safe action until the arm rests, and are then switched off.
struct Guarded<const N: usize> {
    joints: Box<dyn JointIo<N> + Send>,
    action: SafeAction,
    period: Duration,
    /// True if a frame was ever sent that could have moved the arm.
    used: bool,
}

impl<const N: usize> Guarded<N> {
    /// A tick of the safe action. Returns the readings before it.
    fn stop(&mut self, action: SafeAction) -> Option<Readings<N>> {
        let readings = self.joints.measure();
        self.joints.safe(action);
        std::thread::sleep(self.period);
        readings
    }
}

/// True if every joint was measured now and rests.
fn rests<const N: usize>(readings: &Readings<N>) -> bool {
    let still = match readings.sensed {
        Sensed::State { qd, .. } => qd.iter().all(|velocity| velocity.abs() < REST),
        Sensed::Counts(_) => false,
    };
    still && readings.age_ticks == [0; N]
}

impl<const N: usize> Drop for Guarded<N> {
    fn drop(&mut self) {
        let (begun, mut resting, mut silent) = (Instant::now(), 0, 0);
        // `off` is no action that an arm comes to rest by. Drives that no longer answer do not hear either: their timeouts act.
        let damps = self.used && self.action != SafeAction::Off;
        while damps && resting < REST_TICKS && silent < SILENT_TICKS && begun.elapsed() < DAMPED_MAX {
            let readings = self.stop(self.action);
            resting = if readings.as_ref().is_some_and(rests) { resting + 1 } else { 0 };
            silent = if readings.is_some_and(|readings| readings.age_ticks.contains(&0)) { 0 } else { silent + 1 };
        }
        for _ in 0..OFF_TICKS {
            self.stop(SafeAction::Off);
        }
        for _ in 0..END_TICKS {
            self.joints.measure();
            self.joints.end();
            std::thread::sleep(self.period);
        }
    }
}

/// Runs until the operator's program has gone and the arm has no torque.
pub(super) fn run<const N: usize>(
    mut session: DeskSession<N>,
    joints: Box<dyn JointIo<N> + Send>,
    period: Duration,
    ends: &Ends,
    shown: &Shown,
) {
    let _ = shown.real_time.set(real_time::prepare());
    let meter = Meter::new(Uncounted);
    let mut guarded = Guarded { joints, action: session.safe_action(), period, used: false };
    // An earlier program may have left drives on.
    guarded.joints.safe(session.safe_action());
    let mut due = Instant::now();
    let mut alone_since = None;
    loop {
        loop {
            match ends.from_host.try_recv() {
                Ok(frame) => take(&mut session, frame, &mut guarded, ends),
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => {
                    alone_since.get_or_insert_with(Instant::now);
                    break;
                }
            }
        }
        if let Some(since) = alone_since
            && (!has_torque(&session) || since.elapsed() > ALONE_MAX)
        {
            return;
        }
        if !session.is_live() {
            match ends.from_host.recv_timeout(IDLE) {
                Ok(frame) => take(&mut session, frame, &mut guarded, ends),
                Err(RecvTimeoutError::Timeout | RecvTimeoutError::Disconnected) => {}
            }
            due = Instant::now() + period;
            continue;
        }
        wait_until(due);
        let begun = Instant::now();
        let next = due + period;
        // A computer has no lines. A demand for an emergency stop acts as a board's line: no request is counted, and none is taken for a repetition.
        let lines = Lines { emergency_stop: shown.stops.swap(false, Ordering::Relaxed), ..Lines::NONE };
        let in_time = run_tick(&mut session, guarded.joints.as_mut(), &meter, || lines, || Instant::now() >= next);
        guarded.action = session.safe_action();
        guarded.used |= has_torque(&session);
        if let Ok(mut times) = shown.times.try_lock() {
            times.add(due, begun, in_time);
        }
        while let Some(report) = session.say() {
            // A host that has gone is seen above; one that does not read loses reports.
            let _ = ends.to_host.try_send(Report::frame(report));
        }
        // Missed ticks are not caught up: their torques would be old.
        due = if in_time { next } else { Instant::now() + period };
    }
}

/// True if the drives give torque.
fn has_torque<const N: usize>(session: &DeskSession<N>) -> bool {
    matches!(session.state(), State::Supervised(_, state) if StateCode::new(state).has_torque())
}

/// Gives the session a frame, and sends its answers.
fn take<const N: usize>(session: &mut DeskSession<N>, frame: Frame, guarded: &mut Guarded<N>, ends: &Ends) {
    let say = |frame| {
        let _ = ends.to_host.try_send(frame);
    };
    match session.receive(Ok(Received { frame, missed: 0 })) {
        Reaction::None | Reaction::Tick => {}
        Reaction::Reply(frame) | Reaction::Resume(frame) => say(frame),
        Reaction::Start(_, hello) => {
            guarded.joints.safe(session.safe_action());
            say(hello);
        }
        Reaction::Stop(hello, refusal) => {
            guarded.joints.safe(session.safe_action());
            say(hello);
            say(refusal);
        }
    }
}
