//! Counts the instructions of kernels in the emulated chip, and writes one line for each; `cargo xtask bench` reads them.
//!
//! With `-icount shift=0` QEMU's TIM2 counts instructions (as in `firmware/src/boards/netduinoplus2.rs`). The number in
//! a line is the count of the function alone: the count of an empty function, called the same way, is subtracted.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod cases;
#[cfg(target_os = "none")]
mod count;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("kernels are counted in the emulated chip: cargo xtask bench");
}
