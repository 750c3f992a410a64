//! The three moves, and the choice of the next one.

use super::items::{Addend, Algebra, AlgebraItem, Id, pairs};
use std::collections::{BTreeMap, BTreeSet};

/// A change that saves operations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Move {
    /// Shares the sum of the two; with the flag, the second is subtracted.
    ShareSum(Id, Id, bool),
    /// Shares the product of the two.
    ShareProduct(Id, Id),
    /// Factors the item out of the sum.
    TakeOut(Id, Id),
}

/// Effects of the moves. A test replaces some by wrong ones.
#[derive(Clone, Copy)]
pub(in crate::kernel) struct Moves {
    /// True if the shared sum is subtracted, from the sign of its first part in a sum.
    pub(in crate::kernel) shared_sum: fn(Addend) -> bool,
    /// The rest of a product without one factor.
    pub(in crate::kernel) without: fn(&[Id], Id) -> Vec<Id>,
    /// The sign inside the bracket.
    pub(in crate::kernel) inside: fn(Addend) -> bool,
}

/// The correct moves.
pub(in crate::kernel) const MOVES: Moves = Moves {
    shared_sum: |first| first.minus,
    without: |factors, taken| {
        let mut left = factors.to_vec();
        if let Some(place) = left.iter().position(|&f| f == taken) {
            left.remove(place);
        }
        left
    },
    inside: |part| part.minus,
};

impl Algebra {
    /// Applies one move after another until no move saves anything. Among equal savings, `rank` orders the kinds of moves,
    /// and then the first or the last candidate is chosen.
    pub(super) fn reduced(mut self, moves: Moves, rank: [u8; 3], late: bool) -> Self {
        while let Some(best) = self.best_move(rank, late) {
            self.make(best, moves);
            self.flatten();
        }
        self
    }

    fn best_move(&self, rank: [u8; 3], late: bool) -> Option<Move> {
        let uses = self.uses();
        let mut times: BTreeMap<Move, usize> = BTreeMap::new();
        // A pair that occurs twice in the same sum or product counts once: it could only be shared with itself.
        let mut count = |found: Vec<Move>| {
            for m in BTreeSet::from_iter(found) {
                *times.entry(m).or_default() += 1;
            }
        };
        for i in (0..self.items.len()).filter(|&i| uses[i] > 0) {
            match &self.items[i] {
                AlgebraItem::Leaf(_) | AlgebraItem::Number(_) | AlgebraItem::Quotient(..) => {}
                AlgebraItem::Product(factors) => {
                    count(pairs(factors).map(|(a, b)| Move::ShareProduct(a.min(b), a.max(b))).collect());
                }
                AlgebraItem::Sum(parts) => {
                    let two = pairs(parts).filter(|(a, b)| a.id != b.id).map(|(a, b)| {
                        let (first, second) = if a.id < b.id { (a, b) } else { (b, a) };
                        Move::ShareSum(first.id, second.id, a.minus != b.minus)
                    });
                    count(two.collect());
                    for part in parts.iter().filter(|part| uses[part.id.0] == 1) {
                        if let AlgebraItem::Product(factors) = &self.items[part.id.0] {
                            count(factors.iter().map(|&factor| Move::TakeOut(factor, Id(i))).collect());
                        }
                    }
                }
            }
        }
        let kind = |m: &Move| match m {
            Move::ShareSum(..) => rank[0],
            Move::ShareProduct(..) => rank[1],
            Move::TakeOut(..) => rank[2],
        };
        let saving = times.into_iter().filter(|(_, times)| *times > 1);
        let best = if late {
            saving.max_by_key(|(m, times)| (*times, kind(m), *m))
        } else {
            saving.max_by_key(|(m, times)| (*times, kind(m), core::cmp::Reverse(*m)))
        };
        best.map(|(m, _)| m)
    }

    fn make(&mut self, chosen: Move, moves: Moves) {
        match chosen {
            Move::ShareSum(a, b, differ) => self.share_sum(a, b, differ, moves),
            Move::ShareProduct(a, b) => self.share_product(a, b, moves),
            Move::TakeOut(factor, sum) => self.take_out(factor, sum, moves),
        }
    }

    fn share_sum(&mut self, a: Id, b: Id, differ: bool, moves: Moves) {
        let shared = vec![Addend { minus: false, id: a }, Addend { minus: differ, id: b }];
        let shared = self.push(AlgebraItem::Sum(shared));
        for i in 0..shared.0 {
            let AlgebraItem::Sum(parts) = &mut self.items[i] else { continue };
            let find = |id: Id| parts.iter().position(|part| part.id == id);
            let (Some(at), Some(other)) = (find(a), find(b)) else { continue };
            if (parts[at].minus != parts[other].minus) == differ {
                parts[at] = Addend { minus: (moves.shared_sum)(parts[at]), id: shared };
                parts.remove(other);
            }
        }
    }

    fn share_product(&mut self, a: Id, b: Id, moves: Moves) {
        let shared = self.push(AlgebraItem::Product(vec![a, b]));
        for i in 0..shared.0 {
            let AlgebraItem::Product(factors) = &mut self.items[i] else { continue };
            let without = |from: &[Id], id| from.contains(&id).then(|| (moves.without)(from, id));
            // A square needs its factor twice.
            if let Some(mut left) = without(factors, a).and_then(|left| without(&left, b)) {
                left.push(shared);
                *factors = left;
            }
        }
    }

    fn take_out(&mut self, factor: Id, sum: Id, moves: Moves) {
        let uses = self.uses();
        let AlgebraItem::Sum(parts) = self.items[sum.0].clone() else { return };
        let (mut inside, mut outside) = (Vec::new(), Vec::new());
        for part in parts {
            match &self.items[part.id.0] {
                AlgebraItem::Product(factors) if uses[part.id.0] == 1 && factors.contains(&factor) => {
                    let left = AlgebraItem::Product((moves.without)(factors, factor));
                    inside.push(Addend { minus: (moves.inside)(part), id: self.push(left) });
                }
                _ => outside.push(part),
            }
        }
        // A bracket of subtracted terms is subtracted as a whole.
        let minus = inside.iter().all(|part| part.minus);
        inside.iter_mut().for_each(|part| part.minus &= !minus);
        let bracket = self.push(AlgebraItem::Sum(inside));
        let product = self.push(AlgebraItem::Product(vec![factor, bracket]));
        outside.push(Addend { minus, id: product });
        self.items[sum.0] = AlgebraItem::Sum(outside);
    }
}
