//! Tests of the simulator on the desk: its parts, and the program as run by a user. All are one test program, which
//! links in a fraction of the time and disk space of thirty.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that fails should stop there")]

mod batch;
mod bound;
mod browser;
mod campaign;
mod campaign_drives;
mod chapter12;
mod check;
mod closed_loop;
mod collision;
mod command_line;
mod compare_page;
mod contact;
mod doctor;
mod drives;
mod dynamics;
mod energy;
mod excite;
mod explain_command;
mod extremes;
mod feel;
mod first_motion;
mod friction;
mod heat;
mod identify;
mod identify_logs;
mod judge;
mod kernel_command;
mod linkage;
mod live_board;
mod operate;
mod outputs;
mod pages;
mod plant;
mod plant_elasticity;
mod plant_integrators;
mod plant_rotor_coupling;
#[path = "../program/mod.rs"]
mod program;
mod push;
mod rates;
mod reference;
mod report_page;
#[path = "../../../robot-compiler/tests/common/rooms.rs"]
mod room_names;
mod rooms;
#[path = "../../../robot-compiler/tests/common/skipping.rs"]
mod skipping;
mod split;
mod statics;
mod stiction;
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
#[path = "../../../robot-compiler/tests/common/wrong_rounding.rs"]
mod wrong_rounding;
