//! State, targets and stops, between the operator and the connections. No side ever waits long for the other.

use super::snapshot::Snapshot;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Answer to targets that nobody wants.
const NOT_FOLLOWING: &str = "the arm follows no targets now: enter `follow` in its session";

/// A control loop that this program runs.
pub trait ControlLoop: Send + Sync {
    /// Demands an emergency stop, even if the operator hangs.
    fn stop_at_once(&self);

    /// Times of its ticks in words; `None` before the first.
    fn timing(&self) -> Option<String>;
}

/// Number of stops that other programs have demanded, modulo 2^32.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Demanded {
    /// Stops along the path.
    pub calm: u32,
    /// Emergency stops.
    pub emergency: u32,
}

impl Demanded {
    /// True if all of `other` are among these.
    fn includes(self, other: Self) -> bool {
        let reached = |mine: u32, other: u32| mine.wrapping_sub(other).cast_signed() >= 0;
        reached(self.calm, other.calm) && reached(self.emergency, other.emergency)
    }
}

/// Outcome of a stop.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StopOutcome {
    /// The arm has stopped; the operator's message.
    Confirmed(String),
    /// It may still move: the reason.
    NotConfirmed(&'static str),
}

/// Time for which the text of the control loop's times is kept: to write it takes the loop's lock.
const TIMING_KEPT: Duration = Duration::from_millis(500);

/// State that the operator and the connections share.
pub struct Shared {
    demanded: Mutex<Demanded>,
    control: Option<Arc<dyn ControlLoop>>,
    timing: Mutex<Option<(Instant, Option<String>)>>,
    inner: Mutex<Inner>,
}

#[derive(Debug, Default)]
struct Inner {
    snapshot: Snapshot,
    /// Time of the snapshot, where time passes as on the clock.
    published: Option<Instant>,
    /// Demands that the operator has handled, and its message about the last, if the arm has stopped.
    handled: (Demanded, Option<String>),
    /// True once the session has ended.
    ended_session: bool,
    targets: Option<Targets>,
    /// Reason why the last targets were not followed further.
    ended: Option<String>,
}

/// Targets while the arm follows them.
#[derive(Debug)]
struct Targets {
    opened: Instant,
    /// The connection that sends them.
    owner: Option<u64>,
    newest: Option<Vec<f64>>,
    received: Option<Instant>,
    over: Option<Over>,
}

/// Reason for the end of the targets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Over {
    /// The program has said so.
    Done,
    /// The connection is closed.
    Gone,
}

/// News from another program since the last look.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Received {
    /// The newest target, if one came.
    pub target: Option<Vec<f64>>,
    /// Time since the newest target; `None` before the first.
    pub silent: Option<Duration>,
    /// Time since targets are followed.
    pub waited: Duration,
    /// Set once no more targets come.
    pub over: Option<Over>,
}

impl fmt::Debug for Shared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Shared").field("inner", &self.inner).finish_non_exhaustive()
    }
}

impl Shared {
    /// No state yet. `control` is the control loop, if this program runs it.
    #[must_use]
    pub fn new(control: Option<Arc<dyn ControlLoop>>) -> Self {
        Self { demanded: Mutex::default(), control, timing: Mutex::default(), inner: Mutex::default() }
    }

    fn inner(&self) -> MutexGuard<'_, Inner> {
        // Every change under the lock is complete at any of its lines.
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The operator's part: the new state. `is_live`: time passes as on the clock, so that a state grows old.
    pub fn publish(&self, snapshot: Snapshot, is_live: bool) {
        let mut inner = self.inner();
        (inner.snapshot, inner.published) = (snapshot, is_live.then(Instant::now));
    }

