//! Shared parts of boards with an STM32G474 and a 24 MHz crystal: clocks, the control timer, the lines. Their link is in `dma_channels`,
//! their CAN controllers in `fdcan_bus`.
//!
//! Written from the reference manual (RM0440) and compiled; **not yet run on silicon**.

pub use super::cortex::{CycleCounter, Generator, cycle_counter, halt};
use super::cortex::{Watchdog, port_c};
use core::convert::Infallible;
use embedded_hal::digital::{ErrorType, OutputPin};
use firmware::board::{BoardLines, Ticker};
use pac::{FLASH, GPIOC, IWDG, PWR, RCC, RNG, TIM3};
use session::readings::Lines;

/// The chip's registers, and its vectors under the names that the tasks are bound to.
pub mod pac {
    pub use stm32g4::stm32g474::{
        DMA1, DMAMUX, FLASH, GPIOA, GPIOB, GPIOC, IWDG, Interrupt, NVIC_PRIO_BITS, PWR, Peripherals, RCC, RNG, TIM3,
        USART2, fdcan,
    };

    /// Vectors of the tasks. `firmware/memory/stm32g474/chip_memory.x` maps their handlers to this chip's names.
    pub mod interrupt {
        use super::Interrupt;

        /// The receiver of the link.
        pub const USART2: Interrupt = Interrupt::USART2;
        /// The control timer.
        pub const TIM3: Interrupt = Interrupt::TIM3;
        /// A vector that no peripheral uses.
        pub const EXTI0: Interrupt = Interrupt::EXTI0;
        /// The DMA that stores the link's bytes.
        pub const DMA1_STREAM5: Interrupt = Interrupt::DMA1_CH1;
        /// The DMA that sends the link's bytes.
        pub const DMA1_STREAM6: Interrupt = Interrupt::DMA1_CH2;
        /// The controller of the first bus.
        pub const CAN1_RX0: Interrupt = Interrupt::FDCAN1_IT0;
        /// The controller of the second bus.
        pub const CAN1_RX1: Interrupt = Interrupt::FDCAN2_IT0;
        /// The controller of the third bus.
        pub const CAN2_RX0: Interrupt = Interrupt::FDCAN3_IT0;
    }
}

/// Clock of the core, of both peripheral buses and of the timers, Hz.
pub const CLOCK_HZ: u32 = 170_000_000;

/// TIM3.
pub struct ControlTimer(TIM3);

/// The emergency stop at PC5, and the independent watchdog.
pub struct Guards {
    /// Port of the emergency stop's pin, which has a pull-up and a normally closed contact to ground: high if pressed or if the wire is broken.
    port: GPIOC,
    watchdog: Watchdog,
}

/// Starts the clocks: 170 MHz from the crystal, for everything except the random number generator, which uses the chip's 48 MHz oscillator.
pub fn start_clocks(rcc: &RCC, power: &PWR, flash: &FLASH) {
    rcc.cr().modify(|_, w| w.hseon().on());
    rcc.crrcr().modify(|_, w| w.hsi48on().set_bit());
    rcc.apb1enr1().modify(|_, w| w.pwren().enabled());
    while rcc.cr().read().hserdy().bit_is_clear() || rcc.crrcr().read().hsi48rdy().bit_is_clear() {}
    // 24 MHz / 6 * 85 / 2.
    rcc.pllcfgr().write(|w| w.pllsrc().hse().pllm().div6().plln().div85().pllr().div2().pllren().set_bit());
    rcc.cr().modify(|_, w| w.pllon().on());
    while rcc.cr().read().pllrdy().bit_is_clear() {}
    // Above 150 MHz the core needs a higher voltage, and the clock must be halved for at least 1 us during the change.
    rcc.cfgr().modify(|_, w| w.hpre().div2());
    power.cr5().modify(|_, w| w.r1mode().clear_bit());
    flash.acr().modify(|_, w| w.latency().wait4().prften().set_bit().icen().set_bit().dcen().set_bit());
    while !flash.acr().read().latency().is_wait4() {}
    rcc.cfgr().modify(|_, w| w.sw().pll());
    while !rcc.cfgr().read().sws().is_pll() {}
    cortex_m::asm::delay(CLOCK_HZ / 1_000_000);
    rcc.cfgr().modify(|_, w| w.hpre().div1());
    // CAN uses the clock of its peripheral bus, which has the crystal's accuracy and is fast enough for the controller's memory.
    rcc.ccipr().modify(|_, w| w.fdcansel().pclk().clk48sel().hsi48());
    rcc.ahb1enr().modify(|_, w| w.dma1en().enabled().dmamux1en().enabled());
    rcc.ahb2enr().modify(|_, w| w.rngen().enabled());
    rcc.apb1enr1().modify(|_, w| w.tim3en().enabled().usart2en().enabled().fdcanen().enabled());
    // A peripheral is ready two cycles after its clock is on; this read takes longer.
    rcc.apb1enr1().read();
}

