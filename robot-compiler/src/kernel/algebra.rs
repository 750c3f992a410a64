//! Level `regrouped`: sums and products of many terms, with common parts computed once.
//!
//! The tape has operations of two operands, in the order of the recursion. In exact arithmetic a sum is a
//! set of signed parts and a product a set of factors, and both can be split in another way. Three moves save operations:
//!
//! | move | example | saves |
//! |---|---|---|
//! | share a sum | `a + b + c`, `d - a - b` | an addition for each use but the first |
//! | share a product | `a b c`, `a b d` | a multiplication for each use but the first |
//! | factor out | `a b + a c - a d = a (b + c - d)` | a multiplication for each term but the first |
//!
//! Each move enables or prevents others. They are made greedily, the one that saves most first. Every order of preference
//! among equals is tried, and the cheapest result is taken.

use super::arena::{Arena, Expr, Precision};
use super::program::Program;
use items::Algebra;

mod flat;
mod items;
mod moves;
mod write;

pub(super) use moves::{MOVES, Moves};

/// The program with the fewest operations that the moves reach.
#[must_use]
pub(super) fn fewest_operations(arena: Arena, outputs: &[Expr], precision: Precision, moves: Moves) -> Program {
    let start = Algebra::read(&arena, outputs, precision);
    let preferences = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let ends =
        preferences.into_iter().flat_map(|rank| [false, true].map(|late| start.clone().reduced(moves, rank, late)));
    // A value without a register costs as much as an operation.
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
    // Without a saving, the plain program keeps the terms in their order.
    least.filter(|(cost, _)| *cost <= plain.0).unwrap_or(plain).1
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp, reason = "whole numbers")]

    use super::super::rules::RuleSet;
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
