//! Ctrl-C.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

/// Returns a counter of Ctrl-C presses: the first press stops the operator's arm, the second ends the program.
pub(super) fn presses() -> Arc<AtomicU32> {
    let presses = Arc::new(AtomicU32::new(0));
    let count = Arc::clone(&presses);
    if let Err(error) = ctrlc::set_handler(move || {
        count.fetch_add(1, Ordering::Relaxed);
    }) {
        eprintln!("Ctrl-C will leave the arm to its heartbeat: {error}");
    }
    presses
}

/// As [`presses`], for a program that holds an arm itself: a request to end (`SIGTERM`), the end of the terminal (`SIGHUP`) and Ctrl-Z (`SIGTSTP`), which
/// would stop the control loop, count as Ctrl-C.
pub(super) fn presses_of_any_kind() -> Arc<AtomicU32> {
    let presses = presses();
    #[cfg(unix)]
    {
        use signal_hook::consts::{SIGHUP, SIGTERM, SIGTSTP};
        let count = Arc::clone(&presses);
        match signal_hook::iterator::Signals::new([SIGTERM, SIGHUP, SIGTSTP]) {
            Ok(mut signals) => {
                std::thread::spawn(move || {
                    for _ in signals.forever() {
                        count.fetch_add(1, Ordering::Relaxed);
                    }
                });
            }
            Err(error) => eprintln!("a closed terminal will leave the arm to the drives' timeouts: {error}"),
        }
    }
    presses
}
