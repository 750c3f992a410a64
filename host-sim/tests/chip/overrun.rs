//! A chip that is too slow for its own timer reports it and brakes. A chip that is fast enough keeps driving.

use board::chip::{Chip, ChipReply, build_firmware, hello};
use dynamics_core::{Command, Fault, Measurement, Reference, Sensed};
use link::Pacing;
use robot_compiler::SceneFile;
use std::path::Path;

const N: usize = 6;

/// Number of examined answers at the timer's pace; they may all refer to a measurement of the same age.
const ANSWERS: usize = 20;

/// Duration of a tick on the emulated chip at one instruction per nanosecond: longer than 10 us, shorter than 20. Most
/// of it is libm's sine and cosine, which use double precision; the chip has no hardware for it.
const TICK_NS: std::ops::Range<u32> = 11_000..18_000;

/// First answers of the chip at the pace of its own timer.
fn in_the_timers_pace(rate: u32) -> Vec<(u32, ChipReply<N>)> {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("overrun_{rate}.toml"));
    let text = format!(
        "name = \"overrun\"\nrobot = \"{}/../robots/puma560.toml\"\n\
         [control]\nrate = {rate}.0\ntrig = \"libm\"\nage_max = {ANSWERS}\n\
         [motion]\nkind = \"hold\"\nq = [0.1, 0.9, -1.6, 0.2, 0.5, 0.3]\nduration = 0.01\n",
        env!("CARGO_MANIFEST_DIR"),
    );
    std::fs::write(&path, text).unwrap();
    let scene = SceneFile::load(&path).unwrap();
    let model = scene.robot.model::<N>().unwrap();
    let hello = hello(&scene, &model, Pacing::LockStep);
    let mut chip = Chip::start(&build_firmware(&path).unwrap(), hello).unwrap();
    let q = [0.1, 0.9, -1.6, 0.2, 0.5, 0.3];
    let reference = Reference { q, qd: [0.0; N], qdd: [0.0; N] };
    let measurement = Measurement { sensed: Sensed::State { q, qd: [0.0; N] }, age_ticks: 0 };

    // In lock step there is no timer: the same tick is no fault, whatever its duration.
    for _ in 0..3 {
        let reply = chip.tick(&reference, &measurement).unwrap();
        assert!(matches!(reply.command, Command::Drive { .. }), "{reply:?}");
        let nanoseconds = reply.instructions.unwrap();
        assert!(TICK_NS.contains(&nanoseconds), "{nanoseconds} ns, expected {TICK_NS:?}");
    }
    chip.start_timer(hello, &reference, &measurement).unwrap();
    (0..ANSWERS).map(|_| chip.next_timed().unwrap()).collect()
}

#[test]
fn a_tick_that_is_longer_than_the_timers_period_brakes_with_fault_6_and_stays_braked() {
    let answers = in_the_timers_pace(100_000);
    // The first tick drives, and at its end the firmware detects that it took too long. The next tick is due at that moment, so its answer (the
    // fault) may replace the first one.
    let faults = &answers[usize::from(answers[0].0 == 0)..];
    assert_eq!(faults[0].0, 1);
    assert!(faults.iter().all(|(_, reply)| reply.command == Command::Brake(Fault::Overrun)), "{faults:?}");
    assert_eq!(Fault::Overrun.code(), 6);
}

#[test]
fn the_same_tick_in_twice_the_period_is_no_fault() {
    let answers = in_the_timers_pace(50_000);
    let driving = |reply: &ChipReply<N>| matches!(reply.command, Command::Drive { .. });
    assert!(answers.iter().all(|(_, reply)| driving(reply)), "{answers:?}");
}
