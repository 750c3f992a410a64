//! The client with the real firmware in the real emulator.
#![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

use super::{Chip, ChipError, Emulator, Timeouts, build_firmware};
use dynamics_core::control::Fault;
use dynamics_core::{Command, Measurement, Reference, Sensed};
use link::{Frame, Hello, Pacing, Refusal};
use robot_compiler::SceneFile;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

fn scene() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/planar2r_swing.toml")
}

fn hello() -> Hello {
    let file = SceneFile::load(&scene()).unwrap();
    let model = file.robot.model::<2>().unwrap();
    crate::chip::hello(&file, &model, Pacing::LockStep)
}

fn emulator() -> Emulator {
    let elf = build_firmware(&scene()).unwrap();
    Emulator::start(Path::new("qemu-system-arm"), &elf, Timeouts::default()).unwrap()
}

fn chip() -> Chip {
    Chip::over(emulator(), hello()).unwrap()
}

fn still() -> (Reference<f32, 2>, Measurement<f32, 2>) {
    let sensed = Sensed::State { q: [0.1, 0.2], qd: [0.0; 2] };
    (Reference { q: [0.1, 0.2], qd: [0.0; 2], qdd: [0.0; 2] }, Measurement { sensed, age_ticks: 0 })
}

fn tick(chip: &mut Chip) -> Result<super::ChipReply<2>, ChipError> {
    let (reference, measurement) = still();
    chip.tick(&reference, &measurement)
}

#[test]
fn a_program_for_another_robot_is_refused_with_both_hashes() {
    let other = Hello { robot: 0xbad, ..hello() };
    let text = Chip::over(emulator(), other).unwrap_err().to_string();
    assert!(text.contains(&format!("{:016x}", hello().robot)) && text.contains("0000000000000bad"), "{text}");
}

#[test]
fn equal_ticks_cost_equal_instructions_and_the_link_costs_none_of_them() {
    let mut chip = chip();
    let first = tick(&mut chip).unwrap().instructions;
    let counts: Vec<_> = (0..20).map(|_| tick(&mut chip).unwrap().instructions.unwrap()).collect();
    // The first tick has no earlier torque that limits its rate, so its count differs from the others.
    assert!(first.is_some());
    assert!(counts.iter().all(|&count| count == counts[0]), "{counts:?}");
}

#[test]
fn a_damaged_packet_to_the_chip_is_refused_by_name() {
    let mut chip = chip();
    tick(&mut chip).unwrap();
    let measurement = Frame::Measurement(link::Measurement::new(9, &still().1));
    let mut packet = chip.channel.encode(&measurement).unwrap();
    packet[6] ^= 2;
    chip.emulator.write(&packet).unwrap();
    let answer = chip.receive("a refusal").unwrap();
    assert_eq!(answer, Frame::Refusal(Refusal::Unauthentic { count: 1 }));
    // A packet number is now missing, so the chip rejects the next packet.
    let text = tick(&mut chip).unwrap_err().to_string();
    assert!(text.contains("1 packets to the chip were lost"), "{text}");
}

#[test]
fn a_packet_that_never_arrives_is_noticed_with_the_next() {
    let mut chip = chip();
    tick(&mut chip).unwrap();
    chip.channel.encode(&Frame::Refusal(Refusal::NoHello)).unwrap();
    let error = tick(&mut chip).unwrap_err();
    assert!(matches!(error, ChipError::Refused(Refusal::Lost { missed: 1 })), "{error}");
}

#[test]
fn a_killed_emulator_is_dead_within_a_second() {
    let mut chip = chip();
    tick(&mut chip).unwrap();
    chip.emulator.process.end();
    let begun = Instant::now();
    let error = tick(&mut chip).unwrap_err();
    assert!(matches!(error, ChipError::Dead { .. }), "{error}");
    assert!(begun.elapsed() < Duration::from_secs(1));
}

#[test]
fn an_emulator_that_stands_still_is_silent_within_its_time() {
    let mut chip = chip();
    chip.emulator.set_answer_timeout(Duration::from_millis(200)).unwrap();
    // Half a packet: the chip waits for the rest, and the host for an answer.
    chip.emulator.write(&[5, 1, 2]).unwrap();
    let begun = Instant::now();
    let error = chip.receive("an answer").unwrap_err();
    assert!(matches!(error, ChipError::Silent { .. }), "{error}");
    assert!(begun.elapsed() < Duration::from_secs(2));
}

#[test]
fn the_emulator_ends_with_the_chip() {
    let chip = chip();
    let process = chip.emulator.process();
    drop(chip);
    assert!(!Path::new(&format!("/proc/{process}")).exists());
}

#[test]
fn the_timer_paces_ticks_by_itself_and_brakes_when_measurements_stop() {
    let mut chip = chip();
    let age_max = {
        let file = SceneFile::load(&scene()).unwrap();
        file.control.age_max
    };
    let (reference, measurement) = still();
    chip.start_timer(hello(), &reference, &measurement).unwrap();
    for expected in 0..=age_max {
        let (tick, reply) = chip.next_timed::<2>().unwrap();
        assert_eq!(tick, expected);
        assert!(matches!(reply.command, Command::Drive { .. }), "tick {tick}: {reply:?}");
    }
    let (tick, reply) = chip.next_timed::<2>().unwrap();
    assert_eq!((tick, reply.command), (age_max + 1, Command::Brake(Fault::StaleMeasurement)));
}
