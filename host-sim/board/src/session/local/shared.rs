//! State, targets and stops, between the operator and the connections. No side ever waits long for the other.

use super::message::Snapshot;
use super::targets::{Over, Received, Targets};
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

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
    targets: Targets,
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
        self.inner().targets.open();
    }

    /// The operator's part: targets are no longer followed, for this reason. The first reason stays.
    pub fn close(&self, why: &str) {
        self.inner().targets.close(why);
    }

    /// The operator's part: the targets since the last call.
    pub fn received(&self) -> Received {
        self.inner().targets.received()
    }

    /// A connection's part: the state.
    pub fn snapshot(&self) -> Snapshot {
        let timing = self.timing();
        let inner = self.inner();
        let age = inner.published.map(|published| published.elapsed().as_secs_f64());
        Snapshot { following: inner.targets.is_open(), timing, age, ..inner.snapshot.clone() }
    }

    /// A connection's part: a target. A later target replaces one that was not taken yet.
    ///
    /// # Errors
    /// The reason why it is not followed.
    pub fn target(&self, connection: u64, q: Vec<f64>) -> Result<(), String> {
        self.inner().targets.take(connection, q)
    }

    /// A connection's part: it sends no more targets.
    pub fn over(&self, connection: u64, over: Over) {
        self.inner().targets.end(connection, over);
    }

    fn timing(&self) -> Option<String> {
        let control = self.control.as_ref()?;
        let mut kept = self.timing.lock().unwrap_or_else(PoisonError::into_inner);
        if kept.as_ref().is_none_or(|(at, _)| at.elapsed() >= TIMING_KEPT) {
            *kept = Some((Instant::now(), control.timing()));
        }
        kept.as_ref().and_then(|(_, text)| text.clone())
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
    use super::{ControlLoop, Demanded, Shared, StopOutcome};
    use std::sync::Arc;
    use std::sync::atomic::{AtomicU32, Ordering};
    use std::time::Duration;

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