    /// The operator's part: the stops that were demanded so far.
    #[must_use]
    pub fn demanded(&self) -> Demanded {
        *self.demanded.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The operator's part: these stops are handled; with a message if the arm has stopped.
    pub fn stopped(&self, handled: Demanded, text: Option<String>) {
        self.inner().handled = (handled, text);
    }

    /// The operator's part: the session has ended. The arm may still be on its way to rest.
    pub fn end(&self) {
        self.inner().ended_session = true;
    }

    /// The operator's part: targets are followed from here on.
    pub fn open(&self) {
        let mut inner = self.inner();
        let targets = Targets { opened: Instant::now(), owner: None, newest: None, received: None, over: None };
        (inner.targets, inner.ended) = (Some(targets), None);
    }

    /// The operator's part: targets are no longer followed, for this reason. The first reason stays.
    pub fn close(&self, why: &str) {
        let mut inner = self.inner();
        if inner.targets.take().is_some() {
            inner.ended = Some(why.to_owned());
        }
    }

    /// The operator's part: the targets since the last call.
    pub fn received(&self) -> Received {
        let mut inner = self.inner();
        inner.targets.as_mut().map_or_else(Received::default, |targets| Received {
            target: targets.newest.take(),
            silent: targets.received.map(|at| at.elapsed()),
            waited: targets.opened.elapsed(),
            over: targets.over,
        })
    }

    /// A connection's part: the state.
    pub fn snapshot(&self) -> Snapshot {
        let timing = self.timing();
        let inner = self.inner();
        let age = inner.published.map(|published| published.elapsed().as_secs_f64());
        Snapshot { following: inner.targets.is_some(), timing, age, ..inner.snapshot.clone() }
    }

    /// A connection's part: a target. A later target replaces one that was not taken yet.
    ///
    /// # Errors
    /// The reason why it is not followed.
    pub fn target(&self, connection: u64, q: Vec<f64>) -> Result<(), String> {
        let mut inner = self.inner();
        let Inner { targets, ended, .. } = &mut *inner;
        let Some(targets) = targets.as_mut() else {
            return Err(ended.as_ref().map_or_else(
                || NOT_FOLLOWING.to_owned(),
                |why| format!("the arm no longer follows targets: {why}; enter `follow` in its session"),
            ));
        };
        if *targets.owner.get_or_insert(connection) != connection {
            return Err("the arm follows the targets of another program".into());
        }
        if targets.over.is_some() {
            return Err("the targets were ended".into());
        }
        (targets.newest, targets.received) = (Some(q), Some(Instant::now()));
        Ok(())
    }

    fn timing(&self) -> Option<String> {
        let control = self.control.as_ref()?;
        let mut kept = self.timing.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.as_ref().is_none_or(|(at, _)| at.elapsed() >= TIMING_KEPT) {
            *kept = Some((Instant::now(), control.timing()));
        }
        kept.as_ref().and_then(|(_, text)| text.clone())
    }

    /// A connection's part: it sends no more targets.
    pub fn over(&self, connection: u64, over: Over) {
        let mut inner = self.inner();
        let Some(targets) = inner.targets.as_mut() else { return };
        // Who ends the targets before the first one is their program, too. A connection that only looked is not.
        let is_owner = targets.owner == Some(connection) || (targets.owner.is_none() && over == Over::Done);
        if is_owner {
            targets.owner = Some(connection);
            targets.over.get_or_insert(over);
        }
    }

    /// A connection's part: demands a stop. Returns the demands to wait for.
    pub fn stop(&self, emergency: bool) -> Demanded {
        let mut demanded = self.demanded.lock().unwrap_or_else(PoisonError::into_inner);
        let count = if emergency { &mut demanded.emergency } else { &mut demanded.calm };
        *count = count.wrapping_add(1);
        if let (true, Some(control)) = (emergency, &self.control) {
            control.stop_at_once();
        }
        *demanded
    }

    /// A connection's part: waits until these demands are handled, at most for this time.
    pub fn until_stopped(&self, wanted: Demanded, time: Duration) -> StopOutcome {
        let begun = Instant::now();
        loop {
            let (handled, text, ended) = {
                let inner = self.inner();
                (inner.handled.0, inner.handled.1.clone(), inner.ended_session)
            };
            if handled.includes(wanted) {
                return text.map_or(
                    StopOutcome::NotConfirmed("the controller has not confirmed the stop, or the arm still moves"),
                    StopOutcome::Confirmed,
                );
            }
            if ended {
                return StopOutcome::NotConfirmed(
                    "the session has ended, and its arm is being brought to rest: `newtau stop --emergency`, or the emergency stop",
                );
            }
            if begun.elapsed() >= time {
                return StopOutcome::NotConfirmed("the session does not answer");
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]
    use super::{ControlLoop, Demanded, Over, Shared, StopOutcome};
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU32, Ordering};
    use std::time::Duration;

    #[test]
    fn the_newest_target_of_one_program_is_taken_once() {
        let shared = Shared::new(None);
        assert!(shared.target(1, vec![0.0]).unwrap_err().contains("enter `follow`"), "not yet");
        shared.open();
        assert_eq!(shared.received().silent, None);
        shared.over(3, Over::Gone);
        assert_eq!(shared.received().over, None, "who only looked ends nothing");
        shared.target(1, vec![0.0]).unwrap();
        shared.target(1, vec![1.0]).unwrap();
        assert!(shared.target(2, vec![9.0]).unwrap_err().contains("another program"));
        shared.over(2, Over::Done);
        let received = shared.received();
        assert_eq!((received.target, received.over), (Some(vec![1.0]), None));
        assert!(received.silent.unwrap() < Duration::from_secs(1));
        assert_eq!(shared.received().target, None);
        shared.over(1, Over::Done);
        shared.over(1, Over::Gone);
        assert_eq!(shared.received().over, Some(Over::Done));
        assert!(shared.target(1, vec![2.0]).is_err(), "what is ended is ended");
        shared.close("a stop");
        shared.close("something later");
        assert!(shared.target(1, vec![2.0]).unwrap_err().contains("a stop"));
        assert!(!shared.snapshot().following);
        shared.open();
        shared.over(4, Over::Done);
        assert_eq!(shared.received().over, Some(Over::Done), "before the first target");
    }

    #[test]
    fn every_stop_waits_for_its_own_confirmation_and_an_emergency_stop_reaches_the_control_loop() {
        struct Counted(AtomicU32);
        impl ControlLoop for Counted {
            fn stop_at_once(&self) {
                self.0.fetch_add(1, Ordering::Relaxed);
            }

            fn timing(&self) -> Option<String> {
                Some("in time".into())
            }
        }
        let control = Arc::new(Counted(AtomicU32::new(0)));
        let shared = Shared::new(Some(Arc::<Counted>::clone(&control)));
        assert_eq!(shared.snapshot().timing.as_deref(), Some("in time"));
        let short = Duration::from_millis(5);
        let unanswered = StopOutcome::NotConfirmed("the session does not answer");
        let first = shared.stop(false);
        assert_eq!(first, Demanded { calm: 1, emergency: 0 });
        assert_eq!(shared.until_stopped(first, short), unanswered);
        shared.stopped(first, Some("held".into()));
        assert_eq!(shared.until_stopped(first, short), StopOutcome::Confirmed("held".into()));
        let second = shared.stop(true);
        assert_eq!((second, control.0.load(Ordering::Relaxed)), (Demanded { calm: 1, emergency: 1 }, 1));
        assert_eq!(shared.until_stopped(second, short), unanswered, "an older confirmation is none for it");
        shared.stopped(second, None);
        assert!(
            matches!(shared.until_stopped(second, short), StopOutcome::NotConfirmed(why) if why.contains("still moves"))
        );
        let third = shared.stop(false);
        shared.end();
        assert!(
            matches!(shared.until_stopped(third, short), StopOutcome::NotConfirmed(why) if why.contains("has ended"))
        );
    }

    #[test]
    fn counts_may_wrap() {
        let before = Demanded { calm: u32::MAX, emergency: 0 };
        let after = Demanded { calm: 0, emergency: 0 };
        assert!(after.includes(before) && !before.includes(after) && after.includes(after));
    }
}
