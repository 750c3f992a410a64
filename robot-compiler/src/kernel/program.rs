//! The statements of a tape that the outputs need.

use super::arena::{Arena, Expr, Node};
use super::schedule;
use dynamics_core::scalar::Label;

/// A straight-line program: statements in order, each made of numbers, inputs and earlier statements.
#[derive(Clone, Debug)]
pub struct Program {
    arena: Arena,
    order: Vec<Expr>,
    outputs: Vec<Expr>,
    live_max: usize,
}

/// Operation counts of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Operations {
    /// Multiplications.
    pub mul: usize,
    /// Additions.
    pub add: usize,
    /// Subtractions.
    pub sub: usize,
    /// Divisions; only forward dynamics has any.
    pub div: usize,
    /// Negations.
    pub neg: usize,
}

impl Operations {
    /// Multiplications, additions, subtractions and divisions. A negation only flips a bit and does not count.
    #[must_use]
    pub const fn total(&self) -> usize {
        self.mul + self.add + self.sub + self.div
    }
}

impl Program {
    /// The part of `arena` that the outputs need, in an order that keeps few values alive.
    #[must_use]
    pub fn new(mut arena: Arena, outputs: &[Expr]) -> Self {
        let outputs: Vec<Expr> = outputs.iter().map(|&output| turn_over(&mut arena, output)).collect();
        let needed = needed(&arena, &outputs);
        let traced: Vec<Expr> = needed.iter().copied().filter(|&e| arena.node(e).is_statement()).collect();
        let order = schedule::few_alive(&arena, &traced, &outputs);
        let live_max = schedule::live_max(&arena, &order, &outputs);
        Self { arena, order, outputs, live_max }
    }

    /// The statements' values, in order.
    #[must_use]
    pub fn order(&self) -> &[Expr] {
        &self.order
    }

    /// The values of the outputs. An output may be a number or an input, and may occur twice.
    #[must_use]
    pub fn outputs(&self) -> &[Expr] {
        &self.outputs
    }

    /// Origin of a value.
    #[must_use]
    pub fn node(&self, expr: Expr) -> Node {
        self.arena.node(expr)
    }

    /// Name of a value.
    #[must_use]
    pub fn label(&self, expr: Expr) -> Option<Label> {
        self.arena.label(expr)
    }

    /// The value of a constant; `None` for any other expression.
    #[must_use]
    pub fn number(&self, expr: Expr) -> Option<f64> {
        self.arena.number(expr)
    }

    /// Most computed values alive at once: the size of the register file that would hold them.
    #[must_use]
    pub fn live_max(&self) -> usize {
        self.live_max
    }

    /// Most values alive at once with the statements in traced order.
    #[must_use]
    pub fn live_max_as_traced(&self) -> usize {
        schedule::live_max(&self.arena, &self.traced(), &self.outputs)
    }

    /// The same program with its statements in traced order.
    #[must_use]
    pub fn as_traced(&self) -> Self {
        let (order, live_max) = (self.traced(), self.live_max_as_traced());
        Self { order, live_max, ..self.clone() }
    }

    /// Stores and loads that a Cortex-M4F's 32 registers would require, with the statements in this order.
    #[must_use]
    pub fn spills(&self) -> usize {
        schedule::spills(&self.arena, &self.order)
    }

    fn traced(&self) -> Vec<Expr> {
        let mut traced = self.order.clone();
        traced.sort_unstable();
        traced
    }

    /// Operation counts of the program.
    #[must_use]
    pub fn operations(&self) -> Operations {
        let mut operations = Operations::default();
        for &expr in &self.order {
            match self.node(expr) {
                Node::Add(..) => operations.add += 1,
                Node::Sub(..) => operations.sub += 1,
                Node::Mul(..) => operations.mul += 1,
                Node::Div(..) => operations.div += 1,
                Node::Neg(_) => operations.neg += 1,
                Node::Constant(_) | Node::Input(_) => {}
            }
        }
        operations
    }

    /// The numbers of the inputs that the program reads, in order.
    #[must_use]
    pub fn inputs(&self) -> Vec<u32> {
        let mut inputs: Vec<u32> = needed(&self.arena, &self.outputs)
            .into_iter()
            .filter_map(|e| if let Node::Input(number) = self.node(e) { Some(number) } else { None })
            .collect();
        inputs.sort_unstable();
        inputs
    }

    /// Runs the program with the interpreter of the tape. Missing inputs count as zero.
    #[must_use]
    pub fn evaluate<S: dynamics_core::Field>(&self, inputs: &[S]) -> Vec<S> {
        let mut values = vec![S::zero(); self.arena.nodes().len()];
        let leaves = self.arena.nodes().iter().enumerate();
        for (i, node) in leaves {
            match *node {
                Node::Constant(bits) => values[i] = S::literal(f64::from_bits(bits)),
                Node::Input(number) => {
                    values[i] = inputs.get(number as usize).copied().unwrap_or_else(S::zero);
                }
                Node::Add(..) | Node::Sub(..) | Node::Mul(..) | Node::Div(..) | Node::Neg(_) => {}
            }
        }
        for &expr in &self.order {
            let value = |e: Expr| values[e.index()];
            values[expr.index()] = match self.node(expr) {
                Node::Add(a, b) => value(a) + value(b),
                Node::Sub(a, b) => value(a) - value(b),
                Node::Mul(a, b) => value(a) * value(b),
                Node::Div(a, b) => value(a) / value(b),
                Node::Neg(a) => -value(a),
                Node::Constant(_) | Node::Input(_) => continue,
            };
        }
        self.outputs.iter().map(|output| values[output.index()]).collect()
    }
}

/// Multiplications, additions, subtractions and divisions that the outputs need.
pub(super) fn operations(arena: &Arena, outputs: &[Expr]) -> usize {
    let counts = |e: &&Expr| matches!(arena.node(**e), Node::Add(..) | Node::Sub(..) | Node::Mul(..) | Node::Div(..));
    needed(arena, outputs).iter().filter(counts).count()
}

/// Rewrites an output `-(a - b)` as `b - a`: the sign that moved out of the last difference moves back in.
fn turn_over(arena: &mut Arena, output: Expr) -> Expr {
    if let Node::Neg(inner) = arena.node(output)
        && let Node::Sub(a, b) = arena.node(inner)
    {
        return arena.write(Node::Sub(b, a));
    }
    output
}

/// All operands of the outputs, direct and indirect, each after its own operands.
pub(super) fn needed(arena: &Arena, outputs: &[Expr]) -> Vec<Expr> {
    let mut seen = vec![false; arena.nodes().len()];
    let mut pending = outputs.to_vec();
    let mut found = Vec::new();
    while let Some(expr) = pending.pop() {
        if !core::mem::replace(&mut seen[expr.index()], true) {
            found.push(expr);
            pending.extend(arena.node(expr).operands());
        }
    }
    found.sort_unstable();
    found
}
