//! A bare STM32F405 with an 8 MHz crystal and two CAN transceivers: up to three MIT-mode actuators per bus.
//!
//! Written from the reference manual (RM0090) and compiled; **not yet run on silicon**.
//!
//! | pin | use |
//! |---|---|
//! | PA2, PA3 | USART2: the link, 1 Mbaud |
//! | PB8, PB9 | CAN1 receive, transmit: bus 1, 1 Mbit/s |
//! | PB12, PB13 | CAN2 receive, transmit: bus 2, 1 Mbit/s |
//! | PC4 | brake line: low engages, so a reset or a broken wire brakes |
//! | PC5 | emergency stop: a normally closed contact to ground; an open contact or a broken wire counts as pressed |

use super::can_bus::{self, BIT_TIMING_1_MBIT, Bus};
use super::can_drives::{DRIVES, exits};
use super::dma_link;
use super::f405::{self, ControlTimer, CycleCounter, Guards};
use super::pac;
use bxcan::Fifo;
use bxcan::filter::Mask32;
use firmware::board::{Board, Parts};
use firmware::joint_io::can::CanJoints;
use firmware::joint_io::can_bus::NoBus;
use stm32f4xx_hal::can::{Can, CanExt as _};
use stm32f4xx_hal::gpio::{Output as OutputPin, PC4, PinState};
use stm32f4xx_hal::prelude::*;

/// Checks at compile time that a bxCAN can reach all drives.
const _: () = {
    let mut i = 0;
    while i < arm::N {
        assert!(DRIVES[i].bus < 2, "the board has buses 1 and 2");
        assert!(DRIVES[i].data_rate.is_none(), "the board's controllers have classic frames alone");
        i += 1;
    }
};

/// The board.
pub struct F405Can;

impl Board<{ arm::N }> for F405Can {
    type Peripherals = super::Chip;
    type Input = dma_link::Input;
    type Incoming = dma_link::Incoming;
    type Output = dma_link::Output;
    type Ticker = ControlTimer;
    type Counter = CycleCounter;
    type Lines = Guards;
    type Joints = CanJoints<arm::Frames, Bus<Can<pac::CAN1>>, Bus<Can<pac::CAN2>>, NoBus, PC4<OutputPin>, { arm::N }>;
    type Nonces = f405::Generator;

    const NAME: &'static str = "STM32F405, CAN";

    fn start(chip: super::Chip, rate_hz: f32) -> Parts<Self, { arm::N }> {
        let super::Chip { device, mut core } = chip;
        let mut rcc = device.RCC.freeze(f405::clocks());
        let (gpioa, gpiob, gpioc) =
            (device.GPIOA.split(&mut rcc), device.GPIOB.split(&mut rcc), device.GPIOC.split(&mut rcc));
        // Before anything else, the brakes are engaged.
        let brake = gpioc.pc4.into_push_pull_output_in_state(PinState::Low);
        let Some((input, incoming, output)) =
            dma_link::start(device.USART2, device.DMA1, (gpioa.pa2, gpioa.pa3), &mut rcc)
        else {
            Self::halt(|| {})
        };

        let first = device.CAN1.can((gpiob.pb9, gpiob.pb8), &mut rcc);
        let second = device.CAN2.can((gpiob.pb13, gpiob.pb12), &mut rcc);
        let mut first = bxcan::Can::builder(first).set_bit_timing(BIT_TIMING_1_MBIT).leave_disabled();
        let second = bxcan::Can::builder(second).set_bit_timing(BIT_TIMING_1_MBIT).leave_disabled();
        // Both controllers share 28 filters, which the first one owns. All frames go to FIFO 0 of their controller.
        let mut filters = first.modify_filters();
        filters.set_split(14).enable_bank(0, Fifo::Fifo0, Mask32::accept_all());
        filters.slave_filters().enable_bank(14, Fifo::Fifo0, Mask32::accept_all());
        drop(filters);
        Parts {
            input,
            incoming,
            output,
            ticker: f405::control_timer(device.TIM3, rate_hz, &mut rcc),
            counter: f405::cycle_counter(&mut core),
            lines: f405::guards(Some(gpioc.pc5.into_pull_up_input().erase()), device.IWDG, rate_hz),
            joints: CanJoints::new((Bus::new(first), Bus::new(second), NoBus), brake, DRIVES),
            nonces: f405::generator(device.RNG, &mut rcc),
        }
    }

    fn halt(write_log: impl FnOnce()) -> ! {
        f405::halt(drives_off, write_log)
    }
}

/// Engages the brakes and switches all drives off. Not inlined: there is a caller for each reason to halt.
#[inline(never)]
fn drives_off() {
    // PC4.
    f405::port_c(1 << (16 + 4));
    can_bus::send_last::<Can<pac::CAN1>>(exits(0));
    can_bus::send_last::<Can<pac::CAN2>>(exits(1));
}
