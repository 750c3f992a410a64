//! Level `regrouped`: common factors, `a b + a c = a (b + c)`.

use super::program::needed;
use super::rules::RuleSet;
use super::tape::{Arena, Expr, Node, Precision};
use std::collections::HashMap;

/// The outputs on a new tape, with every common factor taken out of sums whose products nobody else needs; repeated until
/// none is left. One multiplication less each time; rounding changes.
#[must_use]
pub(super) fn common_factors(mut arena: Arena, mut outputs: Vec<Expr>, precision: Precision) -> (Arena, Vec<Expr>) {
    loop {
        let (next, moved, factored) = pass(&arena, &outputs, precision);
        arena = next;
        outputs = moved;
        if factored == 0 {
            return (arena, outputs);
        }
    }
}

fn pass(arena: &Arena, outputs: &[Expr], precision: Precision) -> (Arena, Vec<Expr>, usize) {
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
        let place = match (common(arena, node, once), node) {
            (Some((factor, b, c)), Node::Add(..)) => {
                factored += 1;
                let sum = fresh.make(Node::Add(at(b), at(c)));
                fresh.make(Node::Mul(at(factor), sum))
            }
            (Some((factor, b, c)), _) => {
                factored += 1;
                let difference = fresh.make(Node::Sub(at(b), at(c)));
                fresh.make(Node::Mul(at(factor), difference))
            }
            (None, Node::Constant(bits)) => fresh.constant(f64::from_bits(bits)),
            (None, Node::Input(_)) => fresh.write(node),
            (None, Node::Add(a, b)) => fresh.make(Node::Add(at(a), at(b))),
            (None, Node::Sub(a, b)) => fresh.make(Node::Sub(at(a), at(b))),
            (None, Node::Mul(a, b)) => fresh.make(Node::Mul(at(a), at(b))),
            (None, Node::Neg(a)) => fresh.make(Node::Neg(at(a))),
        };
        if let Some(label) = arena.label(expr) {
            fresh.name(place, label);
        }
        moved.insert(expr, place);
    }
    let outputs = outputs.iter().map(|output| moved.get(output).copied().unwrap_or(*output)).collect();
    (fresh, outputs, factored)
}

/// `(a, b, c)` when a sum or difference is of `a b` and `a c`, both needed nowhere else.
fn common(arena: &Arena, node: Node, once: impl Fn(Expr) -> bool) -> Option<(Expr, Expr, Expr)> {
    let (Node::Add(left, right) | Node::Sub(left, right)) = node else { return None };
    let (Node::Mul(a, b), Node::Mul(c, d)) = (arena.node(left), arena.node(right)) else { return None };
    if !(once(left) && once(right)) {
        return None;
    }
    [(a, b, c, d), (a, b, d, c), (b, a, c, d), (b, a, d, c)]
        .into_iter()
        .find_map(|(factor, rest, other, other_rest)| (factor == other).then_some((factor, rest, other_rest)))
}
