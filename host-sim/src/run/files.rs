//! Files of a run: log, summary and plots.

use crate::failure::{Failure, in_file};
use crate::run::plot;
use crate::run::report;
use crate::run::simulate::Run;
use robot_compiler::SceneFile;
use std::fs::{self, File};
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// A name that is one safe part of a path.
pub(crate) fn file_name(name: &str) -> String {
    let safe = |c: char| if c.is_alphanumeric() || matches!(c, '-' | '_') { c } else { '_' };
    let name: String = name.chars().map(safe).collect();
    if name.is_empty() { "scene".to_owned() } else { name }
}

/// Write the report of a run; returns the file.
pub(crate) fn write_report(run: &Run, scene: &SceneFile, path: &Path) -> Result<PathBuf, Failure> {
    let page = report::page(run, scene)?;
    fs::write(path, page.html()).map_err(|error| in_file(path, &error))?;
    Ok(path.to_owned())
}

/// Write log, summary and plots; returns the files.
pub(crate) fn write(run: &Run, name: &str, folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let log = folder.join("log.csv");
    let file = File::create(&log).map_err(|error| in_file(&log, &error))?;
    run.record.write_csv(BufWriter::new(file)).map_err(|error| in_file(&log, &error))?;
    let summary = folder.join("summary.json");
    let text = serde_json::to_string_pretty(&run.summary).map_err(|error| Failure::Output(error.into()))?;
    fs::write(&summary, text + "\n").map_err(|error| in_file(&summary, &error))?;
    let plots = plot::write_all(&run.record, &run.marks, name, folder).map_err(|error| in_file(folder, &error))?;
    Ok([log, summary].into_iter().chain(plots).collect())
}

#[cfg(test)]
mod tests {
    use super::file_name;

    #[test]
    fn a_scene_cannot_name_a_folder_elsewhere() {
        assert_eq!(file_name("puma560_pick"), "puma560_pick");
        assert_eq!(file_name("../../etc/x y"), "______etc_x_y");
        assert_eq!(file_name(""), "scene");
    }
}
