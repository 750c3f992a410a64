//! Start-up, clock and output of a core without an operating system.

#[cfg_attr(target_arch = "arm", path = "cortex_m.rs")]
#[cfg_attr(any(target_arch = "riscv32", target_arch = "riscv64"), path = "riscv.rs")]
#[cfg_attr(target_arch = "aarch64", path = "aarch64.rs")]
mod core_specific;

use core::fmt::Write as _;
use core_specific::{calibrate, call, now};

/// Semihosting operations.
const WRITE_0: usize = 0x04;
const EXIT: usize = 0x18;

/// The emulator's output.
struct Output;

impl core::fmt::Write for Output {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        // The operation reads until a zero byte.
        let mut piece = [0_u8; 64];
        for part in text.as_bytes().chunks(63) {
            piece[..part.len()].copy_from_slice(part);
            piece[part.len()] = 0;
            call(WRITE_0, piece.as_ptr() as usize);
        }
        Ok(())
    }
}

/// Instructions of the loop that the clock is compared with: two in each round.
const CALIBRATION: u64 = 2_000_000;

/// Runs after the stack and the floating-point unit are there.
extern "C" fn main() -> ! {
    let start = now();
    calibrate(CALIBRATION / 2);
    let unit = now().wrapping_sub(start).max(1);
    // Without a floating-point unit an evaluation takes a hundred times as long.
    let repeats = if cfg!(feature = "soft") { 2 } else { 20 };
    let double = cfg!(feature = "double");
    cores::run(double, repeats, &mut now, &mut |row| {
        let instructions = (row.time * CALIBRATION).div_ceil(unit).div_ceil(1000);
        writeln!(Output, "row|{}|{}|{:016x}|{instructions}", row.scalar, row.what, row.hash).ok();
    });
    exit()
}

/// Ends the emulator.
fn exit() -> ! {
    // The reason "the application ended" is a number on a 32-bit core, and stands in a block with the exit code on a 64-bit one.
    const ENDED: usize = 0x20026;
    let block = [ENDED, 0];
    call(EXIT, if cfg!(target_pointer_width = "64") { block.as_ptr() as usize } else { ENDED });
    loop {
        core::hint::spin_loop();
    }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo) -> ! {
    writeln!(Output, "{info}").ok();
    exit()
}
