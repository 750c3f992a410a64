//! A chip under attack: emulators with and without a key, and a dry run of which every sent byte is kept.

use crate::chip::{Chip, Emulator, Timeouts, build_firmware};
use dynamics_core::{Measurement, Reference, Sensed};
use link::{Actuation, Frame, Hello, HostChannel, Key, Lines, Pacing, Point, Refusal, Request, StateCode, Status};
use robot_compiler::SceneFile;
use std::path::{Path, PathBuf};

pub(super) const KEY: Key = Key::new([0x6b; 32]);

pub(super) const REST: Sensed<f32, 2> = Sensed::State { q: [0.1, 0.2], qd: [0.0; 2] };

pub(super) fn scene() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/planar2r_swing.toml")
}

pub(super) fn hello(pacing: Pacing) -> Hello {
    let file = SceneFile::load(&scene()).unwrap();
    crate::chip::hello(&file, &file.robot.model::<2>().unwrap(), pacing)
}

pub(super) fn emulator(key: Option<Key>) -> Emulator {
    emulator_of(&build_firmware(&scene()).unwrap(), key)
}

pub(super) fn emulator_of(elf: &Path, key: Option<Key>) -> Emulator {
    let program = Path::new("qemu-system-arm");
    match key {
        Some(key) => Emulator::start_with_key(program, elf, Timeouts::default(), key),
        None => Emulator::start_without_key(program, elf, Timeouts::default()),
    }
    .unwrap()
}

/// A chip with its host in a dry run, and the number of the last tick.
pub(super) struct AttackedDryRun(pub(super) Chip, pub(super) u32);

impl AttackedDryRun {
    pub(super) fn start() -> Self {
        Self::over(emulator(Some(KEY)))
    }

    pub(super) fn over(emulator: Emulator) -> Self {
        let mut chip = Chip::over(emulator, hello(Pacing::LockStep)).unwrap();
        chip.change_pacing(hello(Pacing::DryRun)).unwrap();
        chip.send(&Frame::Lines(Lines::CALM)).unwrap();
        Self(chip, 0)
    }

    /// A dry run with an armed arm. The fixture keeps all bytes that were sent to arm it.
    pub(super) fn armed() -> Self {
        Self::start().arm()
    }

    pub(super) fn arm(mut self) -> Self {
        for request in [Request::Home, Request::Confirm, Request::Arm] {
            self.ask(request);
        }
        while self.tick().0.state != StateCode::Armed {
            assert!(self.1 < 100, "it is not armed");
        }
        self
    }

    pub(super) fn running() -> Self {
        Self::armed().run()
    }

    pub(super) fn run(mut self) -> Self {
        let reference = link::Reference::new(&Reference { q: [0.1_f32, 0.2], qd: [0.0; 2], qdd: [0.0; 2] });
        self.0.send(&Frame::Point(Point { ticks: 0, reference })).unwrap();
        assert_eq!(self.ask(Request::Run).0.state, StateCode::Running);
        self
    }

    pub(super) fn ask(&mut self, request: Request) -> (Status, u16) {
        let number = self.1 as u8;
        self.0.send(&Frame::request(number, request)).unwrap();
        self.tick()
    }

    /// Runs one tick. Returns its status, and the highest count of packets rejected as not authentic before it (0 if none).
    pub(super) fn tick(&mut self) -> (Status, u16) {
        let (status, refusals) = self.tick_after_noise();
        let count = |refusal: &Refusal| match refusal {
            Refusal::Unauthentic { count } => *count,
            other => panic!("{other:?}"),
        };
        (status, refusals.iter().map(count).fold(0, |_, last| last))
    }

    /// Runs one tick. Returns its status and every refusal before it.
    pub(super) fn tick_after_noise(&mut self) -> (Status, Vec<Refusal>) {
        self.1 += 1;
        let measurement = link::Measurement::new(self.1, &Measurement { sensed: REST, age_ticks: 0 });
        self.0.send(&Frame::Measurement(measurement)).unwrap();
        let mut refusals = Vec::new();
        loop {
            match self.0.receive("a status").unwrap() {
                Frame::Refusal(refusal) => refusals.push(refusal),
                Frame::Answer(_) => {}
                Frame::Status(status) => return (status, refusals),
                other => panic!("{other:?}"),
            }
        }
    }

    /// Encodes a frame as a packet of the session, without sending it.
    pub(super) fn packet(&mut self, frame: &Frame) -> Vec<u8> {
        self.0.channel.encode(frame).unwrap().to_vec()
    }

    pub(super) fn attack(&mut self, bytes: &[u8]) {
        self.0.emulator.write(bytes).unwrap();
    }
}

pub(super) fn drives(status: &Status) -> bool {
    matches!(status.actuation, Some(Actuation::Drive { .. }))
}

/// Sends bytes to a chip, then a join without a key. Returns all frames of the chip up to the challenge that answers this join.
pub(super) fn heard_by_a_stranger(emulator: &mut Emulator, bytes: &[u8]) -> Vec<Frame> {
    let mut stranger = HostChannel::new(None);
    emulator.write(bytes).unwrap();
    emulator.write(&stranger.join([0xee; 16]).unwrap()).unwrap();
    let mut frames = Vec::new();
    // The bytes may contain a join too. The challenge to our own join is the last one: nothing follows it for a while.
    while !matches!(frames.last(), Some(Frame::Challenge(_))) {
        let byte = emulator.read_byte("a challenge").unwrap();
        if let Some(Ok(received)) = stranger.push(byte) {
            frames.push(received.frame);
        }
    }
    frames
}

/// A chip that has started and sent its hello.
pub(super) fn started(key: Option<Key>) -> Emulator {
    let mut emulator = self::emulator(key);
    let mut host = HostChannel::new(None);
    while host.push(emulator.read_byte("the chip's hello").unwrap()).is_none() {}
    emulator
}
