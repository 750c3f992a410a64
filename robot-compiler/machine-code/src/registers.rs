//! Register allocation: which value is in which register while a program runs.
//!
//! All statements are known in advance, so when a register is needed, the value whose next use is farthest is removed (L. A. Belady, A study of
//! replacement algorithms for a virtual-storage computer, 1966). Inputs and numbers have slots in memory from the start and are simply
//! dropped; a computed value is stored first, once.

use core::ops::Range;
use robot_compiler::kernel::Program;
use robot_compiler::kernel::tape::{Expr, Node};

/// A vector register, by its number.
pub(crate) type Register = u8;

/// Operation of a statement. A negation is computed as a difference from -0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Operation {
    Add,
    Sub,
    Mul,
    Div,
}

/// Second operand of a statement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Operand {
    Register(Register),
    Place(usize),
}

/// One instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Instruction {
    Load { to: Register, from: usize },
    Store { to: usize, from: Register },
    Compute { operation: Operation, to: Register, a: Register, b: Operand },
}

/// A program's instructions, and the memory slots that they use.
#[derive(Clone, Debug)]
pub(crate) struct Allocation {
    pub(crate) instructions: Vec<Instruction>,
    /// Number of slots in memory: inputs first, then outputs.
    pub(crate) places: usize,
    pub(crate) inputs: usize,
    pub(crate) outputs: usize,
    /// Slots that hold numbers, and the numbers.
    pub(crate) numbers: Vec<(usize, f64)>,
}

/// Instructions of a program for this number of registers, at least three.
pub(crate) fn allocate(program: &Program, inputs: usize, registers: Register) -> Allocation {
    let mut allocator = Allocator::new(program, inputs, registers);
    for (now, &expr) in program.order().iter().enumerate() {
        allocator.statement(now, expr);
    }
    allocator.finish()
}

/// Stands for the next use of a value that is never used again.
const NEVER: usize = usize::MAX;

/// Where a value is, and its further uses. An arm is compiled while the user waits, so there is one of these for each value, by its index.
#[derive(Clone, Debug, Default)]
struct Value {
    /// Its uses to come: a range of [`Allocator::uses`].
    uses: Range<usize>,
    register: Option<Register>,
    /// Its slot in memory.
    home: Option<usize>,
    /// Its first place among the outputs.
    output: Option<usize>,
}

struct Allocator<'a> {
    program: &'a Program,
    values: Vec<Value>,
    /// Statements that use each value, in order and each once: one list after another.
    uses: Vec<usize>,
    /// Value in each register.
    held: Vec<Option<Expr>>,
    /// Slots that no value needs any more, and those that no value needs after the current statement.
    free: Vec<usize>,
    released: Vec<usize>,
    minus_zero: Option<usize>,
    out: Allocation,
}

impl<'a> Allocator<'a> {
    fn new(program: &'a Program, inputs: usize, registers: Register) -> Self {
        let order = program.order();
        let all = order.iter().flat_map(|&expr| program.node(expr).operands()).chain(order.iter().copied());
        let count = all.chain(program.outputs().iter().copied()).map(Expr::index).max().map_or(0, |last| last + 1);
        let mut values = vec![Value::default(); count];
        let mut number = vec![0; count];
        for operand in order.iter().flat_map(|&expr| program.node(expr).operands()) {
            number[operand.index()] += 1;
        }
        let mut begun = 0;
        for (value, number) in values.iter_mut().zip(number) {
            (value.uses, begun) = (begun..begun, begun + number);
        }
        let mut uses = vec![0; begun];
        for (place, &expr) in order.iter().enumerate() {
            for operand in program.node(expr).operands() {
                let range = &mut values[operand.index()].uses;
                if range.start == range.end || uses[range.end - 1] != place {
                    uses[range.end] = place;
                    range.end += 1;
                }
            }
        }
        for (output, &expr) in program.outputs().iter().enumerate().rev() {
            values[expr.index()].output = Some(output);
        }
        let inputs = program.inputs().last().map_or(inputs, |&last| inputs.max(last as usize + 1));
        let outputs = program.outputs().len();
        let out =
            Allocation { instructions: Vec::new(), places: inputs + outputs, inputs, outputs, numbers: Vec::new() };
        let held = vec![None; usize::from(registers)];
        Self { program, values, uses, held, free: Vec::new(), released: Vec::new(), minus_zero: None, out }
    }

    fn value(&self, expr: Expr) -> &Value {
        &self.values[expr.index()]
    }

    fn value_mut(&mut self, expr: Expr) -> &mut Value {
        &mut self.values[expr.index()]
    }

    fn statement(&mut self, now: usize, expr: Expr) {
        let (operation, [a, b]) = match self.program.node(expr) {
            Node::Add(a, b) => (Operation::Add, self.register_first([a, b])),
            Node::Mul(a, b) => (Operation::Mul, self.register_first([a, b])),
            Node::Sub(a, b) => (Operation::Sub, [a, b]),
            Node::Div(a, b) => (Operation::Div, [a, b]),
            Node::Neg(b) => return self.negation(now, expr, b),
            Node::Constant(_) | Node::Input(_) => return,
        };
        let a_register = self.loaded(a, &[b]);
        let b_operand = self.operand(b, now, a);
        self.used(now, [a, b]);
        self.compute(expr, operation, a_register, b_operand);
    }

