//! Order of the statements: few values alive at once, because every value beyond the registers costs a store and a load.
//!
//! A simulated arm is scheduled while the user waits, so tables are indexed by a value's index in the arena for speed.

use super::arena::{Arena, Expr};
use core::cmp::Reverse;
use std::collections::BinaryHeap;

/// The best of three orders: as traced, depth first from the outputs, and greedy by the values that a statement frees.
pub(super) fn few_alive(arena: &Arena, traced: &[Expr], outputs: &[Expr]) -> Vec<Expr> {
    let candidates = [traced.to_vec(), depth_first(arena, outputs), greedy(arena, traced, outputs)];
    let cost = |order: &Vec<Expr>| (spills(arena, order), live_max(arena, order, outputs));
    candidates.into_iter().min_by_key(cost).unwrap_or_default()
}

/// Operands that earlier statements compute. Numbers and inputs do not count: they can be loaded when they are used.
fn computed_operands(arena: &Arena, expr: Expr) -> impl Iterator<Item = Expr> {
    arena.node(expr).operands().filter(|&e| arena.node(e).is_statement())
}

/// The same, each once.
fn distinct_operands(arena: &Arena, expr: Expr) -> impl Iterator<Item = Expr> {
    let mut first = None;
    computed_operands(arena, expr).filter(move |&operand| first.replace(operand) != Some(operand))
}

/// Single-precision registers of a Cortex-M4F, less two for the inputs and numbers of a statement.
const REGISTERS: usize = 30;

/// A list for each value, in one piece of memory.
struct Lists<T> {
    items: Vec<T>,
    /// For each value, where its list begins; the last entry is the end of the last list.
    begin: Vec<usize>,
}

impl<T: Copy + Default> Lists<T> {
    /// The items of each value, in the order in which `pairs` gives them. It is run twice.
    fn new<I: Iterator<Item = (Expr, T)>>(values: usize, pairs: impl Fn() -> I) -> Self {
        let mut begin = vec![0; values + 1];
        pairs().for_each(|(value, _)| begin[value.index() + 1] += 1);
        for value in 0..values {
            begin[value + 1] += begin[value];
        }
        let mut items = vec![T::default(); begin[values]];
        let mut next = begin.clone();
        for (value, item) in pairs() {
            items[next[value.index()]] = item;
            next[value.index()] += 1;
        }
        Self { items, begin }
    }

    fn of(&self, value: Expr) -> &[T] {
        &self.items[self.begin[value.index()]..self.begin[value.index() + 1]]
    }
}

/// The statements that use each value, in order. A statement that uses a value twice is there twice.
struct Uses {
    places: Lists<usize>,
    /// Number of uses that have passed, for each value.
    passed: Vec<usize>,
}

impl Uses {
    fn new(arena: &Arena, order: &[Expr]) -> Self {
        let values = arena.nodes().len();
        let places = Lists::new(values, || {
            let all = order.iter().enumerate();
            all.flat_map(|(place, &expr)| computed_operands(arena, expr).map(move |operand| (operand, place)))
        });
        Self { places, passed: vec![0; values] }
    }

    /// Passes one use of a value.
    fn pass(&mut self, expr: Expr) {
        self.passed[expr.index()] += 1;
    }

    /// The statement that uses a value next.
    fn next(&self, expr: Expr) -> Option<usize> {
        self.places.of(expr).get(self.passed[expr.index()]).copied()
    }
}

/// Stores and loads of values for which there is no free register. When a register is needed, the value whose next use is farthest is removed
/// (Belady's rule, which is optimal for loads). An output is stored at its destination and uses no register afterwards.
pub(super) fn spills(arena: &Arena, order: &[Expr]) -> usize {
    let mut uses = Uses::new(arena, order);
    // Next use of each value in a register, and the value.
    let mut held: Vec<(usize, Expr)> = Vec::with_capacity(REGISTERS + 3);
    let mut stored = vec![false; arena.nodes().len()];
    let mut moved = 0;
    for &expr in order {
        computed_operands(arena, expr).for_each(|operand| uses.pass(operand));
        for operand in distinct_operands(arena, expr) {
            let register = held.iter().position(|&(_, other)| other == operand);
            moved += usize::from(register.is_none());
            match (register, uses.next(operand)) {
                (Some(register), Some(next)) => held[register].0 = next,
                (Some(register), None) => {
                    held.swap_remove(register);
                }
                (None, Some(next)) => held.push((next, operand)),
                (None, None) => {}
            }
        }
        held.extend(uses.next(expr).map(|next| (next, expr)));
        while held.len() > REGISTERS
            && let Some((register, &(_, farthest))) = held.iter().enumerate().max_by_key(|(_, held)| **held)
        {
            held.swap_remove(register);
            moved += usize::from(!core::mem::replace(&mut stored[farthest.index()], true));
        }
    }
    moved
}

