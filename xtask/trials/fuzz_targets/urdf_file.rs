//! [`trials::fuzz::urdf_file`] under libFuzzer; without it, on the files named as arguments.
#![cfg_attr(fuzzing, no_main)]

#[cfg(fuzzing)]
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| trials::fuzz::urdf_file::check(bytes));

#[cfg(not(fuzzing))]
fn main() -> std::io::Result<()> {
    trials::fuzz::replay(trials::fuzz::urdf_file::check)
}
