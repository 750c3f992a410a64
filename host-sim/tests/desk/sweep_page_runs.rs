//! A study's page in a real browser: the commands of its runs, long names, and the page of a campaign.

use crate::browser::{Browser, FLAT};
use crate::pages::{WINDOWS, handed_over, open, rows};
use crate::sweep::{cells, folder};
use crate::sweep_page::{FAILING, WORST, fixture, list, shows_the_distributions, studied};
use crate::sweep_told::{of_rows, prepared, rods};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Output of a command, run by a shell in a folder.
fn done(command: &str, folder: &Path) -> String {
    let programs = Path::new(env!("CARGO_BIN_EXE_newtau")).parent().unwrap();
    let path = format!("{}:{}", programs.display(), std::env::var("PATH").unwrap());
    let done = Command::new("sh").args(["-c", command]).env("PATH", &path).current_dir(folder).output().unwrap();
    assert!(done.status.success(), "{command}: {done:?}");
    String::from_utf8(done.stdout).unwrap()
}

#[test]
fn the_command_of_a_worst_run_repeats_it_wherever_the_study_lies() {
    let Some(mut browser) = Browser::start("sweep_command", FLAT) else { return };
    let (out, results) = studied("a study's $HOME", &fixture(), 40);
    let page = out.join("report.html");
    open(&mut browser, &page, WINDOWS[0]);
    let [(_, exact), (worst_command, _)] = rows(&mut browser, WORST)[0].last_chunk().unwrap().clone();
    let first = results["failing"][0].as_u64().unwrap();
    let [(run, _), (failing_command, _)] = rows(&mut browser, FAILING)[0].last_chunk().unwrap().clone();
    assert_eq!(run, first.to_string());
    assert!(failing_command.ends_with(&format!(" --replay {first} --out out/run_{first}")), "{failing_command}");
    let handed = [WORST, FAILING].map(|caption| handed_over(&mut browser, caption)[0].clone());
    assert_eq!(handed, [worst_command, failing_command]);
    // The keyboard focus is on the last command that was reached: that of the last row.
    let last = handed_over(&mut browser, FAILING).pop().unwrap();
    browser.press("Enter");
    browser.until(&format!("document.querySelector('.note')?.textContent.includes({}) === true", json!(last)));
    handed.iter().for_each(|command| drop(done(command, &out)));
    let error = |index: u64| {
        let summary = fs::read_to_string(out.join(format!("out/run_{index}/summary.json"))).unwrap();
        let summary: Value = serde_json::from_str(&summary).unwrap();
        list(&summary["tracking_max"]).iter().filter_map(Value::as_f64).fold(0.0, f64::max)
    };
    let worst = results["metrics"][0]["worst"][0]["index"].as_u64().unwrap();
    assert_eq!(Some(error(worst)), exact);
    assert!(error(first) > results["metrics"][0]["limit"].as_f64().unwrap());
}

#[test]
fn a_study_with_a_long_name_and_many_keys_can_be_read_on_a_desk_and_on_a_phone() {
    let Some(mut browser) = Browser::start("sweep_long", FLAT) else { return };
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().join("scenes");
    let text = fs::read_to_string(fixture()).unwrap().replace("../../../scenes", scenes.to_str().unwrap());
    let name = "what_a_heavier_payload_and_a_late_torque_do_to_the_tracking_of_two_rods";
    let mut text = text.replace("\"rods\"", &format!("{name:?}"));
    let more =
        ["robot.joint.1.friction.viscous", "robot.joint.2.friction.viscous", "robot.joint.2.mass", "plant.masses.1"];
    for key in more {
        text += &format!("\n[[vary]]\nkey = {key:?}\nuniform = [0.9, 1.1]\n");
    }
    let study = folder("long").join("long.toml");
    fs::write(&study, text).unwrap();
    let (out, _) = studied("long_out", &study, 12);
    for window in WINDOWS {
        open(&mut browser, &out.join("report.html"), window);
        let labels = browser.value("[...document.querySelectorAll('figure text')].map((text) => text.textContent)");
        assert!(more.iter().all(|key| list(&labels).contains(&json!(key))), "{labels}");
    }
    assert_eq!(browser.complaints(), [""; 0]);
}

#[test]
fn runs_in_a_fault_have_a_row_of_their_own_on_a_desk_and_on_a_phone() {
    let Some(mut browser) = Browser::start("sweep_faults", FLAT) else { return };
    let (out, results) = of_rows("page_faults", &prepared("host-sim/tests/fixtures/study.toml", 11), &rods());
    let results = serde_json::to_value(&results).unwrap();
    assert_eq!(results["broken_off"]["share"]["count"], 4);
    for window in WINDOWS {
        open(&mut browser, &out.join("report.html"), window);
        shows_the_distributions(&mut browser, &results, &cells(&out.join("runs.csv")));
    }
    assert_eq!(browser.complaints(), [""; 0]);
}
