//! A test's source as tokens, its functions and its imports: enough of the grammar to find out which function calls which.

/// A token. Comments and blanks are omitted; a text literal is stored without its quotes.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(crate) enum Token {
    Name(String),
    Text(String),
    Sign(char),
}

/// The end of a text literal that opens at `at` (a quote), and its content.
fn literal(all: &[char], at: usize, hashes: Option<usize>) -> (usize, String) {
    let mut end = at + 1;
    while end < all.len() {
        let closed = all[end] == '"' && (0..hashes.unwrap_or(0)).all(|n| all.get(end + 1 + n) == Some(&'#'));
        if closed {
            break;
        }
        end += if all[end] == '\\' && hashes.is_none() { 2 } else { 1 };
    }
    let inside = all[at + 1..end.min(all.len())].iter().collect();
    (end + 1 + hashes.unwrap_or(0), inside)
}

/// The end of a block comment that opens at `at`; block comments nest.
fn block_comment(all: &[char], mut at: usize) -> usize {
    let mut depth = 0;
    while at < all.len() {
        match (all[at], all.get(at + 1)) {
            ('/', Some('*')) => (depth, at) = (depth + 1, at + 2),
            ('*', Some('/')) => (depth, at) = (depth - 1, at + 2),
            _ => at += 1,
        }
        if depth == 0 {
            break;
        }
    }
    at
}

pub(crate) fn tokens(text: &str) -> Vec<Token> {
    let all: Vec<char> = text.chars().collect();
    let of_name = |c: char| c.is_alphanumeric() || c == '_';
    let (mut found, mut at) = (Vec::new(), 0);
    while at < all.len() {
        let next = all.get(at + 1).copied();
        match all[at] {
            '/' if next == Some('/') => at += all[at..].iter().take_while(|c| **c != '\n').count(),
            '/' if next == Some('*') => at = block_comment(&all, at),
            '"' => {
                let (end, inside) = literal(&all, at, None);
                found.push(Token::Text(inside));
                at = end;
            }
            // A character, which may be a brace; a lifetime has no second quote.
            '\'' if next == Some('\\') => at += 3 + all[at + 3..].iter().take_while(|c| **c != '\'').count() + 1,
            '\'' if all.get(at + 2) == Some(&'\'') => at += 3,
            c if of_name(c) => {
                let end = at + all[at..].iter().take_while(|c| of_name(**c)).count();
                let name: String = all[at..end].iter().collect();
                let hashes = all[end..].iter().take_while(|c| **c == '#').count();
                if name == "r" && all.get(end + hashes) == Some(&'"') {
                    let (behind, inside) = literal(&all, end + hashes, Some(hashes));
                    found.push(Token::Text(inside));
                    at = behind;
                } else {
                    found.push(Token::Name(name));
                    at = end;
                }
            }
            c => {
                if !c.is_whitespace() {
                    found.push(Token::Sign(c));
                }
                at += 1;
            }
        }
    }
    found
}

fn sign(token: Option<&Token>, wanted: char) -> bool {
    token == Some(&Token::Sign(wanted))
}

fn name(token: Option<&Token>) -> Option<&str> {
    match token {
        Some(Token::Name(name)) => Some(name),
        _ => None,
    }
}

/// A function or a macro: its name, and the token positions of its signature and body.
pub(crate) struct Function {
    pub(crate) name: String,
    /// The type for which it implements a trait, if it does.
    pub(crate) implements_for: Option<String>,
    pub(crate) start: usize,
    pub(crate) end: usize,
}

/// The end of the braces that open first after `at`, if they open before the item ends.
fn body_end(all: &[Token], at: usize) -> Option<usize> {
    let (mut round, mut braces) = (0, 0);
    for (n, token) in all.iter().enumerate().skip(at) {
        match token {
            // Patterns of the arguments may have braces too.
            Token::Sign('(' | '[') if braces == 0 => round += 1,
            Token::Sign(')' | ']') if braces == 0 => round -= 1,
            Token::Sign('{') if round == 0 => braces += 1,
            Token::Sign('}') if round == 0 => {
                braces -= 1;
                if braces == 0 {
                    return Some(n + 1);
                }
            }
            Token::Sign(';') if round == 0 && braces == 0 => return None,
            _ => {}
        }
    }
    None
}

