//! AArch64 without translation of addresses: stack, floating-point unit, the generic timer as the clock.

use core::arch::{asm, global_asm};

global_asm!(
    ".section .start, \"ax\"",
    ".global start",
    "start:",
    "ldr x0, =_stack_start",
    "mov sp, x0",
    // CPACR_EL1.FPEN: floating point does not trap.
    "mov x0, #(3 << 20)",
    "msr cpacr_el1, x0",
    "isb",
    "bl {main}",
    ".ltorg",
    main = sym super::main,
);

/// Time in units of the generic timer.
pub(super) fn now() -> u64 {
    let count: u64;
    // SAFETY: reads a counter.
    unsafe {
        asm!("isb", "mrs {}, cntvct_el0", out(reg) count);
    }
    count
}

/// Two instructions in each round.
pub(super) fn calibrate(rounds: u64) {
    // SAFETY: a loop on one register.
    unsafe {
        asm!("2:", "subs {0}, {0}, #1", "b.ne 2b", inout(reg) rounds => _);
    }
}

/// A semihosting operation.
pub(super) fn call(operation: usize, argument: usize) {
    // SAFETY: the emulator reads the memory of the argument.
    unsafe {
        asm!("hlt 0xf000", inout("x0") operation => _, in("x1") argument);
    }
}
