//! Sums and products as sets of signed parts and of factors.

use crate::kernel::arena::{Expr, Precision};
use std::collections::HashMap;

/// A sum, a product, or an operand of these.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum AlgebraItem {
    /// An input.
    Leaf(Expr),
    /// A number, by its bits.
    Number(u64),
    /// The quotient of the first and the second.
    Quotient(Id, Id),
    /// Signed parts; a sum with one part equals that part.
    Sum(Vec<Addend>),
    /// Factors, at most one of them a number.
    Product(Vec<Id>),
}

/// Index of an item.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(in crate::kernel) struct Id(pub(super) usize);

/// A term of a sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::kernel) struct Addend {
    /// True if it is subtracted.
    pub(in crate::kernel) minus: bool,
    /// The item.
    pub(in crate::kernel) id: Id,
}

/// Sums and products that lead to the outputs.
#[derive(Clone, Debug)]
pub(super) struct Algebra {
    pub(super) items: Vec<AlgebraItem>,
    pub(super) outputs: Vec<Id>,
    pub(super) names: HashMap<Id, Expr>,
    pub(super) precision: Precision,
}

impl Algebra {
    pub(super) fn push(&mut self, item: AlgebraItem) -> Id {
        self.items.push(item);
        Id(self.items.len() - 1)
    }

    /// Operands of an item.
    pub(super) fn operands(&self, id: Id) -> Vec<Id> {
        match &self.items[id.0] {
            AlgebraItem::Leaf(_) | AlgebraItem::Number(_) => Vec::new(),
            AlgebraItem::Quotient(a, b) => vec![*a, *b],
            AlgebraItem::Sum(parts) => parts.iter().map(|part| part.id).collect(),
            AlgebraItem::Product(factors) => factors.clone(),
        }
    }

    /// Number of uses of every item, counting from the outputs; zero for items no longer needed.
    pub(super) fn uses(&self) -> Vec<usize> {
        let mut uses = vec![0; self.items.len()];
        let mut pending = self.outputs.clone();
        while let Some(id) = pending.pop() {
            uses[id.0] += 1;
            if uses[id.0] == 1 {
                pending.extend(self.operands(id));
            }
        }
        uses
    }
}

/// Every pair, once.
pub(super) fn pairs<T: Copy>(all: &[T]) -> impl Iterator<Item = (T, T)> + '_ {
    pairs_of_places(all.len()).map(|(i, j)| (all[i], all[j]))
}

/// Every pair of indices out of `n`, the lower one first.
pub(super) fn pairs_of_places(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(move |i| (i + 1..n).map(move |j| (i, j)))
}
