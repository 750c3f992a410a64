//! No command overwrites an existing file without permission.

use crate::program::{at_the_top, new, told};
use std::fs;
use std::path::{Path, PathBuf};

/// An empty folder of a test, in which its commands run.
fn work(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("outputs").join(test);
    fs::create_dir_all(new(&folder)).unwrap();
    fs::write(folder.join("script.txt"), "home\n").unwrap();
    fs::write(folder.join("log.csv"), "time,q_1,q_2,tau_1,tau_2\n0,0,0,0,0\n").unwrap();
    fs::copy(top("robots/planar2r.toml"), folder.join("arm.toml")).unwrap();
    folder
}

fn top(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().unwrap().join(path)
}

/// A command in a folder; words that begin with `@` are paths of the project.
fn sim(folder: &Path, line: &str) -> (i32, String) {
    let words = line.split_whitespace().map(|word| match word.strip_prefix('@') {
        Some(path) => top(path).to_str().unwrap().to_owned(),
        None => word.to_owned(),
    });
    let (code, out, error) = told(at_the_top().current_dir(folder).args(words).output().unwrap());
    (code, out + &error)
}

/// Every command that writes a file, with FILE in its place.
const FILES: [&str; 16] = [
    "doctor --bundle FILE",
    "model export @robots/planar2r.toml --urdf --out FILE",
    "identify excite @robots/planar2r.toml --friction --out FILE",
    "import @host-sim/tests/fixtures/traps.urdf --out FILE",
    "model motion log.csv --scene @scenes/planar2r_sine.toml --out FILE",
    "identify arm.toml --log log.csv --out FILE",
    "identify arm.toml --log log.csv --predict FILE",
    "choose @scenes/planar2r_sine.toml --max-tracking-error 1 --out FILE",
    "run @scenes/planar2r_sine.toml --duration 0.01 --quiet --out run --mcap FILE",
    "run @scenes/planar2r_sine.toml --duration 0.01 --quiet --out run --report FILE",
    "connect @scenes/planar2r_swing.toml --target desk --script script.txt --record FILE",
    "report a b --report FILE",
    "firmware key new FILE",
    "firmware key page arm.key --out FILE",
    "connect @scenes/planar2r_swing.toml --target desk --script dump.txt",
    "connect @scenes/planar2r_swing.toml --target desk --script record.txt",
];

/// Every command that writes into a folder, with FOLDER in its place, and a file that it writes there.
const FOLDERS: [(&str, &str); 11] = [
    ("run @scenes/planar2r_sine.toml --duration 0.01 --quiet --out FOLDER", "log.csv"),
    ("model energy @scenes/planar2r_sine.toml --duration 0.01 --out FOLDER", "energy.json"),
    ("model statics @robots/planar2r.toml --q 0,0.1 --sweep shoulder --out FOLDER", "report.html"),
    ("model linkage @robots/chapter12/four_bar.toml --out FOLDER", "driven.csv"),
    ("model linkage @robots/chapter12/four_bar.toml --simulate 0.5 --duration 0.01 --out FOLDER", "summary.json"),
    ("identify arm.toml --log log.csv --report FOLDER", "index.html"),
    ("choose trade @scenes/planar2r_sine.toml --out FOLDER", "trade.csv"),
    ("sweep @host-sim/tests/fixtures/study.toml --quiet --out FOLDER", "results.json"),
    ("sweep @host-sim/tests/fixtures/study.toml --quiet --replay 1 --out FOLDER", "log.csv"),
    ("sweep @host-sim/tests/fixtures/study.toml --submit slurm --shards 2 --out FOLDER", "submit.sbatch"),
    ("sweep merge shards --quiet --out FOLDER", "runs.csv"),
];

