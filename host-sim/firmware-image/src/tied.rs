//! Child processes that end with this program, however it ends.
//!
//! A process that is killed cannot end its children. So a shell starts the child, and a second shell reads from a pipe whose other end this program
//! keeps open. The system closes that end even after `kill -9`; then the second shell kills the whole process group, itself included. A child that
//! never ends is killed after a limit of processor time.

use crate::process::which;
use rustix::process::{Pid, Signal, kill_process_group};
use std::io;
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Output, Stdio};
use std::time::Duration;

/// Arguments: the limit in seconds, then the child's command line. The last command's status is the child's; 128 and a signal's number if one ended it.
const SCRIPT: &str = r#"
ulimit -S -t "$1" 2>/dev/null
shift
exec 3<&0
"$@" 3<&- </dev/null &
child=$!
(read -r line <&3; kill -9 -$$) >/dev/null 2>&1 &
waiter=$!
wait "$child"
status=$?
kill -9 "$waiter"
wait "$waiter" 2>/dev/null
exit "$status"
"#;

/// A child process that ends when this program ends, or when this value is dropped. All of its own children that stay in its process group end too.
#[derive(Debug)]
pub struct TiedProcess {
    child: Child,
    /// As long as this is open, the child lives.
    alive: Option<ChildStdin>,
}

/// Command that runs `command` tied to this program, with this limit of processor time for each of its processes. Standard output and error are those
/// that the caller sets on the result; the input is empty. Start it with [`TiedProcess::spawn`].
///
/// # Errors
/// There is no such program.
pub fn tied(command: &Command, limit: Duration) -> io::Result<Command> {
    let program = command.get_program();
    let path = Path::new(program);
    let has_folder = path.components().count() > 1;
    let is_there = if has_folder { path.is_file() } else { which(&program.to_string_lossy()).is_some() };
    if !is_there {
        return Err(io::ErrorKind::NotFound.into());
    }
    let mut tied = Command::new("/bin/sh");
    tied.args(["-c", SCRIPT, "sh", &limit.as_secs().max(1).to_string()]).arg(program).args(command.get_args());
    for (name, value) in command.get_envs() {
        match value {
            Some(value) => tied.env(name, value),
            None => tied.env_remove(name),
        };
    }
    if let Some(folder) = command.get_current_dir() {
        tied.current_dir(folder);
    }
    tied.stdin(Stdio::piped());
    // Ctrl-C in a terminal reaches every process of its group, and a run should end in order while its child still answers.
    std::os::unix::process::CommandExt::process_group(&mut tied, 0);
    Ok(tied)
}

impl TiedProcess {
    /// Starts a command of [`tied`].
    ///
    /// # Errors
    /// It cannot start.
    pub fn spawn(mut tied: Command) -> io::Result<Self> {
        let mut child = tied.spawn()?;
        let alive = child.stdin.take();
        Ok(Self { child, alive })
    }

    /// Runs a command to its end, tied to this program, and returns its output. What it prints on standard error is in the output too if `keeps_errors`,
    /// otherwise it is printed.
    ///
    /// # Errors
    /// It cannot start, or its output cannot be read.
    pub fn output(command: &Command, limit: Duration, keeps_errors: bool) -> io::Result<Output> {
        let mut tied = tied(command, limit)?;
        tied.stdout(Stdio::piped()).stderr(if keeps_errors { Stdio::piped() } else { Stdio::inherit() });
        let mut child = tied.spawn()?;
        // `wait_with_output` would close it, and the child would end.
        let alive = child.stdin.take();
        let output = child.wait_with_output();
        drop(alive);
        output
    }

    /// The child; its process id is that of the group.
    pub fn child(&mut self) -> &mut Child {
        &mut self.child
    }

    /// Process id of the group, and of the shell that waits for the child.
    #[must_use]
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Kills the child and its group, and waits for the shell that started it. Nothing happens if it has ended.
    pub fn end(&mut self) {
        let has_ended = matches!(self.child.try_wait(), Ok(Some(_)));
        if !has_ended && let Some(group) = i32::try_from(self.child.id()).ok().and_then(Pid::from_raw) {
            // It fails only if the group has ended meanwhile.
            kill_process_group(group, Signal::KILL).ok();
        }
        self.alive = None;
        self.child.wait().ok();
    }
}

