//! Cortex-M: the vector table, the floating-point unit, SysTick as the clock.

use core::arch::{asm, global_asm};

// The stack pointer and the reset vector; any other exception stops in a loop.
global_asm!(
    ".section .start, \"a\"",
    ".word _stack_start",
    ".word start",
    ".rept 14",
    ".word hang",
    ".endr",
    ".section .text.start, \"ax\"",
    ".global start",
    ".type start, %function",
    ".thumb_func",
    "start:",
    // CPACR: full access to the coprocessors 10 and 11. Without the unit the write has no effect.
    "ldr r0, =0xe000ed88",
    "ldr r1, =0x00f00000",
    "str r1, [r0]",
    "dsb",
    "isb",
    "bl {prepare}",
    "bl {main}",
    ".ltorg",
    ".type hang, %function",
    ".thumb_func",
    "hang:",
    "b hang",
    prepare = sym prepare,
    main = sym super::main,
);

const CONTROL: *mut u32 = 0xe000_e010 as *mut u32;
const RELOAD: *mut u32 = 0xe000_e014 as *mut u32;
const VALUE: *mut u32 = 0xe000_e018 as *mut u32;

/// Starts the clock.
extern "C" fn prepare() {
    // SAFETY: registers of SysTick, which every Cortex-M has at these addresses.
    unsafe {
        RELOAD.write_volatile(0x00ff_ffff);
        VALUE.write_volatile(0);
        // Enabled, from the processor's clock, without an interrupt.
        CONTROL.write_volatile(0b101);
    }
    #[cfg(feature = "flush-to-zero")]
    // SAFETY: sets FPSCR.FZ, which changes results and no memory.
    unsafe {
        asm!("vmsr fpscr, {}", in(reg) 1_u32 << 24);
    }
}

/// Time in units of SysTick, of which 24 bits count; no measured stretch is that long.
pub(super) fn now() -> u64 {
    static mut BEFORE: (u32, u64) = (0, 0);
    // SAFETY: a register of SysTick; one thread, and no interrupt, uses the variable.
    unsafe {
        let value = 0x00ff_ffff - VALUE.read_volatile();
        let (last, sum) = BEFORE;
        let sum = sum + u64::from(value.wrapping_sub(last) & 0x00ff_ffff);
        BEFORE = (value, sum);
        sum
    }
}

/// Two instructions in each round.
pub(super) fn calibrate(rounds: u64) {
    // SAFETY: a loop on one register.
    unsafe {
        asm!("2:", "subs {0}, #1", "bne 2b", inout(reg) rounds as u32 => _);
    }
}

/// A semihosting operation.
pub(super) fn call(operation: usize, argument: usize) {
    // SAFETY: the emulator reads the memory of the argument.
    unsafe {
        asm!("bkpt 0xab", inout("r0") operation => _, in("r1") argument);
    }
}
