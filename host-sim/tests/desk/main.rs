//! Tests of the simulator on the desk: its parts, and the program as run by a user. They are one test program, which links in a fraction of the time
//! and disk space of thirty programs.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should stop there")]

mod bound;
mod browser;
mod can_adapter;
#[path = "../../../robot-compiler/tests/common/cases.rs"]
#[allow(dead_code, reason = "the robot compiler's tests need more of it")]
mod cases;
mod chapter12;
mod check;
mod command_line;
mod compare_page;
mod contact;
mod doctor;
mod drive;
mod dynamics;
mod emit;
mod energy;
mod excite;
mod explain_command;
mod faults;
mod feel;
mod first_motion;
#[cfg(unix)]
mod flash;
mod friction;
mod heat;
mod help;
mod identify;
mod identify_logs;
mod kernel_command;
mod linkage;
mod live_board;
mod margins;
mod motors_check;
mod motors_setup;
mod motors_setup_rejections;
mod motors_setup_robstride;
#[cfg(unix)]
mod newtau_run;
mod operate;
mod output_reference;
mod outputs;
mod page_commands;
mod pages;
#[path = "../program/mod.rs"]
mod program;
mod push;
#[path = "../../sim/tests/simulation/reference.rs"]
mod reference;
mod report_page;
mod report_themes;
#[path = "../../../robot-compiler/tests/common/rooms.rs"]
mod room_names;
mod rooms;
mod session_page;
mod session_socket;
#[path = "../../../robot-compiler/tests/common/skipping.rs"]
mod skipping;
mod statics;
mod study_page;
mod sweep;
mod sweep_bad;
mod sweep_page;
mod sweep_page_runs;
mod sweep_replay;
mod sweep_store;
mod sweep_submit;
mod sweep_told;
mod teach;
mod terms_command;
mod trade;
mod urdf_command;
mod viewers;

/// Compares an output with the one of this name in `outputs.txt`.
fn compare_output(name: &str, found: String) {
    cases::check(std::path::Path::new("tests/desk/outputs.txt"), &[(name, found)]);
}
