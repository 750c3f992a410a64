//! Words of a column's heading.

/// Splits a name into lower-case words: at other characters, between digits and letters, and at humps of camel case.
pub(super) fn words(text: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut last: Option<char> = None;
    for c in text.chars() {
        if c.is_alphanumeric() {
            let begins = last
                .is_none_or(|last| last.is_numeric() != c.is_numeric() || (last.is_lowercase() && c.is_uppercase()));
            if begins {
                words.push(String::new());
            }
            if let Some(word) = words.last_mut() {
                word.extend(c.to_lowercase());
            }
        }
        last = c.is_alphanumeric().then_some(c);
    }
    words
}

pub(super) fn without(words: &[String], begin: usize, length: usize) -> Vec<String> {
    [&words[..begin], &words[begin + length..]].concat()
}

pub(super) fn found(words: &[String], part: &[String]) -> Option<usize> {
    (!part.is_empty()).then(|| words.windows(part.len()).position(|window| window == part)).flatten()
}

pub(super) fn any(words: &[String], of: &[&str]) -> bool {
    words.iter().any(|word| of.contains(&word.as_str()))
}

/// Splits a heading at its last bracket: the text before, in and after it. `None` if that bracket contains only numbers (an index), or if no name
/// precedes it.
pub(super) fn bracket(heading: &str) -> Option<(&str, &str, &str)> {
    let open = heading.rfind(['[', '(', '{'])?;
    let close = open + heading[open..].find([']', ')', '}'])?;
    // `qd / (rad/s)` and `[N m]` are units; `[0]` and `[1, 2]` are indices.
    let inner = heading[open + 1..close].trim();
    let name = heading[..open].trim_end_matches([' ', '/', '_']);
    let says = inner.chars().any(|c| !c.is_numeric() && !c.is_whitespace() && c != ',');
    (says && !name.trim().is_empty()).then_some((name, inner, &heading[close + 1..]))
}
