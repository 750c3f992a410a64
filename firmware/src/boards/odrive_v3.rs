//! ODrive v3 and its like: an STM32F405 with an 8 MHz crystal.
//!
//! Written from the reference manual (RM0090) and compiled; **not yet run on silicon**.
//!
//! | pin | board's name | use |
//! |---|---|---|
//! | PA2, PA3 | GPIO3, GPIO4 | USART2: the link, 1 Mbaud |
//! | PC4 | GPIO5 | brake line: low engages, so a reset or a broken wire brakes |
//! | PB12 | EN_GATE | held low: the power stages stay off until a later slice drives them |
//!
//! Measurements come and commands go over the link; the timer paces the tick.

use super::pac;
use firmware::board::{Board, JointIo, LinkInput, LinkOutput, Parts, Ticker};
use firmware::meter::Counter;
use link::Cost;
use stm32f4xx_hal::gpio::{Output as OutputPin, PB12, PC4, PinState};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::rcc::Config;
use stm32f4xx_hal::serial::config::Config as SerialConfig;
use stm32f4xx_hal::serial::{Rx, Tx};
use stm32f4xx_hal::time::Hertz;
use stm32f4xx_hal::timer::{CounterHz, Event, Flag};

/// The board.
pub struct OdriveV3;

/// Receiver of USART2.
pub struct Input(Rx<pac::USART2>);

/// Transmitter of USART2.
pub struct Output(Tx<pac::USART2>);

/// TIM3.
pub struct ControlTimer {
    timer: CounterHz<pac::TIM3>,
    rate: Hertz,
}

/// The core's cycle counter.
pub struct CycleCounter;

/// The brake line, and the power stages' enable that stays low.
pub struct Lines {
    brake: PC4<OutputPin>,
    _power_off: PB12<OutputPin>,
}

impl Board for OdriveV3 {
    type Peripherals = super::Chip;
    type Input = Input;
    type Output = Output;
    type Ticker = ControlTimer;
    type Counter = CycleCounter;
    type Joints = Lines;

    const NAME: &'static str = "ODrive v3";

    fn start(chip: super::Chip, rate_hz: f32) -> Parts<Self> {
        let super::Chip { device, mut core } = chip;
        let mut rcc = device.RCC.freeze(Config::hse(8.MHz()).sysclk(168.MHz()));
        let (gpioa, gpiob, gpioc) =
            (device.GPIOA.split(&mut rcc), device.GPIOB.split(&mut rcc), device.GPIOC.split(&mut rcc));
        let joints = Lines {
            brake: gpioc.pc4.into_push_pull_output_in_state(PinState::Low),
            _power_off: gpiob.pb12.into_push_pull_output_in_state(PinState::Low),
        };

        let config = SerialConfig::default().baudrate(1_000_000.bps());
        let Ok(serial) = device.USART2.serial((gpioa.pa2, gpioa.pa3), config, &mut rcc) else {
            // 42 MHz / 1 Mbaud = 42: this rate exists on this clock, and no other clock is set above.
            Self::halt()
        };
        let (output, mut input) = serial.split();
        input.listen();

        core.DCB.enable_trace();
        core.DWT.enable_cycle_counter();

        let mut timer = device.TIM3.counter_hz(&mut rcc);
        timer.listen(Event::Update);
        // Whole hertz: the cast saturates, and a rate below 1 Hz is no control rate.
        let rate = (rate_hz as u32).max(1).Hz();
        Parts {
            input: Input(input),
            output: Output(output),
            ticker: ControlTimer { timer, rate },
            counter: CycleCounter,
            joints,
        }
    }

    fn halt() -> ! {
        cortex_m::interrupt::disable();
        #[allow(unsafe_code, reason = "the program is over; whoever owned the pin does not run again")]
        // SAFETY: interrupts are off and nothing returns from here, so nobody else touches the port. A write to the
        // set-reset register changes the one pin that it names: bit 20 resets pin 4.
        unsafe {
            (*pac::GPIOC::ptr()).bsrr().write(|w| w.bits(1 << 20));
        }
        loop {
            cortex_m::asm::wfi();
        }
    }
}

impl LinkInput for Input {
    fn read(&mut self) -> Option<u8> {
        // An overrun or a framing error also clears here; the packet's check sum finds the missing byte.
        self.0.read().ok()
    }
}

impl LinkOutput for Output {
    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            // Ends: the transmitter empties at its baud rate, whoever listens.
            while self.0.write(byte).is_err() {}
        }
    }
}

impl Ticker for ControlTimer {
    fn run(&mut self) {
        // Fails only for rates above the timer's clock; the timer then stays held, and the host hears nothing.
        self.timer.start(self.rate).ok();
    }

    fn hold(&mut self) {
        // Not running is no error here.
        self.timer.cancel().ok();
        self.timer.clear_flags(Flag::Update);
    }

    fn acknowledge(&mut self) {
        self.timer.clear_flags(Flag::Update);
    }

    fn is_due(&self) -> bool {
        self.timer.flags().contains(Flag::Update)
    }

    fn trigger(&mut self) {
        rtic::pend(pac::Interrupt::TIM3);
    }
}

impl Counter for CycleCounter {
    fn now(&self) -> u32 {
        cortex_m::peripheral::DWT::cycle_count()
    }

    fn cost(count: u32) -> Cost {
        Cost::Cycles(count)
    }

    fn exercise(&self) {
        cortex_m::asm::delay(100);
    }
}

impl JointIo for Lines {
    fn brake(&mut self) {
        self.brake.set_low();
    }

    fn release_brakes(&mut self) {
        self.brake.set_high();
    }
}
