//! Steps of a page: its commands, the output shown for them, and the files that the reader writes or edits.

/// A step of a page.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// A file that the reader writes.
    Write { file: String, text: String },
    /// A change of a file that the reader makes.
    Edit(Edit),
    /// A `console` block.
    Run(Console),
}

/// A change of a file.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Edit {
    pub(super) file: String,
    /// Start of the line that is replaced, or before which the text is inserted.
    pub(super) start: String,
    pub(super) text: String,
    pub(super) keeps_the_line: bool,
}

/// A `console` block.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Console {
    /// Line of its fence, from 1.
    pub(super) line: usize,
    /// Calls of `newtau`, without the program's name and without comments.
    pub(super) calls: Vec<String>,
    pub(super) how: How,
    /// The `text` blocks that show its output: one directly below, and those with the comment `more output`.
    pub(super) shown: Vec<String>,
}

/// The test of a block's commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum How {
    NotRun,
    /// They succeed, but for the last one, which ends with this code.
    Compared {
        exit: i32,
    },
    NotCompared,
    Typed,
}

/// Steps of a page, and the page in whose folder it continues.
#[derive(Debug, Default)]
pub(super) struct Page {
    pub(super) steps: Vec<Step>,
    pub(super) after: Option<String>,
}
