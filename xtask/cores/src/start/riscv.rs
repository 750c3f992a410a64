//! RISC-V in machine mode: stack, floating-point unit, the cycle counter as the clock.

use core::arch::{asm, global_asm};

global_asm!(
    ".section .start, \"ax\"",
    ".global start",
    "start:",
    "la sp, _stack_start",
    // mstatus.FS: the floating-point unit is on. Without one the bits stay zero.
    "li t0, 0x2000",
    "csrs mstatus, t0",
    "call {main}",
    main = sym super::main,
);

/// Executed instructions: the emulator counts one in a cycle.
pub(super) fn now() -> u64 {
    let low: usize;
    // SAFETY: reads a counter.
    unsafe {
        asm!("csrr {}, mcycle", out(reg) low);
    }
    low as u64
}

/// Two instructions in each round.
pub(super) fn calibrate(rounds: u64) {
    // SAFETY: a loop on one register.
    unsafe {
        asm!("2:", "addi {0}, {0}, -1", "bnez {0}, 2b", inout(reg) rounds as usize => _);
    }
}

/// A semihosting operation: a break between two shifts that do nothing, without compressed instructions.
pub(super) fn call(operation: usize, argument: usize) {
    // SAFETY: the emulator reads the memory of the argument.
    unsafe {
        asm!(
            ".option push", ".option norvc", ".balign 16", "slli x0, x0, 0x1f", "ebreak", "srai x0, x0, 7", ".option pop",
            inout("a0") operation => _, in("a1") argument
        );
    }
}
