//! Calls from a test to functions of the workspace, direct or through the helpers of its file and of the folders next to it.

use super::source::{Function, Import, Token, calls, functions, imports, tokens};
use std::collections::BTreeSet;
use std::path::Path;

/// Files of helpers that tests of this package share.
const HELPERS: [&str; 2] = ["dynamics-core/tests/common", "dynamics-core/tests/chapter12"];

pub(crate) struct Source {
    tokens: Vec<Token>,
    functions: Vec<Function>,
    imports: Vec<Import>,
}

impl Source {
    pub(crate) fn of(text: &str) -> Self {
        let tokens = tokens(text);
        Self { functions: functions(&tokens), imports: imports(&tokens), tokens }
    }
}

/// A test's own file, followed by the helpers' files.
pub(crate) fn sources(root: &Path, file: &str) -> Vec<Source> {
    let own = std::fs::read_to_string(root.join(file)).unwrap_or_default();
    let mut texts = vec![own];
    let folders = HELPERS.iter().filter(|_| file.starts_with("dynamics-core"));
    for entry in folders.flat_map(|folder| std::fs::read_dir(root.join(folder)).unwrap()) {
        let path = entry.unwrap().path();
        if path != root.join(file) && path.extension().is_some_and(|e| e == "rs") {
            texts.push(std::fs::read_to_string(path).unwrap());
        }
    }
    texts.iter().map(|text| Source::of(text)).collect()
}

/// Function bodies that a test reaches, with their files.
pub(crate) struct Reached<'a> {
    sources: &'a [Source],
    bodies: Vec<(usize, &'a [Token])>,
}

impl<'a> Reached<'a> {
    /// Starts from the function `test` of the first source. A bare name is one of the same file or an imported one. A method, or a name after
    /// a type, may belong to any helper. An implementation of a trait counts if a counted body names its type.
    pub(crate) fn by(sources: &'a [Source], test: &str) -> Self {
        let mut reached = Self { sources, bodies: Vec::new() };
        let mut seen = BTreeSet::new();
        let mut next = vec![(0, test.to_owned())];
        let mut implementations: Vec<(usize, &Function)> = Vec::new();
        loop {
            let mut bodies: Vec<(usize, &Function)> = Vec::new();
            if let Some((file, name)) = next.pop() {
                if seen.insert((file, name.clone())) {
                    let named = sources[file].functions.iter().filter(|function| function.name == name);
                    let (of_traits, free) = named.map(|of| (file, of)).partition(|(_, of)| of.implements_for.is_some());
                    implementations.extend::<Vec<_>>(of_traits);
                    bodies = free;
                }
            } else {
                let named = |of: &Function| of.implements_for.as_ref().is_some_and(|name| reached.names(name));
                let found = implementations.iter().position(|(_, of)| named(of));
                let Some(found) = found else { break };
                bodies.push(implementations.swap_remove(found));
            }
            for (file, function) in bodies {
                let body = &sources[file].tokens[function.start..function.end];
                reached.bodies.push((file, body));
                for call in calls(body) {
                    let own = sources[file].functions.iter().any(|inner| inner.name == call.name);
                    let imported = sources[file].imports.iter().any(|import| {
                        let local = matches!(import.path.first().map(String::as_str), Some("super" | "crate"));
                        local && import.alias == call.name
                    });
                    let bare = call.on == Some("");
                    if own && !(bare && imported) {
                        next.push((file, call.name.to_owned()));
                    }
                    if imported || !bare {
                        next.extend((1..sources.len()).map(|other| (other, call.name.to_owned())));
                    }
                }
            }
        }
        reached
    }

    /// True if a name occurs in a body or its signature.
    fn names(&self, wanted: &str) -> bool {
        let name = Token::Name(wanted.to_owned());
        self.bodies.iter().any(|(_, body)| body.contains(&name))
    }

    /// True if a name occurs in a body, its signature, or the imports of its file.
    fn mentions(&self, wanted: &str) -> bool {
        let imported = |file: usize| self.sources[file].imports.iter().any(|import| import.alias == wanted);
        self.names(wanted) || self.bodies.iter().any(|(file, _)| imported(*file))
    }

    /// True if a command of the program is run: its name is passed as a text.
    pub(crate) fn runs(&self, command: &str) -> bool {
        self.bodies.iter().any(|(_, body)| body.contains(&Token::Text(command.to_owned())))
    }

    /// True if `item` of `owner` (a module, a type, or a trait) is called; a type is used when it is named. `alone` is true if no
    /// other function has this name: then the owner of a method need not be named.
    pub(crate) fn uses(&self, owner: &str, item: &str, alone: bool) -> bool {
        if item.starts_with(char::is_uppercase) {
            return self.mentions(item);
        }
        let of_type = owner.starts_with(char::is_uppercase);
        self.bodies.iter().any(|(file, body)| {
            let imports = &self.sources[*file].imports;
            let real = |alias: &str| {
                let import = imports.iter().find(|import| import.alias == alias);
                import.map_or_else(|| vec![alias.to_owned()], |import| import.path.clone())
            };
            calls(body).iter().any(|call| match call.on {
                None => of_type && call.name == item && (alone || self.mentions(owner)),
                Some("") => real(call.name).ends_with(&[owner.to_owned(), item.to_owned()]),
                Some(on) => call.name == item && real(on).last().is_some_and(|real| real == owner),
            })
        })
    }
}
