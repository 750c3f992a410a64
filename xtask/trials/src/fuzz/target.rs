//! A fuzz target.

/// A fuzz target.
#[derive(Clone, Copy, Debug)]
pub struct FuzzTarget {
    /// Name for `cargo fuzz run`.
    pub name: &'static str,
    /// Function that panics if a property does not hold.
    pub check: fn(&[u8]),
    /// Inputs to start with, most of them valid.
    pub examples: fn() -> Vec<Vec<u8>>,
    /// Words with a meaning in an input: a dictionary in libFuzzer's format.
    pub words: &'static str,
}
