//! A scalar that writes down what is done to it.
//!
//! [`Expr`] is a `Copy` handle into an arena that belongs to the thread while [`trace`] runs. Any public function written
//! on [`Scalar`] can be traced: call it with `Expr` arguments. Every operation passes the [`super::rules`] in force before
//! it is written down, and equal expressions are written down once (hash-consing), so the arena holds only simplified,
//! shared expressions and no later pass has to look for them.

use super::rules::{self, Rewrite, Rule, RuleSet};
use core::cell::RefCell;
use core::ops::{Add, Div, Mul, Neg, Sub};
use dynamics_core::scalar::Label;
use dynamics_core::{Field, Real, Scalar, assign_by_operators};
use num_traits::{One, Zero};
use rustc_hash::FxHashMap as HashMap;

/// The precision in which constants are folded: the one that the kernel will compute in, or its bits would differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precision {
    /// `f32`
    Single,
    /// `f64`
    Double,
}

impl Precision {
    /// The precision of a scalar.
    #[must_use]
    pub fn of<S: Real>() -> Self {
        // One unit in the last place of f32's 1 is 2^-23: a smaller step is lost there and kept in f64.
        let step = S::literal(1.0 + f64::from(f32::EPSILON) / 4.0);
        if step == S::one() { Self::Single } else { Self::Double }
    }

    /// The name of its type.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Single => "f32",
            Self::Double => "f64",
        }
    }

    /// `x` as this precision holds it.
    #[must_use]
    pub fn round(self, x: f64) -> f64 {
        match self {
            Self::Single => f64::from(x as f32),
            Self::Double => x,
        }
    }
}

/// A value on the tape.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Expr(u32);

impl Expr {
    /// Its place in the arena: an expression comes after everything that it is made of.
    #[must_use]
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

/// How a value comes about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Node {
    /// A number, by its bits in double precision.
    Constant(u64),
    /// The input with this number.
    Input(u32),
    /// Sum.
    Add(Expr, Expr),
    /// Difference.
    Sub(Expr, Expr),
    /// Product.
    Mul(Expr, Expr),
    /// Quotient. The recursions cannot write one down: only a function on [`Field`] can.
    Div(Expr, Expr),
    /// The opposite.
    Neg(Expr),
}

impl Node {
    /// The same operation on other operands.
    #[must_use]
    pub(super) fn map(self, to: impl Fn(Expr) -> Expr) -> Self {
        match self {
            Self::Constant(_) | Self::Input(_) => self,
            Self::Add(a, b) => Self::Add(to(a), to(b)),
            Self::Sub(a, b) => Self::Sub(to(a), to(b)),
            Self::Mul(a, b) => Self::Mul(to(a), to(b)),
            Self::Div(a, b) => Self::Div(to(a), to(b)),
            Self::Neg(a) => Self::Neg(to(a)),
        }
    }

    /// What it is made of, one or two.
    pub fn operands(self) -> impl Iterator<Item = Expr> {
        let (first, second) = match self {
            Self::Constant(_) | Self::Input(_) => (None, None),
            Self::Neg(a) => (Some(a), None),
            Self::Add(a, b) | Self::Sub(a, b) | Self::Mul(a, b) | Self::Div(a, b) => (Some(a), Some(b)),
        };
        first.into_iter().chain(second)
    }
}

/// Everything written down while a function is traced.
#[derive(Clone, Debug)]
pub struct Arena {
    nodes: Vec<Node>,
    index: HashMap<Node, Expr>,
    labels: HashMap<Expr, Label>,
    rules: RuleSet,
    /// What each rule does: [`rules::TABLE`], unless a test puts a wrong one in.
    table: &'static [(Rule, Rewrite)],
    precision: Precision,
}

thread_local! {
    static ARENA: RefCell<Arena> = RefCell::new(Arena::new(RuleSet::ALL, Precision::Double));
}

/// Run `function` on a tape, and take both its result and the tape.
pub fn trace<T>(tape: Arena, function: impl FnOnce() -> T) -> (T, Arena) {
    let before = ARENA.replace(tape);
    let result = function();
    (result, ARENA.replace(before))
}

