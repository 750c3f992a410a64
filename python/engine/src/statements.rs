//! From a function of an arm to the statements of a program.
//!
//! The robot compiler's tape records the recursion, at level exact: results are equal (`==`) to those of the recursion for finite
//! inputs. Then products that are read once, by a sum or a difference, join its statement. Both operations are still rounded.

use crate::quantity::Quantity;
use dynamics_core::{Dynamics, Model, Scene, SinCos};
use robot_compiler::kernel::tape::{Arena, Expr, Node, input, trace};
use robot_compiler::kernel::{Precision, Program, RuleSet};
use std::collections::HashMap;

/// Index of a value in the memory of a kernel.
pub type Slot = u16;

/// One statement: results and operands are slots; `k` is a number of [`Statements::numbers`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Statement {
    /// `a + b`
    Add([Slot; 3]),
    /// `a - b`
    Sub([Slot; 3]),
    /// `a b`
    Mul([Slot; 3]),
    /// `a / b`
    Div([Slot; 3]),
    /// `-a`
    Neg([Slot; 2]),
    /// `a b + c`
    MulAdd([Slot; 4]),
    /// `a b - c`
    MulSub([Slot; 4]),
    /// `c - a b`
    SubMul([Slot; 4]),
}

/// Source of an input of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// Sine of a joint's position.
    Sine(usize),
    /// Cosine of a joint's position.
    Cosine(usize),
    /// Entry of an input list: the list, and the joint.
    List(usize, usize),
}

/// A program in the form that a kernel executes.
#[derive(Clone, Debug, Default)]
pub struct Statements {
    /// Slots that the caller fills, and their source.
    pub inputs: Vec<(Slot, Source)>,
    /// Slots that hold numbers.
    pub numbers: Vec<(Slot, f64)>,
    /// Statements in order.
    pub statements: Vec<Statement>,
    /// Slot of each output.
    pub outputs: Vec<Slot>,
    /// Number of slots.
    pub slots: usize,
}

/// Traces a function of the arm and returns its statements.
#[must_use]
pub fn statements<const N: usize>(
    quantity: Quantity,
    model: &Model<f64, N>,
    scene: &Scene<f64, N>,
    precision: Precision,
) -> Statements {
    let (outputs, arena) = trace(Arena::new(RuleSet::ALL, precision), || {
        let list = |group: usize| -> [Expr; N] { core::array::from_fn(|i| input((group * N + i) as u32)) };
        let turn: [SinCos<Expr>; N] = core::array::from_fn(|i| SinCos { sin: list(0)[i], cos: list(1)[i] });
        let dynamics = Dynamics::new(model.cast::<Expr>(), scene.cast());
        let mut out = vec![list(0)[0]; quantity.outputs(N)];
        quantity.evaluate(&dynamics, &turn, [&list(2), &list(3), &list(4)], &mut out);
        out
    });
    Builder::new(&Program::new(arena, &outputs)).build(N)
}

/// Source of the input with this number, in the order of [`statements`].
fn source(number: usize, joints: usize) -> Source {
    let joint = number % joints;
    match number / joints {
        0 => Source::Sine(joint),
        1 => Source::Cosine(joint),
        list => Source::List(list - 2, joint),
    }
}

/// Assignment of slots while the statements are written.
struct Builder<'a> {
    program: &'a Program,
    /// Reads that remain for each value; an output has one more, which never happens.
    reads: HashMap<Expr, usize>,
    /// Products that are part of the statement that reads them.
    joined: HashMap<Expr, (Expr, Expr)>,
    slots: HashMap<Expr, Slot>,
    free: Vec<Slot>,
    out: Statements,
}

impl<'a> Builder<'a> {
    fn new(program: &'a Program) -> Self {
        let mut reads: HashMap<Expr, usize> = HashMap::new();
        let operands = program.order().iter().flat_map(|expr| program.node(*expr).operands());
        for expr in operands.chain(program.outputs().iter().copied()) {
            *reads.entry(expr).or_default() += 1;
        }
        let mut builder = Self {
            program,
            reads,
            joined: HashMap::new(),
            slots: HashMap::new(),
            free: Vec::new(),
            out: Statements::default(),
        };
        for expr in program.order() {
            builder.join(*expr);
        }
        builder
    }

