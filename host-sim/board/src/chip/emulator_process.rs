//! The emulator's process, the socket to its serial port, and its key page file.

use super::ChipError;
use crate::key;
use firmware_image::child_process::ChildProcess;
use firmware_image::scratch::ScratchFile;
use link::{Key, key_page};
use std::ffi::OsString;
use std::io::{ErrorKind, Read as _};
use std::time::{Duration, Instant};

/// Makes the error of an emulator that has closed its socket: ends the process and includes its output.
pub(super) fn dead(process: &mut ChildProcess, waiting_for: &'static str) -> ChipError {
    // The emulator closes the socket a moment before it ends; wait a moment, so that the error holds its exit status.
    let limit = Instant::now() + Duration::from_millis(500);
    let status = loop {
        match process.child().try_wait() {
            Ok(Some(status)) => break status.to_string(),
            Ok(None) if Instant::now() < limit => std::thread::sleep(Duration::from_millis(2)),
            Ok(None) | Err(_) => break "its link is closed".into(),
        }
    };
    process.end();
    let mut output = String::new();
    if let Some(mut stderr) = process.child().stderr.take() {
        stderr.read_to_string(&mut output).ok();
    }
    let output = output.trim_end();
    let output = if output.is_empty() { String::new() } else { format!(":\n{output}") };
    ChipError::Dead { status, waiting_for, output }
}

/// The chip's key page as a file, which the emulator loads before it starts; the file is deleted on drop.
#[derive(Debug)]
pub(super) struct KeyFile(Option<ScratchFile>);

impl KeyFile {
    pub(super) fn new(key: Option<Key>) -> Result<Self, ChipError> {
        let Some(key) = key else { return Ok(Self(None)) };
        let file = ScratchFile::new("key")?;
        key::write_for_owner(file.path(), &key::page(&key)?)?;
        Ok(Self(Some(file)))
    }

    pub(super) fn arguments(&self) -> Vec<OsString> {
        let Some(file) = &self.0 else { return Vec::new() };
        let mut loader = OsString::from("loader,file=");
        loader.push(file.path());
        loader.push(format!(",addr={:#x},force-raw=on", key_page::ADDRESS));
        vec!["-device".into(), loader]
    }
}

/// Connection to the emulated serial port.
#[cfg(unix)]
pub(super) type Stream = std::os::unix::net::UnixStream;

/// Connection to the emulated serial port. The emulator for Windows has no sockets with a file name.
#[cfg(not(unix))]
pub(super) type Stream = std::net::TcpStream;

/// A listening socket with a file name; the file is deleted on drop.
#[cfg(unix)]
pub(super) struct Socket {
    listener: std::os::unix::net::UnixListener,
    file: ScratchFile,
}

#[cfg(unix)]
impl Socket {
    pub(super) fn new() -> Result<Self, ChipError> {
        let file = ScratchFile::new("sock")?;
        let listener = std::os::unix::net::UnixListener::bind(file.path())?;
        listener.set_nonblocking(true)?;
        Ok(Self { listener, file })
    }

    /// The address, as an option of the emulator.
    pub(super) fn address(&self) -> String {
        format!("path={}", self.file.path().display())
    }
}

/// A listening socket of this computer.
#[cfg(not(unix))]
pub(super) struct Socket {
    listener: std::net::TcpListener,
    address: std::net::SocketAddr,
}

#[cfg(not(unix))]
impl Socket {
    pub(super) fn new() -> Result<Self, ChipError> {
        let listener = std::net::TcpListener::bind((std::net::Ipv4Addr::LOCALHOST, 0))?;
        listener.set_nonblocking(true)?;
        let address = listener.local_addr()?;
        Ok(Self { listener, address })
    }

    /// The address, as an option of the emulator.
    pub(super) fn address(&self) -> String {
        format!("host={},port={}", self.address.ip(), self.address.port())
    }
}

impl Socket {
    pub(super) fn accept(&self, process: &mut ChildProcess, timeout: Duration) -> Result<Stream, ChipError> {
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
            if process.child().try_wait()?.is_some() {
                return Err(dead(process, WAITING_FOR));
            }
            if Instant::now() >= end {
                return Err(ChipError::Silent { waiting_for: WAITING_FOR, timeout });
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }
}

/// Runs `start` with this thread pinned to its current processor; a child process inherits the affinity.
#[cfg(target_os = "linux")]
pub(super) fn on_one_processor<T>(start: impl FnOnce() -> T) -> T {
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
pub(super) fn on_one_processor<T>(start: impl FnOnce() -> T) -> T {
    start()
}
