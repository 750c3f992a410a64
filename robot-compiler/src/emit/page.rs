//! Pages of the documentation with tables that commands and tasks write.

use std::io::{Error, ErrorKind, Result};
use std::path::{Path, PathBuf};

/// A page with sections for measured text: each lies between `<!-- measured: NAME -->` and `<!-- end measured: NAME -->`.
#[derive(Clone, Debug)]
pub struct Page {
    path: PathBuf,
    text: String,
}

impl Page {
    /// Reads the page and checks that it has the marker lines of every section. So a missing section is reported before hours of
    /// work, not after.
    ///
    /// # Errors
    /// The file cannot be read, or lacks a section. Every message begins with the path.
    pub fn read(path: impl Into<PathBuf>, places: &[&str]) -> Result<Self> {
        let path = path.into();
        let text = std::fs::read_to_string(&path).map_err(|error| named(&path, &error))?;
        let mut page = Self { path, text };
        places.iter().try_for_each(|name| page.put(name, ""))?;
        Ok(page)
    }

    /// Replaces the text between the lines of this name.
    ///
    /// # Errors
    /// The page lacks the lines.
    pub fn put(&mut self, name: &str, measured: &str) -> Result<()> {
        let (begin, end) = (format!("<!-- measured: {name} -->\n"), format!("<!-- end measured: {name} -->"));
        let place = self.text.find(&begin).map(|at| at + begin.len()).zip(self.text.find(&end));
        let Some((from, to)) = place.filter(|(from, to)| from <= to) else {
            let begin = begin.trim_end();
            let problem = format!("expected the lines `{begin}` and `{end}`, between which the table goes");
            return Err(Error::new(ErrorKind::InvalidData, format!("{}: {problem}", self.path.display())));
        };
        self.text.replace_range(from..to, &format!("\n{}\n\n", measured.trim_end()));
        Ok(())
    }

    /// Writes the page back.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(&self) -> Result<()> {
        std::fs::write(&self.path, &self.text).map_err(|error| named(&self.path, &error))
    }
}

fn named(path: &Path, error: &Error) -> Error {
    Error::new(error.kind(), format!("{}: {error}", path.display()))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a page that is missing should stop the test")]
mod tests {
    use super::Page;

    #[test]
    fn only_what_stands_between_the_lines_changes() {
        let path = std::env::temp_dir().join(format!("newtau_page_{}.md", std::process::id()));
        std::fs::write(&path, "a\n<!-- measured: x -->\nold\n<!-- end measured: x -->\nb\n").unwrap();
        let mut page = Page::read(&path, &["x"]).unwrap();
        page.put("x", "| new |\n").unwrap();
        page.write().unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text, "a\n<!-- measured: x -->\n\n| new |\n\n<!-- end measured: x -->\nb\n");
        let lacks = Page::read(&path, &["x", "y"]).unwrap_err().to_string();
        assert!(lacks.contains("newtau_page_") && lacks.contains("<!-- measured: y -->"), "{lacks}");
        std::fs::remove_file(&path).unwrap();
    }
}
