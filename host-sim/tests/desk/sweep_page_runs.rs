//! A study's page in a real browser: the commands of its runs, long names, and a campaign's.

use crate::browser::{Browser, FLAT};
use crate::pages::{WINDOWS, open, rows};
use crate::sweep::folder;
use crate::sweep_page::{WORST, fixture, list, studied};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::process::Command;

#[test]
fn the_command_of_a_worst_run_repeats_it_wherever_the_study_lies() {
    let Some(mut browser) = Browser::start("sweep_command", FLAT) else { return };
    let (out, results) = studied("a study's $HOME", &fixture(), 40);
    let page = out.join("report.html");
    open(&mut browser, &page, WINDOWS[0]);
    let [(_, exact), (command, _)] = rows(&mut browser, WORST)[0].last_chunk().unwrap().clone();
    let first = results["failing"][0].as_u64().unwrap();
    let shown = browser.value("document.querySelector('pre.terminal').textContent");
    assert!(shown.as_str().unwrap().ends_with(&format!(" --replay {first} --out out/run_{first}")), "{shown}");
    let programs = Path::new(env!("CARGO_BIN_EXE_host-sim")).parent().unwrap();
    let path = format!("{}:{}", programs.display(), std::env::var("PATH").unwrap());
    for command in [command.as_str(), shown.as_str().unwrap()] {
        let done = Command::new("sh").args(["-c", command]).env("PATH", &path).current_dir(&out).output().unwrap();
        assert!(done.status.success(), "{command}: {done:?}");
    }
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
fn a_study_that_is_a_campaign_has_a_page_without_figures_or_commands() {
    let Some(mut browser) = Browser::start("sweep_campaign", FLAT) else { return };
    let study = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scenes/studies/campaign.toml");
    let (out, _) = studied("campaign_page", &study, 30);
    for window in WINDOWS {
        open(&mut browser, &out.join("report.html"), window);
        assert_eq!(browser.value("document.querySelectorAll('figure, pre').length"), 0);
        assert!(!browser.value("document.body.textContent").as_str().unwrap().contains("--replay"));
        // Every run is in one cell, as `failed/runs`.
        let cells = rows(&mut browser, "Failed of runs");
        let runs = cells.iter().flat_map(|row| &row[1..]).filter_map(|cell| cell.0.strip_prefix("0/"));
        assert_eq!(runs.map(|runs| runs.parse::<u64>().unwrap()).sum::<u64>(), 30);
    }
    assert_eq!(browser.complaints(), [""; 0]);
}
