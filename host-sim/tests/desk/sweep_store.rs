//! The folder of a study has the same bytes however the study is split, and whenever it is killed.

use crate::program::{at_its_fixtures, printed, told};
use crate::sweep::folder;
use sha2::{Digest, Sha256};
use sim::failure::Failure;
use sim::output::Output;
use sim::parallel::Jobs;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use studies::sweep::Prepared;
use studies::sweep::store::{self, Manifest, Progress, Shard};

fn study(runs: u64) -> Prepared {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/study.toml");
    Prepared::load(&path, Some(runs)).unwrap()
}

fn write(prepared: &Prepared, out: &Path, shard: &str, jobs: usize) -> Result<Manifest, Failure> {
    let jobs = Jobs::new(Some(jobs)).unwrap();
    let stop = AtomicBool::new(false);
    let progress = Progress { shard: shard.parse().unwrap(), jobs: &jobs, stop: &stop, after_block: &|_| {} };
    store::write(prepared, out, &progress).map(|done| done.manifest)
}

fn bytes(folder: &Path) -> (Vec<u8>, Vec<u8>) {
    (fs::read(folder.join("runs.csv")).unwrap(), fs::read(folder.join("manifest.json")).unwrap())
}

fn shards(prepared: &Prepared, name: &str, of: u64) -> Vec<PathBuf> {
    let part = |number: u64| {
        let out = folder(&format!("{name}_{number}_of_{of}"));
        write(prepared, &out, &format!("{number}/{of}"), 1 + (number % 2) as usize).unwrap();
        out
    };
    (1..=of).map(part).collect()
}

fn message(failure: Failure) -> String {
    let code = failure.code();
    let report = failure.report();
    let help = report.help().map_or(String::new(), |help| help.to_string());
    format!("{code}: {report} ({help})")
}

#[test]
fn shards_of_any_division_merge_to_the_bytes_of_one_process() {
    let prepared = study(17);
    let whole = folder("whole");
    write(&prepared, &whole, "1/1", 2).unwrap();
    let one = folder("one_thread");
    write(&prepared, &one, "1/1", 1).unwrap();
    assert!(bytes(&whole) == bytes(&one));
    for of in [1, 2, 3, 7, 17, 23] {
        let mut parts = shards(&prepared, "part", of);
        // The shards can be merged in any order.
        parts.reverse();
        let out = folder(&format!("merged_{of}"));
        fs::remove_dir(&out).unwrap();
        let (again, _) = store::merge(&parts, &out, &mut Output::default(), &|_| {}).unwrap();
        assert!(bytes(&out) == bytes(&whole), "{of} shards");
        assert_eq!(again.identity, prepared.identity);
    }
}

#[test]
fn a_kill_at_any_byte_resumes_to_the_same_bytes() {
    let prepared = study(6);
    let whole = folder("unkilled");
    let manifest = write(&prepared, &whole, "1/1", 1).unwrap();
    let (table, _) = bytes(&whole);
    let ends: Vec<usize> = table.iter().enumerate().filter(|(_, b)| **b == b'\n').map(|(at, _)| at + 1).collect();
    assert_eq!(ends.len(), 7);
    let out = folder("killed");
    for cut in (0..=table.len()).step_by(23).chain(ends.iter().copied()).chain([table.len()]) {
        // The manifest may state any block that ended before the cut, or one that the disk has lost since.
        for rows in [0, 2, 5] {
            let sure = ends[rows];
            let state = Manifest {
                rows: rows as u64,
                bytes: sure as u64,
                sha256: Sha256::digest(&table[..sure]).iter().map(|byte| format!("{byte:02x}")).collect(),
                ..manifest.clone()
            };
            state.write(&out).unwrap();
            fs::write(out.join("runs.csv"), &table[..cut]).unwrap();
            write(&prepared, &out, "1/1", 1).unwrap();
            assert!(bytes(&out) == bytes(&whole), "cut at {cut}, {rows} rows sure");
        }
    }
    // A kill before the first manifest.
    fs::remove_file(out.join("manifest.json")).unwrap();
    fs::write(out.join("runs.csv"), &table[..99]).unwrap();
    write(&prepared, &out, "1/1", 1).unwrap();
    assert!(bytes(&out) == bytes(&whole));
}

#[test]
fn a_kill_between_the_empty_table_and_its_manifest_can_be_continued() {
    let study = Path::new("tests/fixtures/study.toml");
    let out = folder("empty_table");
    fs::remove_dir(&out).unwrap();
    let sweep = || {
        let mut command = at_its_fixtures();
        command.arg("sweep").arg(study).args(["--runs", "3", "--shard", "1/2", "--quiet", "--out"]).arg(&out);
        told(command.output().unwrap())
    };
    assert_eq!(sweep().0, 0);
    // As after a kill: the folder is marked as newtau's, the table exists and is empty, and there is no manifest.
    fs::remove_file(out.join("manifest.json")).unwrap();
    fs::write(out.join("runs.csv"), "").unwrap();
    let (code, _, error) = sweep();
    assert_eq!(code, 0, "{error}");
    // A table that somebody filled is not overwritten.
    fs::remove_file(out.join("manifest.json")).unwrap();
    fs::write(out.join("runs.csv"), "mine\n").unwrap();
    assert_eq!(sweep().0, 2);
    assert_eq!(fs::read(out.join("runs.csv")).unwrap(), b"mine\n");
}

