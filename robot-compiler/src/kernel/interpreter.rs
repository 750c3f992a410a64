//! Fast interpreter of a program, for the desk, where no compiler is available at run time.
//!
//! [`Program::evaluate`] visits one node after another and allocates; this interpreter is prepared once. Statements of
//! the same kind (a product, a sum, ..) form runs, one loop each, so the kind is decided once per run and not once per
//! statement. Values are in slots; a slot is reused after the last read of its value. The operations, and so the bits,
//! are those of the program; only their order differs.

use super::arena::{Expr, Node};
use super::program::Program;
use dynamics_core::Real;
use std::collections::{BTreeSet, HashMap};

/// Slots for inputs, numbers and values. The count is a power of two: a slot number masked to that many bits is always
/// inside, so the compiler omits the bounds check. A six-joint arm needs less than half of the slots.
const SLOTS: usize = 1024;

/// Index of a slot in the memory.
type Slot = u16;

/// The operation of a run of statements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum Operation {
    Add,
    Sub,
    Mul,
    Div,
    Neg,
}

/// Slots of a result and its operands; a negation has the same operand twice.
#[derive(Clone, Copy, Debug)]
struct Statement {
    to: Slot,
    a: Slot,
    b: Slot,
}

/// Statements of one kind, in an order in which each finds its operands ready.
#[derive(Clone, Debug)]
struct Run {
    kind: Operation,
    end: usize,
}

/// A program prepared to run in `S`.
#[derive(Clone, Debug)]
pub struct Interpreter<S> {
    /// Inputs first, then numbers, which no statement overwrites, and values.
    memory: Box<[S; SLOTS]>,
    inputs: usize,
    statements: Vec<Statement>,
    runs: Vec<Run>,
    outputs: Vec<Slot>,
}

impl<S: Real> Interpreter<S> {
    /// Prepares a program; `inputs` is the number of inputs that the caller will pass. `None` if it needs more than 1,024
    /// slots.
    #[must_use]
    pub fn new(program: &Program, inputs: usize) -> Option<Self> {
        Builder::new(program, inputs)?.build()
    }

    /// Runs the program on these inputs and writes the values of the outputs to `outputs`. Missing inputs count as zero.
    pub fn run(&mut self, inputs: &[S], outputs: &mut [S]) {
        let memory = &mut *self.memory;
        for (place, input) in memory[..self.inputs].iter_mut().enumerate() {
            *input = inputs.get(place).copied().unwrap_or_else(S::zero);
        }
        let mut start = 0;
        for run in &self.runs {
            let statements = &self.statements[start..run.end];
            start = run.end;
            match run.kind {
                Operation::Add => each(memory, statements, |a, b| a + b),
                Operation::Sub => each(memory, statements, |a, b| a - b),
                Operation::Mul => each(memory, statements, |a, b| a * b),
                Operation::Div => each(memory, statements, |a, b| a / b),
                Operation::Neg => each(memory, statements, |a, _| -a),
            }
        }
        for (output, &slot) in outputs.iter_mut().zip(&self.outputs) {
            *output = memory[usize::from(slot) % SLOTS];
        }
    }
}

#[inline]
fn each<S: Real>(memory: &mut [S; SLOTS], statements: &[Statement], operation: impl Fn(S, S) -> S) {
    for &Statement { to, a, b } in statements {
        memory[usize::from(to) % SLOTS] = operation(memory[usize::from(a) % SLOTS], memory[usize::from(b) % SLOTS]);
    }
}

/// Memory while a program is prepared.
struct Builder<'a> {
    program: &'a Program,
    inputs: usize,
    /// Statements that wait for operands, with the number of operands.
    waits: HashMap<Expr, usize>,
    users: HashMap<Expr, Vec<Expr>>,
    /// Number of reads left for a value; outputs have one extra read and are never released.
    reads: HashMap<Expr, usize>,
    slots: HashMap<Expr, Slot>,
    free: Vec<Slot>,
    used: usize,
}