    /// Marks a product that only this sum or difference reads.
    fn join(&mut self, expr: Expr) {
        let (Node::Add(a, b) | Node::Sub(a, b)) = self.program.node(expr) else { return };
        if a == b {
            return;
        }
        for operand in [a, b] {
            if let Node::Mul(x, y) = self.program.node(operand)
                && self.reads.get(&operand) == Some(&1)
            {
                self.joined.insert(operand, (x, y));
                return;
            }
        }
    }

    fn build(mut self, joints: usize) -> Statements {
        for number in self.program.inputs() {
            let slot = self.fresh();
            self.out.inputs.push((slot, source(number as usize, joints)));
        }
        let leaves: Vec<Expr> = (self.program.order().iter())
            .flat_map(|expr| self.program.node(*expr).operands())
            .chain(self.program.outputs().iter().copied())
            .collect();
        for expr in leaves {
            self.leaf(expr, joints);
        }
        for &expr in self.program.order() {
            if !self.joined.contains_key(&expr) {
                self.statement(expr);
            }
        }
        self.out.outputs = self.program.outputs().iter().map(|expr| self.slot(*expr)).collect();
        self.out
    }

    /// Gives a number or an input its slot.
    fn leaf(&mut self, expr: Expr, joints: usize) {
        if self.slots.contains_key(&expr) {
            return;
        }
        let slot = match self.program.node(expr) {
            Node::Input(number) => {
                let wanted = source(number as usize, joints);
                self.out.inputs.iter().find(|(_, source)| *source == wanted).map(|(slot, _)| *slot)
            }
            Node::Constant(bits) => {
                let slot = self.fresh();
                self.out.numbers.push((slot, f64::from_bits(bits)));
                Some(slot)
            }
            _ => None,
        };
        if let Some(slot) = slot {
            self.slots.insert(expr, slot);
        }
    }

    fn fresh(&mut self) -> Slot {
        let slot = self.out.slots as Slot;
        self.out.slots += 1;
        slot
    }

    /// Slot of a value that was computed before.
    fn slot(&self, expr: Expr) -> Slot {
        self.slots.get(&expr).copied().unwrap_or_default()
    }

    fn statement(&mut self, expr: Expr) {
        let operands: Vec<Expr> = self.program.node(expr).operands().collect();
        let product = operands.iter().find_map(|operand| self.joined.get(operand).map(|pair| (*operand, *pair)));
        let read: Vec<Expr> = match product {
            None => operands.clone(),
            Some((product, (x, y))) => {
                let other = if operands[0] == product { operands[1] } else { operands[0] };
                vec![x, y, other]
            }
        };
        let slots: Vec<Slot> = read.iter().map(|expr| self.slot(*expr)).collect();
        for expr in read {
            self.release(expr);
        }
        let to = self.free.pop().unwrap_or_else(|| self.fresh());
        self.slots.insert(expr, to);
        let node = self.program.node(expr);
        self.out.statements.push(match (node, slots.as_slice(), product) {
            (Node::Add(..), &[a, b, c], Some(_)) => Statement::MulAdd([to, a, b, c]),
            (Node::Sub(first, _), &[a, b, c], Some((product, _))) if first == product => {
                Statement::MulSub([to, a, b, c])
            }
            (Node::Sub(..), &[a, b, c], Some(_)) => Statement::SubMul([to, a, b, c]),
            (Node::Add(..), &[a, b], _) => Statement::Add([to, a, b]),
            (Node::Sub(..), &[a, b], _) => Statement::Sub([to, a, b]),
            (Node::Mul(..), &[a, b], _) => Statement::Mul([to, a, b]),
            (Node::Div(..), &[a, b], _) => Statement::Div([to, a, b]),
            (_, slots, _) => Statement::Neg([to, slots.first().copied().unwrap_or_default()]),
        });
    }

    /// Counts a read; after the last one the slot of a computed value is free.
    fn release(&mut self, expr: Expr) {
        let Some(left) = self.reads.get_mut(&expr) else { return };
        *left -= 1;
        let computed = !matches!(self.program.node(expr), Node::Constant(_) | Node::Input(_));
        if *left == 0
            && computed
            && let Some(slot) = self.slots.get(&expr)
        {
            self.free.push(*slot);
        }
    }
}
