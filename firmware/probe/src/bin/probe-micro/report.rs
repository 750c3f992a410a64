//! Times all loops and prints the results.

use crate::stretches::{Data, Stretch, all};
use core::fmt;

/// Times every loop twice, and prints the second time, with warm caches.
pub(crate) fn report(
    data: &mut Data,
    time: impl Fn(&Stretch, &mut Data) -> u32,
    mut write: impl FnMut(fmt::Arguments<'_>),
) {
    write(format_args!("micro begin"));
    for stretch in all() {
        time(stretch, data);
        let count = time(stretch, data);
        write(format_args!("micro {} {count}", stretch.name()));
    }
    write(format_args!("micro end {}", all().len()));
}
