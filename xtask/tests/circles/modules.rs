//! The modules of a library or program, and resolution of the paths in them.

use super::graph::Graph;
use super::names::{self, Names, Use};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use syn::visit::Visit as _;
use syn::{Expr, ExprLit, Item, ItemMod, Lit, Meta};

/// A module, in its own file or inside its parent's.
struct Module {
    file: PathBuf,
    parent: Option<usize>,
    names: BTreeMap<String, Vec<Meaning>>,
    uses: Vec<Use>,
    paths: BTreeSet<Vec<String>>,
}

/// Meaning of a name within a module.
enum Meaning {
    Module(usize),
    /// An item of this module.
    Item(usize),
    /// A path from a `use`.
    Use(Vec<String>),
}

/// Result of resolving a path, or a part of it.
enum Place {
    Module(usize),
    /// An item: the module that defines it, and its name.
    Item(usize, String),
}

/// All modules of a library or program, its root first.
pub(crate) struct Modules(Vec<Module>);

/// Largest number of imports that are followed for one path; more indicate a path that leads back to itself.
const DEEPEST: usize = 12;

/// Reads a library or program from its root file.
pub(crate) fn read(root: &Path) -> Modules {
    let mut modules = Modules(Vec::new());
    modules.file(root, root.parent().unwrap(), None);
    modules
}

/// The name that an item defines.
fn defined(item: &Item) -> Vec<String> {
    let name = match item {
        Item::Const(item) => &item.ident,
        Item::Enum(item) => &item.ident,
        Item::Fn(item) => &item.sig.ident,
        Item::Static(item) => &item.ident,
        Item::Struct(item) => &item.ident,
        Item::Trait(item) => &item.ident,
        Item::Type(item) => &item.ident,
        Item::Union(item) => &item.ident,
        Item::Macro(item) => match &item.ident {
            Some(name) => name,
            None => return made(&names::paths(item.mac.tokens.clone())),
        },
        _ => return Vec::new(),
    };
    vec![name.to_string()]
}

/// Names of items in the input of a macro that passes them on.
fn made(paths: &[Vec<String>]) -> Vec<String> {
    let words: Vec<&String> = paths.iter().filter_map(|path| path.first()).collect();
    let makes = |word: &str| ["const", "enum", "fn", "static", "struct", "trait", "type"].contains(&word);
    words.windows(2).filter(|pair| makes(pair[0])).map(|pair| pair[1].clone()).collect()
}

/// File name in a `#[path]` attribute.
fn given_path(item: &ItemMod) -> Option<String> {
    item.attrs.iter().find_map(|attribute| match &attribute.meta {
        Meta::NameValue(pair) if pair.path.is_ident("path") => match &pair.value {
            Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) => Some(text.value()),
            _ => None,
        },
        _ => None,
    })
}

impl Modules {
    /// Reads the module of a file; `folder` contains the files of its children.
    fn file(&mut self, file: &Path, folder: &Path, parent: Option<usize>) -> usize {
        let text = std::fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let parsed = syn::parse_file(&text).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        self.module(&parsed.items, file, folder, parent)
    }

    fn module(&mut self, items: &[Item], file: &Path, folder: &Path, parent: Option<usize>) -> usize {
        let at = self.0.len();
        let (names, uses, paths) = <_>::default();
        self.0.push(Module { file: file.to_owned(), parent, names, uses, paths });
        let mut named = Names::default();
        let mut meanings: Vec<(String, Meaning)> = Vec::new();
        for item in items.iter().filter(|item| !names::for_tests(names::attributes(item))) {
            if let Item::Mod(child) = item {
                meanings.push((child.ident.to_string(), Meaning::Module(self.child(child, file, folder, at))));
            } else {
                named.visit_item(item);
                for name in defined(item) {
                    if names::is_exported_macro(item) {
                        self.0[0].names.entry(name.clone()).or_default().push(Meaning::Item(at));
                    }
                    meanings.push((name, Meaning::Item(at)));
                }
            }
        }
        let imported = |import: &Use| Some((import.name.clone()?, Meaning::Use(import.path.clone())));
        meanings.extend(named.uses.iter().filter_map(imported));
        let module = &mut self.0[at];
        for (name, meaning) in meanings {
            module.names.entry(name).or_default().push(meaning);
        }
        (module.uses, module.paths) = (named.uses, named.paths);
        at
    }

