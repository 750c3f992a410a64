//! Micro-benchmarks: times loops of one class of instructions each, on a board or in the emulated chip, and prints one line for each.
//! `cargo xtask cycles` reads them.
//!
//! The same program runs on both, so a board runs exactly the code that was estimated. If the core's cycle counter counts, this is a board, and
//! the lines are sent over USART2 again and again. Otherwise instructions are counted, and the lines are sent over semihosting once. A line is
//! `micro NAME COUNT`, between `micro begin` and `micro end ROWS`.
//!
//! On a board only one pin is driven, the link's PA2. **Not yet run on silicon.**
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
mod report;
#[cfg(target_os = "none")]
#[allow(unsafe_code, reason = "the stretches are in assembler")]
mod stretches;
#[cfg(target_os = "none")]
mod time;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("stretches are timed on the chip: cargo xtask cycles --micro");
}
