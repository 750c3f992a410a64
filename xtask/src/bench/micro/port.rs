//! Reader of a board's report on a serial port.

use super::report::{Report, StretchRow};
use anyhow::Result;
use firmware_image::BadInput;
use std::io::{ErrorKind, Read as _};
use std::time::{Duration, Instant};

/// Baud rate of `firmware/probe/src/bin/probe-micro/board.rs`.
const BAUD: u32 = 1_000_000;

/// Timeout for a whole report. A board begins one every second.
const TIMEOUT: Duration = Duration::from_secs(10);

/// Timeout of one reading.
const READING: Duration = Duration::from_millis(100);

/// Reads the rows of the next whole report.
///
/// # Errors
/// [`BadInput`]: the port cannot be opened, or no report arrives in time. Also if the port fails.
pub(super) fn read(name: &str) -> Result<Vec<StretchRow>> {
    read_within(name, TIMEOUT)
}

fn read_within(name: &str, timeout: Duration) -> Result<Vec<StretchRow>> {
    let open = serialport::new(name, BAUD).timeout(READING).open();
    let mut port = open.map_err(|error| BadInput(format!("--port {name}: {error}")))?;
    let end = Instant::now() + timeout;
    let (mut report, mut line, mut bytes) = (Report::default(), Vec::new(), 0);
    let mut buffer = [0; 512];
    while Instant::now() < end {
        let count = match port.read(&mut buffer) {
            Ok(count) => count,
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => 0,
            Err(error) => return Err(error.into()),
        };
        bytes += count;
        for byte in buffer.iter().take(count) {
            if *byte != b'\n' {
                line.push(*byte);
            } else if let Some(rows) = report.line(&String::from_utf8_lossy(&std::mem::take(&mut line))) {
                return Ok(rows);
            }
        }
    }
    let timeout = timeout.as_secs_f32();
    Err(BadInput(format!(
        "--port {name}: {bytes} bytes in {timeout} s and no whole report, expected one a second from the program: is the board \
         powered and wired as for the link, and the program written to it (--flash)?"
    ))
    .into())
}

#[cfg(all(test, unix))]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

    use super::{BadInput, StretchRow, read_within};
    use serialport::{SerialPort as _, TTYPort};
    use std::io::Write as _;
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::time::Duration;

    /// Reads from a simulated board that repeats `text`.
    fn said(text: &'static str, timeout: Duration) -> anyhow::Result<Vec<StretchRow>> {
        let (mut board, host) = TTYPort::pair().unwrap();
        let name = host.name().unwrap();
        // The open handle holds the lock that excludes other readers.
        drop(host);
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let thread = std::thread::spawn(move || {
            while !stopped.load(Ordering::Relaxed) {
                // At first the port is not open, and the bytes are lost.
                board.write_all(text.as_bytes()).ok();
                std::thread::sleep(Duration::from_millis(20));
            }
        });
        let found = read_within(&name, timeout);
        stop.store(true, Ordering::Relaxed);
        thread.join().unwrap();
        found
    }

    #[test]
    fn a_report_is_read_from_whatever_line_on_the_reader_comes() {
        let text =
            "o 7\r\nmicro end 2\r\nmicro begin\r\nmicro nothing_flash 9\r\nmicro vldr_flash 2057\r\nmicro end 2\r\n";
        let rows = said(text, Duration::from_secs(10)).unwrap();
        let expected =
            [("nothing_flash", 9), ("vldr_flash", 2057)].map(|(name, count)| StretchRow { name: name.into(), count });
        assert_eq!(rows, expected);
    }

    #[test]
    fn a_board_with_another_program_and_a_missing_port_are_bad_input() {
        for text in ["", "hello\r\n", "micro begin\r\nmicro vldr_flash 2057\r\nmicro end 2\r\n"] {
            let error = said(text, Duration::from_millis(300)).unwrap_err();
            assert!(error.is::<BadInput>() && error.to_string().contains("no whole report"), "{error}");
        }
        assert!(read_within("/dev/no-such-port", Duration::from_millis(1)).unwrap_err().is::<BadInput>());
    }
}
