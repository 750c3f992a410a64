//! Pages of the documentation whose tables the commands write themselves.

use crate::cli::run::in_file;
use crate::failure::Failure;
use std::fs;
use std::path::Path;

/// A page with places for what is measured: what stands between `<!-- measured: NAME -->` and `<!-- end measured: NAME -->`.
pub(crate) struct Document<'a> {
    path: &'a Path,
    text: String,
}

impl<'a> Document<'a> {
    /// The page, if it has the lines between which each of these goes: better known before hours of work than after.
    pub(crate) fn read(path: &'a Path, places: &[&str]) -> Result<Self, Failure> {
        let text =
            fs::read_to_string(path).map_err(|error| Failure::Input(miette::miette!("{}: {error}", path.display())))?;
        let mut document = Self { path, text };
        places.iter().try_for_each(|name| document.put(name, ""))?;
        Ok(document)
    }

    /// Replace what stands between the lines of this name.
    pub(crate) fn put(&mut self, name: &str, measured: &str) -> Result<(), Failure> {
        let (begin, end) = (format!("<!-- measured: {name} -->\n"), format!("<!-- end measured: {name} -->"));
        let place = self.text.find(&begin).map(|at| at + begin.len()).zip(self.text.find(&end));
        let Some((from, to)) = place.filter(|(from, to)| from <= to) else {
            return Err(Failure::Input(miette::miette!(
                "{}: expected the lines `{}` and `{end}`, between which the table goes",
                self.path.display(),
                begin.trim_end()
            )));
        };
        self.text.replace_range(from..to, &format!("\n{measured}\n"));
        Ok(())
    }

    /// Where pictures that the page shows lie.
    pub(crate) fn folder(&self) -> &Path {
        self.path.parent().unwrap_or(Path::new("."))
    }

    pub(crate) fn write(&self) -> Result<(), Failure> {
        fs::write(self.path, &self.text).map_err(|error| in_file(self.path, &error))
    }
}
