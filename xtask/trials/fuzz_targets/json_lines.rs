//! [`trials::fuzz::json_lines`] under libFuzzer; without it, on the files named as arguments.
#![cfg_attr(fuzzing, no_main)]

trials::fuzz_program!(json_lines);