/// Starts the random number generator.
pub fn generator(rng: RNG) -> Generator {
    rng.cr().modify(|_, w| w.rngen().enabled());
    Generator(rng)
}

/// Sets up the control timer, stopped; `rate_hz` is the control rate, Hz.
pub fn control_timer(timer: TIM3, rate_hz: f32) -> ControlTimer {
    // The rate is rounded down to whole hertz, at least 1 Hz; the cast saturates.
    let period = CLOCK_HZ / (rate_hz as u32).clamp(1, CLOCK_HZ);
    // The counter has 16 bits. The smallest prescaler that divides the period makes the rate exact, if there is a suitable one.
    let least = period.div_ceil(1 << 16);
    let prescaler = (least..2 * least).find(|prescaler| period.is_multiple_of(*prescaler)).unwrap_or(least);
    timer.psc().write(|w| w.psc().set((prescaler - 1) as u16));
    timer.arr().write(|w| w.arr().set(period / prescaler - 1));
    // Only an overflow of the counter sets the update flag.
    timer.cr1().write(|w| w.urs().counter_only());
    timer.dier().write(|w| w.uie().enabled());
    ControlTimer(timer)
}

/// Sets up the watchdog, not running, and the emergency stop's pin with its pull-up; `rate_hz` is the control rate, Hz.
pub fn guards(port: GPIOC, watchdog: IWDG, rate_hz: f32) -> Guards {
    port.pupdr().modify(|_, w| w.pupdr(5).pull_up());
    port.moder().modify(|_, w| w.moder(5).input());
    Guards { port, watchdog: Watchdog::new(watchdog, rate_hz) }
}

impl BoardLines for Guards {
    fn read(&mut self) -> Lines {
        Lines { emergency_stop: self.port.idr().read().idr(5).bit_is_set(), ..Lines::NONE }
    }

    fn feed(&mut self) {
        self.watchdog.feed();
    }
}

impl Ticker for ControlTimer {
    fn run(&mut self) {
        // Restart at zero, with prescaler and period as set before.
        self.0.egr().write(|w| w.ug().update());
        self.0.sr().write(|w| w.uif().clear());
        self.0.cr1().modify(|_, w| w.cen().enabled());
    }

    fn hold(&mut self) {
        self.0.cr1().modify(|_, w| w.cen().disabled());
        self.0.sr().write(|w| w.uif().clear());
    }

    fn acknowledge(&mut self) {
        self.0.sr().write(|w| w.uif().clear());
    }

    fn is_due(&self) -> bool {
        self.0.sr().read().uif().is_update_pending()
    }

    fn trigger(&mut self) {
        rtic::pend(pac::Interrupt::TIM3);
    }
}

/// The brake line at PC4. High opens the brakes.
pub struct BrakeLine(());

/// Sets up the brake line as an output and engages the brakes. Called before anything else.
pub fn brake_line(rcc: &RCC, port: &GPIOC) -> BrakeLine {
    rcc.ahb2enr().modify(|_, w| w.gpioaen().enabled().gpioben().enabled().gpiocen().enabled());
    // A port is ready two cycles after its clock is on; this read takes longer.
    rcc.ahb2enr().read();
    engage_brakes();
    port.moder().modify(|_, w| w.moder(4).output());
    BrakeLine(())
}

/// Sets the brake line low, without owning it. Used by its owner, and at the end of the program, when no owner runs any more.
pub fn engage_brakes() {
    port_c(1 << (16 + 4));
}

impl ErrorType for BrakeLine {
    type Error = Infallible;
}

impl OutputPin for BrakeLine {
    fn set_low(&mut self) -> Result<(), Infallible> {
        engage_brakes();
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        port_c(1 << 4);
        Ok(())
    }
}
