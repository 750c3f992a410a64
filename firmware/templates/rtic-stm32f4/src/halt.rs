//! The end of the program after a panic, a hard fault or an unexpected interrupt: drives off, brakes engaged, no interrupts. The watchdog then resets
//! the chip, which starts idle and not homed.

use cortex_m_rt::exception;

/// Sets the lines of the joints low, and stops.
pub extern "C" fn halt() -> ! {
    cortex_m::interrupt::disable();
    super::chip::lines_low();
    super::chip::stop()
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    halt()
}

/// Handles an interrupt that nothing handles, and the non-maskable interrupt.
///
/// # Safety
/// Only the processor calls it.
#[exception]
unsafe fn DefaultHandler(_: i16) -> ! {
    halt()
}

/// Handles a hard fault. After a stack overflow the stack cannot be used, so it starts again at its top.
///
/// # Safety
/// Only the processor calls it.
#[unsafe(no_mangle)]
#[unsafe(naked)]
#[unsafe(link_section = ".HardFault.template")]
unsafe extern "C" fn HardFault() -> ! {
    core::arch::naked_asm!("ldr r0, =_stack_start", "msr MSP, r0", "b {halt}", ".ltorg", halt = sym halt)
}
