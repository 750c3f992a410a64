//! Child processes that end with this program, however it ends.
//!
//! A process that is killed cannot end its children. So a shell starts the child, and a second shell reads from a pipe whose other end this program
//! keeps open. The system closes that end even after `kill -9`; then the second shell kills the whole process group, itself included. A child that
//! never ends is killed after a limit of processor time.
//!
//! Windows has no such shell: there, a child outlives a program that is killed, and has no limit.

use std::io;
use std::process::{Child, ChildStdin, Command, Output, Stdio};
use std::time::Duration;

/// Arguments: the limit in seconds, then the child's command line. The last command's status is the child's; 128 and a signal's number if one ended it.
#[cfg(unix)]
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
pub struct ChildProcess {
    child: Child,
    /// As long as this is open, the child lives.
    alive: Option<ChildStdin>,
}

/// Gives a command the environment and the folder of another one.
fn copy_surroundings(from: &Command, to: &mut Command) {
    for (name, value) in from.get_envs() {
        match value {
            Some(value) => to.env(name, value),
            None => to.env_remove(name),
        };
    }
    if let Some(folder) = from.get_current_dir() {
        to.current_dir(folder);
    }
}

/// Starts the shells that run a command, and returns the pipe that keeps the child alive.
#[cfg(unix)]
fn start(command: &Command, limit: Duration, stdout: Stdio, stderr: Stdio) -> io::Result<(Child, Option<ChildStdin>)> {
    let program = command.get_program();
    let path = std::path::Path::new(program);
    let has_folder = path.components().count() > 1;
    let is_there =
        if has_folder { path.is_file() } else { crate::process::which(&program.to_string_lossy()).is_some() };
    if !is_there {
        return Err(io::ErrorKind::NotFound.into());
    }
    let mut shell = Command::new("/bin/sh");
    shell.args(["-c", SCRIPT, "sh", &limit.as_secs().max(1).to_string()]).arg(program).args(command.get_args());
    copy_surroundings(command, &mut shell);
    // Ctrl-C in a terminal reaches every process of its group, and a run should end in order while its child still answers.
    std::os::unix::process::CommandExt::process_group(&mut shell, 0);
    let mut child = shell.stdin(Stdio::piped()).stdout(stdout).stderr(stderr).spawn()?;
    let alive = child.stdin.take();
    Ok((child, alive))
}

/// Ends a child and everything in its group. It fails only if they have ended meanwhile.
#[cfg(unix)]
fn kill(child: &mut Child) {
    use rustix::process::{Pid, Signal, kill_process_group};
    if let Some(group) = i32::try_from(child.id()).ok().and_then(Pid::from_raw) {
        kill_process_group(group, Signal::KILL).ok();
    }
}

/// Starts a command itself.
#[cfg(not(unix))]
fn start(command: &Command, _: Duration, stdout: Stdio, stderr: Stdio) -> io::Result<(Child, Option<ChildStdin>)> {
    let mut copy = Command::new(command.get_program());
    copy.args(command.get_args());
    copy_surroundings(command, &mut copy);
    Ok((copy.stdin(Stdio::null()).stdout(stdout).stderr(stderr).spawn()?, None))
}

/// Ends a child. It fails only if it has ended meanwhile.
#[cfg(not(unix))]
fn kill(child: &mut Child) {
    child.kill().ok();
}

impl ChildProcess {
    /// Starts a command, with this limit of processor time for each of its processes. Its input is empty.
    ///
    /// # Errors
    /// There is no such program, or it cannot start.
    pub fn spawn(command: &Command, limit: Duration, stdout: Stdio, stderr: Stdio) -> io::Result<Self> {
        start(command, limit, stdout, stderr).map(|(child, alive)| Self { child, alive })
    }

    /// Runs a command as [`ChildProcess::spawn`] does, to its end, and returns its output. What it prints on standard error is in the output too if
    /// `keeps_errors`, otherwise it is printed.
    ///
    /// # Errors
    /// It cannot start, or its output cannot be read.
    pub fn output(command: &Command, limit: Duration, keeps_errors: bool) -> io::Result<Output> {
        let errors = if keeps_errors { Stdio::piped() } else { Stdio::inherit() };
        // Open until the end: without it, the child would end.
        let (child, _alive) = start(command, limit, Stdio::piped(), errors)?;
        child.wait_with_output()
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
        if !has_ended {
            kill(&mut self.child);
        }
        self.alive = None;
        self.child.wait().ok();
    }
}

impl Drop for ChildProcess {
    fn drop(&mut self) {
        self.end();
    }
}

#[cfg(all(test, unix))]
#[allow(clippy::unwrap_used, reason = "a test that fails should stop there")]
mod tests {
    use super::ChildProcess;
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

    /// A child that starts another one, as cargo does.
    fn sleeper() -> ChildProcess {
        ChildProcess::spawn(&shell("sleep 1000 & sleep 1000"), LIMIT, Stdio::inherit(), Stdio::inherit()).unwrap()
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
            let process = sleeper();
            std::fs::write(file, process.id().to_string()).unwrap();
            loop {
                std::thread::park();
            }
        }
        let file = std::env::temp_dir().join(format!("newtau-test-child-{}", std::process::id()));
        let name = "child_process::tests::a_child_and_its_children_end_with_a_parent_that_is_killed";
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
        let process = sleeper();
        let group = process.id();
        assert!(lives(group));
        drop(process);
        until_gone(group);
    }

    #[test]
    fn output_and_status_are_those_of_the_command() {
        let output =
            ChildProcess::output(shell("echo said; echo wrong >&2; exit 7").env("X", "1"), LIMIT, true).unwrap();
        assert_eq!((output.stdout.as_slice(), output.stderr.as_slice()), (&b"said\n"[..], &b"wrong\n"[..]));
        assert_eq!(output.status.code(), Some(7));
        let output = ChildProcess::output(shell("echo $X; cat").env("X", "1"), LIMIT, true).unwrap();
        assert_eq!((output.stdout.as_slice(), output.status.code()), (&b"1\n"[..], Some(0)), "the input is empty");
        let missing = ChildProcess::output(&Command::new("no-such-program"), LIMIT, true).unwrap_err();
        assert_eq!(missing.kind(), std::io::ErrorKind::NotFound);
    }

    #[test]
    fn a_child_that_computes_for_ever_is_killed() {
        let output = ChildProcess::output(&shell("while :; do :; done"), Duration::from_secs(1), true).unwrap();
        assert!(!output.status.success() && output.status.code().is_some_and(|code| code > 128), "{output:?}");
    }
}
