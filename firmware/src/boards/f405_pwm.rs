//! A bare STM32F405 with an 8 MHz crystal, H-bridges on PWM and AS5047P encoders on SPI: up to four joints.
//!
//! Written from the reference manual (RM0090) and compiled; **not yet run on silicon**.
//!
//! | pin, channel 1 to 4 | use |
//! |---|---|
//! | PA2, PA3 | USART2: the link, 1 Mbaud |
//! | PA8, PA9, PA10, PA11 | TIM1: duty cycle of each bridge, 20 kHz |
//! | PB0, PB1, PB2, PB10 | direction: high drives the motor forwards |
//! | PC0, PC1, PC2, PC3 | enable of each bridge |
//! | PA5, PA6, PA7 | SPI1: clock, from the encoders, to the encoders; 5 MHz, mode 1 |
//! | PC6, PC7, PC8, PC9 | chip select of each encoder, active low |
//! | PC4 | brake line: low engages, so a reset or a broken wire brakes |
//! | PC5 | emergency stop: a normally closed contact to ground; an open contact or a broken wire counts as pressed |
//!
//! Each bridge needs a pull-down at its enable input, because the pins float until the program runs.

use super::dma_link;
use super::f405::{self, ControlTimer, CycleCounter, Guards};
use super::pac;
use dynamics_core::drive::{Drives, PwmDrive};
use embedded_hal::spi::MODE_1;
use embedded_hal_bus::spi::{AtomicDevice, NoDelay};
use embedded_hal_bus::util::AtomicCell;
use firmware::board::{Board, Parts};
use firmware::joint_io::pwm::{Channel, NoSensor, PwmJoints};
use stm32f4xx_hal::gpio::{AnyPin, Output as OutputPin, PC4, PinState};
use stm32f4xx_hal::prelude::*;
use stm32f4xx_hal::spi::Spi;
use stm32f4xx_hal::timer::ErasedChannel;

/// Number of joints that the board has lines for.
const CHANNELS: usize = 4;

/// The arm's drives. Drives of another kind cause a compile error.
const DRIVES: [PwmDrive; arm::N] = match arm::drives() {
    Drives::Pwm(drives) => drives,
    Drives::Link | Drives::Mit(_) => {
        panic!("this board drives H-bridges: build it with a scene whose robot has drives of the kind pwm")
    }
};

const _: () = {
    let mut i = 0;
    while i < arm::N {
        assert!((DRIVES[i].channel as usize) < CHANNELS, "the board has channels 1 to 4");
        i += 1;
    }
};

type Pin = AnyPin<OutputPin>;
type Encoder = AtomicDevice<'static, Spi<pac::SPI1>, Pin, NoDelay>;
type Lines = Channel<ErasedChannel<pac::TIM1>, Pin, Pin, Encoder>;

/// The board.
pub struct F405Pwm;

impl Board<{ arm::N }> for F405Pwm {
    type Peripherals = super::Chip;
    type Input = dma_link::Input;
    type Incoming = dma_link::Incoming;
    type Output = dma_link::Output;
    type Ticker = ControlTimer;
    type Counter = CycleCounter;
    type Lines = Guards;
    type Joints = PwmJoints<ErasedChannel<pac::TIM1>, Pin, Pin, Encoder, NoSensor, PC4<OutputPin>, { arm::N }>;
    type Nonces = f405::Generator;

    const NAME: &'static str = "STM32F405, PWM and encoders";

