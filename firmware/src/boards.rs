//! The boards: the only files that use the chip's registers.

// For each board: its module, and its type as this program's board.
#[cfg(feature = "f405-can")]
pub mod f405_can;
#[cfg(feature = "f405-can")]
pub use f405_can::F405Can as ThisBoard;
#[cfg(feature = "f405-pwm")]
pub mod f405_pwm;
#[cfg(feature = "f405-pwm")]
pub use f405_pwm::F405Pwm as ThisBoard;
#[cfg(feature = "g474-fdcan")]
pub mod g474_fdcan;
#[cfg(feature = "g474-fdcan")]
pub use g474_fdcan::G474Fdcan as ThisBoard;
#[cfg(feature = "netduinoplus2")]
pub mod netduinoplus2;
#[cfg(feature = "netduinoplus2")]
pub use netduinoplus2::NetduinoPlus2 as ThisBoard;
#[cfg(feature = "odrive-v3")]
pub mod odrive_v3;
#[cfg(feature = "odrive-v3")]
pub use odrive_v3::OdriveV3 as ThisBoard;

// Modules that several boards share.
#[cfg(all(feature = "netduinoplus2", not(feature = "dma")))]
mod byte_link;
#[cfg(feature = "f405-can")]
mod can_bus;
#[cfg(any(feature = "f405-can", feature = "g474-fdcan"))]
mod can_drives;
#[cfg(any(feature = "f405-can", feature = "g474-fdcan"))]
mod can_frame;
#[cfg(not(feature = "netduinoplus2"))]
mod cortex;
#[cfg(feature = "g474-fdcan")]
mod dma_channels;
#[cfg(all(feature = "f405", not(feature = "netduinoplus2")))]
mod dma_link;
#[cfg(all(feature = "netduinoplus2", feature = "dma"))]
mod dma_stand_in;
#[cfg(all(feature = "f405", not(feature = "netduinoplus2")))]
mod f405;
#[cfg(feature = "g474-fdcan")]
mod fdcan_bus;
#[cfg(feature = "g474-fdcan")]
mod g474;

#[cfg(feature = "g474-fdcan")]
pub use g474::pac;
#[cfg(feature = "f405")]
pub use stm32f4xx_hal::pac;

/// All peripherals of the chip, before they are split among owners.
pub struct Chip {
    /// Peripherals of the microcontroller.
    pub device: pac::Peripherals,
    /// Peripherals of the Cortex-M core.
    pub core: cortex_m::Peripherals,
}

impl Chip {
    /// True if the floating-point unit rounds as the desk does, here and in interrupts: to nearest, subnormal numbers kept, NaN handed on (RMode, FZ,
    /// DN and AHP of FPSCR and FPDSCR are 0). So it is after a reset; a boot loader or an operating system may have changed it.
    #[must_use]
    pub fn rounds_as_the_desk(&self) -> bool {
        const MODES: u32 = 0b1_1111 << 22;
        (cortex_m::register::fpscr::read().bits() | self.core.FPU.fpdscr.read()) & MODES == 0
    }
}
