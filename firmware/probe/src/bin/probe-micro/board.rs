//! A board: its cycle counter, and USART2 at 1 Mbaud for the lines. Clocks and pins as in `firmware/src/boards/f405.rs`.

use crate::report::report;
use crate::stretches::{Data, Stretch};
use core::fmt::Write as _;
use cortex_m::peripheral::DWT;
use stm32f4xx_hal::pac;
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Config;
use stm32f4xx_hal::serial::config::Config as SerialConfig;

/// Pause between two reports, cycles: 1 s.
const PAUSE: u32 = 168_000_000;

/// Switches the cycle counter on; `None` if it does not count, as in the emulator.
pub(crate) fn counting(mut core: cortex_m::Peripherals) -> Option<cortex_m::Peripherals> {
    core.DCB.enable_trace();
    core.DWT.enable_cycle_counter();
    let before = DWT::cycle_count();
    cortex_m::asm::delay(100);
    (DWT::cycle_count() != before).then_some(core)
}

/// Repeats the report for ever. If a peripheral is not available or the baud rate is not possible, ends like the emulated program.
pub(crate) fn run(_: cortex_m::Peripherals) -> ! {
    let Some(device) = pac::Peripherals::take() else { probe::give_up() };
    let clocks = Config::hse(8.MHz()).sysclk(168.MHz()).pclk1(42.MHz());
    let mut rcc = device.RCC.freeze(clocks);
    let pins = device.GPIOA.split(&mut rcc);
    let config = SerialConfig::default().baudrate(1_000_000.bps());
    let Ok(mut serial) = device.USART2.serial::<u8>((pins.pa2, pins.pa3), config, &mut rcc) else { probe::give_up() };
    let mut data = Data::new();
    loop {
        // If the transmitter has an error, a line is lost; the reader then waits for the next report.
        report(&mut data, timed, |line| {
            write!(serial, "{line}\r\n").ok();
        });
        cortex_m::asm::delay(PAUSE);
    }
}

/// Cycles of one run. Not inlined, so that every run is between the same instructions.
#[inline(never)]
fn timed(stretch: &Stretch, data: &mut Data) -> u32 {
    let start = DWT::cycle_count();
    stretch.run(data);
    DWT::cycle_count().wrapping_sub(start)
}
