//! Level `regrouped`: common factors, `a b + a c = a (b + c)`.

use super::program::needed;
use super::rules::RuleSet;
use super::tape::{Arena, Expr, Node, Precision};
use std::collections::HashMap;

/// The outputs on a new tape, with every common factor taken out of sums whose products nobody else needs; repeated until
/// none is left. One multiplication less each time; rounding changes.
#[must_use]
pub(super) fn common_factors(arena: Arena, outputs: Vec<Expr>, precision: Precision) -> (Arena, Vec<Expr>) {
    factored(arena, outputs, precision, common)
}

/// From a node, and what is needed only once: the common factor, and the sum or difference that it multiplies.
pub(super) type Common = fn(&Arena, Node, &dyn Fn(Expr) -> bool) -> Option<(Expr, Node)>;

/// The same, by any notion of a common factor.
pub(super) fn factored(
    mut arena: Arena,
    mut outputs: Vec<Expr>,
    precision: Precision,
    common: Common,
) -> (Arena, Vec<Expr>) {
    loop {
        let (next, moved, factored) = pass(&arena, &outputs, precision, common);
        arena = next;
        outputs = moved;
        if factored == 0 {
            return (arena, outputs);
        }
    }
}

fn pass(arena: &Arena, outputs: &[Expr], precision: Precision, common: Common) -> (Arena, Vec<Expr>, usize) {
    let needed = needed(arena, outputs);
    let mut uses: HashMap<Expr, usize> = HashMap::new();
    for operand in needed.iter().flat_map(|&e| arena.node(e).operands()).chain(outputs.iter().copied()) {
        *uses.entry(operand).or_default() += 1;
    }
    let mut fresh = Arena::new(RuleSet::ALL, precision);
    let mut moved: HashMap<Expr, Expr> = HashMap::new();
    let mut factored = 0;
    for &expr in &needed {
        let node = arena.node(expr);
        let at = |e: Expr| moved.get(&e).copied().unwrap_or(e);
        let once = |e: Expr| uses.get(&e) == Some(&1);
        let moved_node = |node: Node| match node {
            Node::Constant(_) | Node::Input(_) => node,
            Node::Add(a, b) => Node::Add(at(a), at(b)),
            Node::Sub(a, b) => Node::Sub(at(a), at(b)),
            Node::Mul(a, b) => Node::Mul(at(a), at(b)),
            Node::Div(a, b) => Node::Div(at(a), at(b)),
            Node::Neg(a) => Node::Neg(at(a)),
        };
        let place = match (common(arena, node, &once), node) {
            (Some((factor, inner)), _) => {
                factored += 1;
                let inner = fresh.make(moved_node(inner));
                fresh.make(Node::Mul(at(factor), inner))
            }
            (None, Node::Constant(bits)) => fresh.constant(f64::from_bits(bits)),
            (None, Node::Input(_)) => fresh.write(node),
            (None, _) => fresh.make(moved_node(node)),
        };
        if let Some(label) = arena.label(expr) {
            fresh.name(place, label);
        }
        moved.insert(expr, place);
    }
    let outputs = outputs.iter().map(|output| moved.get(output).copied().unwrap_or(*output)).collect();
    (fresh, outputs, factored)
}

/// `a` and `b + c` (or `b - c`) when a sum (or difference) is of `a b` and `a c`, both needed nowhere else.
pub(super) fn common(arena: &Arena, node: Node, once: &dyn Fn(Expr) -> bool) -> Option<(Expr, Node)> {
    let (Node::Add(left, right) | Node::Sub(left, right)) = node else { return None };
    let (Node::Mul(a, b), Node::Mul(c, d)) = (arena.node(left), arena.node(right)) else { return None };
    if !(once(left) && once(right)) {
        return None;
    }
    let pairs = [(a, b, c, d), (a, b, d, c), (b, a, c, d), (b, a, d, c)];
    let (factor, b, _, c) = pairs.into_iter().find(|(factor, _, other, _)| factor == other)?;
    Some((factor, if matches!(node, Node::Add(..)) { Node::Add(b, c) } else { Node::Sub(b, c) }))
}
