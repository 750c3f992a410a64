//! Level `regrouped`: sums and products of many terms, with what is common taken out.
//!
//! The tape has operations of two operands, in the order in which the recursion spells them. In exact arithmetic a sum is a
//! set of signed parts and a product a set of factors, and both can be taken apart anew. Three moves save operations:
//!
//! | move | example | saves |
//! |---|---|---|
//! | share a sum | `a + b + c`, `d - a - b` | an addition each time but the first |
//! | share a product | `a b c`, `a b d` | a multiplication each time but the first |
//! | take a factor out | `a b + a c - a d = a (b + c - d)` | a multiplication each time but the first |
//!
//! Each move makes others possible or impossible. They are made greedily, the one that saves most first; what to prefer
//! among equals is tried out in every order, and the cheapest end is taken.

use super::arena::{Arena, Expr, Node, Precision};
use super::program::{Program, needed};
use super::rules::RuleSet;
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// A sum, a product, or what both are made of.
#[derive(Clone, Debug, PartialEq)]
enum Item {
    /// An input.
    Leaf(Expr),
    /// A number, by its bits.
    Number(u64),
    /// The first by the second.
    Quotient(Id, Id),
    /// Signed parts; one part alone stands for what it names.
    Sum(Vec<Part>),
    /// Factors, one number at most.
    Product(Vec<Id>),
}

/// The place of an item.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Id(usize);

/// A term of a sum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Part {
    /// Whether it is subtracted.
    pub(super) minus: bool,
    /// What.
    pub(super) id: Id,
}

/// Sums and products that lead to the outputs.
#[derive(Clone, Debug)]
pub(super) struct Algebra {
    items: Vec<Item>,
    outputs: Vec<Id>,
    names: HashMap<Id, Expr>,
    precision: Precision,
}

/// A way to save operations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Move {
    /// The sum of the two, the second subtracted if so said.
    ShareSum(Id, Id, bool),
    /// The product of the two.
    ShareProduct(Id, Id),
    /// The factor, out of the sum.
    TakeOut(Id, Id),
}

/// What each move does. A test puts wrong ones in.
#[derive(Clone, Copy)]
pub(super) struct Moves {
    /// Whether the shared sum is subtracted, from the sign of its first part in a sum.
    pub(super) shared_sum: fn(Part) -> bool,
    /// What is left of a product without a factor.
    pub(super) without: fn(&[Id], Id) -> Vec<Id>,
    /// The sign inside the bracket.
    pub(super) inside: fn(Part) -> bool,
}

