//! Adapters on pseudo-terminals with a simulated arm behind them.

use board::can::frame::CanFrame;
use board::can::simulated::SimulatedArm;
use embedded_can::Frame as _;
use robot_compiler::SceneFile;
use serialport::{SerialPort as _, TTYPort};
use std::io::{Read as _, Write as _};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Protocol of an adapter, written from its description without the program's code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Slcan,
    Damiao,
}

impl Kind {
    /// Removes the first whole command from the received bytes: a frame, or something that is none.
    pub(crate) fn command(self, bytes: &mut Vec<u8>) -> Option<Option<CanFrame>> {
        match self {
            Self::Slcan => {
                let end = bytes.iter().position(|&byte| byte == b'\r')?;
                let line: Vec<u8> = bytes.drain(..=end).collect();
                let text = String::from_utf8(line[..end].to_vec()).unwrap();
                let (digits, rest) = match text.split_at_checked(1) {
                    Some(("t", rest)) => (3, rest),
                    Some(("T", rest)) => (8, rest),
                    _ => {
                        assert!(["", "C", "S8", "O"].contains(&text.as_str()), "{text}");
                        return Some(None);
                    }
                };
                let number = |digits: &str| u32::from_str_radix(digits, 16).unwrap();
                let data: Vec<u8> =
                    (digits + 1..rest.len()).step_by(2).map(|at| number(&rest[at..at + 2]) as u8).collect();
                assert_eq!(data.len(), number(&rest[digits..=digits]) as usize, "{text}");
                Some(CanFrame::of(number(&rest[..digits]), digits == 8, &data))
            }
            Self::Damiao => {
                if bytes.len() < 30 {
                    return None;
                }
                let command: Vec<u8> = bytes.drain(..30).collect();
                assert_eq!(command[..4], [0x55, 0xAA, 30, 3]);
                let id = u32::from(command[13]) | u32::from(command[14]) << 8;
                Some(CanFrame::of(id, false, &command[21..21 + usize::from(command[18])]))
            }
        }
    }

    /// The bytes of a frame that was received on the bus.
    pub(crate) fn report(self, frame: &CanFrame) -> Vec<u8> {
        match self {
            Self::Slcan => {
                let data: String = frame.data().iter().map(|byte| format!("{byte:02X}")).collect();
                let (kind, digits) = if frame.is_extended() { ('T', 8) } else { ('t', 3) };
                format!("{kind}{:0digits$X}{}{data}\r", frame.raw_id(), frame.dlc()).into_bytes()
            }
            Self::Damiao => {
                let mut bytes = vec![0xAA, 0x11, frame.dlc() as u8];
                bytes.extend(frame.raw_id().to_le_bytes());
                bytes.extend(frame.data());
                bytes.extend(std::iter::repeat_n(0, 8 - frame.dlc()));
                bytes.push(0x55);
                bytes
            }
        }
    }

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Slcan => "slcan",
            Self::Damiao => "damiao",
        }
    }
}

/// An adapter on a pseudo-terminal with a simulated arm behind it.
pub(crate) struct Adapter {
    pub(crate) arm: SimulatedArm,
    pub(crate) name: String,
    ends: Arc<AtomicBool>,
    /// Every frame from the program, with its time.
    pub(crate) frames: Arc<Mutex<Vec<(Instant, CanFrame)>>>,
    thread: Option<JoinHandle<()>>,
}

impl Adapter {
    pub(crate) fn new(kind: Kind, scene: &Path) -> Self {
        let (mut board, host) = TTYPort::pair().unwrap();
        board.set_timeout(Duration::from_millis(1)).unwrap();
        let name = format!("{}:{}", kind.name(), host.name().unwrap());
        let arm = SimulatedArm::new(&SceneFile::load(scene).unwrap()).unwrap_or_else(|why| panic!("{why:?}"));
        let (ends, frames) = (Arc::new(AtomicBool::new(false)), Arc::new(Mutex::new(Vec::new())));
        let (its_arm, its_end, its_frames) = (arm.clone(), Arc::clone(&ends), Arc::clone(&frames));
        let thread = thread::spawn(move || {
            // Kept open, so that the terminal lives before and between programs.
            let _host = host;
            let (mut bytes, mut buffer) = (Vec::new(), [0; 512]);
            while !its_end.load(Ordering::Relaxed) {
                its_arm.advance();
                let Ok(count) = board.read(&mut buffer) else { continue };
                bytes.extend(&buffer[..count]);
                while let Some(command) = kind.command(&mut bytes) {
                    let Some(frame) = command else { continue };
                    its_frames.lock().unwrap().push((Instant::now(), frame));
                    let replies: Vec<u8> =
                        its_arm.deliver(&frame).iter().flat_map(|reply| kind.report(reply)).collect();
                    board.write_all(&replies).unwrap();
                }
            }
        });
        Self { arm, name, ends, frames, thread: Some(thread) }
    }

    /// Time of the first frame that ends with this byte, among those that end with seven bytes `FF` before it.
    pub(crate) fn first(&self, last: u8) -> Option<Instant> {
        let frames = self.frames.lock().unwrap();
        let special = |frame: &CanFrame| matches!(frame.data(), [0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, byte] if *byte == last);
        frames.iter().find(|(_, frame)| special(frame)).map(|(time, _)| *time)
    }

    pub(crate) fn unplug(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            thread.join().unwrap();
        }
    }
}

impl Drop for Adapter {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
    }
}
