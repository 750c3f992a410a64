//! The closed loop with the real firmware under its safety state machine: home, confirm, arm, run a motion, stop. Every status of the chip equals the
//! desk's bit for bit.

use board::chip::{Chip, ChipError, build_firmware, build_firmware_by_dma, hello};
use board::session::dry_run::{DryRun, OnChip, OnDesk, without_cost};
use dynamics_core::{Measurement, Reference, Sensed};
use link::{Actuation, Frame, Lines, Pacing, Point, Request, StateCode, Status};
use robot_compiler::SceneFile;
use std::path::{Path, PathBuf};

const N: usize = 6;

/// Two targets that must give the same answers.
struct Both {
    chip: OnChip,
    desk: OnDesk<N>,
    tick: u32,
    least: u32,
    most: u32,
}

impl Both {
    fn start(name: &str, build: impl Fn(&Path) -> Result<PathBuf, ChipError>) -> (Self, SceneFile) {
        let scene = SceneFile::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes").join(name)).unwrap();
        let model = scene.robot.model::<N>().unwrap();
        let bench = hello(&scene, &model, Pacing::LockStep);
        let chip = Chip::start(&build(&scene.path).unwrap(), bench).unwrap();
        let chip = OnChip::start(chip, bench).unwrap();
        let both = Self { chip, desk: OnDesk::start(&scene, &model), tick: 0, least: u32::MAX, most: 0 };
        (both, scene)
    }

    fn send(&mut self, frame: &Frame) {
        self.chip.send(frame).unwrap();
        self.desk.send(frame).unwrap();
    }

    /// Runs one tick with these encoder counts. Returns the status, which both must agree on.
    fn tick(&mut self, counts: [i32; N]) -> Status {
        self.tick += 1;
        let measurement = Measurement { sensed: Sensed::<f32, N>::Counts(counts), age_ticks: 0 };
        let measurement = link::Measurement::new(self.tick, &measurement);
        let chip = self.chip.tick(&measurement).unwrap();
        let desk = self.desk.tick(&measurement).unwrap();
        let Some(Frame::Status(status)) = chip.last().cloned() else { panic!("{chip:?}") };
        if status.state == StateCode::Running
            && let Some(link::TickCost { all: link::Cost::Instructions(all), .. }) = status.cost
        {
            (self.least, self.most) = (self.least.min(all), self.most.max(all));
        }
        let chip: Vec<Frame> = chip.into_iter().map(without_cost).collect();
        assert_eq!(chip, desk, "tick {}", self.tick);
        status
    }

    fn ask(&mut self, request: Request, counts: [i32; N]) -> Status {
        self.send(&Frame::request(self.tick as u8, request));
        self.tick(counts)
    }
}

#[test]
fn a_motion_under_supervision_has_the_desk_s_bits_in_every_status() {
    motion(build_firmware);
}

/// Every packet of the session is read from the DMA receive buffer and sent through the output queue, which both wrap around many times.
#[test]
fn a_motion_over_the_link_by_dma_has_the_desk_s_bits_in_every_status() {
    motion(build_firmware_by_dma);
}

fn motion(build: fn(&Path) -> Result<PathBuf, ChipError>) {
    let (mut both, scene) = Both::start("puma560_pick.toml", build);
    let model = scene.robot.model::<N>().unwrap();
    let encoder = scene.controller_config(&model).encoder;
    let counts =
        |q: &[f64; N]| core::array::from_fn(|i| encoder[i].zero + (q[i] / encoder[i].per_count).round() as i32);
    let motion = scene.trajectory(&model).unwrap();
    let start = motion.start();

    let lines = Lines { supply: Some(24.0), temperature: Some(30.0), ..Lines::CALM };
    both.send(&Frame::Lines(lines));
    both.send(&Frame::Live(link::Live::new(&scene.live(&model).cast::<f32>()).unwrap()));
    assert_eq!(both.ask(Request::Arm, counts(&start.q)).state, StateCode::Idle, "not homed yet");
    both.ask(Request::Home, counts(&start.q));
    assert!(both.ask(Request::Confirm, counts(&start.q)).homed);
    both.ask(Request::Arm, counts(&start.q));
    // Torque rises against engaged brakes.
    while both.tick(counts(&start.q)).state != StateCode::Armed {
        assert!(both.tick < 200, "it is not armed");
    }

    let point = |ticks, at: &Reference<f64, N>| Point { ticks, reference: link::Reference::new(&at.cast::<f32>()) };
    both.send(&Frame::Point(point(0, &start)));
    let (step, ticks) = (10_u16, 600);
    let mut sent = 0;
    for k in 0..ticks {
        // The arm follows the motion exactly; another test covers the effects of a plant.
        let here = motion.sample(f64::from(k) * scene.period());
        while sent < k + 100 && sent < ticks {
            sent += u32::from(step);
            let at = motion.sample(f64::from(sent) * scene.period());
            both.send(&Frame::Point(point(step, &at)));
        }
        if k == 0 {
            both.send(&Frame::request(200, Request::Run));
        }
        let status = both.tick(counts(&here.q));
        assert_eq!((status.state, status.refused), (StateCode::Running, None), "tick {k}");
        assert!(matches!(status.actuation, Some(Actuation::Drive { .. })));
    }
    assert_eq!(both.ask(Request::Hold, counts(&motion.sample(0.6).q)).state, StateCode::Holding);
    both.send(&Frame::Lines(Lines { emergency_stop: true, ..lines }));
    let status = both.tick(counts(&motion.sample(0.6).q));
    assert_eq!((status.state, status.cause, status.actuation), (StateCode::Fault, 9, Some(Actuation::Brake)));
    println!("a running tick takes {} to {} instructions", both.least, both.most);
}