/// The right ones.
pub(super) const MOVES: Moves = Moves {
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

/// The program with the fewest operations that the moves reach.
#[must_use]
pub(super) fn fewest_operations(arena: Arena, outputs: &[Expr], precision: Precision, moves: Moves) -> Program {
    let start = Algebra::read(&arena, outputs, precision);
    let preferences = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let ends =
        preferences.into_iter().flat_map(|rank| [false, true].map(|late| start.clone().reduced(moves, rank, late)));
    // A value that finds no register costs as much as an operation.
    let costed = |program: Program| {
        let operations = program.operations();
        ((operations.total() + program.spills(), operations.neg), program)
    };
    let reduced = ends.map(|end| {
        let (arena, outputs) = end.write(&arena);
        costed(Program::new(arena, &outputs))
    });
    let least = reduced.min_by_key(|(cost, _)| *cost);
    let plain = costed(Program::new(arena, outputs));
    // What reduces nothing still has its terms in their place.
    least.filter(|(cost, _)| *cost <= plain.0).unwrap_or(plain).1
}

impl Algebra {
    /// What the outputs need, sums and products that only one other needs being taken into it.
    fn read(arena: &Arena, outputs: &[Expr], precision: Precision) -> Self {
        let mut algebra = Self { items: Vec::new(), outputs: Vec::new(), names: HashMap::new(), precision };
        let mut place: HashMap<Expr, Id> = HashMap::new();
        for expr in needed(arena, outputs) {
            let at = |e: Expr| place.get(&e).copied().unwrap_or(Id(0));
            let plus = |e| Part { minus: false, id: at(e) };
            let minus = |e| Part { minus: true, id: at(e) };
            let item = match arena.node(expr) {
                Node::Constant(bits) => Item::Number(bits),
                Node::Input(_) => Item::Leaf(expr),
                Node::Add(a, b) => Item::Sum(vec![plus(a), plus(b)]),
                Node::Sub(a, b) => Item::Sum(vec![plus(a), minus(b)]),
                Node::Neg(a) => Item::Sum(vec![minus(a)]),
                Node::Mul(a, b) => Item::Product(vec![at(a), at(b)]),
                Node::Div(a, b) => Item::Quotient(at(a), at(b)),
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

    fn push(&mut self, item: Item) -> Id {
        self.items.push(item);
        Id(self.items.len() - 1)
    }

    /// What an item is made of.
    fn operands(&self, id: Id) -> Vec<Id> {
        match &self.items[id.0] {
            Item::Leaf(_) | Item::Number(_) => Vec::new(),
            Item::Quotient(a, b) => vec![*a, *b],
            Item::Sum(parts) => parts.iter().map(|part| part.id).collect(),
            Item::Product(factors) => factors.clone(),
        }
    }

    /// How often every item is needed, counting from the outputs; nought for what is no longer needed.
    fn uses(&self) -> Vec<usize> {
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

    /// Take sums that only one sum needs into it, and products likewise; leave out sums of one part; multiply numbers.
    fn flatten(&mut self) {
        loop {
            let uses = self.uses();
            let mut changed = false;
            for i in (0..self.items.len()).filter(|&i| uses[i] > 0) {
                match self.items[i].clone() {
                    Item::Leaf(_) | Item::Number(_) | Item::Quotient(..) => {}
                    Item::Sum(parts) => {
                        let flat = parts.iter().flat_map(|&part| self.spread(part, &uses)).collect();
                        let flat = without_opposites(flat);
                        if flat.is_empty() {
                            self.items[i] = Item::Number(0.0_f64.to_bits());
                            changed = true;
                        } else if flat != parts {
                            self.items[i] = Item::Sum(flat);
                            changed = true;
                        }
                    }
                    Item::Product(factors) => {
                        let flat: Vec<Id> =
                            factors.iter().flat_map(|&factor| self.spread_factor(factor, &uses)).collect();
                        let flat = self.one_number(flat);
                        if flat != factors {
                            self.items[i] = Item::Product(flat);
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

    fn spread(&self, part: Part, uses: &[usize]) -> Vec<Part> {
        match &self.items[part.id.0] {
            Item::Sum(inner) if inner.len() == 1 || uses.get(part.id.0) == Some(&1) => {
                inner.iter().map(|p| Part { minus: p.minus != part.minus, id: p.id }).collect()
            }
            Item::Product(inner) if inner.len() == 1 => vec![Part { id: inner[0], ..part }],
            _ => vec![part],
        }
    }

    fn spread_factor(&self, factor: Id, uses: &[usize]) -> Vec<Id> {
        match &self.items[factor.0] {
            Item::Product(inner) if inner.len() == 1 || uses.get(factor.0) == Some(&1) => inner.clone(),
            Item::Sum(inner) if matches!(inner[..], [Part { minus: false, .. }]) => vec![inner[0].id],
            _ => vec![factor],
        }
    }

    /// The same factors with their numbers multiplied into one.
    fn one_number(&mut self, factors: Vec<Id>) -> Vec<Id> {
        let number = |id: &Id| match self.items[id.0] {
            Item::Number(bits) => Some(f64::from_bits(bits)),
            _ => None,
        };
        let numbers: Vec<f64> = factors.iter().filter_map(number).collect();
        if numbers.len() < 2 {
            return factors;
        }
        let product = self.precision.round(numbers.iter().product());
        let mut left: Vec<Id> = factors.iter().copied().filter(|id| number(id).is_none()).collect();
        let product = Item::Number(product.to_bits());
        let place = self.items.iter().position(|item| *item == product).map_or_else(|| self.push(product), Id);
        left.insert(0, place);
        left
    }

    /// Move after move, until none saves anything. Among equal savings the kinds of moves go by `rank`, then the first or
    /// the last place.
    fn reduced(mut self, moves: Moves, rank: [u8; 3], late: bool) -> Self {
        while let Some(best) = self.best_move(rank, late) {
            self.make(best, moves);
            self.flatten();
        }
        self
    }

    fn best_move(&self, rank: [u8; 3], late: bool) -> Option<Move> {
        let uses = self.uses();
        let mut times: BTreeMap<Move, usize> = BTreeMap::new();
        // Twice in the same sum or product counts once: it could be shared with itself only.
        let mut count = |found: Vec<Move>| {
            for m in BTreeSet::from_iter(found) {
                *times.entry(m).or_default() += 1;
            }
        };
        for i in (0..self.items.len()).filter(|&i| uses[i] > 0) {
            match &self.items[i] {
                Item::Leaf(_) | Item::Number(_) | Item::Quotient(..) => {}
                Item::Product(factors) => {
                    count(pairs(factors).map(|(a, b)| Move::ShareProduct(a.min(b), a.max(b))).collect());
                }
                Item::Sum(parts) => {
                    let two = pairs(parts).filter(|(a, b)| a.id != b.id).map(|(a, b)| {
                        let (first, second) = if a.id < b.id { (a, b) } else { (b, a) };
                        Move::ShareSum(first.id, second.id, a.minus != b.minus)
                    });
                    count(two.collect());
                    for part in parts.iter().filter(|part| uses[part.id.0] == 1) {
                        if let Item::Product(factors) = &self.items[part.id.0] {
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
        let shared = vec![Part { minus: false, id: a }, Part { minus: differ, id: b }];
        let shared = self.push(Item::Sum(shared));
        for i in 0..shared.0 {
            let Item::Sum(parts) = &mut self.items[i] else { continue };
            let find = |id: Id| parts.iter().position(|part| part.id == id);
            let (Some(at), Some(other)) = (find(a), find(b)) else { continue };
            if (parts[at].minus != parts[other].minus) == differ {
                parts[at] = Part { minus: (moves.shared_sum)(parts[at]), id: shared };
                parts.remove(other);
            }
        }
    }

    fn share_product(&mut self, a: Id, b: Id, moves: Moves) {
        let shared = self.push(Item::Product(vec![a, b]));
        for i in 0..shared.0 {
            let Item::Product(factors) = &mut self.items[i] else { continue };
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
        let Item::Sum(parts) = self.items[sum.0].clone() else { return };
        let (mut inside, mut outside) = (Vec::new(), Vec::new());
        for part in parts {
            match &self.items[part.id.0] {
                Item::Product(factors) if uses[part.id.0] == 1 && factors.contains(&factor) => {
                    let left = Item::Product((moves.without)(factors, factor));
                    inside.push(Part { minus: (moves.inside)(part), id: self.push(left) });
                }
                _ => outside.push(part),
            }
        }
        // A bracket of subtracted terms is subtracted as a whole.
        let minus = inside.iter().all(|part| part.minus);
        inside.iter_mut().for_each(|part| part.minus &= !minus);
        let bracket = self.push(Item::Sum(inside));
        let product = self.push(Item::Product(vec![factor, bracket]));
        outside.push(Part { minus, id: product });
        self.items[sum.0] = Item::Sum(outside);
    }

    /// The outputs on a new tape.
    fn write(&self, names: &Arena) -> (Arena, Vec<Expr>) {
        let mut arena = Arena::new(RuleSet::ALL, self.precision);
        let mut place: HashMap<Id, Expr> = HashMap::new();
        // In the order in which it was traced, as far as what is shared now allows.
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
            Item::Leaf(expr) => arena.write(old.node(*expr)),
            Item::Number(bits) => arena.constant(f64::from_bits(*bits)),
            Item::Quotient(a, b) => arena.make(Node::Div(at(*a).unwrap_or(zero), at(*b).unwrap_or(zero))),
            Item::Product(factors) => {
                let factors: Vec<Expr> = factors.iter().filter_map(|&f| at(f)).collect();
                factors.into_iter().reduce(|a, b| arena.make(Node::Mul(a, b))).unwrap_or(zero)
            }
            Item::Sum(parts) => {
                // What is added comes first, else the first would have to be negated.
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

/// The parts without those that cancel, `x - x`.
fn without_opposites(mut parts: Vec<Part>) -> Vec<Part> {
    let opposite = |parts: &[Part]| {
        pairs_of_places(parts.len()).find(|&(i, j)| parts[i].id == parts[j].id && parts[i].minus != parts[j].minus)
    };
    while let Some((i, j)) = opposite(&parts) {
        parts.remove(j);
        parts.remove(i);
    }
    parts
}

/// Each two of them, once.
fn pairs<T: Copy>(all: &[T]) -> impl Iterator<Item = (T, T)> + '_ {
    pairs_of_places(all.len()).map(|(i, j)| (all[i], all[j]))
}

/// Each two places out of so many, the first before the second.
fn pairs_of_places(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(move |i| (i + 1..n).map(move |j| (i, j)))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp, reason = "whole numbers")]

    use super::super::tape::{input, trace};
    use super::*;

    /// Operations of each kind (mul, add and sub) before and after, and the outputs at the inputs 1, 2, 3, ...
    fn reduced<const M: usize>(f: impl FnOnce([Expr; 6]) -> [Expr; M]) -> ([usize; 2], Vec<f64>) {
        let (outputs, arena) =
            trace(Arena::new(RuleSet::ALL, Precision::Double), || f(core::array::from_fn(|i| input(i as u32))));
        let inputs = [2.0, 3.0, 5.0, 7.0, 11.0, 13.0];
        let before = Program::new(arena.clone(), &outputs);
        let after = fewest_operations(arena, &outputs, Precision::Double, MOVES);
        assert_eq!(before.evaluate::<f64>(&inputs), after.evaluate(&inputs));
        let n = after.operations();
        ([n.mul, n.add + n.sub], after.evaluate(&inputs))
    }

    #[test]
    fn a_common_factor_is_taken_out_of_a_sum_and_out_of_a_difference() {
        assert_eq!(reduced(|[a, b, c, d, ..]| [a * b + c * a - a * d]), ([1, 2], vec![2.0 * (3.0 + 5.0 - 7.0)]));
        assert_eq!(reduced(|[a, b, c, ..]| [-(a * b) - a * c]), ([1, 1], vec![-16.0]));
    }

    #[test]
    fn a_product_that_is_needed_elsewhere_is_not_taken_apart() {
        // a b, a c, and two sums; taking a out would compute a b twice.
        assert_eq!(reduced(|[a, b, c, ..]| [a * b + a * c, a * b]).0, [2, 1]);
    }

    #[test]
    fn a_sum_that_two_others_hold_is_computed_once_whatever_its_sign() {
        assert_eq!(reduced(|[a, b, c, d, ..]| [a + c + b, d - a - b]), ([0, 3], vec![10.0, 2.0]));
        // Not the same sum: a + b and a - b.
        assert_eq!(reduced(|[a, b, c, d, ..]| [(a + c) + b, (a + d) - b]).0, [0, 4]);
    }

    #[test]
    fn a_product_that_two_others_hold_is_computed_once_and_a_square_needs_its_factor_twice() {
        assert_eq!(reduced(|[a, b, c, d, ..]| [(a * c) * b, (a * d) * b]), ([3, 0], vec![30.0, 42.0]));
        assert_eq!(reduced(|[a, b, c, ..]| [(a * b) * a, (a * c) * a, a * b]), ([4, 0], vec![12.0, 20.0, 6.0]));
    }

    #[test]
    fn numbers_of_a_product_become_one_and_what_cancels_is_gone() {
        let two = || <Expr as dynamics_core::Scalar>::literal(2.0);
        assert_eq!(reduced(|[a, b, ..]| [two() * (a * (two() * b))]), ([2, 0], vec![24.0]));
        assert_eq!(reduced(|[a, b, c, ..]| [(a + b) - (c + b)]), ([0, 1], vec![-3.0]));
        assert_eq!(reduced(|[a, b, ..]| [(a + b) - (b + a)]), ([0, 0], vec![0.0]));
    }
}