/// The input with this number. Meaningful inside [`trace`].
#[must_use]
pub fn input(number: u32) -> Expr {
    on_tape(|arena| arena.write(Node::Input(number)))
}

fn on_tape<T>(f: impl FnOnce(&mut Arena) -> T) -> T {
    ARENA.with_borrow_mut(f)
}

impl Arena {
    /// An empty tape.
    #[must_use]
    pub fn new(rules: RuleSet, precision: Precision) -> Self {
        Self {
            nodes: Vec::new(),
            index: HashMap::default(),
            labels: HashMap::default(),
            rules,
            table: &rules::TABLE,
            precision,
        }
    }

    /// The same with other rewrites, to see that a wrong one is found.
    #[cfg(test)]
    pub(super) fn with_table(self, table: &'static [(Rule, Rewrite)]) -> Self {
        Self { table, ..self }
    }

    /// How `expr` comes about.
    #[must_use]
    pub fn node(&self, expr: Expr) -> Node {
        self.nodes[expr.index()]
    }

    /// Its number, if it is one.
    #[must_use]
    pub fn number(&self, expr: Expr) -> Option<f64> {
        match self.node(expr) {
            Node::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    /// What it was called when it was traced.
    #[must_use]
    pub fn label(&self, expr: Expr) -> Option<Label> {
        self.labels.get(&expr).copied()
    }

    /// Every node, each after what it is made of.
    #[must_use]
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The rules in force.
    #[must_use]
    pub fn rules(&self) -> RuleSet {
        self.rules
    }

    /// A number, rounded to the tape's precision; -0 becomes +0, which `==` cannot tell apart.
    pub fn constant(&mut self, x: f64) -> Expr {
        let x = self.precision.round(x);
        self.write(Node::Constant(if x == 0.0 { 0.0_f64.to_bits() } else { x.to_bits() }))
    }

    /// Write a node down through the rules: the first that applies says what stands there instead.
    pub fn make(&mut self, node: Node) -> Expr {
        for &(rule, rewrite) in self.table {
            if self.rules.contains(rule)
                && let Some(instead) = rewrite(self, node)
            {
                return instead;
            }
        }
        self.write(node)
    }

    /// Remember what a value is called; the first name stays.
    pub fn name(&mut self, expr: Expr, label: Label) {
        self.labels.entry(expr).or_insert(label);
    }

    /// Write a node down as it is; one that stands there already is not written again.
    pub fn write(&mut self, node: Node) -> Expr {
        let shared = self.rules.contains(Rule::Share) || matches!(node, Node::Constant(_) | Node::Input(_));
        if shared && let Some(expr) = self.index.get(&node) {
            return *expr;
        }
        let expr = Expr(u32::try_from(self.nodes.len()).unwrap_or(u32::MAX));
        self.nodes.push(node);
        self.index.insert(node, expr);
        expr
    }
}

impl Add for Expr {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        on_tape(|arena| arena.make(Node::Add(self, other)))
    }
}

impl Sub for Expr {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        on_tape(|arena| arena.make(Node::Sub(self, other)))
    }
}

impl Mul for Expr {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        on_tape(|arena| arena.make(Node::Mul(self, other)))
    }
}

impl Div for Expr {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        on_tape(|arena| arena.make(Node::Div(self, other)))
    }
}

impl Neg for Expr {
    type Output = Self;
    fn neg(self) -> Self {
        on_tape(|arena| arena.make(Node::Neg(self)))
    }
}

assign_by_operators!(Expr);

impl Zero for Expr {
    fn zero() -> Self {
        Self::literal(0.0)
    }
    fn is_zero(&self) -> bool {
        on_tape(|arena| arena.number(*self)) == Some(0.0)
    }
}

impl One for Expr {
    fn one() -> Self {
        Self::literal(1.0)
    }
}

impl Field for Expr {}

impl Scalar for Expr {
    fn literal(x: f64) -> Self {
        on_tape(|arena| arena.constant(x))
    }

    fn labelled(self, label: Label) -> Self {
        on_tape(|arena| arena.name(self, label));
        self
    }
}
