//! Description of this machine, for pages with measurements.

use crate::process::output;
use std::process::Command;

/// Name of the processor.
pub(crate) fn processor() -> String {
    let information = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = information.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
    name.map_or_else(|| "unknown processor".to_owned(), |(_, name)| name.to_owned())
}

/// Number of processors that the program may use.
pub(crate) fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// The day in UTC, for example `2026-11-26`.
pub(crate) fn today() -> String {
    output(Command::new("date").args(["-u", "+%F"])).unwrap_or_else(|| "unknown day".to_owned())
}