#[test]
fn a_killed_process_continues_where_its_last_block_ended() {
    let command = |out: &Path| {
        let mut command = at_its_fixtures();
        command.args(["sweep", "tests/fixtures/study.toml", "--runs", "3000", "--quiet", "--out"]).arg(out);
        command
    };
    let out = folder("struck");
    let mut child = command(&out).spawn().unwrap();
    let rows = |out: &Path| Manifest::read(out).unwrap().map_or(0, |manifest| manifest.rows);
    while rows(&out) == 0 && child.try_wait().unwrap().is_none() {
        std::thread::yield_now();
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let done = rows(&out);
    assert!(done > 0 && done < 3_000, "{done}");
    printed(command(&out).output().unwrap());
    let whole = folder("never_struck");
    printed(command(&whole).output().unwrap());
    for name in ["runs.csv", "manifest.json", "results.json", "results.md", "study.toml", "scene.toml", "robot.toml"] {
        assert!(fs::read(out.join(name)).unwrap() == fs::read(whole.join(name)).unwrap(), "{name}");
    }
    // A second call has nothing left to do.
    printed(command(&out).output().unwrap());
}

#[test]
fn two_processes_do_not_write_into_one_folder() {
    let prepared = study(4);
    let out = folder("locked");
    write(&prepared, &out, "1/1", 1).unwrap();
    let file = fs::File::open(out.join("runs.csv")).unwrap();
    file.lock().unwrap();
    let refused = message(write(&prepared, &out, "1/1", 1).unwrap_err());
    assert!(refused.starts_with("1: ") && refused.contains("another process writes here"), "{refused}");
}

#[test]
fn a_folder_of_another_study_or_shard_is_refused() {
    let out = folder("taken");
    write(&study(4), &out, "1/2", 1).unwrap();
    let refused = message(write(&study(5), &out, "1/2", 1).unwrap_err());
    assert!(refused.contains("holds 4 runs, not 5") && refused.starts_with("2: "), "{refused}");
    let refused = message(write(&study(4), &out, "2/2", 1).unwrap_err());
    assert!(refused.contains("holds shard 1/2, not 2/2"), "{refused}");
    fs::write(out.join("manifest.json"), "{}").unwrap();
    let refused = message(write(&study(4), &out, "1/2", 1).unwrap_err());
    assert!(refused.contains("manifest.json") && refused.contains("expected a manifest"), "{refused}");
}

#[test]
fn a_copy_of_the_study_replaces_no_file_of_a_person() {
    let out = folder("own_files");
    fs::write(out.join("study.toml"), "name = \"mine\"\n").unwrap();
    let refused = message(write(&study(4), &out, "1/1", 1).unwrap_err());
    assert!(refused.contains("has another study.toml"), "{refused}");
    assert_eq!(fs::read_to_string(out.join("study.toml")).unwrap(), "name = \"mine\"\n");
    let runs = folder("own_runs");
    write(&study(4), &runs, "1/1", 1).unwrap();
    let mut replay = at_its_fixtures();
    replay.args(["sweep", "tests/fixtures/study.toml", "--replay", "1", "--out"]).arg(&runs);
    let (code, _, error) = told(replay.output().unwrap());
    assert!(code == 2 && error.contains("holds a study"), "{error}");
}

#[test]
fn shards_that_do_not_belong_together_are_refused() {
    let prepared = study(9);
    let parts = shards(&prepared, "odd", 3);
    let other = shards(&study(10), "other", 3);
    let changed = |name: &str, change: &dyn Fn(&mut Manifest)| {
        let out = folder(&format!("odd_{name}"));
        for entry in fs::read_dir(&parts[1]).unwrap() {
            let path = entry.unwrap().path();
            fs::copy(&path, out.join(path.file_name().unwrap())).unwrap();
        }
        let mut manifest = Manifest::read(&out).unwrap().unwrap();
        change(&mut manifest);
        manifest.write(&out).unwrap();
        out
    };
    let version = changed("version", &|manifest| manifest.version = "9.9.9".to_owned());
    let build = changed("build", &|manifest| manifest.first_run = "0".to_owned());
    let half = changed("half", &|manifest| manifest.rows -= 1);
    let false_range = changed("range", &|manifest| manifest.from += 1);
    let damaged = changed("damaged", &|_| {});
    let mut table = fs::read(damaged.join("runs.csv")).unwrap();
    let place = table.len() - 9;
    table[place] ^= 1;
    fs::write(damaged.join("runs.csv"), table).unwrap();
    let [a, b, c] = [parts[0].clone(), parts[1].clone(), parts[2].clone()];
    let bad: [(&str, Vec<PathBuf>, &str); 11] = [
        ("hole", vec![a.clone(), c.clone()], "no shard has the runs from 3 to 5"),
        ("end", vec![a.clone(), b.clone()], "no shard has the runs from 6 to 8"),
        ("start", vec![b.clone(), c.clone()], "no shard has the runs from 0 to 2"),
        ("twice", vec![a.clone(), b.clone(), b.clone(), c.clone()], "two shards have the runs from 3 to 5"),
        ("other study", vec![a.clone(), other[1].clone(), c.clone()], "10 runs, not 9"),
        ("other version", vec![a.clone(), version, c.clone()], "version 9.9.9 of the program"),
        ("other build", vec![a.clone(), build, c.clone()], "another build"),
        ("not complete", vec![a.clone(), half, c.clone()], "has 2 of its 3 runs"),
        ("false range", vec![a.clone(), false_range, c.clone()], "expected the indices of this shard"),
        ("damaged", vec![a.clone(), damaged, c.clone()], "damaged or changed"),
        ("no shard", vec![a.clone(), folder("nothing"), c.clone()], "has no manifest.json"),
    ];
    let out = folder("refused_merge");
    for (name, parts, expected) in bad {
        let refused = message(store::merge(&parts, &out, &mut Output::default(), &|_| {}).unwrap_err());
        assert!(refused.starts_with("2: ") && refused.contains(expected), "{name}: {refused}");
        assert!(!out.join("manifest.json").exists(), "{name}: looks complete");
        assert!(!out.join("runs.new").exists(), "{name}: half a table is left");
    }
    let copy = a.join("study.toml");
    fs::write(&copy, fs::read_to_string(&copy).unwrap() + "# more\n").unwrap();
    let refused = message(store::merge(&[a, b, c], &out, &mut Output::default(), &|_| {}).unwrap_err());
    assert!(refused.contains("another study") && refused.contains("their files unchanged"), "{refused}");
}

#[test]
fn merge_and_shards_work_from_the_command_line() {
    let (whole, merged) = (folder("line_whole"), folder("line_merged"));
    let sweep = |out: &Path, more: &[&str]| {
        let mut command = at_its_fixtures();
        command.args(["sweep", "tests/fixtures/study.toml", "--out"]).arg(out).args(more);
        printed(command.output().unwrap())
    };
    let shown = sweep(&whole, &[]);
    let parts: Vec<PathBuf> = (1..=4).map(|number| folder(&format!("line_{number}"))).collect();
    for (part, number) in parts.iter().zip(1..) {
        let said = sweep(part, &["--shard", &format!("{number}/4")]);
        assert!(said.starts_with(&format!("shard {number}/4: 10 runs in ")), "{said}");
        assert!(!part.join("results.json").exists());
    }
    let mut merge = at_its_fixtures();
    let again = printed(merge.args(["sweep", "merge"]).args(&parts).arg("--out").arg(&merged).output().unwrap());
    for name in ["runs.csv", "manifest.json", "results.json", "results.md", "study.toml", "scene.toml", "robot.toml"] {
        assert!(fs::read(whole.join(name)).unwrap() == fs::read(merged.join(name)).unwrap(), "{name}");
    }
    assert_eq!(shown.lines().next(), again.lines().next());
    let mut twice = at_its_fixtures();
    let (code, _, error) =
        told(twice.args(["sweep", "merge"]).args(&parts).arg("--out").arg(&merged).output().unwrap());
    assert!(code == 2 && error.contains("holds runs already"), "{error}");
    let mut wrong = at_its_fixtures();
    wrong.args(["sweep", "tests/fixtures/study.toml", "--shard", "5/4"]);
    let (code, _, error) = told(wrong.output().unwrap());
    assert!(code == 2 && error.contains("expected K/N with K from 1 to N"), "{error}");
    assert!(Shard::WHOLE.is_whole());
}

#[test]
fn fifty_processes_of_which_one_is_killed_give_the_bytes_of_one() {
    let command = |out: &Path, more: &[&str]| {
        let mut command = at_its_fixtures();
        command.args(["sweep", "tests/fixtures/study.toml", "--runs", "2000", "--quiet", "--out"]).arg(out).args(more);
        command
    };
    let parts: Vec<PathBuf> = (1..=50).map(|number| folder(&format!("fifty_{number}"))).collect();
    for (part, number) in parts.iter().zip(1..) {
        let shard = format!("{number}/50");
        if number == 7 {
            let mut child = command(part, &["--shard", &shard]).spawn().unwrap();
            while !part.join("manifest.json").exists() && child.try_wait().unwrap().is_none() {
                std::thread::yield_now();
            }
            child.kill().unwrap();
            child.wait().unwrap();
        }
        printed(command(part, &["--shard", &shard, "--jobs", "1"]).output().unwrap());
    }
    let (whole, merged) = (folder("fifty_whole"), folder("fifty_merged"));
    printed(command(&whole, &[]).output().unwrap());
    let mut merge = at_its_fixtures();
    printed(merge.args(["sweep", "merge"]).args(&parts).args(["--quiet", "--out"]).arg(&merged).output().unwrap());
    for name in ["runs.csv", "manifest.json", "results.json"] {
        assert!(fs::read(whole.join(name)).unwrap() == fs::read(merged.join(name)).unwrap(), "{name}");
    }
}
