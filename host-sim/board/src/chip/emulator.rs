//! The emulator as a child process with a socket to its serial port.

use super::ChipError;
use super::emulator_process::{KeyFile, Socket, Stream, dead, on_one_processor};
use crate::key;
use firmware_image::child_process::ChildProcess;
use link::Key;
use std::collections::VecDeque;
use std::ffi::OsString;
use std::io::{ErrorKind, Read as _, Write as _};
use std::path::Path;
use std::process::{ChildStderr, Command, Stdio};
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

/// Processor time after which an emulator is killed: a session of some hours.
const LIMIT: Duration = Duration::from_secs(6 * 3600);

/// A running emulator; it ends when it is dropped, and when this program ends.
#[derive(Debug)]
pub struct Emulator {
    pub(super) process: ChildProcess,
    link: Stream,
    timeouts: Timeouts,
    buffer: [u8; 256],
    unread: std::ops::Range<usize>,
    /// Bytes that were read while a write had to wait. They follow the unread ones.
    ahead: VecDeque<u8>,
    carried: Carried,
    key: Option<Key>,
    /// Key page file. It must exist until the emulator has opened it, which is some time after the connection.
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

impl Emulator {
    /// Starts `program` (QEMU for Arm) on an ELF file and waits until its serial port is connected.
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

    /// As [`Emulator::start`], with more arguments for the emulator, for example a log of the executed instructions, or memory to load before it
    /// starts.
    ///
    /// If the emulator logs to its standard error, read this log all the time ([`Emulator::take_log`]). Otherwise the pipe fills up and the emulator
    /// stops.
    ///
    /// # Errors
    /// As [`Emulator::start`].
    pub fn start_with(
        program: &Path,
        elf: &Path,
        timeouts: Timeouts,
        arguments: &[OsString],
    ) -> Result<Self, ChipError> {
        // A new key for every start: no other program knows it.
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
        let page = KeyFile::new(key)?;
        let mut command = Command::new(program);
        command
            .args(["-M", "netduinoplus2", "-icount", "shift=0", "-display", "none", "-monitor", "none"])
            .arg("-chardev")
            .arg(format!("socket,id=link,{}", socket.address()))
            // The firmware's link is the second serial port.
            .args(["-serial", "null", "-serial", "chardev:link"])
            .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
            .arg(elf)
            .args(page.arguments())
            .args(arguments);
        let mut process = on_one_processor(|| ChildProcess::spawn(&command, LIMIT, Stdio::null(), Stdio::piped()))
            .map_err(|source| ChipError::CannotStart { program: program.to_owned(), source })?;
        let link = socket.accept(&mut process, timeouts.connect)?;
        link.set_read_timeout(Some(timeouts.answer))?;
        link.set_write_timeout(Some(timeouts.answer))?;
        Ok(Self {
            process,
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

    /// Sends bytes.
    pub(super) fn write(&mut self, bytes: &[u8]) -> Result<(), ChipError> {
        self.carried.to_chip += bytes.len() as u64;
        self.carried.packets_to_chip += bytes.iter().filter(|byte| **byte == 0).count() as u64;
        self.link.set_nonblocking(true)?;
        let written = self.write_and_read(bytes);
        self.link.set_nonblocking(false)?;
        written.map_err(|error| self.explain(error, "room for a frame"))
    }

    /// Writes all bytes, and reads while the socket accepts none. The emulated transmitter waits until its bytes are read, and the chip does not read
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

    /// Reads the available bytes without waiting. Returns true if there were any.
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
                    Ok(0) => return Err(dead(&mut self.process, waiting_for)),
                    Ok(count) => break count,
                    // A signal to this program, such as Ctrl-C, is no failure of the chip.
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

    /// Sets the timeout of all answers from now on.
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

    /// Takes the emulator's standard error; `None` after the first call. The error of a dead emulator then has no output.
    pub fn take_log(&mut self) -> Option<ChildStderr> {
        self.process.child().stderr.take()
    }

    /// The key in the chip's key page.
    #[must_use]
    pub fn key(&self) -> Option<Key> {
        self.key
    }

    /// Process id of the shell that started the emulator, and of their group.
    #[must_use]
    pub fn process(&self) -> u32 {
        self.process.id()
    }

    fn explain(&mut self, error: std::io::Error, waiting_for: &'static str) -> ChipError {
        match error.kind() {
            ErrorKind::WouldBlock | ErrorKind::TimedOut => {
                ChipError::Silent { waiting_for, timeout: self.timeouts.answer }
            }
            ErrorKind::BrokenPipe | ErrorKind::ConnectionReset | ErrorKind::UnexpectedEof => {
                dead(&mut self.process, waiting_for)
            }
            _ => ChipError::Io(error),
        }
    }
}
