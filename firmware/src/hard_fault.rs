//! Handlers of a hard fault, and of every exception that no task handles: they switch the drives off first.
//!
//! A write to the tick's code in RAM ends here too (`tick_code.rs`). A stack overflow also ends here, because there is no memory below the stack (`memory.x`). The old stack may then be unusable, so the handler
//! resets the stack pointer. It also drops the float registers that the core would still store to the old stack (FPCCR.LSPACT, Arm DDI 0403).
//!
//! The other exceptions are the non-maskable interrupt, which reports errors of clock, flash and RAM, and interrupts of peripherals that nobody uses. The
//! start-up code would wait in them for ever, with the drives on.
#![allow(unsafe_code, reason = "a new stack is set by the machine's own instruction, and found by name")]

use crate::app::ThisBoard;
use firmware::board::Board;

core::arch::global_asm!(
    ".section .HardFault.newtau, \"ax\"",
    ".global HardFault",
    ".type HardFault, %function",
    ".thumb_func",
    "HardFault:",
    "ldr r0, =_stack_start",
    "msr MSP, r0",
    "ldr r1, =0xe000ef34",
    "ldr r2, [r1]",
    "bic r2, r2, #1",
    "str r2, [r1]",
    "dsb",
    "isb",
    "b newtau_hard_fault",
    ".ltorg",
    ".size HardFault, . - HardFault",
);

#[unsafe(no_mangle)]
extern "C" fn newtau_hard_fault() -> ! {
    <ThisBoard as Board<{ arm::N }>>::halt(|| {
        defmt::error!("hard fault: an address that is not there, a write to the tick's code, or a stack that ran over")
    })
}

/// The start-up code's name for the handler of all other exceptions.
#[allow(non_snake_case, reason = "found by this name")]
#[unsafe(no_mangle)]
extern "C" fn DefaultHandler() -> ! {
    <ThisBoard as Board<{ arm::N }>>::halt(|| {
        defmt::error!("an exception that no task handles: the non-maskable interrupt, or one of an unused peripheral")
    })
}
