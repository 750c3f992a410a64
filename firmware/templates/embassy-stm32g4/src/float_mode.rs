//! The floating-point mode, in which the torques are those of the tests on your computer.

/// True if the floating-point unit rounds to nearest, keeps subnormal numbers, and passes NaN on, here and in interrupts: RMode, FZ, DN and AHP of FPSCR
/// and FPDSCR are 0. They are after a reset; a boot loader may have changed them.
pub fn is_as_tested(core: &cortex_m::Peripherals) -> bool {
    const MODES: u32 = 0b1_1111 << 22;
    (cortex_m::register::fpscr::read().bits() | core.FPU.fpdscr.read()) & MODES == 0
}
