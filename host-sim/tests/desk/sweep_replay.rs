//! One run of a study in full: it has the same numbers and the files of `run`, and replaces no file of a user.
#![allow(clippy::float_cmp, reason = "the same bits are demanded")]

use crate::program::{at_its_fixtures, at_the_top, printed, told};
use crate::sweep::{cells, folder, sweep, unbroken};
use serde_json::Value;
use std::fs;
use std::path::Path;

#[test]
fn a_replay_is_the_run_in_full_and_a_scene_of_its_own() {
    let (out, replay, again) = (folder("replayed"), folder("replay"), folder("replay_again"));
    sweep("tests/fixtures/study.toml", &out, &["--quiet"]);
    let row = &cells(&out.join("runs.csv"))[24];
    let copy = out.join("study.toml");
    let shown = sweep(copy.to_str().unwrap(), &replay, &["--replay", "23"]);
    assert!(shown.contains("log.csv") && shown.contains("scene.toml"), "{shown}");
    let read = |folder: &Path| -> Value {
        serde_json::from_str(&fs::read_to_string(folder.join("summary.json")).unwrap()).unwrap()
    };
    assert_eq!(read(&replay)["torque_peak"][0].as_f64().unwrap(), row[6].parse::<f64>().unwrap());
    assert_eq!(row[0], "23");
    let mut run = at_the_top();
    run.arg("run").arg(replay.join("scene.toml")).arg("--quiet").arg("--out").arg(&again);
    printed(run.output().unwrap());
    for field in ["tracking_max", "torque_peak", "torque_chatter", "ticks", "law"] {
        assert_eq!(read(&replay)[field], read(&again)[field], "{field}");
    }
    assert_eq!(fs::read(replay.join("log.csv")).unwrap(), fs::read(again.join("log.csv")).unwrap());
    let page = out.join("compared.html");
    let mut compare = at_its_fixtures();
    printed(compare.arg("report").arg(&replay).arg(&again).arg("--report").arg(&page).output().unwrap());
    assert!(fs::read_to_string(&page).unwrap().contains("viewer-data"));
    let mut beyond = at_its_fixtures();
    beyond.args(["sweep", "tests/fixtures/study.toml", "--replay", "40", "--out"]).arg(&again);
    let (code, _, error) = told(beyond.output().unwrap());
    assert!(code == 2 && error.contains("expected a run from 0 to 39"), "{error}");
}

#[test]
fn a_replay_replaces_neither_a_person_s_scene_nor_the_files_of_shards_to_come() {
    let replay = |out: &Path, run: &str| {
        let mut command = at_its_fixtures();
        command.args(["sweep", "tests/fixtures/study.toml", "--quiet", "--replay", run, "--out"]).arg(out);
        command.output().unwrap()
    };
    for name in ["scene.toml", "robot.toml"] {
        let own = folder("own_scene");
        fs::write(own.join(name), "mine").unwrap();
        let (code, _, error) = told(replay(&own, "1"));
        let error = unbroken(&error);
        assert!(code == 2 && error.contains(&format!("has another {name}")) && error.contains("--out"), "{error}");
        assert_eq!(fs::read_dir(&own).unwrap().count(), 1, "nothing is written");
        assert_eq!(fs::read_to_string(own.join(name)).unwrap(), "mine");
    }
    let submitted = folder("replay_submitted");
    let mut submit = at_its_fixtures();
    submit.args(["sweep", "tests/fixtures/study.toml", "--submit", "slurm", "--shards", "4", "--out"]).arg(&submitted);
    printed(submit.output().unwrap());
    let scene = fs::read(submitted.join("scene.toml")).unwrap();
    let (code, _, error) = told(replay(&submitted, "1"));
    assert!(code == 2 && unbroken(&error).contains("holds a study"), "{error}");
    assert_eq!(fs::read(submitted.join("scene.toml")).unwrap(), scene);
    let own = folder("replay_again_there");
    printed(replay(&own, "1"));
    printed(replay(&own, "1"));
    let (code, _, error) = told(replay(&own, "2"));
    assert!(code == 2 && unbroken(&error).contains("the same run wrote"), "{error}");
}