/// The most computed values alive at once.
pub(super) fn live_max(arena: &Arena, order: &[Expr], outputs: &[Expr]) -> usize {
    let mut last_use: Vec<Option<usize>> = vec![None; arena.nodes().len()];
    for (place, &expr) in order.iter().enumerate() {
        last_use[expr.index()] = Some(place);
        for operand in computed_operands(arena, expr) {
            last_use[operand.index()] = Some(place);
        }
    }
    for &output in outputs.iter().filter(|&&e| arena.node(e).is_statement()) {
        last_use[output.index()] = Some(order.len());
    }
    let mut dying = vec![0_usize; order.len() + 1];
    for place in last_use.into_iter().flatten() {
        dying[place] += 1;
    }
    let (mut alive, mut most) = (0, 0);
    for dies_here in dying.iter().take(order.len()) {
        // The result may take the register of an operand that is used for the last time.
        alive = alive + 1 - dies_here;
        most = most.max(alive);
    }
    most
}

/// Each output in turn, preceded by its operands, the larger operand first.
fn depth_first(arena: &Arena, outputs: &[Expr]) -> Vec<Expr> {
    let mut weight = vec![0_usize; arena.nodes().len()];
    for (i, node) in arena.nodes().iter().enumerate() {
        weight[i] = 1 + node.operands().map(|e| weight[e.index()]).max().unwrap_or(0);
    }
    let mut done = vec![false; arena.nodes().len()];
    let mut order = Vec::new();
    for &output in outputs {
        let mut stack = vec![(output, false)];
        while let Some((expr, ready)) = stack.pop() {
            if done[expr.index()] || !arena.node(expr).is_statement() {
                continue;
            }
            if ready {
                done[expr.index()] = true;
                order.push(expr);
                continue;
            }
            stack.push((expr, true));
            let mut operands: Vec<Expr> = arena.node(expr).operands().collect();
            operands.sort_by_key(|e| weight[e.index()]);
            stack.extend(operands.into_iter().map(|e| (e, false)));
        }
    }
    order
}

/// Chooses, among the statements that are ready, the one after which the most values are no longer needed; among equals, the one traced first.
fn greedy(arena: &Arena, traced: &[Expr], outputs: &[Expr]) -> Vec<Expr> {
    let nodes = arena.nodes().len();
    let users = Lists::new(nodes, || {
        traced.iter().flat_map(|&expr| distinct_operands(arena, expr).map(move |operand| (operand, Some(expr))))
    });
    let (mut uses, mut waits, mut done) = (vec![0_usize; nodes], vec![0_usize; nodes], vec![false; nodes]);
    for &expr in traced {
        uses[expr.index()] = users.of(expr).len();
        waits[expr.index()] = distinct_operands(arena, expr).count();
    }
    for &output in outputs.iter().filter(|&&e| arena.node(e).is_statement()) {
        uses[output.index()] += 1;
    }
    let rank = |expr: Expr, uses: &[usize]| {
        let ended = distinct_operands(arena, expr).filter(|e| uses[e.index()] == 1).count();
        (ended, Reverse(expr))
    };
    // A statement whose rank rises while it waits is there once more. The rank never falls.
    let mut ready: BinaryHeap<(usize, Reverse<Expr>)> =
        traced.iter().filter(|e| waits[e.index()] == 0).map(|&expr| rank(expr, &uses)).collect();
    let mut order = Vec::with_capacity(traced.len());
    while let Some((_, Reverse(next))) = ready.pop() {
        if core::mem::replace(&mut done[next.index()], true) {
            continue;
        }
        order.push(next);
        for operand in distinct_operands(arena, next) {
            uses[operand.index()] -= 1;
            if uses[operand.index()] == 1 {
                let last = users.of(operand).iter().flatten().filter(|e| !done[e.index()] && waits[e.index()] == 0);
                ready.extend(last.map(|&expr| rank(expr, &uses)));
            }
        }
        for &user in users.of(next).iter().flatten() {
            waits[user.index()] -= 1;
            if waits[user.index()] == 0 {
                ready.push(rank(user, &uses));
            }
        }
    }
    order
}
