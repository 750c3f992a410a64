//! Handler of a hard fault: it switches the drives off first.
//!
//! A stack overflow also ends here, because there is no memory below the stack (`memory.x`). The old stack may then be unusable, so the handler
//! resets the stack pointer.
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
    "b newtau_hard_fault",
    ".ltorg",
    ".size HardFault, . - HardFault",
);

#[unsafe(no_mangle)]
extern "C" fn newtau_hard_fault() -> ! {
    <ThisBoard as Board<{ arm::N }>>::halt(|| {
        defmt::error!("hard fault: an address that is not there, or a stack that ran over")
    })
}