    /// `-0 - b`, which is `-b` for every number.
    fn negation(&mut self, now: usize, expr: Expr, b: Expr) {
        let zero = self.minus_zero.unwrap_or_else(|| self.number(-0.0));
        self.minus_zero = Some(zero);
        let a_register = self.vacant(&[b]);
        self.out.instructions.push(Instruction::Load { to: a_register, from: zero });
        let b_operand = match self.value(b).register {
            Some(register) => Operand::Register(register),
            None => Operand::Place(self.home(b)),
        };
        self.used(now, [b, b]);
        self.compute(expr, Operation::Sub, a_register, b_operand);
    }

    /// The operands of a commutative operation, ordered so that one in a register comes first.
    fn register_first(&self, [a, b]: [Expr; 2]) -> [Expr; 2] {
        if self.value(a).register.is_none() && self.value(b).register.is_some() { [b, a] } else { [a, b] }
    }

    fn compute(&mut self, expr: Expr, operation: Operation, a: Register, b: Operand) {
        let to = self.vacant(&[]);
        self.out.instructions.push(Instruction::Compute { operation, to, a, b });
        self.free.append(&mut self.released);
        if let Some(output) = self.value(expr).output {
            let place = self.out.inputs + output;
            self.out.instructions.push(Instruction::Store { to: place, from: to });
            self.value_mut(expr).home = Some(place);
        }
        if self.next_use(expr) != NEVER {
            self.hold(expr, to);
        }
    }

    /// Register of a value, which is loaded if it is in memory; registers of `keep` are not reused for it.
    fn loaded(&mut self, expr: Expr, keep: &[Expr]) -> Register {
        if let Some(register) = self.value(expr).register {
            return register;
        }
        let from = self.home(expr);
        let to = self.vacant(keep);
        self.out.instructions.push(Instruction::Load { to, from });
        self.hold(expr, to);
        to
    }

    /// A value as second operand: its register; or its slot, unless it is used again before some value that is in a register.
    fn operand(&mut self, expr: Expr, now: usize, beside: Expr) -> Operand {
        if let Some(register) = self.value(expr).register {
            return Operand::Register(register);
        }
        let again = self.uses[self.value(expr).uses.clone()].iter().find(|&&place| place > now).copied();
        let sooner = |again: usize| {
            self.held.iter().any(|held| held.is_none_or(|held| held != beside && self.next_use(held) > again))
        };
        if again.is_some_and(sooner) {
            return Operand::Register(self.loaded(expr, &[beside]));
        }
        Operand::Place(self.home(expr))
    }

    /// Removes this statement's use of its operands, and the values that are not used any more.
    fn used(&mut self, now: usize, operands: [Expr; 2]) {
        for expr in operands {
            if self.next_use(expr) == now {
                self.value_mut(expr).uses.start += 1;
            }
            if self.next_use(expr) != NEVER {
                continue;
            }
            if let Some(register) = self.value_mut(expr).register.take() {
                self.held[usize::from(register)] = None;
            }
            let computed = !matches!(self.program.node(expr), Node::Input(_) | Node::Constant(_));
            if computed && self.value(expr).output.is_none() {
                let home = self.value_mut(expr).home.take();
                self.released.extend(home);
            }
        }
    }

    /// An empty register: a free one, or that of the value whose next use is farthest.
    fn vacant(&mut self, keep: &[Expr]) -> Register {
        if let Some(free) = self.held.iter().position(Option::is_none) {
            return free as Register;
        }
        let candidates = self.held.iter().enumerate().filter_map(|(k, held)| held.map(|held| (k, held)));
        let farthest = candidates.filter(|(_, held)| !keep.contains(held)).max_by_key(|(_, held)| self.next_use(*held));
        // At most two registers are kept, so there is always one.
        let Some((register, expr)) = farthest else { return 0 };
        if self.value(expr).home.is_none() && self.program.number(expr).is_none() {
            let place = self.home(expr);
            self.out.instructions.push(Instruction::Store { to: place, from: register as Register });
        }
        self.held[register] = None;
        self.value_mut(expr).register = None;
        register as Register
    }

    fn hold(&mut self, expr: Expr, register: Register) {
        self.held[usize::from(register)] = Some(expr);
        self.value_mut(expr).register = Some(register);
    }

    /// Slot of a value in memory.
    fn home(&mut self, expr: Expr) -> usize {
        if let Some(place) = self.value(expr).home {
            return place;
        }
        let place = match self.program.node(expr) {
            Node::Input(number) => number as usize,
            Node::Constant(bits) => self.number(f64::from_bits(bits)),
            _ => self.free.pop().unwrap_or_else(|| self.fresh()),
        };
        self.value_mut(expr).home = Some(place);
        place
    }

    fn number(&mut self, number: f64) -> usize {
        let place = self.fresh();
        self.out.numbers.push((place, number));
        place
    }

    fn fresh(&mut self) -> usize {
        self.out.places += 1;
        self.out.places - 1
    }

    fn next_use(&self, expr: Expr) -> usize {
        self.uses[self.value(expr).uses.clone()].first().copied().unwrap_or(NEVER)
    }

    /// Copies the outputs that are inputs or numbers, or that occur twice.
    fn finish(mut self) -> Allocation {
        let spare = 0;
        for (output, &expr) in self.program.outputs().iter().enumerate() {
            let (from, to) = (self.home(expr), self.out.inputs + output);
            if from != to {
                self.out.instructions.push(Instruction::Load { to: spare, from });
                self.out.instructions.push(Instruction::Store { to, from: spare });
            }
        }
        self.out
    }
}
