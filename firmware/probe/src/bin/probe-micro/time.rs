//! The program on the chip.

use crate::board;
use crate::report::report;
use crate::stretches::{Data, Stretch};
use cortex_m_rt::entry;
use cortex_m_semihosting::hprintln;
use probe::Counter;

#[entry]
fn main() -> ! {
    match cortex_m::Peripherals::take().and_then(board::counting) {
        Some(core) => board::run(core),
        None => probe::run(|counter| {
            let mut data = Data::new();
            let count = |stretch: &Stretch, data: &mut Data| counted(counter, stretch, data);
            // A line that cannot be written is missing, which the reader notices.
            report(&mut data, count, |line| hprintln!("{}", line));
        }),
    }
}

fn counted(counter: &Counter, stretch: &Stretch, data: &mut Data) -> u32 {
    counter.call(Stretch::run, stretch, data).0
}
