//! Checks the firmware's own `memcpy`, `memmove` and zeroing (`firmware/src/copy.rs`) in the emulated chip, against loops over bytes.
//!
//! Each call gets a length, two addresses modulo 4 and, for `memmove`, an overlap. All bytes around the destination must stay as they were. The program
//! ends with a failure at the first difference.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod chip;
#[cfg(target_os = "none")]
#[path = "../../../../src/copy.rs"]
mod copy;

#[cfg(not(target_os = "none"))]
fn main() {
    println!("the firmware's memory functions are checked on the chip: cargo nextest run -p host-sim --test chip copy");
}
