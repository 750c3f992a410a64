//! Constant cost of a tick: the same number of instructions in 10,000 states of the arm, and the same bits as on the desk in each.
//!
//! The work is split into four tests of 2,500 ticks, because most of a tick's time is spent on the bytes of the emulated link. All four compare their
//! count with the same constant.

use crate::pinned::assert_pinned;
use board::chip::{Chip, build_firmware, hello};
use dynamics_core::{Command, Measurement, Reference, Sensed};
use link::Pacing;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};
use robot_compiler::SceneFile;
use sim::run::simulate::{self, Desk};
use std::path::Path;

/// Number of joints.
const N: usize = 6;

/// Number of states in each of the four tests.
const STATES: u32 = 2_500;

/// The scene's controller on the desk, and its firmware in the emulator.
struct Pair {
    desk: Desk<f32, N>,
    chip: Chip,
}

impl Pair {
    fn new() -> Self {
        let file = SceneFile::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/puma560_pick.toml")).unwrap();
        let model = file.robot.model::<N>().unwrap();
        let hello = hello(&file, &model, Pacing::LockStep);
        Self {
            desk: simulate::desk(&file, &model),
            chip: Chip::start(&build_firmware(&file.path).unwrap(), hello).unwrap(),
        }
    }

    /// Runs one tick on both and compares the bits. Returns true if a limit acted, and the chip's instructions.
    fn tick(&mut self, reference: &Reference<f32, N>, counts: [i32; N]) -> (bool, u32) {
        let measurement = Measurement { sensed: Sensed::Counts(counts), age_ticks: 0 };
        let expected = self.desk.tick(reference, &measurement);
        let reply = self.chip.tick(reference, &measurement).unwrap();
        let bits = |command: &Command<f32, N>| match command {
            Command::Drive { torque, limits } => (torque.map(f32::to_bits), limits.map(|l| l.bits())),
            Command::Brake(fault) => panic!("{fault}"),
        };
        assert_eq!(bits(&reply.command), bits(&expected), "{reply:?} and {expected:?}");
        (bits(&expected).1 != [0; N], reply.instructions.unwrap())
    }

    fn counts(&self, q: [f64; N]) -> [i32; N] {
        let encoder = self.desk.config().encoder;
        std::array::from_fn(|i| (q[i] / f64::from(encoder[i].per_count)).round() as i32)
    }
}

/// Random number, uniform in `[-width, width)`.
fn within(rng: &mut ChaCha8Rng, width: f64) -> f64 {
    width * (f64::from(rng.next_u32()) / f64::from(1_u32 << 31) - 1.0)
}

/// Swings every joint from the middle of its range to near one end and back, each at a different speed, with a random reference near it: 2,500
/// different states. Returns the least and the greatest number of instructions of a tick.
fn swing(seed: u64) -> (u32, u32) {
    let mut pair = Pair::new();
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let limits = pair.desk.config().limits;
    let middle = limits.map(|l| f64::from(l.position.0 + l.position.1) / 2.0);
    // Each joint moves to one side, up to 95 % of the distance to its limit, at half to four fifths of its greatest speed.
    let reach: [f64; N] = std::array::from_fn(|i| {
        let side = if rng.next_u32() % 2 == 0 { 1.0 } else { -1.0 };
        side * 0.95 * f64::from(limits[i].position.1 - limits[i].position.0) / 2.0
    });
    let omega: [f64; N] = std::array::from_fn(|i| {
        let share = 0.65 + within(&mut rng, 0.15);
        2.0 * share * f64::from(limits[i].velocity) / reach[i].abs()
    });
    let mut range = (u32::MAX, 0);
    for tick in 0..STATES {
        let t = f64::from(tick) * 1e-3;
        let q: [f64; N] = std::array::from_fn(|i| middle[i] + reach[i] * (1.0 - (omega[i] * t).cos()) / 2.0);
        let qd: [f64; N] = std::array::from_fn(|i| reach[i] * omega[i] * (omega[i] * t).sin() / 2.0);
        let qdd: [f64; N] = std::array::from_fn(|i| reach[i] * omega[i] * omega[i] * (omega[i] * t).cos() / 2.0);
        let mut about = |of: [f64; N], width: f64| of.map(|x| (x + within(&mut rng, width)) as f32);
        let reference = Reference { q: about(q, 2e-3), qd: about(qd, 0.05), qdd: about(qdd, 1.0) };
        let (limited, count) = pair.tick(&reference, pair.counts(q));
        assert!(!limited, "state {tick}: a limit acts");
        range = (range.0.min(count), range.1.max(count));
    }
    println!("{STATES} states: {} to {} instructions", range.0, range.1);
    range
}

/// Instructions of a tick at rest in the middle of every joint's range: the first tick after a hello, and the second.
fn at_rest() -> [u32; 2] {
    let mut pair = Pair::new();
    let middle = pair.desk.config().limits.map(|l| (l.position.0 + l.position.1) / 2.0);
    let counts = pair.counts(middle.map(f64::from));
    [(); 2].map(|()| pair.tick(&Reference::at_rest(middle), counts).1)
}

fn assert_all_alike(seed: u64) {
    let [first, second] = at_rest();
    // Counts to angles, observer, guard, sine and cosine, kernel, law, friction, limits.
    assert_pinned("puma560_pick", [u64::from(first); 2]);
    assert_eq!(second, first, "the first reading starts the observer, at no other cost");
    assert_eq!(swing(seed), (first, first));
}

#[test]
fn every_tick_of_10_000_takes_the_same_instructions_first_quarter() {
    assert_all_alike(1);
}

#[test]
fn every_tick_of_10_000_takes_the_same_instructions_second_quarter() {
    assert_all_alike(2);
}

#[test]
fn every_tick_of_10_000_takes_the_same_instructions_third_quarter() {
    assert_all_alike(3);
}

#[test]
fn every_tick_of_10_000_takes_the_same_instructions_fourth_quarter() {
    assert_all_alike(4);
}

#[test]
fn only_a_limit_that_acts_takes_longer() {
    let mut pair = Pair::new();
    let middle = pair.desk.config().limits.map(|l| (l.position.0 + l.position.1) / 2.0);
    let counts = pair.counts(middle.map(f64::from));
    let still = Reference::at_rest(middle);
    let (_, plain) = pair.tick(&still, counts);
    let mut strong = still;
    strong.qdd[3] = 500.0;
    let mut fast = still;
    fast.qd[3] = 1.1 * pair.desk.config().limits[3].velocity;
    // A reference beyond every position limit, moving back too fast.
    let everything = Reference { q: middle.map(|q| q + 10.0), qd: [-10.0; N], qdd: [0.0; N] };
    for (what, reference, longest) in [
        ("one joint's torque", strong, 60),
        ("one joint's velocity and torque", fast, 900),
        ("all positions, velocities and torques", everything, 900),
    ] {
        let (limited, count) = pair.tick(&reference, counts);
        println!("{what}: {count} instructions, {} more", count - plain);
        assert!(limited && count > plain && count < plain + longest, "{what}: {count} after {plain}");
        // The next tick is the same as before.
        assert_eq!(pair.tick(&still, counts), (false, plain), "{what}");
    }
}
