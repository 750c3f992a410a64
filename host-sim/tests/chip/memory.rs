//! A kernel that the scene places in static RAM is linked there, runs there, and computes the same bits.

use board::chip::{Chip, build_firmware, hello};
use dynamics_core::{Command, Measurement, Reference, Sensed};
use link::Pacing;
use object::{Object as _, ObjectSymbol as _};
use robot_compiler::SceneFile;
use robot_compiler::scene::KernelMemory;
use std::path::{Path, PathBuf};

const N: usize = 6;

/// Static RAM of the chip.
const SRAM: std::ops::Range<u64> = 0x2000_0000..0x2002_0000;

/// The arm's scene with its kernel in the given memory.
fn scene(memory: &str) -> PathBuf {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let text = std::fs::read_to_string(top.join("scenes/puma560_pick.toml")).unwrap();
    let robots = top.join("robots").canonicalize().unwrap();
    let text = text
        .replace("../robots", robots.to_str().unwrap())
        .replace("[control]\n", &format!("[control]\nkernel_memory = \"{memory}\"\n"));
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("kernel_in_{memory}.toml"));
    std::fs::write(&path, text).unwrap();
    path
}

/// Addresses and sizes of the inverse dynamics that are not inlined.
fn kernels(elf: &Path) -> Vec<(u64, u64)> {
    let bytes = std::fs::read(elf).unwrap();
    let file = object::File::parse(&*bytes).unwrap();
    // The linker's veneers from flash to RAM have the name of their destination.
    let named = |symbol: &object::Symbol<'_, '_>| {
        symbol.name().is_ok_and(|name| name.contains("inverse_dynamics") && !name.contains("Thunk"))
    };
    // The lowest bit of a function's address marks Thumb code.
    file.symbols().filter(named).map(|s| (s.address() & !1, s.size())).collect()
}

/// Torque bits and instruction counts of some ticks.
fn run(path: &Path, elf: &Path) -> Vec<([u32; N], u32)> {
    let file = SceneFile::load(path).unwrap();
    let model = file.robot.model::<N>().unwrap();
    let hello = hello(&file, &model, Pacing::LockStep);
    let mut chip = Chip::start(elf, hello).unwrap();
    let mut tick = |k: u32| {
        let wave = |phase: f32| std::array::from_fn(|i| 0.5 * (k as f32 * 0.7 + i as f32 + phase).sin());
        let (q, qd) = (wave(0.0), wave(1.0));
        let reference = Reference { q, qd, qdd: wave(2.0) };
        let reply = chip.tick(&reference, &Measurement { sensed: Sensed::State { q, qd }, age_ticks: 0 }).unwrap();
        let Command::Drive { torque, .. } = reply.command else { panic!("{reply:?}") };
        (torque.map(f32::to_bits), reply.instructions.unwrap())
    };
    (0..50).map(&mut tick).collect()
}

#[test]
fn a_kernel_placed_in_sram_is_there_and_gives_the_bits_of_the_one_in_flash() {
    let paths = ["flash", "sram"].map(scene);
    let files = paths.each_ref().map(|path| SceneFile::load(path).unwrap());
    assert_eq!(files.each_ref().map(|f| f.control.kernel_memory), [KernelMemory::Flash, KernelMemory::Sram]);
    let model = files[0].robot.model::<N>().unwrap();
    assert_eq!(files[0].hash(&model), files[1].hash(&model), "no bit depends on the memory");

    let [flash, sram] = paths.each_ref().map(|path| build_firmware(path).unwrap());
    assert!(kernels(&flash).iter().all(|(address, _)| !SRAM.contains(address)));
    let placed = kernels(&sram);
    println!("kernels in the firmware: {placed:x?}");
    let [(address, size)] = placed[..] else { panic!("one function of its own, found {placed:x?}") };
    assert!(SRAM.contains(&address) && size > 1_000, "{size} bytes at {address:#x}");

    let (in_flash, in_sram) = (run(&paths[0], &flash), run(&paths[1], &sram));
    assert!(in_flash.iter().zip(&in_sram).all(|(a, b)| a.0 == b.0));
    // Each kernel has the same number of instructions in every tick. A called kernel needs more than an inlined one, because its arguments and its
    // torque are passed in memory.
    let [(_, count), (_, called)] = [in_flash[0], in_sram[0]];
    assert!(in_flash.iter().all(|tick| tick.1 == count) && in_sram.iter().all(|tick| tick.1 == called));
    println!("{count} instructions in flash, {called} in SRAM");
    assert!((count + 40..count + 150).contains(&called));
}
