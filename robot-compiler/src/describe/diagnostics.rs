//! Errors in a file: the location, the problem, and the expected value.

use super::snippet::Snippet;
use miette::{Diagnostic, LabeledSpan, SourceCode};
use std::fmt;
use std::ops::Range;
use std::path::Path;

/// A file and its text, to which errors refer.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    pub(crate) file: String,
    pub(crate) text: String,
}

/// An error in a robot or scene file that was rejected.
///
/// Displays as `file:line:column: field: problem` on one line. As a [`Diagnostic`] it also carries the text with the
/// location marked, and the expected value. `Debug` adds the expected value to the line: that is what cargo shows if `main` of a build script
/// returns the error.
pub struct FileError(Box<Details>);

struct Details {
    file: String,
    snippet: Option<Snippet>,
    line_column: Option<(usize, usize)>,
    field: String,
    problem: String,
    expected: String,
}

impl Source {
    /// An error about `field`, at `span` in the text.
    ///
    /// `problem` names what was found, `expected` what would have been right.
    pub(crate) fn error(
        &self,
        span: Range<usize>,
        field: impl Into<String>,
        problem: impl Into<String>,
        expected: impl Into<String>,
    ) -> FileError {
        let span = self.within(span);
        FileError(Box::new(Details {
            file: self.file.clone(),
            line_column: Some(self.line_column(span.start)),
            snippet: Some(Snippet::new(&self.file, &self.text, span)),
            field: shown(field),
            problem: shown(problem),
            expected: shown(expected),
        }))
    }

    /// The span cut to the text and moved to character boundaries, so that rendering cannot fail.
    fn within(&self, span: Range<usize>) -> Range<usize> {
        let boundary = |mut at: usize| {
            at = at.min(self.text.len());
            while !self.text.is_char_boundary(at) {
                at -= 1;
            }
            at
        };
        let start = boundary(span.start);
        start..boundary(span.end).max(start)
    }

    fn line_column(&self, at: usize) -> (usize, usize) {
        let before = self.text.get(..at).unwrap_or_default();
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let column = before.get(line_start..).unwrap_or_default().chars().count();
        (before.matches('\n').count() + 1, column + 1)
    }
}

impl FileError {
    /// An error that concerns a file as a whole, without a line: it cannot be read, it is of another kind than requested, or a program found that
    /// the value of `field` does not work.
    pub fn whole_file(
        file: &Path,
        field: impl Into<String>,
        problem: impl Into<String>,
        expected: impl Into<String>,
    ) -> Self {
        let file = file.display().to_string();
        Self(Box::new(Details {
            file: shown(file),
            snippet: None,
            line_column: None,
            field: shown(field),
            problem: shown(problem),
            expected: shown(expected),
        }))
    }

    /// The file, under the name with which it was opened.
    #[must_use]
    pub fn file(&self) -> &str {
        &self.0.file
    }

    /// Line and column, both counted from 1; `None` when the whole file is at fault.
    #[must_use]
    pub fn line_column(&self) -> Option<(usize, usize)> {
        self.0.line_column
    }

    /// The field, as a path: `joint 2 (elbow).inertia.xx`.
    #[must_use]
    pub fn field(&self) -> &str {
        &self.0.field
    }

    /// The problem: what was found.
    #[must_use]
    pub fn problem(&self) -> &str {
        &self.0.problem
    }

    /// The expected value or format.
    #[must_use]
    pub fn expected(&self) -> &str {
        &self.0.expected
    }
}

impl FileError {
    /// The marked text on one line of at most `width` columns; empty if the whole file is at fault.
    pub(crate) fn quote(&self, width: usize) -> String {
        self.0.snippet.as_ref().map_or(String::new(), |snippet| snippet.quote(width))
    }
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let details = &self.0;
        write!(f, "{}", details.file)?;
        if let Some((line, column)) = details.line_column {
            write!(f, ":{line}:{column}")?;
        }
        if !details.field.is_empty() {
            write!(f, ": {}", details.field)?;
        }
        write!(f, ": {}", details.problem)
    }
}

impl fmt::Debug for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self}; expected {}", self.0.expected)
    }
}

impl std::error::Error for FileError {}

/// An error that is one text. `Debug` prints the same text, without quotes: that is what cargo shows if `main` of a build script returns the
/// error.
pub(crate) struct Message(pub(crate) String);

impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl fmt::Debug for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Message {}

impl Diagnostic for FileError {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        Some(Box::new(format!("expected {}", self.0.expected)))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.0.snippet.as_ref().map(|snippet| snippet as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let span = self.0.snippet.as_ref()?.label.clone();
        Some(Box::new(std::iter::once(LabeledSpan::new_with_span(Some("here".to_owned()), span))))
    }
}

/// Prepares a part of a message: escapes control characters, which could control the terminal, and limits text from a file to some lines.
fn shown(text: impl Into<String>) -> String {
    const SHOWN: usize = 2000;
    let text = text.into();
    let mut shown = String::with_capacity(text.len().min(SHOWN));
    for (count, c) in text.chars().enumerate() {
        if count == SHOWN {
            shown += "...";
            break;
        }
        if c.is_control() && c != '\n' {
            shown.extend(c.escape_default());
        } else {
            shown.push(c);
        }
    }
    shown
}

/// The known word nearest to an unknown one, or `None` if no known word is near enough.
pub(crate) fn nearest<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    // The comparison takes time proportional to the product of both lengths.
    const LONGEST: usize = 100;
    if word.len() > LONGEST {
        return None;
    }
    // Names in capitals are often written without them.
    let small = word.to_lowercase();
    let near = |candidate: &&'a str| strsim::damerau_levenshtein(&small, &candidate.to_lowercase());
    let best = known.iter().copied().filter(|known| known.len() <= LONGEST).min_by_key(|known| near(known))?;
    let longest = word.chars().count().max(best.chars().count());
    (near(&best) * 5 <= longest * 2).then_some(best)
}

/// Most names in a list.
const LISTED: usize = 40;

/// Lists the names as "a, b, c", followed by how many more there are.
pub(crate) fn listed(names: &[impl AsRef<str>]) -> String {
    let shown: Vec<&str> = names.iter().take(LISTED).map(AsRef::as_ref).collect();
    let list = shown.join(", ");
    match names.len().saturating_sub(LISTED) {
        0 => list,
        more => format!("{list}, and {more} more"),
    }
}

/// Returns "one of a, b, c", followed by a guess if there is one.
pub(crate) fn one_of(word: &str, known: &[&str]) -> String {
    let list = listed(known);
    nearest(word, known).map_or(format!("one of {list}"), |guess| format!("one of {list}; did you mean `{guess}`?"))
}
