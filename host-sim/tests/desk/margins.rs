//! `choose margins`: each reported border is confirmed by a run on either side of it.

use crate::program::{at_the_top, new, printed, told};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};

const PICK: &str = "scenes/puma560_pick.toml";

fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("margins").join(test);
    fs::create_dir_all(new(&folder)).unwrap();
    folder
}

/// The pick with changes of its text, as a file.
fn changed(folder: &Path, name: &str, changes: &[(&str, String)]) -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().unwrap();
    let mut text = fs::read_to_string(root.join(PICK)).unwrap();
    let robot = root.join("robots/puma560.toml").display().to_string();
    for (from, to) in [("../robots/puma560.toml", robot)].iter().chain(changes) {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    let path = folder.join(name);
    fs::write(&path, text).unwrap();
    path
}

fn margins(scene: &str) -> Value {
    let out = printed(at_the_top().args(["choose", "margins", scene, "--json"]).output().unwrap());
    serde_json::from_str(&out).unwrap()
}

fn margin<'a>(found: &'a Value, quantity: &str) -> &'a Value {
    found["margins"].as_array().unwrap().iter().find(|margin| margin["quantity"] == quantity).unwrap()
}

/// True if the arm of a scene is lost, according to the summary of `run`.
fn is_lost(folder: &Path, scene: &Path) -> bool {
    let out = folder.join("run");
    let run = at_the_top().args(["run", "--json", "--no-report", "--force", "--out"]).arg(&out).arg(scene).output();
    let (_, summary, error) = told(run.unwrap());
    let summary: Value = serde_json::from_str(&summary).unwrap_or_else(|_| panic!("{error}"));
    !summary["faults"].as_array().unwrap().is_empty() || !summary["supervision"]["out_of_reach"].is_null()
}

#[test]
fn a_run_at_the_kept_value_keeps_the_arm_and_one_at_the_lost_value_loses_it() {
    let folder = folder("both");
    let found = margins(PICK);
    let delay = |ms: &Value| {
        let ticks = ms.as_f64().unwrap();
        changed(&folder, "delay.toml", &[("saturation = true", format!("saturation = true\ndelay = {ticks:.0}"))])
    };
    let masses = |factor: &Value| {
        let all = format!("friction = true\nmasses = [{}]", [factor.to_string().as_str(); 6].join(", "));
        changed(&folder, "masses.toml", &[("friction = true", all)])
    };
    let delay_margin = margin(&found, "delay");
    assert!(!is_lost(&folder, &delay(&delay_margin["kept"])), "{delay_margin}");
    assert!(is_lost(&folder, &delay(&delay_margin["lost"])), "{delay_margin}");
    let masses_margin = margin(&found, "masses");
    assert!(!is_lost(&folder, &masses(&masses_margin["kept"])), "{masses_margin}");
    assert!(is_lost(&folder, &masses(&masses_margin["lost"])), "{masses_margin}");
    // The border is found to within 3 %.
    let number = |margin: &Value, key: &str| margin[key].as_f64().unwrap();
    for quantity in ["masses", "friction", "rate"] {
        let margin = margin(&found, quantity);
        let ratio = number(margin, "lost") / number(margin, "kept");
        assert!((1.0..=1.03).contains(&ratio) || (0.97..=1.0).contains(&ratio), "{margin}");
    }
}

#[test]
fn a_stiffer_loop_bears_less_delay() {
    let folder = folder("stiffer");
    let soft = margins(PICK);
    let stiff = changed(&folder, "stiff.toml", &[("natural_frequency = 40.0", "natural_frequency = 120.0".to_owned())]);
    let stiff = margins(stiff.to_str().unwrap());
    let delay = |found: &Value| margin(found, "delay")["lost"].as_f64().unwrap();
    assert!(delay(&stiff) < 0.7 * delay(&soft), "{} {}", delay(&stiff), delay(&soft));
}

#[test]
fn an_arm_that_is_lost_as_it_is_and_a_number_that_a_scene_does_not_have_are_told() {
    let folder = folder("lost");
    let lost = changed(&folder, "late.toml", &[("saturation = true", "saturation = true\ndelay = 60".to_owned())]);
    let (code, out, error) = told(at_the_top().args(["choose", "margins"]).arg(lost).output().unwrap());
    assert_eq!((code, out.as_str()), (2, ""), "{error}");
    assert!(error.contains("the arm is lost as the scene is: fault 5"), "{error}");
    let found = margins("scenes/yam_move.toml");
    for quantity in ["delay", "encoder"] {
        assert!(margin(&found, quantity)["missing"].as_str().unwrap().contains("drives have their own"), "{found}");
    }
}
