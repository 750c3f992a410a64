//! TIM2 as a counter of instructions.

use core::hint::black_box;
use cortex_m_semihosting::debug;
use stm32f4xx_hal::pac;

/// TIM2, free-running.
pub struct Counter(pac::TIM2);

impl Counter {
    /// Starts the timer.
    fn new(timer: pac::TIM2) -> Self {
        timer.psc().write(|w| w.psc().set(0));
        timer.arr().write(|w| w.arr().set(u32::MAX));
        timer.cr1().write(|w| w.cen().enabled());
        Self(timer)
    }

    /// True if equal work gives equal counts, and more work gives a higher count. False if the emulator does not count instructions.
    fn is_exact(&self) -> bool {
        let (short, long) = ([self.trial(100), self.trial(100), self.trial(100)], self.trial(1000));
        short[1] == short[2] && long > short[2]
    }

    /// Not inlined, so that every run has the same instructions.
    #[inline(never)]
    fn trial(&self, loops: u32) -> u32 {
        let start = self.now();
        cortex_m::asm::delay(black_box(loops));
        self.now().wrapping_sub(start)
    }

    fn now(&self) -> u32 {
        self.0.cnt().read().bits()
    }

    /// Returns the count of one call, and its result. Not inlined, so that every call is made by the same instructions.
    ///
    /// The count includes the call itself, which is the count of an empty function.
    #[inline(never)]
    pub fn call<A, B, R>(&self, function: fn(&A, &mut B) -> R, from: &A, to: &mut B) -> (u32, R) {
        let start = self.now();
        let result = function(from, to);
        (self.now().wrapping_sub(start), result)
    }
}

/// Runs the counts and ends the emulator; with a failure if instructions are not counted exactly.
pub fn run(all: fn(&Counter)) -> ! {
    if let Some(chip) = pac::Peripherals::take() {
        let counter = Counter::new(chip.TIM2);
        if counter.is_exact() {
            all(&counter);
            debug::exit(debug::EXIT_SUCCESS);
        }
    }
    give_up()
}

/// Ends the emulator with a failure.
pub fn give_up() -> ! {
    debug::exit(debug::EXIT_FAILURE);
    loop {
        cortex_m::asm::wfi();
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    give_up()
}
