//! [`trials::fuzz::link_stream`] under libFuzzer; without it, on the files named as arguments.
#![cfg_attr(fuzzing, no_main)]

trials::fuzz_program!(link_stream);
