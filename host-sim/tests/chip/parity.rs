//! The parity gate: the emulated chip and the desk give identical bits.

use board::chip::{Chip, build_firmware, hello};
use dynamics_core::trig::Polynomial;
use dynamics_core::{Command, Controller, Dynamics, Measurement, Reference, Sensed};
use link::Pacing;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};
use robot_compiler::SceneFile;
use std::path::{Path, PathBuf};

/// Joints of the arm in [`scene`].
const N: usize = 6;

/// Least number of states that the documentation promises.
const STATES: usize = 2_000;

fn scene() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/puma560_pick.toml")
}

/// Random number, uniform in the range.
fn uniform(rng: &mut ChaCha8Rng, (lo, hi): (f32, f32)) -> f32 {
    lo + (hi - lo) * (rng.next_u32() as f32 / u32::MAX as f32)
}

/// All bits of a command.
fn bits(command: &Command<f32, N>) -> ([u32; N], [u8; N], Option<u8>) {
    match command {
        Command::Drive { torque, limits } => (torque.map(f32::to_bits), limits.map(|l| l.bits()), None),
        Command::Brake(fault) => ([0; N], [0; N], Some(fault.code())),
    }
}

#[test]
fn chip_and_desk_give_the_same_bits_over_random_states() {
    let file = SceneFile::load(&scene()).unwrap();
    let model = file.robot.model::<N>().unwrap();
    let dynamics = Dynamics::new(model.cast(), file.scene(&model).cast());
    let config = file.controller_config(&model).cast();
    let mut desk = Controller::<f32, N, _>::new(config, dynamics, Polynomial);
    let hello = hello(&file, &model, Pacing::LockStep);
    let mut chip = Chip::start(&build_firmware(&scene()).unwrap(), hello).unwrap();

    let mut rng = ChaCha8Rng::seed_from_u64(20_405);
    let limits = desk.config().limits;
    let (mut plain, mut limited) = ((u32::MAX, 0), (u32::MAX, 0));
    let mut driven = 0;
    for state in 0..STATES {
        let mut near = |width: f32, of: [f32; N]| of.map(|x| x + uniform(&mut rng, (-width, width)));
        let q = limits.map(|l| l.position).map(|(lo, hi)| (lo + hi) / 2.0);
        let q = near(1.0, q);
        let qd = near(0.9, [0.0; N]);
        let reference = Reference { q: near(0.05, q), qd: near(0.1, qd), qdd: near(3.0, [0.0; N]) };
        let measurement = Measurement { sensed: Sensed::State { q, qd }, age_ticks: 0 };
        let expected = desk.tick(&reference, &measurement);
        let reply = chip.tick(&reference, &measurement).unwrap();
        assert_eq!(bits(&reply.command), bits(&expected), "state {state}: {:?} and {expected:?}", reply.command);
        driven += usize::from(matches!(expected, Command::Drive { .. }));
        let count = reply.instructions.unwrap();
        let counts = if bits(&expected).1 == [0; N] { &mut plain } else { &mut limited };
        *counts = (counts.0.min(count), counts.1.max(count));
    }
    assert_eq!(driven, STATES, "a controller that brakes compares nothing");
    println!("{STATES} states, identical bits; instructions in a tick: {plain:?}, where a limit acts {limited:?}");
    assert_eq!(plain.0, plain.1, "what a tick costs depends on no state");
    assert!(limited.0 > plain.1 && limited.1 < plain.1 + 200, "{limited:?} where a limit acts");
}
