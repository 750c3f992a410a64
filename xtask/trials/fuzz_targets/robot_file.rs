//! [`trials::fuzz::robot_file`] under libFuzzer; without it, on the files named as arguments.
#![cfg_attr(fuzzing, no_main)]

trials::fuzz_program!(robot_file);
