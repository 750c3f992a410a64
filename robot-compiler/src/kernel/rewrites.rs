//! Rewrites of level `exact`: fewer operations, the same value.
//!
//! Each rewrite is one function from a node to its replacement. All of them keep every result equal (`==`) to that of the
//! traced operations, for finite inputs in round-to-nearest. Rounding is symmetric in sign, addition and multiplication are
//! commutative to the bit, and only the sign of a zero can change, which `==` ignores.

use super::arena::{Arena, Expr, Node, Precision, Rewrite};
use super::rules::{RewriteRule, RuleSet};

impl Arena {
    /// An empty tape.
    #[must_use]
    pub fn new(rules: RuleSet, precision: Precision) -> Self {
        Self::with_table(rules, &TABLE, precision)
    }
}

/// The rules in the order in which they are tried. Constant folding comes first, so that the other rules never see two
/// constants.
pub(super) const TABLE: [(RewriteRule, Rewrite); 5] = [
    (RewriteRule::Fold, fold),
    (RewriteRule::Zero, zero),
    (RewriteRule::One, one),
    (RewriteRule::Signs, signs),
    (RewriteRule::Order, order),
];

/// Folds operations on numbers in the kernel's own precision, so that the bits are those of the kernel.
fn fold(arena: &mut Arena, node: Node) -> Option<Expr> {
    let value = match node {
        Node::Add(a, b) => arena.number(a)? + arena.number(b)?,
        Node::Sub(a, b) => arena.number(a)? - arena.number(b)?,
        Node::Mul(a, b) => arena.number(a)? * arena.number(b)?,
        // A division by zero is kept: infinity and NaN have no literal.
        Node::Div(a, b) => arena.number(a)? / arena.number(b).filter(|b| *b != 0.0)?,
        Node::Neg(a) => -arena.number(a)?,
        Node::Constant(_) | Node::Input(_) => return None,
    };
    // Two numbers of 24 bits have an exact product, and a sum and a quotient that round alike, once in f64 and then to f32:
    // f64 has more than twice the bits of f32 and two to spare (Figueroa 1995), so rounding twice is rounding once.
    Some(arena.constant(value))
}

/// Inputs are checked to be finite before a kernel runs, so `0 x` is 0. `0 / x` is 0 unless `x` is 0; code that divides
/// checks for that.
fn zero(arena: &mut Arena, node: Node) -> Option<Expr> {
    let is_zero = |e: Expr| arena.number(e) == Some(0.0);
    match node {
        Node::Mul(a, b) if is_zero(a) || is_zero(b) => Some(arena.constant(0.0)),
        Node::Div(a, b) if is_zero(a) && !is_zero(b) => Some(a),
        Node::Add(a, b) if is_zero(a) => Some(b),
        Node::Add(a, b) | Node::Sub(a, b) if is_zero(b) => Some(a),
        Node::Sub(a, b) if is_zero(a) => Some(arena.make(Node::Neg(b))),
        Node::Sub(a, b) if a == b => Some(arena.constant(0.0)),
        _ => None,
    }
}

/// Right angles fill rotations with ones.
fn one(arena: &mut Arena, node: Node) -> Option<Expr> {
    let places: &[(Expr, Expr)] = match node {
        Node::Mul(a, b) => &[(a, b), (b, a)],
        Node::Div(a, b) => &[(b, a)],
        _ => return None,
    };
    for &(number, other) in places {
        match arena.number(number) {
            Some(1.0) => return Some(other),
            Some(-1.0) => return Some(arena.make(Node::Neg(other))),
            _ => {}
        }
    }
    None
}

/// A sign moves out of products and quotients and into sums, where it turns an addition into a subtraction at no cost. Numbers are
/// written without sign, so that `c x` and `-c x` share their product. Differences have one order, for the same reason.
fn signs(arena: &mut Arena, node: Node) -> Option<Expr> {
    let inside = |arena: &Arena, e: Expr| match arena.node(e) {
        Node::Neg(x) => Some(x),
        _ => None,
    };
    let unsigned = |arena: &mut Arena, e: Expr| match arena.number(e) {
        Some(x) if x < 0.0 => Some(arena.constant(-x)),
        _ => inside(arena, e),
    };
    let opposite = |arena: &mut Arena, node: Node| {
        let positive = arena.make(node);
        arena.make(Node::Neg(positive))
    };
    match node {
        Node::Neg(a) => inside(arena, a),
        Node::Mul(a, b) => {
            if let Some(positive) = unsigned(arena, a) {
                return Some(opposite(arena, Node::Mul(positive, b)));
            }
            unsigned(arena, b).map(|positive| opposite(arena, Node::Mul(a, positive)))
        }
        Node::Div(a, b) => {
            if let Some(positive) = unsigned(arena, a) {
                return Some(opposite(arena, Node::Div(positive, b)));
            }
            unsigned(arena, b).map(|positive| opposite(arena, Node::Div(a, positive)))
        }
        Node::Add(a, b) => match (inside(arena, a), inside(arena, b)) {
            (Some(x), Some(y)) => Some(opposite(arena, Node::Add(x, y))),
            (Some(x), None) => Some(arena.make(Node::Sub(b, x))),
            (None, Some(y)) => Some(arena.make(Node::Sub(a, y))),
            (None, None) => None,
        },
        Node::Sub(a, b) => match (inside(arena, a), inside(arena, b)) {
            (Some(x), Some(y)) => Some(arena.make(Node::Sub(y, x))),
            (Some(x), None) => Some(opposite(arena, Node::Add(x, b))),
            (None, Some(y)) => Some(arena.make(Node::Add(a, y))),
            (None, None) if a > b => Some(opposite(arena, Node::Sub(b, a))),
            (None, None) => None,
        },
        Node::Constant(_) | Node::Input(_) => None,
    }
}

/// Commutative operands are kept in the order in which they were recorded.
fn order(arena: &mut Arena, node: Node) -> Option<Expr> {
    match node {
        Node::Add(a, b) if a > b => Some(arena.make(Node::Add(b, a))),
        Node::Mul(a, b) if a > b => Some(arena.make(Node::Mul(b, a))),
        _ => None,
    }
}
