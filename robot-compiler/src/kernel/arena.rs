//! Record of a function's operations: nodes, each made from earlier ones.
//!
//! Every operation passes the active rules before it is recorded, and equal expressions are recorded once (hash-consing).
//! So the arena holds only simplified, shared expressions, and no later pass has to look for them.

use super::rules::{RewriteRule, RuleSet};
use dynamics_core::Real;
use dynamics_core::scalar::Label;
use rustc_hash::FxHashMap as HashMap;

/// The precision in which constants are folded. It must be the precision of the kernel; otherwise the bits would differ.
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

    /// Returns `x` rounded to this precision.
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
    /// Index in the arena: an expression comes after all its operands.
    #[must_use]
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

/// Origin of a value.
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
    /// Quotient. The recursions cannot record one, only a function on [`Field`](dynamics_core::Field).
    Div(Expr, Expr),
    /// The negation.
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

    /// True if the node is computed, that is, neither a number nor an input.
    #[must_use]
    pub(super) fn is_statement(self) -> bool {
        !matches!(self, Self::Constant(_) | Self::Input(_))
    }

    /// One or two operands.
    pub fn operands(self) -> impl Iterator<Item = Expr> {
        let (first, second) = match self {
            Self::Constant(_) | Self::Input(_) => (None, None),
            Self::Neg(a) => (Some(a), None),
            Self::Add(a, b) | Self::Sub(a, b) | Self::Mul(a, b) | Self::Div(a, b) => (Some(a), Some(b)),
        };
        first.into_iter().chain(second)
    }
}

/// A rewrite: returns the replacement of a node, if the rule applies.
pub(super) type Rewrite = fn(&mut Arena, Node) -> Option<Expr>;

/// Everything recorded while a function is traced.
#[derive(Clone, Debug)]
pub struct Arena {
    nodes: Vec<Node>,
    index: HashMap<Node, Expr>,
    labels: HashMap<Expr, Label>,
    rules: RuleSet,
    /// Rewrite of each rule: the table of [`super::rewrites`], unless a test replaces one by a wrong rewrite.
    table: &'static [(RewriteRule, Rewrite)],
    precision: Precision,
}

impl Arena {
    /// An empty arena with these rules; `table` gives their rewrites and their order.
    #[must_use]
    pub(super) fn with_table(rules: RuleSet, table: &'static [(RewriteRule, Rewrite)], precision: Precision) -> Self {
        Self { nodes: Vec::new(), index: HashMap::default(), labels: HashMap::default(), rules, table, precision }
    }

    /// Origin of `expr`.
    #[must_use]
    pub fn node(&self, expr: Expr) -> Node {
        self.nodes[expr.index()]
    }

    /// The value of a constant; `None` for any other expression.
    #[must_use]
    pub fn number(&self, expr: Expr) -> Option<f64> {
        match self.node(expr) {
            Node::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    /// Label of the value in the traced function.
    #[must_use]
    pub fn label(&self, expr: Expr) -> Option<Label> {
        self.labels.get(&expr).copied()
    }

    /// Every node, each after its operands.
    #[must_use]
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// A number, rounded to the tape's precision. -0 becomes +0, because `==` does not distinguish them.
    pub fn constant(&mut self, x: f64) -> Expr {
        let x = self.precision.round(x);
        self.write(Node::Constant(if x == 0.0 { 0.0_f64.to_bits() } else { x.to_bits() }))
    }

    /// Records a node through the rules: the first rule that applies gives the replacement.
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

    /// Stores the name of a value; the first name stays.
    pub fn name(&mut self, expr: Expr, label: Label) {
        self.labels.entry(expr).or_insert(label);
    }

    /// Records a node as it is; an equal node that exists already is used instead.
    pub fn write(&mut self, node: Node) -> Expr {
        let shared = self.rules.contains(RewriteRule::Share) || matches!(node, Node::Constant(_) | Node::Input(_));
        if shared && let Some(expr) = self.index.get(&node) {
            return *expr;
        }
        let expr = Expr(u32::try_from(self.nodes.len()).unwrap_or(u32::MAX));
        self.nodes.push(node);
        self.index.insert(node, expr);
        expr
    }
}
