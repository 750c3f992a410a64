//! The names in a module's code: its `use` declarations, and all paths in its code.

use proc_macro2::{Spacing, TokenStream, TokenTree};
use std::collections::BTreeSet;
use syn::visit::{self, Visit};
use syn::{Attribute, Expr, ImplItem, Item, ItemUse, Macro, Meta, Path, Stmt, UseTree, Visibility};

/// A `use` of one name, or of all names of a module.
pub(crate) struct Use {
    pub(crate) path: Vec<String>,
    /// Name of the import in this module; `None` if it imports all names.
    pub(crate) name: Option<String>,
    /// True if other modules may use that name.
    pub(crate) exported: bool,
}

/// Names that some items use, without those that are compiled only for tests.
#[derive(Default)]
pub(crate) struct Names {
    pub(crate) uses: Vec<Use>,
    pub(crate) paths: BTreeSet<Vec<String>>,
}

/// True if an item is compiled only for tests.
pub(crate) fn for_tests(attributes: &[Attribute]) -> bool {
    let words = |attribute: &Attribute| match &attribute.meta {
        Meta::Path(path) => vec![path.get_ident().map(ToString::to_string).unwrap_or_default()],
        Meta::List(list) if list.path.is_ident("cfg") => paths(list.tokens.clone()).concat(),
        _ => Vec::new(),
    };
    let has = |words: &[String], wanted: &str| words.iter().any(|word| word == wanted);
    let only = |words: Vec<String>| has(&words, "test") && !has(&words, "not") && !has(&words, "any");
    attributes.iter().map(words).any(only)
}

/// The attributes of an item.
pub(crate) fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Union(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

/// Attributes of a statement that may be compiled only for tests.
fn statement_attributes(statement: &Stmt) -> &[Attribute] {
    match statement {
        Stmt::Local(local) => &local.attrs,
        Stmt::Macro(call) => &call.attrs,
        Stmt::Expr(Expr::Block(block), _) => &block.attrs,
        Stmt::Expr(Expr::Call(call), _) => &call.attrs,
        Stmt::Expr(Expr::MethodCall(call), _) => &call.attrs,
        Stmt::Expr(..) | Stmt::Item(_) => &[],
    }
}

/// True for a `macro_rules!` that is exported from the root, regardless of its location.
pub(crate) fn is_exported_macro(item: &Item) -> bool {
    matches!(item, Item::Macro(_)) && attributes(item).iter().any(|attribute| attribute.path().is_ident("macro_export"))
}

/// Paths in unparsed tokens: the input of a macro or of an attribute.
pub(crate) fn paths(tokens: TokenStream) -> Vec<Vec<String>> {
    let trees: Vec<TokenTree> = tokens.into_iter().collect();
    let is = |at: Option<usize>, sign: char| matches!(at.and_then(|at| trees.get(at)), Some(TokenTree::Punct(punct)) if punct.as_char() == sign);
    let colons = |at: Option<usize>| {
        let joint = |at| matches!(&trees[at], TokenTree::Punct(punct) if punct.spacing() == Spacing::Joint);
        at.is_some_and(|at| is(Some(at), ':') && joint(at) && is(Some(at + 1), ':'))
    };
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(tree) = trees.get(at) {
        at += 1;
        let before = (at - 1).checked_sub(1);
        let two_before = before.and_then(|before| before.checked_sub(1));
        match tree {
            TokenTree::Group(group) => found.extend(paths(group.stream())),
            TokenTree::Ident(first) => {
                let member = is(before, '.') && !is(two_before, '.');
                let variable = is(before, '$') && first != "crate";
                let mut path = vec![first.to_string()];
                while colons(Some(at)) && matches!(trees.get(at + 2), Some(TokenTree::Ident(_))) {
                    path.push(trees[at + 2].to_string());
                    at += 3;
                }
                if !member && !variable && !colons(two_before) {
                    found.push(path);
                }
            }
            _ => {}
        }
    }
    found
}

impl Names {
    fn add_use(&mut self, tree: &UseTree, before: &[String], exported: bool) {
        let with = |name: &dyn ToString| [before, &[name.to_string()]].concat();
        let mut add = |path: Vec<String>, name: Option<String>| self.uses.push(Use { path, name, exported });
        match tree {
            UseTree::Path(path) => self.add_use(&path.tree, &with(&path.ident), exported),
            UseTree::Group(group) => group.items.iter().for_each(|tree| self.add_use(tree, before, exported)),
            UseTree::Name(name) if name.ident == "self" => add(before.to_vec(), before.last().cloned()),
            UseTree::Name(name) => add(with(&name.ident), Some(name.ident.to_string())),
            UseTree::Rename(name) if name.ident == "self" => add(before.to_vec(), Some(name.rename.to_string())),
            UseTree::Rename(name) => add(with(&name.ident), Some(name.rename.to_string())),
            UseTree::Glob(_) => add(before.to_vec(), None),
        }
    }
}

impl<'ast> Visit<'ast> for Names {
    fn visit_item(&mut self, item: &'ast Item) {
        if !for_tests(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_impl_item(&mut self, item: &'ast ImplItem) {
        if !matches!(item, ImplItem::Fn(function) if for_tests(&function.attrs)) {
            visit::visit_impl_item(self, item);
        }
    }

    fn visit_stmt(&mut self, statement: &'ast Stmt) {
        if !for_tests(statement_attributes(statement)) {
            visit::visit_stmt(self, statement);
        }
    }

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        // A name after `::` belongs to another package.
        if item.leading_colon.is_none() {
            self.add_use(&item.tree, &[], !matches!(item.vis, Visibility::Inherited));
        }
    }

    fn visit_path(&mut self, path: &'ast Path) {
        if path.leading_colon.is_none() {
            self.paths.insert(path.segments.iter().map(|segment| segment.ident.to_string()).collect());
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, call: &'ast Macro) {
        visit::visit_macro(self, call);
        self.paths.extend(paths(call.tokens.clone()));
    }

    fn visit_attribute(&mut self, attribute: &'ast Attribute) {
        if let Meta::List(list) = &attribute.meta {
            self.paths.extend(paths(list.tokens.clone()));
        }
    }

    fn visit_visibility(&mut self, _: &'ast Visibility) {}
}
