//! Times stretches of one class of instructions each, on a board or in the emulated chip, and writes one line for each;
//! `cargo xtask cycles` reads them.
//!
//! One program for both: where the core's cycle counter counts, this is a board, and the lines go over USART2 again and
//! again; elsewhere instructions are counted, and the lines go over semihosting once. So a board runs just what was
//! estimated. A line is `micro NAME COUNT`, between `micro begin` and `micro end ROWS`.
//!
//! On a board no pin is driven but the link's PA2. **Not yet run on silicon.**
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