    fn child(&mut self, item: &ItemMod, file: &Path, folder: &Path, parent: usize) -> usize {
        let below = folder.join(item.ident.to_string());
        if let Some((_, items)) = &item.content {
            return self.module(items, file, &below, Some(parent));
        }
        if let Some(path) = given_path(item) {
            let file = file.parent().unwrap().join(path);
            return self.file(&file, file.parent().unwrap(), Some(parent));
        }
        let alone = below.with_extension("rs");
        let file = if alone.is_file() { alone } else { below.join("mod.rs") };
        self.file(&file, &below, Some(parent))
    }

    /// Resolves a name in a module; `None` if nothing there defines or imports it.
    fn meant(&self, module: usize, name: &str, deep: usize) -> Option<Vec<Place>> {
        let place = |meaning: &Meaning| match meaning {
            Meaning::Module(child) => vec![Place::Module(*child)],
            Meaning::Item(definer) => vec![Place::Item(*definer, name.to_owned())],
            Meaning::Use(path) if path.len() == 1 && path[0] == name => Vec::new(),
            Meaning::Use(path) => self.places(module, path, deep + 1),
        };
        if let Some(meanings) = self.0[module].names.get(name) {
            return Some(meanings.iter().flat_map(place).collect());
        }
        let all = self.0[module].uses.iter().filter(|import| import.name.is_none() && deep < DEEPEST);
        all.flat_map(|import| self.places(module, &import.path, deep + 1)).find_map(|place| match place {
            Place::Module(other) if other != module => self.meant(other, name, deep + 1),
            _ => None,
        })
    }

    /// Resolves a path in a module to items and modules; empty for paths to other packages.
    fn places(&self, module: usize, path: &[String], deep: usize) -> Vec<Place> {
        if deep > DEEPEST {
            return Vec::new();
        }
        let up = |module: usize| self.0[module].parent.map(Place::Module).into_iter().collect::<Vec<_>>();
        let mut places = match path[0].as_str() {
            "crate" => vec![Place::Module(0)],
            "self" => vec![Place::Module(module)],
            "super" => up(module),
            name => self.meant(module, name, deep).unwrap_or_default(),
        };
        for name in &path[1..] {
            let next = |place| match place {
                Place::Module(module) if name == "super" => up(module),
                // A name that is not defined there was created by a macro.
                Place::Module(module) => {
                    self.meant(module, name, deep).unwrap_or_else(|| vec![Place::Item(module, name.clone())])
                }
                item @ Place::Item(..) => vec![item],
            };
            places = places.into_iter().flat_map(next).collect();
        }
        places
    }

    fn is_within(&self, module: usize, other: usize) -> bool {
        module == other || self.0[module].parent.is_some_and(|parent| self.is_within(parent, other))
    }

    /// The outermost module of a module's file.
    fn of_file(&self, module: usize) -> usize {
        let outer = self.0[module].parent.filter(|parent| self.0[*parent].file == self.0[module].file);
        outer.map_or(module, |parent| self.of_file(parent))
    }

    /// Adds the uses between the files of these modules: items that a path in the code means, and imported ones. A module that only re-exports the
    /// items of its children does not use them.
    pub(crate) fn add_uses(&self, graph: &mut Graph) {
        for (at, module) in self.0.iter().enumerate() {
            let mut add = |place: Place, passed_on: bool| {
                if let Place::Item(to, name) = place
                    && !(passed_on && self.is_within(to, self.of_file(at)))
                {
                    graph.add(&module.file, &self.0[to].file, &name);
                }
            };
            for path in &module.paths {
                self.places(at, path, 0).into_iter().for_each(|place| add(place, false));
            }
            for import in &module.uses {
                self.places(at, &import.path, 0).into_iter().for_each(|place| add(place, import.exported));
            }
        }
    }
}
