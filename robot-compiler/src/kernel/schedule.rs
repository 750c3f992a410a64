//! Order of the statements: few values alive at once, because every value beyond the registers costs a store and a load.

use super::arena::{Arena, Expr};
use std::collections::{BTreeMap, BTreeSet, VecDeque};

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

/// Single-precision registers of a Cortex-M4F, less two for the inputs and numbers of a statement.
const REGISTERS: usize = 30;

/// Stores and loads of values that find no register. When a register is needed, the value whose next use is farthest goes
/// (Belady's rule, which is optimal for loads). An output is stored at its destination and takes no register afterwards.
pub(super) fn spills(arena: &Arena, order: &[Expr]) -> usize {
    let mut uses: BTreeMap<Expr, VecDeque<usize>> = BTreeMap::new();
    for (place, &expr) in order.iter().enumerate() {
        for operand in computed_operands(arena, expr) {
            uses.entry(operand).or_default().push_back(place);
        }
    }
    let mut held: BTreeSet<Expr> = BTreeSet::new();
    let mut stored: BTreeSet<Expr> = BTreeSet::new();
    let mut moved = 0;
    for &expr in order {
        let operands: BTreeSet<Expr> = computed_operands(arena, expr).collect();
        for &operand in &operands {
            if held.insert(operand) {
                moved += 1;
            }
        }
        for operand in computed_operands(arena, expr) {
            if let Some(places) = uses.get_mut(&operand) {
                places.pop_front();
            }
        }
        let next = |e: &Expr| uses.get(e).and_then(|places| places.front()).copied();
        held.retain(|e| next(e).is_some());
        if next(&expr).is_some() {
            held.insert(expr);
        }
        while held.len() > REGISTERS
            && let Some(farthest) = held.iter().copied().max_by_key(|e| next(e))
        {
            held.remove(&farthest);
            moved += usize::from(stored.insert(farthest));
        }
    }
    moved
}

/// The most computed values alive at once.
pub(super) fn live_max(arena: &Arena, order: &[Expr], outputs: &[Expr]) -> usize {
    let mut last_use: BTreeMap<Expr, usize> = BTreeMap::new();
    for (place, &expr) in order.iter().enumerate() {
        last_use.insert(expr, place);
        for operand in computed_operands(arena, expr) {
            last_use.insert(operand, place);
        }
    }
    for &output in outputs.iter().filter(|&&e| arena.node(e).is_statement()) {
        last_use.insert(output, order.len());
    }
    let mut dying = vec![0_usize; order.len() + 1];
    for &place in last_use.values() {
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
    let mut done = BTreeSet::new();
    let mut order = Vec::new();
    for &output in outputs {
        let mut stack = vec![(output, false)];
        while let Some((expr, ready)) = stack.pop() {
            if done.contains(&expr) || !arena.node(expr).is_statement() {
                continue;
            }
            if ready {
                done.insert(expr);
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

/// Takes, among the statements that are ready, the one that ends the most lives; among equals, the one traced first.
fn greedy(arena: &Arena, traced: &[Expr], outputs: &[Expr]) -> Vec<Expr> {
    let mut uses: BTreeMap<Expr, usize> = BTreeMap::new();
    let mut users: BTreeMap<Expr, Vec<Expr>> = BTreeMap::new();
    let mut waits: BTreeMap<Expr, usize> = BTreeMap::new();
    for &expr in traced {
        let operands: BTreeSet<Expr> = computed_operands(arena, expr).collect();
        waits.insert(expr, operands.len());
        for operand in operands {
            *uses.entry(operand).or_default() += 1;
            users.entry(operand).or_default().push(expr);
        }
    }
    for &output in outputs.iter().filter(|&&e| arena.node(e).is_statement()) {
        *uses.entry(output).or_default() += 1;
    }
    let mut ready: BTreeSet<Expr> = waits.iter().filter(|(_, n)| **n == 0).map(|(e, _)| *e).collect();
    let mut order = Vec::with_capacity(traced.len());
    while let Some(next) = ready.iter().copied().max_by_key(|&expr| {
        let operands: BTreeSet<Expr> = arena.node(expr).operands().collect();
        let ended = operands.iter().filter(|e| uses.get(e) == Some(&1)).count();
        (ended, core::cmp::Reverse(expr))
    }) {
        ready.remove(&next);
        order.push(next);
        let operands: BTreeSet<Expr> = arena.node(next).operands().collect();
        for operand in operands {
            if let Some(left) = uses.get_mut(&operand) {
                *left -= 1;
            }
        }
        for &user in users.get(&next).into_iter().flatten() {
            if let Some(left) = waits.get_mut(&user) {
                *left -= 1;
                if *left == 0 {
                    ready.insert(user);
                }
            }
        }
    }
    order
}
