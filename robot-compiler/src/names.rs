//! Choices by name: one list for each type, read by files, command lines, tables and the build of a firmware.

use core::mem::discriminant;

/// A type whose values are chosen by name.
pub trait Named: Copy + Send + Sync + 'static {
    /// Name, meaning and value of each, in the order in which help lists them. The meaning is empty if the name explains
    /// itself.
    const NAMES: &'static [(&'static str, &'static str, Self)];
}

/// The name of a value. Numbers inside the value do not affect it.
#[must_use]
pub fn name<T: Named>(value: T) -> &'static str {
    let same = |known: &T| discriminant(known) == discriminant(&value);
    T::NAMES.iter().find(|(_, _, known)| same(known)).map_or("", |(name, ..)| name)
}

/// The value of a name.
///
/// # Errors
/// An unknown name; the message lists the known ones.
pub fn named<T: Named>(name: &str) -> Result<T, String> {
    T::NAMES.iter().find(|(known, ..)| *known == name).map(|(_, _, value)| *value).ok_or_else(|| {
        let known: Vec<&str> = T::NAMES.iter().map(|(known, ..)| *known).collect();
        format!("{name}: expected one of {}", known.join(", "))
    })
}
