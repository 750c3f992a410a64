//! A processor fault turns the drives off and ends the program: after an undefined instruction, and after a stack overflow. The emulator runs the
//! real program with the first instructions of its tick replaced.

use board::chip::{Chip, ChipError, build_firmware, hello};
use dynamics_core::{Measurement, Reference, Sensed};
use link::Pacing;
use object::{Object as _, ObjectSection as _, ObjectSymbol as _};
use robot_compiler::SceneFile;
use std::path::{Path, PathBuf};

/// The firmware of a scene with the first halfwords of the control tick replaced by these.
fn sabotaged(elf: &Path, name: &str, halfwords: &[u16]) -> PathBuf {
    let mut bytes = std::fs::read(elf).unwrap();
    let at = {
        let file = object::File::parse(bytes.as_slice()).unwrap();
        let tick = file.symbols().find(|symbol| symbol.name() == Ok("TIM3")).unwrap();
        // The lowest bit marks Thumb code.
        let address = tick.address() & !1;
        let holds = |s: &object::Section<'_, '_>| s.address() <= address && address < s.address() + s.size();
        let section = file.sections().find(holds).unwrap();
        usize::try_from(section.file_range().unwrap().0 + address - section.address()).unwrap()
    };
    for (i, halfword) in halfwords.iter().enumerate() {
        bytes[at + 2 * i..][..2].copy_from_slice(&halfword.to_le_bytes());
    }
    let copy = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&copy, bytes).unwrap();
    copy
}

/// Runs the chip's first tick.
fn first_tick(name: &str, halfwords: &[u16]) -> Result<(), ChipError> {
    let scene = SceneFile::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/planar2r_swing.toml")).unwrap();
    let model = scene.robot.model::<2>().unwrap();
    let elf = sabotaged(&build_firmware(&scene.path).unwrap(), name, halfwords);
    let mut chip = Chip::start(&elf, hello(&scene, &model, Pacing::LockStep)).unwrap();
    let sensed = Sensed::State { q: [0.1, 0.2], qd: [0.0; 2] };
    let reference = Reference { q: [0.1, 0.2], qd: [0.0; 2], qdd: [0.0; 2] };
    chip.tick(&reference, &Measurement { sensed, age_ticks: 0 }).map(|_| ())
}

/// True if the program ended the emulator itself. A processor that locks up would end it by a signal.
fn ended_by_itself(result: Result<(), ChipError>) -> bool {
    match result {
        Err(ChipError::Dead { status, .. }) => status == "exit status: 1",
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_same_program_without_a_fault_answers() {
    first_tick("faults_none.elf", &[]).unwrap();
}

#[test]
fn an_instruction_that_is_none_turns_the_drives_off_and_ends() {
    // udf #0
    assert!(ended_by_itself(first_tick("faults_undefined.elf", &[0xde00])));
}

#[test]
fn a_stack_that_runs_over_turns_the_drives_off_and_ends() {
    // 1: push {r0-r7}; b 1b
    assert!(ended_by_itself(first_tick("faults_stack.elf", &[0xb4ff, 0xe7fd])));
}
