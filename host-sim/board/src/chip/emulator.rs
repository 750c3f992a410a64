//! The emulator as a child process with a socket to its serial port.

use super::ChipError;
use crate::key;
use link::{Key, key_page};
use std::collections::VecDeque;
use std::ffi::OsString;
use std::io::{ErrorKind, Read as _, Write as _};
use std::os::unix::net::{UnixListener, UnixStream};
use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Command, Stdio};
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

/// Timeouts of each wait.
#[derive(Clone, Copy, Debug)]
pub struct Timeouts {
    /// From the start of the emulator to its connection.
    pub connect: Duration,
    /// From a frame to its answer. A tick takes milliseconds; a machine busy with other work, longer.
    pub answer: Duration,
}

impl Default for Timeouts {
    fn default() -> Self {
        Self { connect: Duration::from_secs(10), answer: Duration::from_secs(5) }
    }
}

/// A running emulator; dropping it ends the process.
#[derive(Debug)]
pub struct Emulator {
    pub(super) child: Child,
    link: UnixStream,
    timeouts: Timeouts,
    buffer: [u8; 256],
    unread: std::ops::Range<usize>,
    /// Bytes that were read while a write found no room; they come behind the unread ones.
    ahead: VecDeque<u8>,
    carried: Carried,
    key: Option<Key>,
    /// The emulator opens the file some time after it has connected.
    _page: KeyFile,
}

/// Bytes that the link has carried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Carried {
    /// From the host.
    pub to_chip: u64,
    /// To the host.
    pub from_chip: u64,
    /// Packets from the host, by the zeros that end them.
    pub packets_to_chip: u64,
}

/// Ends the child if the start fails.
struct Guard(Option<Child>);

impl Drop for Guard {
    fn drop(&mut self) {
        if let Some(mut child) = self.0.take() {
            end(&mut child);
        }
    }
}

fn end(child: &mut Child) {
    // Fails only if the child has ended already.
    child.kill().ok();
    child.wait().ok();
}

impl Emulator {
    /// Start `program` (QEMU for Arm) on an ELF file and wait until its serial port is connected.
    ///
    /// # Errors
    /// The program cannot start, ends, or does not connect in time.
    pub fn start(program: &Path, elf: &Path, timeouts: Timeouts) -> Result<Self, ChipError> {
        Self::start_with(program, elf, timeouts, &[])
    }

    /// As [`Emulator::start`], with nothing in the chip's key page.
    ///
    /// # Errors
    /// As [`Emulator::start`].
    pub fn start_without_key(program: &Path, elf: &Path, timeouts: Timeouts) -> Result<Self, ChipError> {
        Self::start_over(program, elf, timeouts, &[], None)
    }

    /// As [`Emulator::start`], with this key in the chip's key page.
    ///
    /// # Errors
    /// As [`Emulator::start`].
    pub fn start_with_key(program: &Path, elf: &Path, timeouts: Timeouts, key: Key) -> Result<Self, ChipError> {
        Self::start_over(program, elf, timeouts, &[], Some(key))
    }

    /// As [`Emulator::start`], with more arguments for the emulator: a log of the executed instructions, memory to load
    /// before it starts.
    ///
    /// A log on its standard error must be read all the time, see [`Emulator::take_log`]: otherwise the emulator stands
    /// still.
    ///
    /// # Errors
    /// As [`Emulator::start`].
    pub fn start_with(
        program: &Path,
        elf: &Path,
        timeouts: Timeouts,
        arguments: &[OsString],
    ) -> Result<Self, ChipError> {
        // A new one every time: nobody else can know it.
        Self::start_over(program, elf, timeouts, arguments, Some(key::new()?))
    }