impl<'a> Builder<'a> {
    fn new(program: &'a Program, inputs: usize) -> Option<Self> {
        let mut builder = Self {
            program,
            inputs,
            waits: HashMap::new(),
            users: HashMap::new(),
            reads: HashMap::new(),
            slots: HashMap::new(),
            free: Vec::new(),
            used: inputs,
        };
        for &output in program.outputs() {
            *builder.reads.entry(output).or_default() += 1;
            builder.leaf(output)?;
        }
        for &expr in program.order() {
            let mut waits = 0;
            for operand in program.node(expr).operands() {
                *builder.reads.entry(operand).or_default() += 1;
                if kind(program.node(operand)).is_some() {
                    waits += 1;
                    builder.users.entry(operand).or_default().push(expr);
                }
                builder.leaf(operand)?;
            }
            builder.waits.insert(expr, waits);
        }
        Some(builder)
    }

    /// A slot for a number or an input.
    fn leaf(&mut self, expr: Expr) -> Option<()> {
        match self.program.node(expr) {
            Node::Input(number) => {
                let number = number as usize;
                if number >= self.inputs {
                    return None;
                }
                self.slots.insert(expr, Slot::try_from(number).ok()?);
            }
            Node::Constant(_) if !self.slots.contains_key(&expr) => {
                let slot = self.fresh()?;
                self.slots.insert(expr, slot);
            }
            _ => {}
        }
        Some(())
    }

    fn fresh(&mut self) -> Option<Slot> {
        let slot = Slot::try_from(self.used).ok()?;
        self.used += 1;
        (self.used <= SLOTS).then_some(slot)
    }

    /// Builds one run after another: picks the kind with the most ready statements, and takes all statements of that kind that are or become
    /// ready.
    fn build<S: Real>(mut self) -> Option<Interpreter<S>> {
        let mut memory = Box::new([S::zero(); SLOTS]);
        for (&expr, &slot) in &self.slots {
            if let Some(number) = self.program.number(expr) {
                memory[usize::from(slot)] = S::literal(number);
            }
        }
        let mut ready: HashMap<Operation, BTreeSet<Expr>> = HashMap::new();
        for &expr in self.program.order() {
            if self.waits.get(&expr) == Some(&0) {
                ready.entry(kind(self.program.node(expr))?).or_default().insert(expr);
            }
        }
        let (mut statements, mut runs) = (Vec::new(), Vec::new());
        while let Some(next) = most(&ready) {
            while let Some(expr) = ready.get_mut(&next).and_then(BTreeSet::pop_first) {
                statements.push(self.statement(expr)?);
                for user in self.users.get(&expr).cloned().unwrap_or_default() {
                    let left = self.waits.get_mut(&user)?;
                    *left -= 1;
                    if *left == 0 {
                        ready.entry(kind(self.program.node(user))?).or_default().insert(user);
                    }
                }
            }
            runs.push(Run { kind: next, end: statements.len() });
        }
        let outputs = self.program.outputs().iter().map(|output| self.slots.get(output).copied());
        Some(Interpreter { memory, inputs: self.inputs, statements, runs, outputs: outputs.collect::<Option<_>>()? })
    }

    fn statement(&mut self, expr: Expr) -> Option<Statement> {
        let operands: Vec<Expr> = self.program.node(expr).operands().collect();
        let slot = |builder: &Self, place: usize| builder.slots.get(operands.get(place)?).copied();
        let a = slot(self, 0)?;
        let b = slot(self, 1).unwrap_or(a);
        for operand in &operands {
            let left = self.reads.get_mut(operand)?;
            *left -= 1;
            // Numbers and inputs keep their slots: the next run of the program needs them again.
            if *left == 0 && kind(self.program.node(*operand)).is_some() {
                self.free.push(*self.slots.get(operand)?);
            }
        }
        let to = match self.free.pop() {
            Some(slot) => slot,
            None => self.fresh()?,
        };
        self.slots.insert(expr, to);
        Some(Statement { to, a, b })
    }
}

/// The kind with the most ready statements.
fn most(ready: &HashMap<Operation, BTreeSet<Expr>>) -> Option<Operation> {
    let waiting = ready.iter().filter(|(_, statements)| !statements.is_empty());
    waiting.max_by_key(|(kind, statements)| (statements.len(), **kind)).map(|(kind, _)| *kind)
}

/// The operation of a statement; `None` for a number or an input.
const fn kind(node: Node) -> Option<Operation> {
    match node {
        Node::Add(..) => Some(Operation::Add),
        Node::Sub(..) => Some(Operation::Sub),
        Node::Mul(..) => Some(Operation::Mul),
        Node::Div(..) => Some(Operation::Div),
        Node::Neg(_) => Some(Operation::Neg),
        Node::Constant(_) | Node::Input(_) => None,
    }
}
