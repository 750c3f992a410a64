//! Scripts for engines: their shards merge to the bytes of one process.

use crate::program::{at_its_fixtures, printed, told};
use crate::sweep::{folder, unbroken};
use std::fs;
use std::path::Path;
use std::process::Command;

fn submit(engine: &str, out: &Path) -> String {
    let mut command = at_its_fixtures();
    command.args(["sweep", "tests/fixtures/study.toml", "--submit", engine, "--shards", "5", "--out"]).arg(out);
    printed(command.output().unwrap())
}

#[test]
fn the_scripts_of_every_engine_do_the_shards_and_merge_them() {
    let whole = folder("submit_whole");
    let mut command = at_its_fixtures();
    printed(command.args(["sweep", "tests/fixtures/study.toml", "--quiet", "--out"]).arg(&whole).output().unwrap());
    for (engine, own) in [("hyperqueue", "submit.sh"), ("slurm", "submit.sbatch")] {
        let out = folder(&format!("submit_{engine}"));
        assert!(submit(engine, &out).contains(own));
        for number in 1..=5 {
            let script = |environment: &str, line: &str| {
                let mut command = Command::new("sh");
                command.current_dir(&out).env(environment, number.to_string()).args(["-c", line]);
                command
            };
            let mut task = match engine {
                "hyperqueue" => script("HQ_TASK_ID", "exec ./shard.sh \"$HQ_TASK_ID\""),
                _ => script("SLURM_ARRAY_TASK_ID", "exec sh submit.sbatch"),
            };
            printed(task.env("NEWTAU", env!("CARGO_BIN_EXE_newtau")).output().unwrap());
        }
        let mut merge = Command::new(out.join("merge.sh"));
        printed(merge.env("NEWTAU", env!("CARGO_BIN_EXE_newtau")).output().unwrap());
        for name in ["runs.csv", "manifest.json", "results.json"] {
            let same = fs::read(out.join("whole").join(name)).unwrap() == fs::read(whole.join(name)).unwrap();
            assert!(same, "{engine}: {name}");
        }
    }
}

#[test]
fn a_folder_whose_shards_have_begun_takes_no_other_number_of_them() {
    let out = folder("submit_again");
    submit("slurm", &out);
    // The same call again, before and after a shard was run.
    submit("hyperqueue", &out);
    let mut shard = Command::new(out.join("shard.sh"));
    printed(shard.env("NEWTAU", env!("CARGO_BIN_EXE_newtau")).arg("3").output().unwrap());
    submit("slurm", &out);
    let script = fs::read_to_string(out.join("shard.sh")).unwrap();
    let mut other = at_its_fixtures();
    other.args(["sweep", "tests/fixtures/study.toml", "--submit", "slurm", "--shards", "8", "--out"]).arg(&out);
    let (code, _, error) = told(other.output().unwrap());
    let error = unbroken(&error);
    assert!(code == 2 && error.contains("holds shard 3/5") && error.contains("expected --shards 5"), "{error}");
    assert_eq!(fs::read_to_string(out.join("shard.sh")).unwrap(), script);
    // A missing shard is an error, not a folder to skip.
    let mut merge = Command::new(out.join("merge.sh"));
    let (code, _, error) = told(merge.env("NEWTAU", env!("CARGO_BIN_EXE_newtau")).output().unwrap());
    assert!(code == 2 && unbroken(&error).contains("no shard has the runs from 0 to 15"), "{error}");
}

#[test]
fn engines_retry_and_count_as_they_were_asked_to() {
    let text = |engine: &str, name: &str| {
        let out = folder(&format!("told_{engine}"));
        submit(engine, &out);
        fs::read_to_string(out.join(name)).unwrap()
    };
    let slurm = text("slurm", "submit.sbatch");
    for line in ["#SBATCH --array=1-5", "#SBATCH --requeue", "#SBATCH --cpus-per-task=1"] {
        assert!(slurm.lines().any(|found| found == line), "{slurm}");
    }
    let hyperqueue = text("hyperqueue", "submit.sh");
    assert!(hyperqueue.contains("--array 1-5 --cpus 1 --crash-limit 10"), "{hyperqueue}");
}
