//! Rust source without comments, layout and tests, which change no program.

use anyhow::{Result, anyhow};
use proc_macro2::{Delimiter, TokenStream, TokenTree};

/// Tokens of a source file in order, without comments of any kind and without items under `#[cfg(test)]`.
pub(super) fn of(source: &str) -> Result<String> {
    let stream: TokenStream = source.parse().map_err(|error| anyhow!("no Rust: {error}"))?;
    let mut text = String::new();
    write(stream, &mut text);
    Ok(text)
}

fn write(stream: TokenStream, text: &mut String) {
    let trees: Vec<TokenTree> = stream.into_iter().collect();
    let mut at = 0;
    while let Some(tree) = trees.get(at) {
        if let Some((length, attribute)) = attribute(&trees[at..]) {
            at += length;
            match attribute.as_str() {
                "cfg(test)" => at += item(&trees[at..]),
                attribute if attribute.starts_with("doc") => {}
                attribute => *text += &format!("#[{attribute}] "),
            }
            continue;
        }
        match tree {
            TokenTree::Group(group) => {
                let (open, close) = match group.delimiter() {
                    Delimiter::Parenthesis => ("(", ")"),
                    Delimiter::Brace => ("{", "}"),
                    Delimiter::Bracket => ("[", "]"),
                    Delimiter::None => ("", ""),
                };
                *text += open;
                write(group.stream(), text);
                *text += close;
            }
            other => *text += &format!("{other} "),
        }
        at += 1;
    }
}

/// Attribute at the beginning of these trees: its number of trees, and its contents without blanks.
fn attribute(trees: &[TokenTree]) -> Option<(usize, String)> {
    let is = |tree: Option<&TokenTree>, sign| matches!(tree, Some(TokenTree::Punct(punct)) if punct.as_char() == sign);
    if !is(trees.first(), '#') {
        return None;
    }
    let inner = usize::from(is(trees.get(1), '!'));
    match trees.get(1 + inner) {
        Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Bracket => {
            Some((2 + inner, group.stream().to_string().split_whitespace().collect()))
        }
        _ => None,
    }
}

/// Length of an item: up to its first semicolon or braces.
fn item(trees: &[TokenTree]) -> usize {
    let ends = |tree: &TokenTree| match tree {
        TokenTree::Punct(punct) => punct.as_char() == ';',
        TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
        _ => false,
    };
    trees.iter().position(ends).map_or(trees.len(), |at| at + 1)
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]
mod tests {
    use super::of;

    const SOURCE: &str = "//! Doc.\n/// Doc.\n#[inline]\npub fn f(x: u8) -> u8 { x + 1 }\n#[cfg(test)]\nmod tests { fn g() {} }\nconst C: u8 = 2;\n";

    #[test]
    fn layout_comments_and_tests_do_not_count() {
        let same = "#[inline] pub fn f(x:u8)->u8{\n // why\n x+1 /* or */ }\n/** D */ const C : u8=2 ;\n#[cfg(test)] #[path = \"a.rs\"] mod other;";
        assert_eq!(of(SOURCE).unwrap(), of(same).unwrap());
    }

    #[test]
    fn a_number_a_sign_a_name_and_an_attribute_count() {
        let tokens = of(SOURCE).unwrap();
        for (from, to) in
            [("x + 1", "x + 2"), ("x + 1", "x - 1"), ("fn f", "fn g"), ("#[inline]", "#[cold]"), ("u8 = 2", "u8 = 3")]
        {
            assert_ne!(of(&SOURCE.replace(from, to)).unwrap(), tokens, "{from} to {to}");
        }
        assert_ne!(of("a b").unwrap(), of("ab").unwrap());
    }

    #[test]
    fn a_file_that_is_no_rust_is_refused() {
        assert!(of("fn f( {").is_err());
    }
}
