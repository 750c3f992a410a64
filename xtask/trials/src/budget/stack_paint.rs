//! Stack depth, from RAM that is filled with a pattern before the program starts and read back afterwards.
//!
//! Nothing is changed in the program: the emulator loads the pattern with it, and the emulator's monitor writes RAM to a file. The measured program
//! is the flashed one.

use crate::budget::Failure;
use firmware_image::scratch::ScratchFile;
use serde_json::{Value, json};
use std::ffi::OsString;
use std::io::{BufRead as _, BufReader, Write as _};
use std::ops::Range;
use std::os::unix::net::UnixStream;
use std::path::Path;

/// Pattern byte, which a program is unlikely to write repeatedly to its stack.
const PAINT: u8 = 0xa5;

/// Pattern for the free RAM of the stack, and its files, which are deleted when this is dropped.
#[derive(Debug)]
pub struct StackPaint {
    room: Range<u32>,
    paint: ScratchFile,
    monitor: ScratchFile,
    read_back: ScratchFile,
}

impl StackPaint {
    /// Creates the pattern for these addresses.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn new(room: Range<u32>) -> Result<Self, Failure> {
        let file = |what: &str| ScratchFile::new(&format!("paint.{what}"));
        let paint = Self { room, paint: file("bin")?, monitor: file("monitor")?, read_back: file("ram")? };
        std::fs::write(paint.paint.path(), vec![PAINT; paint.size()])?;
        Ok(paint)
    }

    fn size(&self) -> usize {
        (self.room.end - self.room.start) as usize
    }

    /// Arguments for starting the emulator.
    #[must_use]
    pub fn arguments(&self) -> Vec<OsString> {
        let loader = format!("loader,file={},addr={:#x},force-raw=on", self.paint.path().display(), self.room.start);
        let monitor = format!("unix:{},server=on,wait=off", self.monitor.path().display());
        ["-device", &loader, "-qmp", &monitor].map(OsString::from).to_vec()
    }

    /// Bytes of the stack's memory that were written since the program started, counted from the top of the stack.
    ///
    /// # Errors
    /// The monitor does not answer; or the whole pattern is overwritten, or nothing is.
    pub fn deepest(&self) -> Result<u64, Failure> {
        let mut monitor = Monitor::connect(self.monitor.path())?;
        monitor.ask("qmp_capabilities", &json!({}))?;
        let file = self.read_back.path().display().to_string();
        monitor.ask("pmemsave", &json!({ "val": self.room.start, "size": self.size(), "filename": file }))?;
        high_water(&std::fs::read(self.read_back.path())?).ok_or_else(|| {
            Failure::NotSeen(format!(
                "the stack of {} bytes: either nothing was painted, or the program used none or all of it",
                self.size()
            ))
        })
    }
}

/// Bytes from the lowest overwritten one to the end; `None` if all or none are overwritten.
///
/// If the lowest written byte happens to equal the pattern, the next one is found.
fn high_water(room: &[u8]) -> Option<u64> {
    let untouched = room.iter().position(|byte| *byte != PAINT)?;
    (untouched > 0).then_some((room.len() - untouched) as u64)
}

/// The emulator's monitor.
struct Monitor {
    to: UnixStream,
    from: BufReader<UnixStream>,
}

impl Monitor {
    fn connect(path: &Path) -> Result<Self, Failure> {
        let to = UnixStream::connect(path)?;
        to.set_read_timeout(Some(std::time::Duration::from_secs(10)))?;
        let from = BufReader::new(to.try_clone()?);
        Ok(Self { to, from })
    }

    fn ask(&mut self, command: &str, arguments: &Value) -> Result<(), Failure> {
        writeln!(self.to, "{}", json!({ "execute": command, "arguments": arguments }))?;
        let mut line = String::new();
        // The greeting and events may arrive before the answer.
        while self.from.read_line(&mut line)? > 0 {
            let said: Value = serde_json::from_str(&line).unwrap_or_default();
            if said.get("return").is_some() {
                return Ok(());
            }
            if let Some(error) = said.get("error") {
                return Err(Failure::NotSeen(format!("the emulator's monitor refuses {command}: {error}")));
            }
            line.clear();
        }
        Err(Failure::NotSeen(format!("the emulator's monitor ended before it answered {command}")))
    }
}

#[cfg(test)]
mod tests {
    use super::{PAINT, high_water};

    #[test]
    fn the_lowest_byte_that_is_not_paint_counts_whatever_is_above_it() {
        let mut room = [PAINT; 64];
        room[40] = 0;
        room[60] = 1;
        assert_eq!(high_water(&room), Some(24));
    }

    #[test]
    fn no_paint_left_or_nothing_written_is_no_depth() {
        assert_eq!(high_water(&[0; 8]), None);
        assert_eq!(high_water(&[PAINT; 8]), None);
        assert_eq!(high_water(&[]), None);
    }
}
