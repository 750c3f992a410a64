//! QEMU's `netduinoplus2`: the emulated STM32F405.
//!
//! In the emulator the clock controller reads as zero, so waiting for an oscillator or the PLL would never end. The clocks are therefore left as
//! they are, and registers are set directly, because the HAL's constructors wait for clocks. GPIO is not emulated, so there is no brake line: only
//! the fault frame shows that the arm brakes.

#[cfg(not(feature = "dma"))]
use super::byte_link as wire;
#[cfg(feature = "dma")]
use super::dma_stand_in as wire;
use super::pac;
use super::pac::interrupt;
use crate::key::CountedNonces;
use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::peripheral::{NVIC, SCB};
use cortex_m_semihosting::debug;
use dynamics_core::Sensed;
use dynamics_core::control::Spring;
use dynamics_core::safety::SafeAction;
use firmware::board::{Board, BoardLines, Parts, Ticker};
use firmware::joint_io::JointIo;
use link::Cost;
use session::meter::Counter;
use session::readings::{JointFaults, Lines, Readings};

/// With `-icount shift=0` an instruction takes 1 ns, and the emulator counts timers at 1 GHz.
const TIMER_HZ: f32 = 1e9;

/// The board.
pub struct NetduinoPlus2;

/// TIM3.
pub struct ControlTimer(pac::TIM3);

/// TIM2, free-running; counts instructions.
pub struct InstructionCounter(pac::TIM2);

/// Lines of a board without inputs. TIM4, with an interrupt at the control rate, stands in for the watchdog, which the emulator lacks.
pub struct NoLines {
    watchdog: pac::TIM4,
    running: bool,
}

/// Number of interrupts of the watchdog's stand-in since it was fed.
static UNFED: AtomicU32 = AtomicU32::new(0);

/// Number of interrupts without feeding after which the chip is reset. Interrupts are counted instead of time, because the emulator's time goes on
/// while the computer under it is suspended.
const TICKS_UNFED: u32 = 4;

/// Joints that rest at zero, are homed, and do not move under torque, so that a live session can be armed.
pub struct RestingJoints;

impl Board<{ arm::N }> for NetduinoPlus2 {
    type Peripherals = super::Chip;
    type Input = wire::Input;
    type Incoming = wire::Incoming;
    type Output = wire::Output;
    type Ticker = ControlTimer;
    type Counter = InstructionCounter;
    type Lines = NoLines;
    type Joints = RestingJoints;
    type Nonces = CountedNonces<fn() -> u32>;

    const NAME: &'static str = "netduinoplus2 (QEMU)";

    fn start(chip: super::Chip, rate_hz: f32) -> Parts<Self, { arm::N }> {
        let pac::Peripherals { USART2: usart, TIM2: counter, TIM3: timer, TIM4: watchdog, .. } = chip.device;
        usart.cr1().write(|w| w.ue().enabled().re().enabled().te().enabled().rxneie().enabled());
        let Some((input, incoming, output)) = wire::start(usart) else { Self::halt(|| {}) };

        counter.psc().write(|w| w.psc().set(0));
        counter.arr().write(|w| w.arr().set(u32::MAX));
        counter.cr1().write(|w| w.cen().enabled());

        let timer = ControlTimer(timer);
        at_the_control_rate(&timer.0, rate_hz);
        at_the_control_rate(&watchdog, rate_hz);
        #[allow(unsafe_code, reason = "lets the watchdog's interrupt in")]
        // SAFETY: the handler shares only an atomic with other code, and no critical section relies on the interrupt being masked.
        unsafe {
            NVIC::unmask(pac::Interrupt::TIM4);
        }

        Parts {
            input,
            incoming,
            output,
            ticker: timer,
            counter: InstructionCounter(counter),
            lines: NoLines { watchdog, running: false },
            joints: RestingJoints,
            nonces: CountedNonces(time),
        }
    }

    fn halt(write_log: impl FnOnce()) -> ! {
        write_log();
        // Ends the emulator, so that a host that waits for an answer notices at once.
        debug::exit(debug::EXIT_FAILURE);
        loop {
            cortex_m::asm::wfi();
        }
    }
}

