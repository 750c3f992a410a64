//! Configurations as Rust source.

use super::expression::{Float, Item, call, integer, list, number, word};
use dynamics_core::fields::{Fields, Group, Visitor};

/// A configuration, or a part of one, as an expression.
pub(super) fn item<S: Float>(of: &impl Fields<S>) -> Item {
    let mut written = Written(Vec::new());
    of.visit(&mut written);
    written.0.pop().unwrap_or_else(|| word("()"))
}

/// Expressions of the visited parts, one each.
struct Written(Vec<Item>);

impl<S: Float> Visitor<S> for Written {
    fn number(&mut self, x: S) {
        self.0.push(number(x));
    }

    fn integer(&mut self, x: i64) {
        self.0.push(integer(x));
    }

    fn word(&mut self, kind: &'static str, name: &'static str, _: u32) {
        self.0.push(word(&format!("{kind}::{name}")));
    }

    fn option(&mut self, value: Option<&impl Fields<S>>) {
        self.0.push(value.map_or_else(|| word("None"), |value| call("Some", vec![item(value)])));
    }

    fn group(&mut self, group: Group, parts: impl FnOnce(&mut Self)) {
        let mut inner = Self(Vec::new());
        parts(&mut inner);
        self.0.push(match group {
            Group::Record(name) => Item::Group { open: format!("{name} {{"), close: "}", spaced: true, parts: inner.0 },
            Group::Call(function) => call(function, inner.0),
            Group::Tuple => call("", inner.0),
            Group::List => list(inner.0),
        });
    }

    fn field(&mut self, name: &'static str, value: &impl Fields<S>) {
        self.0.push(Item::Field(name, Box::new(item(value))));
    }
}
