//! Time, memory and processor time of a process.

use anyhow::{Context as _, Result};
use std::path::Path;
use std::process::Command;

/// Time and memory of a process.
#[derive(Clone, Copy)]
pub(super) struct Cost {
    /// Wall-clock time, s.
    pub(super) seconds: f64,
    /// Processor time of all its threads, s.
    pub(super) processor: f64,
    /// Most memory, MiB.
    pub(super) memory: f64,
}

/// Runs a command and prints its cost; the standard library does not tell it.
const SCRIPT: &str = "import resource, subprocess, sys, time\n\
                      start = time.monotonic()\n\
                      subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL)\n\
                      used = resource.getrusage(resource.RUSAGE_CHILDREN)\n\
                      print(time.monotonic() - start, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024)";

/// Runs a command to its end.
pub(super) fn measured(python: &Path, command: &mut Command) -> Result<Cost> {
    let mut script = Command::new(python);
    script.args(["-c", SCRIPT]).arg(command.get_program()).args(command.get_args());
    let printed = crate::process::output(&mut script).with_context(|| format!("{command:?} failed"))?;
    let numbers: Vec<f64> = printed.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    match numbers[..] {
        [seconds, processor, memory] => Ok(Cost { seconds, processor, memory }),
        _ => anyhow::bail!("{printed}: expected three numbers"),
    }
}
