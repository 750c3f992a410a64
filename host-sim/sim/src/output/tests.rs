use super::Output;
use crate::marker::MARKER;
use std::fs;
use std::path::{Path, PathBuf};

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("host-sim-output-{}-{name}", std::process::id()));
    fs::remove_dir_all(&folder).ok();
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn said(result: Result<(), crate::failure::Failure>) -> String {
    let failure = result.unwrap_err();
    assert_eq!(failure.code(), crate::failure::INPUT);
    let report = failure.report();
    format!("{report}; {}", report.help().map(|help| help.to_string()).unwrap_or_default())
}

fn write(force: bool, path: &Path, text: &str) -> Result<(), crate::failure::Failure> {
    Output::new(force).write(path, text)
}

#[test]
fn a_file_of_the_user_is_overwritten_by_force_only() {
    let path = folder("file").join("arm.toml");
    fs::write(&path, "mine").unwrap();
    let problem = said(write(false, &path, "new"));
    assert!(problem.contains("the file exists") && problem.contains("--force"), "{problem}");
    assert_eq!(fs::read_to_string(&path).unwrap(), "mine");
    write(true, &path, "new").unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "new");
    // A folder that the program did not create gets no marker, so the same file is rejected again.
    assert!(!path.with_file_name(MARKER).exists());
    assert!(write(false, &path, "newer").is_err());
}

#[test]
fn a_file_in_a_folder_of_ours_is_replaced_until_somebody_changes_it() {
    let path = folder("ours").join("a/b/arm.toml");
    write(false, &path, "first").unwrap();
    write(false, &path, "second").unwrap();
    fs::write(&path, "edited").unwrap();
    let problem = said(write(false, &path, "third"));
    assert!(problem.contains("was changed since"), "{problem}");
    assert_eq!(fs::read_to_string(&path).unwrap(), "edited");
    let own = path.with_file_name("own.toml");
    fs::write(&own, "of the user").unwrap();
    assert!(said(write(false, &own, "x")).contains("the file exists"));
}

#[test]
fn an_input_is_kept_in_spite_of_force_and_by_any_of_its_names() {
    let folder = folder("input");
    let path = folder.join("log.csv");
    fs::write(&path, "data").unwrap();
    let mut names = vec![
        path.clone(),
        folder.join("./log.csv"),
        folder.join("../").join(folder.file_name().unwrap()).join("log.csv"),
    ];
    #[cfg(unix)]
    {
        let link = folder.join("link.csv");
        std::os::unix::fs::symlink(&path, &link).unwrap();
        names.push(link);
    }
    for name in names {
        let problem = said(Output::new(true).reads(&path).write(&name, "x"));
        assert!(problem.contains("is an input"), "{problem}");
    }
    assert_eq!(fs::read_to_string(&path).unwrap(), "data");
    Output::new(true).reads(&folder.join("another.csv")).write(&path, "x").unwrap();
}

#[test]
fn two_outputs_in_one_file_are_refused() {
    let path = folder("two").join("x.csv");
    let mut output = Output::new(true);
    output.file(&path).unwrap();
    assert!(said(output.file(&path)).contains("two outputs"));
}

#[test]
fn a_folder_of_the_user_is_not_mixed_into_and_one_of_ours_is_used_again() {
    let folder = folder("folder");
    let names = ["log.csv", "report.html", "summary.json"];
    let run = |force| {
        let mut output = Output::new(force);
        output.folder(&folder, &names)?;
        let files = [folder.join("log.csv"), folder.join("report.html")];
        files.iter().for_each(|file| fs::write(file, "run").unwrap());
        output.written(&files)
    };
    fs::write(folder.join("thesis.tex"), "years").unwrap();
    let problem = said(run(false));
    assert!(problem.contains("holds thesis.tex") && problem.contains("did not make"), "{problem}");
    run(true).unwrap();
    run(false).unwrap();
    assert_eq!(fs::read_to_string(folder.join("thesis.tex")).unwrap(), "years");
    // A file of the user with the name of an output.
    fs::write(folder.join("summary.json"), "drawn by hand").unwrap();
    assert!(said(run(false)).contains("summary.json: the file exists"));
    fs::remove_file(folder.join("summary.json")).unwrap();
    fs::write(folder.join("log.csv"), "noted by hand").unwrap();
    assert!(said(run(false)).contains("log.csv: the file was changed"));
    // An empty folder is accepted.
    let empty = folder.join("empty");
    fs::create_dir(&empty).unwrap();
    Output::new(false).folder(&empty, &names).unwrap();
    assert!(empty.join(MARKER).exists());
    assert!(said(Output::new(true).folder(&folder.join("thesis.tex"), &names)).contains("is a file"));
}

#[test]
fn devices_are_written_to() {
    #[cfg(unix)]
    write(false, Path::new("/dev/null"), "x").unwrap();
}
