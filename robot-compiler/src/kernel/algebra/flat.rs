//! From a tape to sums and products: an item with a single user is merged into that user.

use super::items::{Addend, Algebra, AlgebraItem, Id, pairs_of_places};
use crate::kernel::arena::{Arena, Expr, Node, Precision};
use crate::kernel::program::needed;
use std::collections::HashMap;

impl Algebra {
    /// Reads everything that the outputs need; a sum or product with a single user is merged into that user.
    pub(super) fn read(arena: &Arena, outputs: &[Expr], precision: Precision) -> Self {
        let mut algebra = Self { items: Vec::new(), outputs: Vec::new(), names: HashMap::new(), precision };
        let mut place: HashMap<Expr, Id> = HashMap::new();
        for expr in needed(arena, outputs) {
            let at = |e: Expr| place.get(&e).copied().unwrap_or(Id(0));
            let plus = |e| Addend { minus: false, id: at(e) };
            let minus = |e| Addend { minus: true, id: at(e) };
            let item = match arena.node(expr) {
                Node::Constant(bits) => AlgebraItem::Number(bits),
                Node::Input(_) => AlgebraItem::Leaf(expr),
                Node::Add(a, b) => AlgebraItem::Sum(vec![plus(a), plus(b)]),
                Node::Sub(a, b) => AlgebraItem::Sum(vec![plus(a), minus(b)]),
                Node::Neg(a) => AlgebraItem::Sum(vec![minus(a)]),
                Node::Mul(a, b) => AlgebraItem::Product(vec![at(a), at(b)]),
                Node::Div(a, b) => AlgebraItem::Quotient(at(a), at(b)),
            };
            let id = algebra.push(item);
            place.insert(expr, id);
            if arena.label(expr).is_some() {
                algebra.names.insert(id, expr);
            }
        }
        algebra.outputs = outputs.iter().filter_map(|output| place.get(output).copied()).collect();
        algebra.flatten();
        algebra
    }

    /// Merges sums with a single use into the sum that uses them, and products likewise; leaves out sums of one part;
    /// multiplies numbers.
    pub(super) fn flatten(&mut self) {
        loop {
            let uses = self.uses();
            let mut changed = false;
            for i in (0..self.items.len()).filter(|&i| uses[i] > 0) {
                match self.items[i].clone() {
                    AlgebraItem::Leaf(_) | AlgebraItem::Number(_) | AlgebraItem::Quotient(..) => {}
                    AlgebraItem::Sum(parts) => {
                        let flat = parts.iter().flat_map(|&part| self.spread(part, &uses)).collect();
                        let flat = without_opposites(flat);
                        if flat.is_empty() {
                            self.items[i] = AlgebraItem::Number(0.0_f64.to_bits());
                            changed = true;
                        } else if flat != parts {
                            self.items[i] = AlgebraItem::Sum(flat);
                            changed = true;
                        }
                    }
                    AlgebraItem::Product(factors) => {
                        let flat: Vec<Id> =
                            factors.iter().flat_map(|&factor| self.spread_factor(factor, &uses)).collect();
                        let flat = self.one_number(flat);
                        if flat != factors {
                            self.items[i] = AlgebraItem::Product(flat);
                            changed = true;
                        }
                    }
                }
            }
            if !changed {
                return;
            }
        }
    }

    fn spread(&self, part: Addend, uses: &[usize]) -> Vec<Addend> {
        match &self.items[part.id.0] {
            AlgebraItem::Sum(inner) if inner.len() == 1 || uses.get(part.id.0) == Some(&1) => {
                inner.iter().map(|p| Addend { minus: p.minus != part.minus, id: p.id }).collect()
            }
            AlgebraItem::Product(inner) if inner.len() == 1 => vec![Addend { id: inner[0], ..part }],
            _ => vec![part],
        }
    }

    fn spread_factor(&self, factor: Id, uses: &[usize]) -> Vec<Id> {
        match &self.items[factor.0] {
            AlgebraItem::Product(inner) if inner.len() == 1 || uses.get(factor.0) == Some(&1) => inner.clone(),
            AlgebraItem::Sum(inner) if matches!(inner[..], [Addend { minus: false, .. }]) => vec![inner[0].id],
            _ => vec![factor],
        }
    }

    /// The same factors with their numbers multiplied into one.
    fn one_number(&mut self, factors: Vec<Id>) -> Vec<Id> {
        let number = |id: &Id| match self.items[id.0] {
            AlgebraItem::Number(bits) => Some(f64::from_bits(bits)),
            _ => None,
        };
        let numbers: Vec<f64> = factors.iter().filter_map(number).collect();
        if numbers.len() < 2 {
            return factors;
        }
        let product = self.precision.round(numbers.iter().product());
        let mut left: Vec<Id> = factors.iter().copied().filter(|id| number(id).is_none()).collect();
        let product = AlgebraItem::Number(product.to_bits());
        let place = self.items.iter().position(|item| *item == product).map_or_else(|| self.push(product), Id);
        left.insert(0, place);
        left
    }
}

/// The parts without those that cancel, `x - x`.
fn without_opposites(mut parts: Vec<Addend>) -> Vec<Addend> {
    let opposite = |parts: &[Addend]| {
        pairs_of_places(parts.len()).find(|&(i, j)| parts[i].id == parts[j].id && parts[i].minus != parts[j].minus)
    };
    while let Some((i, j)) = opposite(&parts) {
        parts.remove(j);
        parts.remove(i);
    }
    parts
}
