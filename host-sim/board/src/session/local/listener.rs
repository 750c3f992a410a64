//! Connections to a socket of this computer, each on a thread of its own.

use std::io;
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

/// Serves every connection with `serve`, which gets its number, at most `most` at a time. Ends with the program.
///
/// # Errors
/// There is no thread.
pub fn listen(
    listener: TcpListener,
    most: usize,
    serve: impl Fn(u64, &TcpStream) + Send + Sync + 'static,
) -> io::Result<()> {
    let (serve, open) = (Arc::new(serve), Arc::new(AtomicUsize::new(0)));
    let accept = move || {
        for (number, stream) in (0..).zip(listener.incoming()) {
            let Ok(stream) = stream else {
                // For want of a resource, perhaps: others may free it.
                thread::sleep(Duration::from_millis(100));
                continue;
            };
            if open.fetch_add(1, Ordering::Relaxed) >= most {
                open.fetch_sub(1, Ordering::Relaxed);
                continue;
            }
            let (serve, count) = (Arc::clone(&serve), Arc::clone(&open));
            let spawned = thread::Builder::new().name("connection".into()).spawn(move || {
                serve(number, &stream);
                count.fetch_sub(1, Ordering::Relaxed);
            });
            if spawned.is_err() {
                open.fetch_sub(1, Ordering::Relaxed);
            }
        }
    };
    thread::Builder::new().name("connections".into()).spawn(accept).map(|_| ())
}
