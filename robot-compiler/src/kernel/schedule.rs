//! Order of the statements: few values alive at once, because every value beyond the registers costs a store and a load.
//!
//! A simulated arm is scheduled while the user waits, so tables are indexed by a value's index in the arena for speed.

use super::arena::{Arena, Expr};

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

/// Stores and loads of values for which there is no free register. When a register is needed, the value whose next use is farthest is removed
/// (Belady's rule, which is optimal for loads). An output is stored at its destination and uses no register afterwards.
pub(super) fn spills(arena: &Arena, order: &[Expr]) -> usize {
    // Statements that use a value, the last one first.
    let mut uses: Vec<Vec<usize>> = vec![Vec::new(); arena.nodes().len()];
    for (place, &expr) in order.iter().enumerate().rev() {
        for operand in computed_operands(arena, expr) {
            uses[operand.index()].push(place);
        }
    }
    let mut held: Vec<Expr> = Vec::with_capacity(REGISTERS + 3);
    let mut stored = vec![false; arena.nodes().len()];
    let mut moved = 0;
    for &expr in order {
        for operand in distinct_operands(arena, expr) {
            if !held.contains(&operand) {
                held.push(operand);
                moved += 1;
            }
        }
        for operand in computed_operands(arena, expr) {
            uses[operand.index()].pop();
        }
        let next = |e: Expr| uses[e.index()].last().copied();
        held.retain(|&e| next(e).is_some());
        if next(expr).is_some() {
            held.push(expr);
        }
        while held.len() > REGISTERS
            && let Some(farthest) = (0..held.len()).max_by_key(|&k| (next(held[k]), held[k]))
        {
            let farthest = held.swap_remove(farthest);
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
    let (mut uses, mut waits) = (vec![0_usize; nodes], vec![0_usize; nodes]);
    let mut users: Vec<Vec<Expr>> = vec![Vec::new(); nodes];
    for &expr in traced {
        for operand in distinct_operands(arena, expr) {
            waits[expr.index()] += 1;
            uses[operand.index()] += 1;
            users[operand.index()].push(expr);
        }
    }
    for &output in outputs.iter().filter(|&&e| arena.node(e).is_statement()) {
        uses[output.index()] += 1;
    }
    let mut ready: Vec<Expr> = traced.iter().copied().filter(|e| waits[e.index()] == 0).collect();
    let mut order = Vec::with_capacity(traced.len());
    while let Some(place) = (0..ready.len()).max_by_key(|&k| {
        let ended = distinct_operands(arena, ready[k]).filter(|e| uses[e.index()] == 1).count();
        (ended, core::cmp::Reverse(ready[k]))
    }) {
        let next = ready.swap_remove(place);
        order.push(next);
        for operand in distinct_operands(arena, next) {
            uses[operand.index()] -= 1;
        }
        for &user in &users[next.index()] {
            waits[user.index()] -= 1;
            if waits[user.index()] == 0 {
                ready.push(user);
            }
        }
    }
    order
}