#[test]
fn no_command_overwrites_a_file_of_the_user() {
    let folder = work("files");
    for name in ["a", "b"] {
        assert_eq!(sim(&folder, &format!("run @scenes/planar2r_sine.toml --duration 0.01 --quiet --out {name}")).0, 0);
    }
    assert_eq!(sim(&folder, "firmware key new arm.key").0, 0);
    let file = folder.join("mine.txt");
    for line in FILES {
        fs::write(&file, "mine").unwrap();
        fs::write(folder.join("dump.txt"), "home\ndump mine.txt\n").unwrap();
        fs::write(folder.join("record.txt"), "home\nrecord mine.txt\n").unwrap();
        let (code, said) = sim(&folder, &line.replace("FILE", "mine.txt"));
        // In a session the command is rejected, and the session goes on.
        let expected = if line.contains("dump.txt") || line.contains("record.txt") { 3 } else { 2 };
        assert_eq!(code, expected, "{line}: {said}");
        // A key is not overwritten with force either.
        let words = if line.starts_with("firmware key") {
            ["mine.txt", "never overwritten"]
        } else {
            ["mine.txt: the file exists", "--force"]
        };
        assert!(words.iter().all(|words| said.contains(words)), "{line}: {said}");
        assert_eq!(fs::read_to_string(&file).unwrap(), "mine", "{line}");
    }
}

#[test]
fn no_command_writes_into_a_folder_of_the_user() {
    let folder = work("folders");
    assert_eq!(sim(&folder, "sweep @host-sim/tests/fixtures/study.toml --quiet --out shards/1").0, 0);
    let mine = folder.join("mine");
    for (line, name) in FOLDERS {
        fs::create_dir_all(new(&mine)).unwrap();
        fs::write(mine.join(name), "mine").unwrap();
        fs::write(mine.join("notes.txt"), "mine").unwrap();
        let (code, said) = sim(&folder, &line.replace("FOLDER", "mine"));
        assert_eq!(code, 2, "{line}: {said}");
        assert!(said.contains("mine") && said.contains("newtau did not make it"), "{line}: {said}");
        assert!(said.contains("--force"), "{line}: {said}");
        let mut held: Vec<String> =
            fs::read_dir(&mine).unwrap().map(|entry| entry.unwrap().file_name().to_str().unwrap().to_owned()).collect();
        held.sort();
        let mut expected = [name, "notes.txt"];
        expected.sort_unstable();
        assert_eq!(held, expected, "{line}");
        assert_eq!(fs::read_to_string(mine.join(name)).unwrap(), "mine", "{line}");
    }
}

/// Fast commands, and the files that they write.
const TWICE: [(&str, &str); 12] = [
    ("run @scenes/planar2r_sine.toml --duration 0.01 --quiet", "out/planar2r_sine/log.csv"),
    ("run @scenes/planar2r_sine.toml --duration 0.01 --quiet --out out/a --mcap out/a.mcap", "out/a.mcap"),
    ("run @scenes/planar2r_sine.toml --duration 0.01 --quiet --out out/b --report out/b.html", "out/b.html"),
    ("report out/a out/planar2r_sine", "out/compare.html"),
    ("model export @robots/planar2r.toml --urdf --out out/arm.urdf", "out/arm.urdf"),
    ("identify excite @robots/planar2r.toml --friction --out out/slow.toml", "out/slow.toml"),
    ("import @host-sim/tests/fixtures/traps.urdf --out out/imported.toml", "out/imported.toml"),
    ("model energy @scenes/planar2r_sine.toml --duration 0.01", "out/planar2r_sine/energy.json"),
    ("model statics @robots/planar2r.toml --q 0,0.1 --sweep shoulder --out out/statics", "out/statics/report.html"),
    ("model linkage @robots/chapter12/four_bar.toml --out out/linkage", "out/linkage/driven.csv"),
    ("sweep @host-sim/tests/fixtures/study.toml --quiet --replay 1 --out out/run", "out/run/log.csv"),
    ("connect @scenes/planar2r_swing.toml --target desk --script script.txt --record out/x.log", "out/x.log"),
];

#[test]
fn what_host_sim_wrote_is_replaced_until_somebody_changes_it() {
    let folder = work("twice");
    for (line, file) in TWICE {
        let file = folder.join(file);
        for _ in 0..2 {
            let (code, said) = sim(&folder, line);
            assert_eq!(code, 0, "{line}: {said}");
        }
        let written = fs::read(&file).unwrap();
        fs::write(&file, "edited").unwrap();
        let (code, said) = sim(&folder, line);
        assert_eq!(code, 2, "{line}: {said}");
        assert!(said.contains("was changed since newtau wrote it") && said.contains("--force"), "{line}: {said}");
        assert_eq!(fs::read_to_string(&file).unwrap(), "edited", "{line}");
        let (code, said) = sim(&folder, &format!("{line} --force"));
        assert!(code == 0 && fs::read(&file).unwrap().len() > "edited".len(), "{line}: {said}");
        // Files with times differ between runs; the sizes of the other files do not.
        assert!(!written.is_empty(), "{line}");
    }
}

