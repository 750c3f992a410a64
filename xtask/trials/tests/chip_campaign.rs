//! A few runs of the fault-injection campaign in the emulated chip: no command is unsafe, and every answer equals the desk's to the last bit.
#![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

use indicatif::ProgressBar;
use robot_compiler::SceneFile;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use trials::campaign::{Campaign, Target};

#[test]
fn no_command_of_the_chip_is_unsafe_and_all_are_the_desk_s() {
    let scene = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/campaign/states.toml");
    let scenes = vec![SceneFile::load(&scene).unwrap()];
    // 61 is coprime to the number of cases, so that the twenty runs are spread over all of them.
    let campaign = Campaign { scenes, seed: 1, runs: (0..20).map(|k| 61 * k).collect(), target: Target::Qemu };
    let report = campaign.report(&AtomicBool::new(false), &ProgressBar::hidden()).unwrap();
    assert!(report.counterexamples.is_empty(), "{}", report.table());
    assert_eq!(report.runs, 20);
    assert!(report.rows.len() >= 15, "{}", report.table());
    println!("{}", report.count());
}