/// Implementations of traits: the type, and the token positions.
fn implementations(all: &[Token]) -> Vec<(String, usize, usize)> {
    let mut found = Vec::new();
    for start in (0..all.len()).filter(|start| name(all.get(*start)) == Some("impl")) {
        let Some(end) = body_end(all, start) else { continue };
        let head = all[start..end].iter().take_while(|token| **token != Token::Sign('{'));
        let of = head.skip_while(|token| **token != Token::Name("for".to_owned())).nth(1);
        found.extend(name(of).map(|of| (of.to_owned(), start, end)));
    }
    found
}

pub(crate) fn functions(all: &[Token]) -> Vec<Function> {
    let implementations = implementations(all);
    let mut found = Vec::new();
    for start in 0..all.len() {
        let named = match name(all.get(start)) {
            Some("fn") => start + 1,
            Some("macro_rules") if sign(all.get(start + 1), '!') => start + 2,
            _ => continue,
        };
        if let (Some(name), Some(end)) = (name(all.get(named)), body_end(all, named)) {
            let around = implementations.iter().find(|(_, from, to)| (*from..*to).contains(&start));
            let implements_for = around.map(|(of, ..)| of.clone());
            found.push(Function { name: name.to_owned(), implements_for, start: named + 1, end });
        }
    }
    found
}

/// A name imported by a `use`: its path, and its name here.
pub(crate) struct Import {
    pub(crate) path: Vec<String>,
    pub(crate) alias: String,
}

/// Reads a `use` tree from `at` on; returns its end.
fn tree(all: &[Token], mut at: usize, before: &[String], found: &mut Vec<Import>) -> usize {
    let mut path = before.to_vec();
    loop {
        match all.get(at) {
            Some(Token::Name(part)) if part == "as" => {
                let alias = name(all.get(at + 1)).unwrap_or("_").to_owned();
                found.push(Import { path, alias });
                return at + 2;
            }
            Some(Token::Name(part)) => path.push(part.clone()),
            Some(Token::Sign('{')) => {
                at += 1;
                while !sign(all.get(at), '}') && at < all.len() {
                    at = tree(all, at, &path, found);
                    at += usize::from(sign(all.get(at), ','));
                }
                return at + 1;
            }
            Some(Token::Sign(':' | '*')) => {}
            _ => {
                let alias = path.last().cloned().unwrap_or_default();
                if alias == "self" {
                    path.pop();
                }
                let alias = path.last().cloned().unwrap_or(alias);
                found.push(Import { path, alias });
                return at;
            }
        }
        at += 1;
    }
}

pub(crate) fn imports(all: &[Token]) -> Vec<Import> {
    let mut found = Vec::new();
    for at in 0..all.len() {
        if name(all.get(at)) == Some("use") {
            tree(all, at + 1, &[], &mut found);
        }
    }
    found
}

/// A call: the name called, and the name before it (`None` for a method after a dot, `Some("")` for a bare name).
#[derive(PartialEq, Eq, Debug)]
pub(crate) struct Call<'a> {
    pub(crate) name: &'a str,
    pub(crate) on: Option<&'a str>,
}

/// The name before the `::` at `at`, skipping type arguments.
fn qualifier(all: &[Token], colons: usize) -> Option<&str> {
    let mut at = colons.checked_sub(1)?;
    if sign(all.get(at), '>') {
        let mut depth = 0;
        loop {
            depth += i32::from(sign(all.get(at), '>')) - i32::from(sign(all.get(at), '<'));
            at = at.checked_sub(1)?;
            if depth == 0 {
                break;
            }
        }
        while sign(all.get(at), ':') {
            at = at.checked_sub(1)?;
        }
    }
    name(all.get(at))
}

/// Calls in a body, and functions that are passed by name.
pub(crate) fn calls(body: &[Token]) -> Vec<Call<'_>> {
    let mut found = Vec::new();
    for at in 0..body.len() {
        let Some(called) = name(body.get(at)) else { continue };
        let next = |n: usize| body.get(at + n);
        let before = |n: usize| at.checked_sub(n).and_then(|at| body.get(at));
        let generic = sign(next(1), ':') && sign(next(2), ':') && sign(next(3), '<');
        let called_here = sign(next(1), '(') || sign(next(1), '!') || generic;
        let ends = sign(next(1), ')') || sign(next(1), ',');
        let qualified = sign(before(1), ':') && sign(before(2), ':');
        let handed_on = ends && (qualified || sign(before(1), '(') || sign(before(1), ','));
        if name(before(1)) == Some("fn") || !(called_here || handed_on) {
            continue;
        }
        let on = if sign(before(1), '.') {
            None
        } else if qualified {
            Some(qualifier(body, at - 2).unwrap_or(""))
        } else {
            Some("")
        };
        found.push(Call { name: called, on });
    }
    found
}
