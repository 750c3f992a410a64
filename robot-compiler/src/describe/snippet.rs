//! The lines of a file around an error, short enough for a screen.

use miette::{MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents};
use std::ops::Range;

/// Widest line that is shown whole, columns.
const WIDTH: usize = 200;
/// Columns shown before the error in a wider line.
const BEFORE: usize = 60;
/// Most lines that are shown.
const LINES: usize = 12;

/// A part of a text, with its position in it.
#[derive(Debug)]
struct TextPart {
    text: String,
    start: usize,
    /// Line, column, counted from 0, and number of lines.
    place: (usize, usize, usize),
}

/// The lines around an error, and the error's position.
#[derive(Debug)]
pub(super) struct Snippet {
    file: String,
    shown: TextPart,
    here: TextPart,
    /// The part of the error's span that is shown.
    pub(super) label: Range<usize>,
}

impl Snippet {
    /// The line before, the lines of `span`, and the line after; only the first columns of long lines and the first lines of long spans.
    pub(super) fn new(file: &str, text: &str, span: Range<usize>) -> Self {
        let whole = part(text, &span, 1);
        let fits = whole.text.lines().count() <= LINES && whole.text.lines().all(|line| line.chars().count() <= WIDTH);
        let here = part(text, &(span.start..span.start), 0);
        let (shown, label) = if fits { (whole, span) } else { cut(text, &span, here.place) };
        let [shown, here] = [shown, here].map(|part| TextPart { text: printable(&part.text), ..part });
        Self { file: file.to_owned(), shown, here, label }
    }
}

impl Snippet {
    /// The marked text on one line; only the first columns of a long one.
    pub(super) fn quote(&self, width: usize) -> String {
        let inside = |at: usize| at.saturating_sub(self.shown.start);
        let marked = self.shown.text.get(inside(self.label.start)..inside(self.label.end)).unwrap_or_default();
        let line = marked.split_whitespace().collect::<Vec<_>>().join(" ");
        let mut short: String = line.chars().take(width).collect();
        if short.len() < line.len() {
            short += "...";
        }
        short
    }
}

/// The lines of a span with `around` lines before and after, in miette's form.
fn part(text: &str, span: &Range<usize>, around: usize) -> TextPart {
    let asked = SourceSpan::new(span.start.into(), span.len());
    match text.read_span(&asked, around, around) {
        Ok(found) => TextPart {
            text: String::from_utf8_lossy(found.data()).into_owned(),
            start: found.span().offset(),
            place: (found.line(), found.column(), found.line_count()),
        },
        // Cannot happen, because a span is limited to the text before.
        Err(_) => TextPart { text: String::new(), start: span.start, place: (0, 0, 0) },
    }
}

/// A piece of the line in which a span starts, and the part of the span inside it.
fn cut(text: &str, span: &Range<usize>, place: (usize, usize, usize)) -> (TextPart, Range<usize>) {
    let (before, behind) = text.split_at(span.start);
    let line = before.rfind('\n').map_or(0, |newline| newline + 1);
    let start = before.char_indices().rev().take(BEFORE).map(|(at, _)| at).last().unwrap_or(span.start).max(line);
    let room = WIDTH - text.get(start..span.start).unwrap_or_default().chars().count();
    let width: usize = behind.chars().take(room).take_while(|c| !matches!(c, '\n' | '\r')).map(char::len_utf8).sum();
    let end = span.start + width;
    let text = text.get(start..end).unwrap_or_default().to_owned();
    (TextPart { text, start, place: (place.0, start - line, 1) }, span.start..span.end.min(end).max(span.start))
}

/// The text with characters that could control the terminal replaced; every byte keeps its position.
fn printable(text: &str) -> String {
    let shown = |c: char| match (c.is_control() && !matches!(c, '\n' | '\r' | '\t'), c.len_utf8()) {
        (false, _) => c,
        (true, 1) => '?',
        (true, _) => '\u{bf}',
    };
    text.chars().map(shown).collect()
}

impl SourceCode for Snippet {
    fn read_span<'a>(
        &'a self,
        _: &SourceSpan,
        lines_before: usize,
        _: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let part = if lines_before == 0 { &self.here } else { &self.shown };
        let (line, column, count) = part.place;
        let span = SourceSpan::new(part.start.into(), part.text.len());
        let data = part.text.as_bytes();
        Ok(Box::new(MietteSpanContents::new_named(self.file.clone(), data, span, line, column, count)))
    }
}
