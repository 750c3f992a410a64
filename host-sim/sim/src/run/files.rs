//! Files of a run: log, summary and report.

use crate::failure::{Failure, in_file};
use crate::pages;
use crate::run::report;
use crate::run::simulate::Run;
use robot_compiler::SceneFile;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// Makes a name safe as one part of a path.
pub fn file_name(name: &str) -> String {
    let safe = |c: char| if c.is_alphanumeric() || matches!(c, '-' | '_') { c } else { '_' };
    let name: String = name.chars().map(safe).collect();
    if name.is_empty() { "scene".to_owned() } else { name }
}

/// A path as one word for a shell.
pub fn shell_word(path: &Path) -> String {
    let path = path.display().to_string();
    let plain = |c: char| c.is_alphanumeric() || matches!(c, '/' | '.' | '_' | '-' | '+' | ',' | ':' | '@' | '%');
    if !path.is_empty() && path.chars().all(plain) { path } else { format!("'{}'", path.replace('\'', "'\\''")) }
}

/// Writes the report of a run. Returns the file.
pub fn write_report(run: &Run, scene: &SceneFile, path: &Path) -> Result<PathBuf, Failure> {
    let page = report::page(run, scene)?;
    pages::write(path, &page)?;
    Ok(path.to_owned())
}

/// Writes log and summary. Returns the files.
pub fn write(run: &Run, folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let log = folder.join("log.csv");
    let file = File::create(&log).map_err(|error| in_file(&log, &error))?;
    run.record.write_csv(BufWriter::new(file)).map_err(|error| in_file(&log, &error))?;
    let summary = folder.join("summary.json");
    let text = serde_json::to_string_pretty(&run.summary).map_err(|error| Failure::Output(error.into()))?;
    fs::write(&summary, text + "\n").map_err(|error| in_file(&summary, &error))?;
    Ok(vec![log, summary])
}

#[cfg(test)]
mod tests {
    use super::{file_name, shell_word};
    use std::path::Path;

    #[test]
    fn a_scene_cannot_name_a_folder_elsewhere() {
        assert_eq!(file_name("puma560_pick"), "puma560_pick");
        assert_eq!(file_name("../../etc/x y"), "______etc_x_y");
        assert_eq!(file_name(""), "scene");
    }

    #[test]
    fn a_path_is_one_word_of_a_shown_command_and_is_quoted_only_where_it_must_be() {
        let word = |path: &str| shell_word(Path::new(path));
        assert_eq!(word("out/pick_1/study.toml"), "out/pick_1/study.toml");
        assert_eq!(word("/a b/it's"), "'/a b/it'\\''s'");
        assert_eq!((word("$HOME"), word("")), ("'$HOME'".to_owned(), "''".to_owned()));
    }
}