impl Drop for TiedProcess {
    fn drop(&mut self) {
        self.end();
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that fails should stop there")]
mod tests {
    use super::{TiedProcess, tied};
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    const LIMIT: Duration = Duration::from_secs(100);

    /// In this process, the test below is the parent that is killed; the file takes the child's group.
    const PARENT: &str = "NEWTAU_TEST_PARENT";

    fn shell(script: &str) -> Command {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        command
    }

    /// True if a process of this group lives. A zombie does not: whoever inherited it may never ask for its status.
    fn lives(group: u32) -> bool {
        let listed = Command::new("ps").args(["-eo", "pgid=,stat="]).output().unwrap();
        String::from_utf8(listed.stdout).unwrap().lines().any(|line| {
            let mut words = line.split_whitespace();
            words.next() == Some(&group.to_string()) && words.next().is_some_and(|state| !state.starts_with('Z'))
        })
    }

    fn until_gone(group: u32) {
        let begun = Instant::now();
        while lives(group) {
            assert!(begun.elapsed() < Duration::from_secs(10), "the group {group} still lives");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    #[test]
    fn a_child_and_its_children_end_with_a_parent_that_is_killed() {
        if let Some(file) = std::env::var_os(PARENT) {
            // A child that starts another one, as cargo does.
            let process = TiedProcess::spawn(tied(&shell("sleep 1000 & sleep 1000"), LIMIT).unwrap()).unwrap();
            std::fs::write(file, process.id().to_string()).unwrap();
            loop {
                std::thread::park();
            }
        }
        let file = std::env::temp_dir().join(format!("newtau-test-tied-{}", std::process::id()));
        let name = "tied::tests::a_child_and_its_children_end_with_a_parent_that_is_killed";
        let mut parent = Command::new(std::env::current_exe().unwrap());
        let mut parent = parent.args(["--exact", name]).env(PARENT, &file).stdout(Stdio::null()).spawn().unwrap();
        let begun = Instant::now();
        let group: u32 = loop {
            if let Some(group) = std::fs::read_to_string(&file).ok().and_then(|text| text.parse().ok()) {
                break group;
            }
            assert!(begun.elapsed() < Duration::from_secs(20), "the parent has not started its child");
            std::thread::sleep(Duration::from_millis(5));
        };
        std::thread::sleep(Duration::from_millis(50));
        assert!(lives(group));
        // SIGKILL: nothing in the parent runs after it.
        parent.kill().unwrap();
        parent.wait().unwrap();
        until_gone(group);
        std::fs::remove_file(&file).unwrap();
    }

    #[test]
    fn a_dropped_process_is_gone_with_its_children() {
        let process = TiedProcess::spawn(tied(&shell("sleep 1000 & sleep 1000"), LIMIT).unwrap()).unwrap();
        let group = process.id();
        assert!(lives(group));
        drop(process);
        until_gone(group);
    }

    #[test]
    fn output_and_status_are_those_of_the_command() {
        let output =
            TiedProcess::output(shell("echo said; echo wrong >&2; exit 7").env("X", "1"), LIMIT, true).unwrap();
        assert_eq!((output.stdout.as_slice(), output.stderr.as_slice()), (&b"said\n"[..], &b"wrong\n"[..]));
        assert_eq!(output.status.code(), Some(7));
        let output = TiedProcess::output(shell("echo $X; cat").env("X", "1"), LIMIT, true).unwrap();
        assert_eq!((output.stdout.as_slice(), output.status.code()), (&b"1\n"[..], Some(0)), "the input is empty");
        let missing = TiedProcess::output(&Command::new("no-such-program"), LIMIT, true).unwrap_err();
        assert_eq!(missing.kind(), std::io::ErrorKind::NotFound);
    }

    #[test]
    fn a_child_that_computes_for_ever_is_killed() {
        let output = TiedProcess::output(&shell("while :; do :; done"), Duration::from_secs(1), true).unwrap();
        assert!(!output.status.success() && output.status.code().is_some_and(|code| code > 128), "{output:?}");
    }
}
