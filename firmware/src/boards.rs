//! The boards: the only files that name the chip's registers.

#[cfg(feature = "netduinoplus2")]
pub mod netduinoplus2;
#[cfg(feature = "odrive-v3")]
pub mod odrive_v3;

pub(crate) use stm32f4xx_hal::pac;