    fn start_over(
        program: &Path,
        elf: &Path,
        timeouts: Timeouts,
        arguments: &[OsString],
        key: Option<Key>,
    ) -> Result<Self, ChipError> {
        let socket = Socket::new()?;
        let page = KeyFile::new(&socket.path, key)?;
        let mut command = Command::new(program);
        command
            .args(["-M", "netduinoplus2", "-icount", "shift=0", "-display", "none", "-monitor", "none"])
            .arg("-chardev")
            .arg(format!("socket,id=link,path={}", socket.path.display()))
            // The firmware's link is the second serial port.
            .args(["-serial", "null", "-serial", "chardev:link"])
            .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
            .arg(elf)
            .args(page.arguments())
            .args(arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            // A process group of its own: Ctrl-C in a terminal reaches every process of the group, and the run should
            // end cleanly while the chip still answers.
            .process_group(0);
        let child = on_one_processor(|| command.spawn())
            .map_err(|source| ChipError::CannotStart { program: program.to_owned(), source })?;
        let mut guard = Guard(Some(child));
        let link = socket.accept(&mut guard, timeouts.connect)?;
        link.set_read_timeout(Some(timeouts.answer))?;
        link.set_write_timeout(Some(timeouts.answer))?;
        let Some(child) = guard.0.take() else {
            return Err(ChipError::Io(ErrorKind::NotFound.into()));
        };
        Ok(Self {
            child,
            link,
            timeouts,
            buffer: [0; 256],
            unread: 0..0,
            ahead: VecDeque::new(),
            carried: Carried::default(),
            key,
            _page: page,
        })
    }

    /// Send bytes.
    pub(super) fn write(&mut self, bytes: &[u8]) -> Result<(), ChipError> {
        self.carried.to_chip += bytes.len() as u64;
        self.carried.packets_to_chip += bytes.iter().filter(|byte| **byte == 0).count() as u64;
        self.link.set_nonblocking(true)?;
        let written = self.write_and_read(bytes);
        self.link.set_nonblocking(false)?;
        written.map_err(|error| self.explain(error, "room for a frame"))
    }

    /// Write all bytes, and read while they find no room. The emulated transmitter waits until its bytes are read, and the chip reads none
    /// meanwhile: without this, chip and host would wait for each other.
    fn write_and_read(&mut self, mut bytes: &[u8]) -> std::io::Result<()> {
        let mut limit = Instant::now() + self.timeouts.answer;
        while !bytes.is_empty() {
            match self.link.write(bytes) {
                Ok(count) => {
                    bytes = bytes.get(count..).unwrap_or_default();
                    limit = Instant::now() + self.timeouts.answer;
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => {
                    if !self.read_ahead()? {
                        std::thread::sleep(Duration::from_micros(50));
                    }
                    if Instant::now() > limit {
                        return Err(error);
                    }
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Read what has come, without waiting. True if something had.
    fn read_ahead(&mut self) -> std::io::Result<bool> {
        let mut bytes = [0; 256];
        match self.link.read(&mut bytes) {
            Ok(0) => Err(ErrorKind::BrokenPipe.into()),
            Ok(count) => {
                self.ahead.extend(bytes.iter().take(count));
                self.carried.from_chip += count as u64;
                Ok(true)
            }
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// The next byte; an error names the awaited answer.
    pub(super) fn read_byte(&mut self, waiting_for: &'static str) -> Result<u8, ChipError> {
        if self.unread.is_empty() {
            if let Some(byte) = self.ahead.pop_front() {
                return Ok(byte);
            }
            let count = loop {
                match self.link.read(&mut self.buffer) {
                    Ok(0) => return Err(dead(&mut self.child, waiting_for)),
                    Ok(count) => break count,
                    // A signal to this program, such as Ctrl-C, says nothing about the chip.
                    Err(error) if error.kind() == ErrorKind::Interrupted => {}
                    Err(error) => return Err(self.explain(error, waiting_for)),
                }
            };
            self.unread = 0..count;
            self.carried.from_chip += count as u64;
        }
        let byte = self.buffer[self.unread.start];
        self.unread.start += 1;
        Ok(byte)
    }

    /// Set the timeout of all answers from now on.
    ///
    /// # Errors
    /// The system refuses the timeout, for example if it is zero.
    pub fn set_answer_timeout(&mut self, timeout: Duration) -> Result<(), ChipError> {
        self.timeouts.answer = timeout;
        Ok(self.link.set_read_timeout(Some(timeout))?)
    }

    pub(super) fn carried(&self) -> Carried {
        self.carried
    }

    /// The emulator's standard error, once. Without it, the error of a dead emulator has no output.
    pub fn take_log(&mut self) -> Option<ChildStderr> {
        self.child.stderr.take()
    }

    /// The key in the chip's key page.
    #[must_use]
    pub fn key(&self) -> Option<Key> {
        self.key
    }

    /// The emulator's process number.
    #[must_use]
    pub fn process(&self) -> u32 {
        self.child.id()
    }

    fn explain(&mut self, error: std::io::Error, waiting_for: &'static str) -> ChipError {
        match error.kind() {
            ErrorKind::WouldBlock | ErrorKind::TimedOut => {
                ChipError::Silent { waiting_for, timeout: self.timeouts.answer }
            }
            ErrorKind::BrokenPipe | ErrorKind::ConnectionReset | ErrorKind::UnexpectedEof => {
                dead(&mut self.child, waiting_for)
            }
            _ => ChipError::Io(error),
        }
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        end(&mut self.child);
    }
}

/// Make the error of an emulator that has closed its side: end it, and repeat its output.
fn dead(child: &mut Child, waiting_for: &'static str) -> ChipError {
    // The emulator closes the socket a moment before it ends; wait a moment, so that the error holds its exit status.
    let limit = Instant::now() + Duration::from_millis(500);
    let status = loop {
        match child.try_wait() {
            Ok(Some(status)) => break status.to_string(),
            Ok(None) if Instant::now() < limit => std::thread::sleep(Duration::from_millis(2)),
            Ok(None) | Err(_) => break "its link is closed".into(),
        }
    };
    end(child);
    let mut output = String::new();
    if let Some(mut stderr) = child.stderr.take() {
        stderr.read_to_string(&mut output).ok();
    }
    let output = output.trim_end();
    let output = if output.is_empty() { String::new() } else { format!(":\n{output}") };
    ChipError::Dead { status, waiting_for, output }
}

/// The chip's key page as a file, which the emulator loads before it starts; the file is deleted on drop.
#[derive(Debug)]
struct KeyFile(Option<PathBuf>);

impl KeyFile {
    fn new(beside: &Path, key: Option<Key>) -> Result<Self, ChipError> {
        let Some(key) = key else { return Ok(Self(None)) };
        let path = beside.with_extension("key");
        std::fs::remove_file(&path).ok();
        key::write_for_owner(&path, &key::page(&key)?)?;
        Ok(Self(Some(path)))
    }

    fn arguments(&self) -> Vec<OsString> {
        let Some(path) = &self.0 else { return Vec::new() };
        let mut loader = OsString::from("loader,file=");
        loader.push(path);
        loader.push(format!(",addr={:#x},force-raw=on", key_page::ADDRESS));
        vec!["-device".into(), loader]
    }
}

impl Drop for KeyFile {
    fn drop(&mut self) {
        if let Some(path) = &self.0 {
            std::fs::remove_file(path).ok();
        }
    }
}

/// A listening socket with a file name; the file is deleted on drop.
struct Socket {
    listener: UnixListener,
    path: PathBuf,
}

impl Socket {
    fn new() -> Result<Self, ChipError> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("newtau-{}-{count}.sock", std::process::id()));
        // The file may be left over from a killed process with the same id.
        std::fs::remove_file(&path).ok();
        let listener = UnixListener::bind(&path)?;
        listener.set_nonblocking(true)?;
        Ok(Self { listener, path })
    }

    fn accept(&self, guard: &mut Guard, timeout: Duration) -> Result<UnixStream, ChipError> {
        const WAITING_FOR: &str = "the emulator's connection";
        let end = Instant::now() + timeout;
        loop {
            match self.listener.accept() {
                Ok((stream, _)) => {
                    stream.set_nonblocking(false)?;
                    return Ok(stream);
                }
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(error) => return Err(error.into()),
            }
            if let Some(child) = &mut guard.0
                && child.try_wait()?.is_some()
            {
                return Err(dead(child, WAITING_FOR));
            }
            if Instant::now() >= end {
                return Err(ChipError::Silent { waiting_for: WAITING_FOR, timeout });
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

impl Drop for Socket {
    fn drop(&mut self) {
        std::fs::remove_file(&self.path).ok();
    }
}

/// Run `start` with this thread pinned to its current processor; a child process inherits the affinity.
#[cfg(target_os = "linux")]
fn on_one_processor<T>(start: impl FnOnce() -> T) -> T {
    use rustix::thread::{CpuSet, sched_getaffinity, sched_getcpu, sched_setaffinity};
    let all = sched_getaffinity(None);
    let mut one = CpuSet::new();
    one.set(sched_getcpu());
    // The affinity only affects speed: if the system refuses it, go on without.
    sched_setaffinity(None, &one).ok();
    let result = start();
    if let Ok(all) = all {
        sched_setaffinity(None, &all).ok();
    }
    result
}

/// Other systems leave the affinity to the scheduler: slower, otherwise the same.
#[cfg(not(target_os = "linux"))]
fn on_one_processor<T>(start: impl FnOnce() -> T) -> T {
    start()
}