    fn start(chip: super::Chip, rate_hz: f32) -> Parts<Self, { arm::N }> {
        let super::Chip { device, mut core } = chip;
        let mut rcc = device.RCC.freeze(f405::clocks());
        let (gpioa, gpiob, gpioc) =
            (device.GPIOA.split(&mut rcc), device.GPIOB.split(&mut rcc), device.GPIOC.split(&mut rcc));
        // Before anything else, the brakes are engaged and the bridges switched off.
        let brake = gpioc.pc4.into_push_pull_output_in_state(PinState::Low);
        let low = PinState::Low;
        let enable: [Pin; CHANNELS] = [
            gpioc.pc0.into_push_pull_output_in_state(low).erase(),
            gpioc.pc1.into_push_pull_output_in_state(low).erase(),
            gpioc.pc2.into_push_pull_output_in_state(low).erase(),
            gpioc.pc3.into_push_pull_output_in_state(low).erase(),
        ];
        let direction: [Pin; CHANNELS] = [
            gpiob.pb0.into_push_pull_output_in_state(low).erase(),
            gpiob.pb1.into_push_pull_output_in_state(low).erase(),
            gpiob.pb2.into_push_pull_output_in_state(low).erase(),
            gpiob.pb10.into_push_pull_output_in_state(low).erase(),
        ];
        let high = PinState::High;
        let select: [Pin; CHANNELS] = [
            gpioc.pc6.into_push_pull_output_in_state(high).erase(),
            gpioc.pc7.into_push_pull_output_in_state(high).erase(),
            gpioc.pc8.into_push_pull_output_in_state(high).erase(),
            gpioc.pc9.into_push_pull_output_in_state(high).erase(),
        ];
        let Some((input, incoming, output)) =
            dma_link::start(device.USART2, device.DMA1, (gpioa.pa2, gpioa.pa3), &mut rcc)
        else {
            Self::halt(|| {})
        };

        let (_, (one, two, three, four)) = device.TIM1.pwm_hz(20.kHz(), &mut rcc);
        let mut duty: [ErasedChannel<pac::TIM1>; CHANNELS] = [
            one.with(gpioa.pa8).erase(),
            two.with(gpioa.pa9).erase(),
            three.with(gpioa.pa10).erase(),
            four.with(gpioa.pa11).erase(),
        ];
        for channel in &mut duty {
            channel.set_duty(0);
            channel.enable();
        }
        let spi = device.SPI1.spi((Some(gpioa.pa5), Some(gpioa.pa6), Some(gpioa.pa7)), MODE_1, 5.MHz(), &mut rcc);
        let Some(bus) = cortex_m::singleton!(: AtomicCell<Spi<pac::SPI1>> = AtomicCell::new(spi)) else {
            Self::halt(|| {})
        };
        let bus: &'static AtomicCell<Spi<pac::SPI1>> = bus;

        let mut lines = [const { None::<Lines> }; CHANNELS];
        let pins = duty.into_iter().zip(direction).zip(enable).zip(select);
        for (line, (((pwm, direction), enable), select)) in lines.iter_mut().zip(pins) {
            // The chip select is already high, and setting it cannot fail: its error type has no values.
            let Ok(encoder) = AtomicDevice::new_no_delay(bus, select);
            *line = Some(Channel { pwm, direction, enable, encoder, sensor: NoSensor });
        }
        let channels = DRIVES.each_ref().map(|drive| lines.get_mut(usize::from(drive.channel)).and_then(Option::take));
        // The reader of robot files checks that each channel is used once, and the board has all channels.
        let channels = channels.map(|channel| channel.unwrap_or_else(|| Self::halt(|| {})));
        Parts {
            input,
            incoming,
            output,
            ticker: f405::control_timer(device.TIM3, rate_hz, &mut rcc),
            counter: f405::cycle_counter(&mut core),
            lines: f405::guards(Some(gpioc.pc5.into_pull_up_input().erase()), device.IWDG, rate_hz),
            joints: PwmJoints::new(channels, brake, DRIVES),
            nonces: f405::generator(device.RNG, &mut rcc),
        }
    }

    fn halt(write_log: impl FnOnce()) -> ! {
        f405::halt(
            || {
                // Enable pins and brake line; bridges that are off ignore the PWM.
                f405::port_c(0b1_1111 << 16);
            },
            write_log,
        )
    }
}
