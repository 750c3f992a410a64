//! A processor fault turns the drives off and ends the program: after an undefined instruction, and after a stack overflow. So does code in RAM that
//! has changed. The emulator runs the real program with the first instructions of its tick replaced.

use board::chip::{Chip, ChipError, Emulator, Timeouts, build_firmware, hello};
use dynamics_core::{Measurement, Reference, Sensed};
use link::Pacing;
use object::{Object as _, ObjectSection as _, ObjectSymbol as _};
use robot_compiler::SceneFile;
use std::path::{Path, PathBuf};
use std::time::Duration;

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

/// A chip that waits for its first tick.
fn waiting(name: &str, halfwords: &[u16]) -> Chip {
    let scene = SceneFile::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/planar2r_swing.toml")).unwrap();
    let model = scene.robot.model::<2>().unwrap();
    let elf = sabotaged(&build_firmware(&scene.path).unwrap(), name, halfwords);
    let timeouts = Timeouts { connect: Duration::from_secs(30), answer: Duration::from_secs(5) };
    let emulator = Emulator::start("qemu-system-arm".as_ref(), &elf, timeouts).unwrap();
    Chip::over(emulator, hello(&scene, &model, Pacing::LockStep)).unwrap()
}

fn tick(chip: &mut Chip) -> Result<(), ChipError> {
    let sensed = Sensed::State { q: [0.1, 0.2], qd: [0.0; 2] };
    let reference = Reference { q: [0.1, 0.2], qd: [0.0; 2], qdd: [0.0; 2] };
    chip.tick(&reference, &Measurement { sensed, age_ticks: 0 }).map(|_| ())
}

/// Runs the chip's first tick.
fn first_tick(name: &str, halfwords: &[u16]) -> Result<(), ChipError> {
    tick(&mut waiting(name, halfwords))
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

#[test]
fn an_exception_that_no_task_handles_turns_the_drives_off_and_ends() {
    // ldr r0, [pc, #8]; movs r1, #1; lsls r1, r1, #31; str r1, [r0]; bx lr; nop; and the address of ICSR, whose highest bit sets the non-maskable
    // interrupt pending.
    let halfwords = [0x4802, 0x2101, 0x07c9, 0x6001, 0x4770, 0xbf00, 0xed04, 0xe000];
    assert!(ended_by_itself(first_tick("faults_unhandled.elf", &halfwords)));
}

/// Starts a tick with these instructions, and then sends up to so many bytes that are no packet, so that the lowest task runs for each. Returns how it
/// ends.
fn tick_and_bytes(name: &str, halfwords: &[u16], bytes: usize) -> Result<(), ChipError> {
    let mut chip = waiting(name, halfwords);
    // No answer comes from a tick that returns at once.
    let _no_answer = tick(&mut chip);
    for _ in 0..bytes {
        // A dead emulator takes none.
        if chip.write(&[0]).is_err() {
            break;
        }
        // The task takes all bytes that have come since its last run, so they come one by one.
        std::thread::sleep(Duration::from_millis(1));
    }
    chip.receive("no frame").map(|_| ())
}

#[test]
fn a_tick_that_overwrites_its_own_code_turns_the_drives_off_and_ends() {
    // mov r0, pc; str r0, [r0, #8]; bx lr. Without the memory protection unit the tick would go on.
    assert!(ended_by_itself(first_tick("faults_overwrites.elf", &[0x4678, 0x6080, 0x4770])));
}

#[test]
fn a_tick_that_overwrites_its_own_code_bit_by_bit_turns_the_drives_off_and_ends() {
    // mov r0, pc; ubfx r0, r0, #0, #20; lsls r0, r0, #5; orr r0, r0, #0x22000000; movs r1, #1; str r1, [r0, #64]; bx lr: the bit's own address.
    let halfwords = [0x4678, 0xf3c0, 0x0013, 0x0140, 0xf040, 0x5008, 0x2101, 0x6401, 0x4770];
    assert!(ended_by_itself(first_tick("faults_bits.elf", &halfwords)));
}

#[test]
fn a_memory_protection_unit_that_is_switched_off_turns_the_drives_off_and_ends() {
    // movw r1, #0xed94; movt r1, #0xe000; movs r2, #0; str r2, [r1]; dsb; bx lr. The lowest task runs after the tick.
    let halfwords = [0xf64e, 0x5194, 0xf2ce, 0x0100, 0x2200, 0x600a, 0xf3bf, 0x8f4f, 0x4770];
    assert!(ended_by_itself(tick_and_bytes("faults_unprotected.elf", &halfwords, 10)));
}

#[test]
fn a_region_of_the_memory_protection_unit_that_is_switched_off_turns_the_drives_off_and_ends() {
    // movw r1, #0xed98; movt r1, #0xe000; movs r2, #0; str r2, [r1]; str r2, [r1, #8]; dsb; bx lr. The lowest task compares a region per run.
    let halfwords = [0xf64e, 0x5198, 0xf2ce, 0x0100, 0x2200, 0x600a, 0x608a, 0xf3bf, 0x8f4f, 0x4770];
    assert!(ended_by_itself(tick_and_bytes("faults_region.elf", &halfwords, 1_000)));
}

#[test]
fn code_that_changes_in_ram_turns_the_drives_off_and_ends() {
    // cpsid f; mov r0, pc; str r0, [r0, #12]; cpsie f; bx lr: at the priority of a hard fault the memory protection unit is off, so the code changes as if
    // a bit had flipped by itself. On a busy machine bytes may come together: then more of them are needed.
    let changed = [0xb671, 0x4678, 0x60c0, 0xb661, 0x4770];
    assert!(ended_by_itself(tick_and_bytes("faults_changed.elf", &changed, 30_000)));
    // Without the store. Four words per run: 3,000 runs compare all code of this small arm.
    let unchanged = tick_and_bytes("faults_unchanged.elf", &[0xb671, 0x4678, 0xbf00, 0xb661, 0x4770], 3_000);
    assert!(!matches!(unchanged, Ok(()) | Err(ChipError::Dead { .. })), "{unchanged:?}");
}
