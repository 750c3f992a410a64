//! A board at the far end of a pseudo-terminal: the firmware's own session on the desk, paced by a timer, with a scene's simulated arm as its joints.
#![allow(unreachable_pub, reason = "a part of a test")]

use board::session::dry_run::{Uncounted, desk_session};
use dynamics_core::Sensed;
use link::{Access, BoardChannel, Frame, Key, NonceSource, Pacing};
use robot_compiler::SceneFile;
use serialport::{SerialPort as _, TTYPort};
use session::black_box::Report;
use session::meter::Meter;
use session::readings::Lines;
use session::readings::{JointFaults, Readings};
use session::{Drives, Reaction};
use sim::plant::sensor::Sample;
use sim::run::scene_world;
use std::io::{Read as _, Write as _};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The board's time stops while its host has been silent for this long. On a machine that is busy with other tests, a program may be delayed longer
/// than a heartbeat limit, and these tests are not about that. The host sends at least every 20 ms.
const AWAY: Duration = Duration::from_millis(40);

/// A running board; it stops on drop.
pub struct LiveBoard {
    /// Name of the port.
    pub port: String,
    /// The key file of this board.
    pub key: PathBuf,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl LiveBoard {
    /// Starts a board with the firmware of a scene.
    pub fn start<const N: usize>(scene: SceneFile) -> Self {
        let (board, host) = TTYPort::pair().unwrap();
        let port = host.name().unwrap();
        // This end holds the lock that excludes other processes.
        drop(host);
        let stop = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&stop);
        let own = board::key::new().unwrap();
        let key = key_file(&own);
        let thread = std::thread::spawn(move || run::<N>(&scene, &own, board, &flag));
        Self { port, key, stop, thread: Some(thread) }
    }
}

impl Drop for LiveBoard {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        std::fs::remove_file(&self.key).ok();
        if let Some(thread) = self.thread.take() {
            let ended = thread.join();
            assert!(ended.is_ok() || std::thread::panicking(), "the board failed");
        }
    }
}

/// A new file with a key.
fn key_file(key: &Key) -> PathBuf {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let name = format!("newtau-board-{}-{}.key", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
    let path = std::env::temp_dir().join(name);
    board::key::save(key, &path).unwrap();
    path
}

fn run<const N: usize>(scene: &SceneFile, key: &Key, mut port: TTYPort, stop: &AtomicBool) {
    let model = scene.robot.model::<N>().unwrap();
    let mut session = desk_session(scene, &model);
    let mut world = scene_world::world::<N>(scene).unwrap();
    let meter = Meter::new(Uncounted);
    let mut channel = BoardChannel::new(Access::Key(Box::leak(Box::new(*key.bytes()))));
    let own = board::chip::hello(scene, &model, Pacing::LockStep);
    let nonce = || Some((board::key::random().unwrap(), NonceSource::Generator));
    let mut heard = Instant::now();
    while !stop.load(Ordering::Relaxed) {
        let mut answers = Vec::new();
        // There are no bytes if the other end is closed.
        let mut bytes = vec![0; port.bytes_to_read().unwrap_or(0) as usize];
        if port.read_exact(&mut bytes).is_err() {
            // The other end was closed in the meantime.
            bytes.clear();
        }
        if !bytes.is_empty() {
            heard = Instant::now();
        }
        for byte in bytes {
            let received = channel.push(byte, &own, &mut { nonce }, &mut |bytes| {
                port.write_all(bytes).ok();
            });
            let Some(received) = received else { continue };
            match session.receive(received) {
                Reaction::Reply(frame) | Reaction::Start(_, frame) | Reaction::Resume(frame) => answers.push(frame),
                Reaction::Stop(hello, refusal) => answers.extend([hello, refusal]),
                Reaction::None | Reaction::Tick => {}
            }
        }
        if session.is_live() && heard.elapsed() < AWAY {
            let reading = world.sensors.read(world.plant.measured());
            let sensed = match reading.sample {
                Sample::State(state) => Sensed::State { q: state.q.map(|x| x as f32), qd: state.qd.map(|x| x as f32) },
                Sample::Counts(counts) => Sensed::Counts(counts),
            };
            let ages = [reading.age_ticks; N];
            let readings = Readings {
                sensed,
                torque: [0.0; N],
                age_ticks: ages,
                faults: [JointFaults::NONE; N],
                errors: [0; N],
                on: [true; N],
                zero_lost: false,
            };
            session.sense(Some(&readings), &Lines::NONE);
            match session.tick(&meter) {
                Drives::Drive(torque) => world.plant.drive(&torque.map(f64::from)).unwrap(),
                Drives::Safe(_) | Drives::Enable(_) | Drives::Preload(_) => world.plant.brake(),
            }
            answers.extend(std::iter::from_fn(|| session.say()).map(Report::frame));
        }
        for frame in answers {
            send(&mut port, &mut channel, &frame);
        }
        std::thread::sleep(Duration::from_secs_f64(scene.period()));
    }
}

fn send(port: &mut TTYPort, channel: &mut BoardChannel, frame: &Frame) {
    // A host that has left receives nothing.
    channel.send(frame, &mut |bytes| port.write_all(bytes).unwrap_or_default());
}
