//! ODrive v3 and similar boards: an STM32F405 with an 8 MHz crystal.
//!
//! Written from the reference manual (RM0090) and compiled; **not yet run on silicon**.
//!
//! | pin | board's name | use |
//! |---|---|---|
//! | PA2, PA3 | GPIO3, GPIO4 | USART2: the link, 1 Mbaud |
//! | PC4 | GPIO5 | brake line: low engages, so a reset or a broken wire brakes |
//! | PB12 | EN_GATE | held low: the power stages stay off, because this firmware does not drive them yet |
//!
//! Measurements and commands are sent over the link; the timer starts the ticks.

use super::dma_link;
use super::f405::{self, ControlTimer, CycleCounter, Guards};
use dynamics_core::control::Spring;
use dynamics_core::safety::SafeAction;
use firmware::board::{Board, Parts};
use firmware::joint_io::JointIo;
use session::readings::Readings;
use stm32f4xx_hal::gpio::{Output as OutputPin, PB12, PC4, PinState};
use stm32f4xx_hal::prelude::*;

/// The board.
pub struct OdriveV3;

/// The brake line, and the enable pin of the power stages, which stays low.
pub struct Lines {
    brake: PC4<OutputPin>,
    _power_off: PB12<OutputPin>,
}

impl Board<{ arm::N }> for OdriveV3 {
    type Peripherals = super::Chip;
    type Input = dma_link::Input;
    type Incoming = dma_link::Incoming;
    type Output = dma_link::Output;
    type Ticker = ControlTimer;
    type Counter = CycleCounter;
    type Lines = Guards;
    type Joints = Lines;
    type Nonces = f405::Generator;

    const NAME: &'static str = "ODrive v3";

    fn start(chip: super::Chip, rate_hz: f32) -> Parts<Self, { arm::N }> {
        let super::Chip { device, mut core } = chip;
        let mut rcc = device.RCC.freeze(f405::clocks());
        let (gpioa, gpiob, gpioc) =
            (device.GPIOA.split(&mut rcc), device.GPIOB.split(&mut rcc), device.GPIOC.split(&mut rcc));
        let joints = Lines {
            brake: gpioc.pc4.into_push_pull_output_in_state(PinState::Low),
            _power_off: gpiob.pb12.into_push_pull_output_in_state(PinState::Low),
        };
        let Some((input, incoming, output)) =
            dma_link::start(device.USART2, device.DMA1, (gpioa.pa2, gpioa.pa3), &mut rcc)
        else {
            Self::halt(|| {})
        };
        Parts {
            input,
            incoming,
            output,
            ticker: f405::control_timer(device.TIM3, rate_hz, &mut rcc),
            counter: f405::cycle_counter(&mut core),
            lines: f405::guards(None, device.IWDG, rate_hz),
            joints,
            nonces: f405::generator(device.RNG, &mut rcc),
        }
    }

    fn halt(write_log: impl FnOnce()) -> ! {
        // PC4.
        f405::halt(|| f405::port_c(1 << (16 + 4)), write_log)
    }
}

impl JointIo<{ arm::N }> for Lines {
    fn measure(&mut self) -> Option<Readings<{ arm::N }>> {
        None
    }

    fn enable(&mut self, _action: SafeAction) {}

    fn preload(&mut self, _torque: &[f32; arm::N], _: Option<&[Spring<f32>; arm::N]>) {
        self.brake.set_low();
    }

    fn drive(&mut self, _torque: &[f32; arm::N], _: Option<&[Spring<f32>; arm::N]>) {
        self.brake.set_high();
    }

    fn safe(&mut self, _action: SafeAction) {
        self.brake.set_low();
    }
}
