//! Pages of the documentation whose tables the commands write themselves.

use robot_compiler::emit::page::Page;
use sim::failure::Failure;
use std::path::Path;

/// The page that `--write` names, with a place for each of these.
pub(crate) fn page(path: Option<&Path>, places: &[&str]) -> Result<Option<Page>, Failure> {
    let read = |path| Page::read(path, places).map_err(|error| Failure::Input(miette::miette!("{error}")));
    path.map(read).transpose()
}

/// Put what was measured into its place and write the page.
pub(crate) fn fill(mut page: Page, measured: &[(&str, String)]) -> Result<(), Failure> {
    let filled = measured.iter().try_for_each(|(place, text)| page.put(place, text));
    filled.and_then(|()| page.write()).map_err(Failure::Output)
}
