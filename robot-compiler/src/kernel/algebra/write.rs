//! From sums and products back to a tape.

use super::items::{Algebra, AlgebraItem, Id};
use crate::kernel::arena::{Arena, Expr, Node};
use crate::kernel::rules::RuleSet;
use std::collections::HashMap;

impl Algebra {
    /// The outputs on a new tape.
    pub(super) fn write(&self, names: &Arena) -> (Arena, Vec<Expr>) {
        let mut arena = Arena::new(RuleSet::ALL, self.precision);
        let mut place: HashMap<Id, Expr> = HashMap::new();
        // In traced order, as far as the shared parts allow.
        let uses = self.uses();
        let traced = (0..self.items.len()).filter(|&i| uses[i] > 0).map(Id);
        let mut pending: Vec<(Id, bool)> = traced.map(|id| (id, false)).collect();
        pending.reverse();
        while let Some((id, ready)) = pending.pop() {
            if place.contains_key(&id) {
                continue;
            }
            if !ready {
                pending.push((id, true));
                pending.extend(self.operands(id).into_iter().rev().map(|operand| (operand, false)));
                continue;
            }
            let at = |id: Id| place.get(&id).copied();
            let expr = self.write_item(id, names, &mut arena, &at);
            if let Some(label) = self.names.get(&id).and_then(|e| names.label(*e)) {
                arena.name(expr, label);
            }
            place.insert(id, expr);
        }
        let outputs = self.outputs.iter().filter_map(|id| place.get(id).copied()).collect();
        (arena, outputs)
    }

    fn write_item(&self, id: Id, old: &Arena, arena: &mut Arena, at: &dyn Fn(Id) -> Option<Expr>) -> Expr {
        let zero = arena.constant(0.0);
        match &self.items[id.0] {
            AlgebraItem::Leaf(expr) => arena.write(old.node(*expr)),
            AlgebraItem::Number(bits) => arena.constant(f64::from_bits(*bits)),
            AlgebraItem::Quotient(a, b) => arena.make(Node::Div(at(*a).unwrap_or(zero), at(*b).unwrap_or(zero))),
            AlgebraItem::Product(factors) => {
                let factors: Vec<Expr> = factors.iter().filter_map(|&f| at(f)).collect();
                factors.into_iter().reduce(|a, b| arena.make(Node::Mul(a, b))).unwrap_or(zero)
            }
            AlgebraItem::Sum(parts) => {
                // Added parts come first; otherwise the first part would have to be negated.
                let first = parts.iter().position(|part| !part.minus).unwrap_or(0);
                let others = parts.iter().enumerate().filter(|(i, _)| *i != first).map(|(_, part)| part);
                let start = at(parts[first].id).unwrap_or(zero);
                let start = if parts[first].minus { arena.make(Node::Neg(start)) } else { start };
                others.fold(start, |sum, part| {
                    let operand = at(part.id).unwrap_or(zero);
                    arena.make(if part.minus { Node::Sub(sum, operand) } else { Node::Add(sum, operand) })
                })
            }
        }
    }
}
