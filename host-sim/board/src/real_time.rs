//! Priority, locked memory and waiting of a control thread, as far as the system allows.

use std::time::{Duration, Instant};

/// Priority and memory that the system allowed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RealTime {
    /// `None` if the thread runs before all ordinary programs; otherwise the reason.
    pub priority: Option<String>,
    /// `None` if the program's memory stays in RAM; otherwise the reason.
    pub memory: Option<String>,
}

impl RealTime {
    /// Message for the operator, with what to do.
    #[must_use]
    pub fn text(&self) -> String {
        let priority = match &self.priority {
            None => "control thread: real-time priority".to_owned(),
            Some(why) => format!(
                "control thread: no real-time priority ({why}); `sudo setcap cap_sys_nice,cap_ipc_lock+ep $(which newtau)`, or `rtprio 80` and `memlock \
                 unlimited` for this user in /etc/security/limits.conf"
            ),
        };
        let memory = match &self.memory {
            None => "memory locked".to_owned(),
            Some(why) => format!("memory not locked ({why})"),
        };
        format!("{priority}; {memory}")
    }
}

/// Gives the calling thread what a control loop needs: priority over ordinary programs, exact waking, memory that is not swapped out.
#[must_use]
pub fn prepare() -> RealTime {
    RealTime { priority: raise_priority().err(), memory: lock_memory().err() }
}

/// Gives the calling thread real-time priority (`SCHED_FIFO` on Linux), and makes its waits exact.
///
/// # Errors
/// The system's reason.
#[cfg(unix)]
pub fn raise_priority() -> Result<(), String> {
    use thread_priority::unix::{set_thread_priority_and_policy, thread_native_id};
    use thread_priority::{RealtimeThreadSchedulePolicy, ThreadPriority, ThreadPriorityValue, ThreadSchedulePolicy};
    // Without real-time priority, waits may be prolonged by 50 us to save power.
    #[cfg(target_os = "linux")]
    let _ = rustix::thread::set_current_timer_slack(core::num::NonZeroU64::new(1));
    let priority = ThreadPriorityValue::try_from(PRIORITY).map(ThreadPriority::Crossplatform)?;
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    set_thread_priority_and_policy(thread_native_id(), priority, policy).map_err(|error| error.to_string())
}

/// Share of the range of real-time priorities, percent. Above it are the system's own threads.
#[cfg(unix)]
const PRIORITY: u8 = 80;

/// Gives the calling thread the highest priority of the system's.
///
/// # Errors
/// The system's reason.
#[cfg(not(unix))]
pub fn raise_priority() -> Result<(), String> {
    thread_priority::set_current_thread_priority(thread_priority::ThreadPriority::Max)
        .map_err(|error| error.to_string())
}

#[cfg(target_os = "linux")]
fn lock_memory() -> Result<(), String> {
    use rustix::mm::{MlockAllFlags, mlockall};
    mlockall(MlockAllFlags::CURRENT | MlockAllFlags::FUTURE).map_err(|error| error.to_string())
}

#[cfg(not(target_os = "linux"))]
fn lock_memory() -> Result<(), String> {
    Err("not on this system".into())
}

/// Waits until this time.
pub(crate) fn wait_until(time: Instant) {
    loop {
        let left = time.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return;
        }
        std::thread::sleep(left);
    }
}

/// The period of a rate, Hz.
#[must_use]
pub fn period(rate_hz: f64) -> Duration {
    Duration::from_secs_f64(1.0 / rate_hz)
}
