//! A floating-point mode that is not the desk's, left behind by a boot loader: the firmware does not start.

use board::chip::build_firmware;
use object::{Object as _, ObjectSymbol as _};
use std::path::Path;
use std::process::{Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Address of the boot loader, in RAM that the firmware leaves alone at its start.
const LOADER: u32 = 0x2001_0000;

/// A boot loader: it switches the floating-point unit on, writes a word to FPSCR and one to FPDSCR, and jumps to the firmware.
fn loader(fpscr: u32, fpdscr: u32, reset: u32) -> Vec<u8> {
    // Each `ldr r, [pc, #n]` reads a word below the code.
    let code: [u16; 18] = [
        0x4808, // ldr r0, [pc, #32]: CPACR
        0x4909, // ldr r1, [pc, #36]: full access
        0x6001, // str r1, [r0]
        0xf3bf, 0x8f4f, // dsb
        0xf3bf, 0x8f6f, // isb
        0x4807, // ldr r0, [pc, #28]: FPDSCR
        0x4907, // ldr r1, [pc, #28]: its value
        0x6001, // str r1, [r0]
        0x4807, // ldr r0, [pc, #28]: FPSCR's value
        0xeee1, 0x0a10, // vmsr fpscr, r0
        0x4807, // ldr r0, [pc, #28]: the firmware's start
        0x4700, // bx r0
        0xbf00, 0xbf00, 0xbf00, // nop
    ];
    let words = [0xe000_ed88, 0x00f0_0000, 0xe000_ef3c, fpdscr, fpscr, reset];
    let code = code.iter().flat_map(|half| half.to_le_bytes());
    code.chain(words.iter().flat_map(|word: &u32| word.to_le_bytes())).collect()
}

/// The firmware after this boot loader: how it ended, or `None` if it runs.
fn started(fpscr: u32, fpdscr: u32) -> Option<ExitStatus> {
    let elf = build_firmware(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/planar2r_swing.toml")).unwrap();
    let bytes = std::fs::read(&elf).unwrap();
    let program = object::File::parse(&*bytes).unwrap();
    let reset = program.symbol_by_name("Reset").unwrap().address() as u32 | 1;
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("loader_{fpscr:x}_{fpdscr:x}.bin"));
    std::fs::write(&file, loader(fpscr, fpdscr, reset)).unwrap();
    let mut child = Command::new("qemu-system-arm")
        .args(["-M", "netduinoplus2", "-icount", "shift=0", "-display", "none", "-monitor", "none", "-serial", "null"])
        .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
        .arg(&elf)
        .args(["-device", &format!("loader,file={},addr={LOADER:#x},force-raw=on", file.display())])
        .args(["-device", &format!("loader,addr={:#x},cpu-num=0", LOADER | 1)])
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let end = Instant::now() + Duration::from_secs(3);
    while Instant::now() < end {
        if let Some(status) = child.try_wait().unwrap() {
            return Some(status);
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    None
}

#[test]
fn the_firmware_starts_only_in_the_desk_s_floating_point_mode() {
    assert_eq!(started(0, 0), None, "the boot loader itself is no reason to stop");
    // Condition and exception flags are results, and no mode.
    assert_eq!(started(0xf000_009f, 0), None);
    for mode in [22, 23, 24, 25, 26] {
        assert!(started(1 << mode, 0).is_some_and(|status| !status.success()), "FPSCR bit {mode}");
    }
    // In interrupts FPDSCR decides.
    assert!(started(0, 1 << 24).is_some_and(|status| !status.success()));
}
