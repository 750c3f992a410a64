//! Command names of earlier versions, and their present names.

use sim::failure::Failure;

/// Earlier name and present name. The earlier names are recognised for one release.
pub const RENAMED: [(&str, &str); 18] = [
    ("bound", "choose bound"),
    ("compare", "report"),
    ("contact", "model contact"),
    ("dynamics", "model dynamics"),
    ("energy", "model energy"),
    ("excite", "identify excite"),
    ("export", "model export"),
    ("extremes", "choose margins"),
    ("info", "model info"),
    ("kernel", "model kernel"),
    ("key", "firmware key"),
    ("linkage", "model linkage"),
    ("merge", "sweep merge"),
    ("motion", "model motion"),
    ("replay", "connect replay"),
    ("statics", "model statics"),
    ("terms", "model terms"),
    ("trade", "choose trade"),
];

/// Rejects a command name of an earlier version, and gives the present one.
///
/// # Errors
/// [`Failure::Input`]: the word is such a name.
pub fn refuse(word: Option<&str>) -> Result<(), Failure> {
    let renamed = RENAMED.iter().find(|(earlier, _)| Some(*earlier) == word);
    renamed.map_or(Ok(()), |(earlier, present)| {
        Err(Failure::Input(miette::miette!(
            help = format!("expected `newtau {present}`; `newtau --help` lists all commands"),
            "`{earlier}` is not a command any more"
        )))
    })
}
