//! Test steps, and counts of passed and failed ones.

use crate::process::run;
use anyhow::{Context as _, Result};
use std::cmp::Reverse;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Results of the steps.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    passed: u64,
    failed: u64,
    failures: Vec<String>,
    /// Name of each step, and how long it took.
    times: Vec<(String, Duration)>,
}

/// Shortest step that is listed at the end.
const LISTED: Duration = Duration::from_secs(10);

impl Tally {
    /// Runs a step and counts it as one test.
    pub(crate) fn step(&mut self, name: &str, step: impl FnOnce() -> Result<()>) {
        let begin = announce(name);
        match step() {
            Ok(()) => self.passed += 1,
            Err(why) => self.fail(name, &format!("{why:#}")),
        }
        self.end(name, begin);
    }

    /// Runs a command and counts it as one test.
    pub(crate) fn command(&mut self, name: &str, command: &mut Command) {
        self.step(name, || run(command));
    }

    /// Runs a test runner and adds the tests that it reports; a run without tests is a failure.
    pub(crate) fn tests(&mut self, name: &str, command: &mut Command) {
        let begin = announce(name);
        let outcome = counted(command);
        match outcome {
            Ok((success, counts)) => {
                self.passed += counts.passed;
                self.failed += counts.failed;
                if counts.failed > 0 {
                    self.failures.push(format!("{name}: {} failed", counts.failed));
                } else if !success {
                    self.fail(name, "the test runner failed");
                } else if counts.passed == 0 {
                    self.fail(name, "no test ran");
                }
            }
            Err(why) => self.fail(name, &format!("{why:#}")),
        }
        self.end(name, begin);
    }

    fn end(&mut self, name: &str, begin: Instant) {
        let time = begin.elapsed();
        eprintln!("    {name}: {:.0} s", time.as_secs_f64());
        self.times.push((name.to_owned(), time));
    }

    /// Prints the longest steps, the failures and the counts. Returns true if nothing failed.
    pub(crate) fn report(&mut self) -> bool {
        self.times.sort_by_key(|(_, time)| Reverse(*time));
        for (name, time) in self.times.iter().filter(|(_, time)| *time >= LISTED) {
            eprintln!("{:>6.0} s  {name}", time.as_secs_f64());
        }
        for failure in &self.failures {
            eprintln!("FAILED {failure}");
        }
        println!("{} passed, {} failed", self.passed, self.failed);
        self.failed == 0 && self.passed > 0
    }

    fn fail(&mut self, name: &str, why: &str) {
        self.failed += 1;
        self.failures.push(format!("{name}: {why}"));
    }
}

fn announce(name: &str) -> Instant {
    eprintln!("\n==> {name}");
    Instant::now()
}

#[derive(Debug, Default, PartialEq, Eq)]
struct TestCounts {
    passed: u64,
    failed: u64,
}

/// Prints a test runner's output as it arrives, and sums its summaries.
fn counted(command: &mut Command) -> Result<(bool, TestCounts)> {
    // nextest prints its summary on standard error, the built-in harness on standard output, so each gets a pipe.
    let mut child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .with_context(|| format!("cannot start {command:?}"))?;
    let stderr = child.stderr.take().map(|pipe| std::thread::spawn(move || echo(BufReader::new(pipe))));
    let mut counts = child.stdout.take().map_or_else(TestCounts::default, |pipe| echo(BufReader::new(pipe)));
    if let Some(thread) = stderr {
        let more = thread.join().map_err(|_| anyhow::anyhow!("the output reader stopped"))?;
        counts.passed += more.passed;
        counts.failed += more.failed;
    }
    let status = child.wait().with_context(|| format!("cannot wait for {command:?}"))?;
    Ok((status.success(), counts))
}

fn echo(pipe: impl BufRead) -> TestCounts {
    let mut counts = TestCounts::default();
    for line in pipe.lines().map_while(Result::ok) {
        eprintln!("{line}");
        if let Some(summary) = summary(&line) {
            counts.passed += summary.passed;
            counts.failed += summary.failed;
        }
    }
    counts
}

/// The counts in a summary line of nextest or of Rust's own test harness.
fn summary(line: &str) -> Option<TestCounts> {
    let of_nextest = line.trim_start().starts_with("Summary [");
    // Not trimmed: nextest indents the output of a failed test, which is already counted.
    let of_harness = line.starts_with("test result: ");
    if !of_nextest && !of_harness {
        return None;
    }
    let before = |word: &str| -> u64 {
        let words: Vec<&str> = line.split([' ', ',', ';']).filter(|w| !w.is_empty()).collect();
        words.windows(2).find(|w| w[1] == word).and_then(|w| w[0].parse().ok()).unwrap_or(0)
    };
    Some(TestCounts { passed: before("passed"), failed: before("failed") + before("timed") })
}

#[cfg(test)]
mod tests {
    use super::{TestCounts, summary};

    #[test]
    fn summaries_are_read() {
        let nextest = "     Summary [   1.234s] 120 tests run: 118 passed (2 slow), 2 failed, 3 skipped";
        assert_eq!(summary(nextest), Some(TestCounts { passed: 118, failed: 2 }));
        let harness = "test result: ok. 5 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.10s";
        assert_eq!(summary(harness), Some(TestCounts { passed: 5, failed: 0 }));
        assert_eq!(summary("12 passed"), None);
        assert_eq!(summary("    test result: FAILED. 0 passed; 1 failed; 0 ignored"), None, "inside nextest's output");
    }
}
