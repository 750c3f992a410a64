//! Impossible studies: each is rejected with file, line, field, the value found and the value expected.

use crate::program::{at_the_top, told};
use crate::sweep::{folder, unbroken};
use std::fs;
use std::path::Path;

/// Text of the study, its replacement, the line of the message, and words in it.
type Bad = (&'static str, &'static str, usize, &'static [&'static str]);

const BAD: [Bad; 33] = [
    ("name = \"rods\"", "", 1, &["name", "missing"]),
    ("name = \"rods\"", "nam = \"rods\"", 2, &["nam: unknown key", "did you mean `name`?"]),
    ("[runs]", "[run]", 5, &["run: unknown key", "did you mean `runs`?"]),
    ("planar2r_sine.toml", "planar2r_sin.toml", 3, &["scene: ", "planar2r_sin.toml: cannot be read"]),
    ("count = 40", "count = 0", 6, &["runs.count", "found 0"]),
    ("count = 40", "count = 4.5", 6, &["runs.count", "found the number 4.5"]),
    ("count = 40", "count = 40\nsobol = 40", 7, &["given beside `count`", "exactly one of"]),
    ("count = 40", "grid = true", 6, &["`plant.masses.2` has no `steps`"]),
    ("count = 40", "grid = false", 6, &["found false"]),
    ("seed = 7", "seed = -1", 7, &["runs.seed", "a whole number"]),
    ("\"plant.masses\" =", "\"plant.mases\" =", 11, &["plant.mases", "unknown key", "did you mean `masses`?"]),
    ("\"plant.masses\" =", "plant.masses =", 11, &["set.plant", "the whole path in quotes"]),
    ("[1.0, 1.0]", "[-1.0, 1.0]", 11, &["plant.masses", "found -1"]),
    ("\"plant.masses.2\"", "\"plant.masses.3\"", 14, &["`masses` has no `3`", "a number from 1 to 2"]),
    ("\"plant.masses.2\"", "\"plant.masses.elbwo\"", 14, &["`masses` has no `elbwo`", "did you mean `elbow`?"]),
    ("\"plant.masses.2\"", "\"robot\"", 14, &["found the key \"robot\""]),
    ("\"plant.masses.2\"", "\"plant..masses\"", 14, &["found the key \"plant..masses\""]),
    ("\"plant.masses.2\"", "\"name.x\"", 14, &["`name` is a value, which has no key `x`"]),
    ("\"plant.masses.2\"", "\"control.kernel\"", 14, &["control.kernel", "found the number"]),
    (
        "\"robot.joint.1.mass\"",
        "\"robot.joint.1.mas\"",
        18,
        &["the file has no such key", "beside `relative`; did you mean `mass`?"],
    ),
    ("\"robot.joint.1.mass\"", "\"robot.joint.hip.mass\"", 18, &["`joint` has no `hip`"]),
    ("uniform = [0.5, 2.0]", "uniform = [2.0, 0.5]", 15, &["found 2 to 0.5", "the lower one first"]),
    ("uniform = [0.5, 2.0]", "unifrom = [0.5, 2.0]", 15, &["unknown key", "did you mean `uniform`?"]),
    ("uniform = [0.5, 2.0]", "uniform = [0.5, 2.0]\nwhole = [1, 2]", 16, &["given beside `uniform`"]),
    ("uniform = [0.5, 2.0]", "uniform = [0.5, 2.0]\nsteps = 3", 6, &["`steps`, which only a grid takes"]),
    ("deviation = 0.2", "deviation = 0.0", 19, &["deviation", "above zero"]),
    ("within = [0.5, 1.5]", "within = [50.0, 60.0]", 19, &["farther than five deviations"]),
    ("whole = [0, 3]", "whole = [0.5, 3]", 28, &["whole numbers"]),
    ("name = \"tracking_max\"", "name = \"traking_max\"", 31, &["did you mean `tracking_max`?"]),
    ("joint = 1", "joint = 7", 36, &["metric[1].joint: found the integer 7", "expected a joint's number, 1 to 6"]),
    ("[runs]", "unset = [\"modle\"]\n[runs]", 5, &["modle: the file has no such key", "did you mean `model`?"]),
    ("joint = 1", "joint = 3", 0, &["metric `torque_peak.3`", "expected a joint from 1 to 2"]),
    ("name = \"settling_time\"", "name = \"tracking_max\"", 39, &["`tracking_max` is given twice"]),
];

#[test]
fn every_bad_study_is_refused_at_its_line() {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let good = fs::read_to_string(top.join("host-sim/tests/fixtures/study.toml")).unwrap();
    let good = good.replace("../../../scenes", top.join("scenes").to_str().unwrap());
    let out = folder("bad");
    for (from, to, line, words) in BAD {
        assert_eq!(good.matches(from).count(), 1, "{from}");
        let path = out.join("bad.toml");
        fs::write(&path, good.replace(from, to)).unwrap();
        let (code, printed, error) =
            told(at_the_top().arg("sweep").arg(&path).arg("--out").arg(out.join("none")).output().unwrap());
        assert_eq!((code, printed.as_str()), (2, ""), "{to}: {error}");
        let error = unbroken(&error);
        for word in words {
            assert!(error.contains(word), "{to}: no {word:?} in {error}");
        }
        let place = format!("bad.toml:{line}:");
        assert!(line < 2 || error.contains(&place), "{to}: no {place} in {error}");
    }
    assert!(!out.join("none").exists(), "nothing is written before the study is understood");
}

#[test]
fn options_that_contradict_are_refused() {
    let study = "scenes/studies/delay_stiffness.toml";
    for (options, words) in [
        (vec!["--runs", "5"], "is a grid, whose steps give its runs"),
        (vec!["--runs", "0"], "1..="),
        (vec!["--shard", "2/1"], "expected K/N"),
        (vec!["--submit", "slurm"], "--shards"),
        (vec!["--shards", "5"], "--submit"),
        (vec!["--submit", "slrum", "--shards", "5"], "slurm"),
        (vec!["--submit", "slurm", "--shards", "500"], "at most one for each of the 54 runs"),
        (vec!["--shard", "1/2", "--write"], "expected the whole study"),
        (vec!["--jobs", "0"], "zero"),
    ] {
        let (code, _, error) = told(at_the_top().args(["sweep", study]).args(&options).output().unwrap());
        assert!(code == 2 && error.contains(words), "{options:?}: {error}");
    }
}
