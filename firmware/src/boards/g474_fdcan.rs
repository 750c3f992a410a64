//! An STM32G474RE with a 24 MHz crystal and three CAN transceivers, such as a Nucleo-G474RE with transceivers on its pins. Per bus it drives up
//! to three MIT-mode actuators with classic frames, or up to six with FD frames.
//!
//! Written from the reference manual (RM0440) and compiled; **not yet run on silicon**.
//!
//! | pin | use |
//! |---|---|
//! | PA2, PA3 | USART2: the link, 1 Mbaud; a Nucleo's own adapter is wired to them |
//! | PA11, PA12 | FDCAN1 receive, transmit: bus 1, 1 Mbit/s, FD data at 2 or 5 Mbit/s |
//! | PB12, PB13 | FDCAN2 receive, transmit: bus 2, the same |
//! | PA8, PA15 | FDCAN3 receive, transmit: bus 3, the same |
//! | PC4 | brake line: low engages, so a reset or a broken wire brakes |
//! | PC5 | emergency stop: a normally closed contact to ground; an open contact or a broken wire counts as pressed |
//!
//! The other pins of FDCAN1 are not used: one of them selects the boot loader at reset, and an idle bus would select it.

use super::can_drives::{DRIVES, LOADS, exits};
use super::dma_channels;
use super::fdcan_bus::{self, Bus, FIRST, SECOND, THIRD};
use super::g474::{self, BrakeLine, ControlTimer, CycleCounter, Guards};
use super::pac::{GPIOA, GPIOB};
use dynamics_core::drive::DataRate;
use firmware::board::{Board, Parts};
use firmware::joint_io::can::{BUSES, CanJoints};
use firmware::joint_io::queued::Queued;

/// Data rate of each bus; `None` for classic frames.
const RATES: [Option<DataRate>; BUSES] = {
    let mut rates = [None; BUSES];
    let mut i = 0;
    while i < arm::N {
        rates[DRIVES[i].bus as usize] = DRIVES[i].data_rate;
        i += 1;
    }
    rates
};

/// The board.
pub struct G474Fdcan;

impl Board<{ arm::N }> for G474Fdcan {
    type Peripherals = super::Chip;
    type Input = dma_channels::Input;
    type Incoming = dma_channels::Incoming;
    type Output = dma_channels::Output;
    type Ticker = ControlTimer;
    type Counter = CycleCounter;
    type Lines = Guards;
    type Joints =
        CanJoints<arm::Frames, Queued<Bus<FIRST>>, Queued<Bus<SECOND>>, Queued<Bus<THIRD>>, BrakeLine, { arm::N }>;
    type Nonces = g474::Generator;

    const NAME: &'static str = "STM32G474, CAN FD";

    fn start(chip: super::Chip, rate_hz: f32) -> Parts<Self, { arm::N }> {
        let super::Chip { device, mut core } = chip;
        // Before anything else, the brakes are engaged.
        let brake = g474::brake_line(&device.RCC, &device.GPIOC);
        g474::start_clocks(&device.RCC, &device.PWR, &device.FLASH);
        set_up_pins(&device.GPIOA, &device.GPIOB);
        let (input, incoming, output) = dma_channels::start(device.USART2, device.DMA1, &device.DMAMUX);
        let [one, two, three] = LOADS.map(|load| load.actuators > 0);
        let buses = (
            Queued::new(Bus::start(device.FDCAN1, RATES[0], one)),
            Queued::new(Bus::start(device.FDCAN2, RATES[1], two)),
            Queued::new(Bus::start(device.FDCAN3, RATES[2], three)),
        );
        Parts {
            input,
            incoming,
            output,
            ticker: g474::control_timer(device.TIM3, rate_hz),
            counter: g474::cycle_counter(&mut core),
            lines: g474::guards(device.GPIOC, device.IWDG, rate_hz),
            joints: CanJoints::new(buses, brake, DRIVES),
            nonces: g474::generator(device.RNG),
        }
    }

    fn halt(write_log: impl FnOnce()) -> ! {
        g474::halt(drives_off, write_log)
    }
}

/// Engages the brakes and switches all drives off. Not inlined: there is a caller for each reason to halt.
#[inline(never)]
fn drives_off() {
    g474::engage_brakes();
    let [one, two, three] = RATES.map(|rate| rate.is_some());
    fdcan_bus::send_last::<FIRST>(one, exits(0));
    fdcan_bus::send_last::<SECOND>(two, exits(1));
    fdcan_bus::send_last::<THIRD>(three, exits(2));
}

/// Sets up the pins of link and CAN. A pull-up keeps a receive pin idle if nothing is wired to it or its transceiver has no power.
fn set_up_pins(a: &GPIOA, b: &GPIOB) {
    a.afrl().modify(|_, w| w.afr(2).af7().afr(3).af7());
    a.afrh().modify(|_, w| w.afrh11().af9().afrh12().af9().afrh8().af11().afrh15().af11());
    b.afrh().modify(|_, w| w.afrh12().af9().afrh13().af9());
    a.ospeedr().modify(|_, w| w.ospeedr(12).high_speed().ospeedr(15).high_speed());
    b.ospeedr().modify(|_, w| w.ospeedr(13).high_speed());
    a.pupdr().modify(|_, w| w.pupdr(3).pull_up().pupdr(11).pull_up().pupdr(8).pull_up());
    b.pupdr().modify(|_, w| w.pupdr(12).pull_up());
    a.moder().modify(|_, w| {
        w.moder(2).alternate().moder(3).alternate().moder(8).alternate();
        w.moder(11).alternate().moder(12).alternate().moder(15).alternate()
    });
    b.moder().modify(|_, w| w.moder(12).alternate().moder(13).alternate());
}
