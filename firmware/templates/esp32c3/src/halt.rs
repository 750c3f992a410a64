//! The end of the program after a panic or an exception: drives off, brakes engaged, no interrupts. The watchdog then resets the chip, which starts
//! idle and not homed.

/// Sets the lines of the joints low, and stops.
fn halt() -> ! {
    // SAFETY: the program is over, so no interrupt has to be handled: bit 3 of `mstatus` is cleared.
    unsafe { core::arch::asm!("csrci mstatus, 8") }
    super::chip::lines_low();
    super::chip::stop()
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo) -> ! {
    halt()
}

/// Handles an exception, for example an access to an address that does not exist.
///
/// # Safety
/// Only the start-up code calls it.
#[unsafe(no_mangle)]
unsafe extern "C" fn ExceptionHandler(_: *const u8) -> ! {
    halt()
}
