//! The boards: the only files that name the chip's registers.

#[cfg(feature = "netduinoplus2")]
pub mod netduinoplus2;
#[cfg(feature = "odrive-v3")]
pub mod odrive_v3;

pub use stm32f4xx_hal::pac;

/// All that the chip has, before anyone owns a part of it.
pub struct Chip {
    /// What the maker put around the core.
    pub device: pac::Peripherals,
    /// What belongs to the core.
    #[allow(dead_code, reason = "not every board needs it")]
    pub core: cortex_m::Peripherals,
}