/// Sets a timer up for interrupts at the control rate, not counting yet. TIM2 counts from power-on.
fn at_the_control_rate(timer: &pac::tim3::RegisterBlock, rate_hz: f32) {
    // The timers have 16 bits: a prescaler of 1000 gives 1 MHz, which permits 16 Hz and more. The cast saturates.
    let period = (TIMER_HZ / 1000.0 / rate_hz) as u16;
    timer.psc().write(|w| w.psc().set(1000 - 1));
    // QEMU 7.2 (`stm32f2xx_timer_set_alarm`) sets the alarm to now plus the time at which the count was zero plus the reload. That is one period only
    // if the count was zero at power-on; a later reset of the count makes every period longer by that time. So the count is set to the time since
    // power-on, from TIM2, to 1 us. The reload is the whole period there, not one less. After a reset TIM2 restarts, and periods are longer: ticks by
    // the timer have the right rate only after the first start.
    timer.cnt().write(|w| w.cnt().set((time() / 1000) as u16));
    timer.arr().write(|w| w.arr().set(period.max(1)));
    timer.dier().write(|w| w.uie().enabled());
}

/// Starts a timer.
fn let_run(timer: &pac::tim3::RegisterBlock) {
    timer.sr().reset();
    timer.cr1().write(|w| w.cen().enabled());
    // The alarm was lost while the timer was stopped. In the emulator, writing the reload sets it one period ahead, even with the same value.
    timer.arr().modify(|_, w| w);
}

/// The watchdog's stand-in. Like a reset, it has priority over everything else.
#[interrupt]
fn TIM4() {
    #[allow(unsafe_code, reason = "the owner of the timer does not use its status while it runs")]
    // SAFETY: a single volatile write, which clears the interrupt.
    unsafe {
        (*pac::TIM4::ptr()).sr().write(|w| w.uif().clear());
    }
    if UNFED.fetch_add(1, Ordering::Relaxed) >= TICKS_UNFED {
        SCB::sys_reset();
    }
}

/// Reads TIM2.
fn time() -> u32 {
    #[allow(unsafe_code, reason = "the counter's owner only reads it too")]
    // SAFETY: a single volatile read, without a side effect.
    let count = unsafe { (*pac::TIM2::ptr()).cnt().read().bits() };
    count
}

impl Ticker for ControlTimer {
    fn run(&mut self) {
        let_run(&self.0);
    }

    fn hold(&mut self) {
        self.0.cr1().write(|w| w.cen().disabled());
        self.0.sr().reset();
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

impl Counter for InstructionCounter {
    fn now(&self) -> u32 {
        self.0.cnt().read().bits()
    }

    fn cost(count: u32) -> Cost {
        Cost::Instructions(count)
    }

    fn exercise(&self) {
        cortex_m::asm::delay(100);
    }
}

impl BoardLines for NoLines {
    fn read(&mut self) -> Lines {
        Lines::NONE
    }

    fn feed(&mut self) {
        UNFED.store(0, Ordering::Relaxed);
        if !self.running {
            self.running = true;
            let_run(&self.watchdog);
        }
    }
}

impl JointIo<{ arm::N }> for RestingJoints {
    fn measure(&mut self) -> Option<Readings<{ arm::N }>> {
        const ZERO: [f32; arm::N] = [0.0; arm::N];
        Some(Readings {
            sensed: Sensed::State { q: ZERO, qd: ZERO },
            torque: ZERO,
            age_ticks: [0; arm::N],
            faults: [JointFaults::NONE; arm::N],
            errors: [0; arm::N],
            on: [true; arm::N],
            zero_lost: false,
        })
    }

    fn enable(&mut self, _action: SafeAction) {}

    fn preload(&mut self, _torque: &[f32; arm::N], _: Option<&[Spring<f32>; arm::N]>) {}

    fn drive(&mut self, _torque: &[f32; arm::N], _: Option<&[Spring<f32>; arm::N]>) {}

    fn safe(&mut self, _action: SafeAction) {}
}