#[test]
fn an_input_is_never_overwritten_with_force_neither() {
    let folder = work("inputs");
    fs::copy(top("scenes/planar2r_sine.toml"), folder.join("scene.toml")).unwrap();
    let text = fs::read_to_string(folder.join("scene.toml")).unwrap();
    let robot = top("robots/planar2r.toml");
    fs::write(folder.join("scene.toml"), text.replace("../robots/planar2r.toml", robot.to_str().unwrap())).unwrap();
    fs::copy(top("host-sim/tests/fixtures/traps.urdf"), folder.join("arm.urdf")).unwrap();
    assert_eq!(sim(&folder, "sweep @host-sim/tests/fixtures/study.toml --quiet --out shards/1").0, 0);
    for (line, input) in [
        ("model export arm.toml --urdf --out arm.toml", "arm.toml"),
        ("identify excite arm.toml --friction --out ./arm.toml", "arm.toml"),
        ("import arm.urdf --out arm.urdf", "arm.urdf"),
        ("model motion log.csv --scene scene.toml --out log.csv", "log.csv"),
        ("identify arm.toml --log log.csv --out log.csv", "log.csv"),
        ("identify arm.toml --log log.csv --validate log.csv --predict ../inputs/log.csv", "log.csv"),
        ("run scene.toml --duration 0.01 --quiet --out run --mcap scene.toml", "scene.toml"),
        ("run scene.toml --duration 0.01 --quiet --out run --report scene.toml", "scene.toml"),
        ("connect @scenes/planar2r_swing.toml --target desk --script script.txt --record script.txt", "script.txt"),
        ("sweep merge shards/1 --quiet --out shards/1", "shards/1/runs.csv"),
    ] {
        let before = fs::read(folder.join(input)).unwrap();
        let (code, said) = sim(&folder, &format!("{line} --force"));
        assert_eq!(code, 2, "{line}: {said}");
        assert!(line.starts_with("sweep merge") || said.contains("is an input of this command"), "{line}: {said}");
        assert!(fs::read(folder.join(input)).unwrap() == before, "{line}");
    }
}

#[test]
fn shards_are_merged_again_with_force_only() {
    let folder = work("merged");
    let merge = "sweep merge shards --quiet --out whole";
    assert_eq!(sim(&folder, "sweep @host-sim/tests/fixtures/study.toml --quiet --out shards/1").0, 0);
    assert_eq!(sim(&folder, merge).0, 0);
    let table = fs::read(folder.join("whole/runs.csv")).unwrap();
    let (code, said) = sim(&folder, merge);
    assert!(code == 2 && said.contains("holds runs already") && said.contains("--force"), "{said}");
    fs::write(folder.join("whole/results.md"), "notes").unwrap();
    let (code, said) = sim(&folder, &format!("{merge} --force"));
    assert_eq!(code, 0, "{said}");
    assert!(fs::read(folder.join("whole/runs.csv")).unwrap() == table);
    assert_ne!(fs::read_to_string(folder.join("whole/results.md")).unwrap(), "notes");
    // A sweep continues in its folder, and keeps a page that a user has edited.
    let sweep = "sweep @host-sim/tests/fixtures/study.toml --quiet --out shards/1";
    assert_eq!(sim(&folder, sweep).0, 0);
    fs::write(folder.join("shards/1/results.md"), "notes").unwrap();
    let (code, said) = sim(&folder, sweep);
    assert!(code == 2 && said.contains("results.md: the file was changed"), "{said}");
    assert_eq!(sim(&folder, &format!("{sweep} --force")).0, 0);
}

#[test]
fn two_outputs_in_one_file_are_refused() {
    let folder = work("one");
    let (code, said) = sim(&folder, "identify arm.toml --log log.csv --out x --predict x");
    assert!(code == 2 && said.contains("two outputs of this command in one file"), "{said}");
}
