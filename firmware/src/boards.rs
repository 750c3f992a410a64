//! The boards: the only files that name the chip's registers.

#[cfg(all(feature = "netduinoplus2", not(feature = "dma")))]
mod byte_link;
#[cfg(feature = "f405-can")]
mod can_bus;
#[cfg(any(feature = "f405-can", feature = "g474-fdcan"))]
mod can_frame;
#[cfg(any(feature = "odrive-v3", feature = "f405-can", feature = "f405-pwm", feature = "g474-fdcan"))]
mod cortex;
#[cfg(feature = "g474-fdcan")]
mod dma_channels;
#[cfg(any(feature = "odrive-v3", feature = "f405-can", feature = "f405-pwm"))]
mod dma_link;
#[cfg(all(feature = "netduinoplus2", feature = "dma"))]
mod dma_stand_in;
#[cfg(any(feature = "odrive-v3", feature = "f405-can", feature = "f405-pwm"))]
mod f405;
#[cfg(feature = "f405-can")]
pub mod f405_can;
#[cfg(feature = "f405-pwm")]
pub mod f405_pwm;
#[cfg(feature = "g474-fdcan")]
mod fdcan_bus;
#[cfg(feature = "g474-fdcan")]
mod g474;
#[cfg(feature = "g474-fdcan")]
pub mod g474_fdcan;
#[cfg(feature = "netduinoplus2")]
pub mod netduinoplus2;
#[cfg(feature = "odrive-v3")]
pub mod odrive_v3;

#[cfg(feature = "g474-fdcan")]
pub use g474::pac;
#[cfg(feature = "f405")]
pub use stm32f4xx_hal::pac;

/// All peripherals of the chip, before they are split among owners.
pub struct Chip {
    /// Peripherals of the chip's maker.
    pub device: pac::Peripherals,
    /// Peripherals of the core.
    #[allow(dead_code, reason = "not every board needs it")]
    pub core: cortex_m::Peripherals,
}
