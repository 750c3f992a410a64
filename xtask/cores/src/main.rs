//! Prints the rows of this core. With the feature `bare` it needs no operating system: it prints over semihosting, to an emulator.
#![cfg_attr(feature = "bare", no_std, no_main)]

#[cfg(feature = "bare")]
mod start;

#[cfg(not(feature = "bare"))]
fn main() {
    cores::run(true, 1, &mut || 0, &mut |row| {
        println!("row|{}|{}|{:016x}|{}", row.scalar, row.what, row.hash, row.time);
    });
}
