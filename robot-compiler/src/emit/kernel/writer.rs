//! The statements of a program as Rust or C.

use crate::kernel::inputs::input_name;
use crate::kernel::tape::{Expr, Node};
use crate::kernel::{Precision, Program};
use crate::names::Named;
use std::collections::{HashMap, HashSet};

/// Programming language of a kernel's source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// `no_std` Rust.
    Rust,
    /// C99. Live inputs and the reference are pointers.
    C,
}

impl Named for Language {
    const NAMES: &'static [(&'static str, &'static str, Self)] =
        &[("rust", "`no_std` Rust", Self::Rust), ("c", "C99, with a header for C++", Self::C)];
}

/// Names for the values of a program.
pub(in crate::emit) struct Writer<'a> {
    program: &'a Program,
    names: HashMap<Expr, String>,
    /// Numbers declared at the top, in order of their first use.
    hoisted: Vec<Expr>,
    joints: usize,
    precision: Precision,
    language: Language,
}

impl<'a> Writer<'a> {
    /// Names the values: a labelled value by its label, `w3_z`; any other by its position in the order, `t17`.
    ///
    /// With `hoist`, numbers are declared at the top as `c3`, through `S::literal`, so that the statements stay readable.
    pub(in crate::emit) fn new(
        program: &'a Program,
        joints: usize,
        precision: Precision,
        hoist: bool,
        language: Language,
    ) -> Self {
        let mut names = HashMap::new();
        let mut taken: HashMap<String, usize> = HashMap::new();
        let mut plain = 0;
        for &expr in program.order() {
            let name = program.label(expr).map_or_else(
                || {
                    plain += 1;
                    format!("t{plain}")
                },
                |label| format!("{}{}_{}", label.symbol, label.link, label.axis),
            );
            // A quantity may be computed several times, for one column of a matrix after another.
            let times = taken.entry(name.clone()).and_modify(|n| *n += 1).or_insert(1);
            let name = if *times == 1 { name } else { format!("{name}{times}") };
            names.insert(expr, name);
        }
        let mut hoisted = Vec::new();
        if hoist {
            let operands = program.order().iter().flat_map(|&expr| program.node(expr).operands());
            for number in operands.chain(program.outputs().iter().copied()).filter(|&e| program.number(e).is_some()) {
                names.entry(number).or_insert_with(|| {
                    hoisted.push(number);
                    format!("c{}", hoisted.len())
                });
            }
        }
        Self { program, names, hoisted, joints, precision, language }
    }

    pub(in crate::emit) fn statements(&self, pad: &str) -> String {
        let mut text = String::new();
        for &number in &self.hoisted {
            let value = self.program.number(number).map_or_else(String::new, |x| self.argument(x));
            text += &format!("{pad}let {} = S::literal({value});\n", self.value(number));
        }
        let mut announced = HashSet::new();
        let (declare, open, close) = match (self.language, self.precision) {
            (Language::Rust, _) => ("let", "//", ""),
            (Language::C, Precision::Single) => ("const float", "/*", " */"),
            (Language::C, Precision::Double) => ("const double", "/*", " */"),
        };
        for &expr in self.program.order() {
            if let Some(label) = self.program.label(expr) {
                let pass = if matches!(label.symbol, "f" | "n") { "Inward" } else { "Outward" };
                if announced.insert((pass, label.link)) {
                    text += &format!("{pad}{open} {pass}: link {}.{close}\n", label.link);
                }
            }
            let (a, b, operator) = match self.program.node(expr) {
                Node::Add(a, b) => (a, b, "+"),
                Node::Sub(a, b) => (a, b, "-"),
                Node::Mul(a, b) => (a, b, "*"),
                Node::Div(a, b) => (a, b, "/"),
                Node::Neg(a) => {
                    text += &format!("{pad}{declare} {} = -{};\n", self.value(expr), self.value(a));
                    continue;
                }
                Node::Constant(_) | Node::Input(_) => continue,
            };
            text += &format!("{pad}{declare} {} = {} {operator} {};\n", self.value(expr), self.value(a), self.value(b));
        }
        text
    }

    pub(in crate::emit) fn value(&self, expr: Expr) -> String {
        if let Some(name) = self.names.get(&expr) {
            return name.clone();
        }
        match self.program.node(expr) {
            Node::Constant(bits) => self.literal(f64::from_bits(bits)),
            Node::Input(number) => match self.language {
                Language::Rust => input_name(number, self.joints),
                Language::C => by_pointer(&input_name(number, self.joints)),
            },
            // Nodes that are statements have names.
            Node::Add(..) | Node::Sub(..) | Node::Mul(..) | Node::Div(..) | Node::Neg(_) => String::new(),
        }
    }

    /// The shortest decimal that reads back as the same number.
    fn literal(&self, x: f64) -> String {
        let suffix = if self.language == Language::C { "f" } else { "" };
        match self.precision {
            Precision::Single => format!("{:?}{suffix}", x as f32),
            Precision::Double => format!("{x:?}"),
        }
    }

    /// The number as an argument of `S::literal`, which takes an f64. A short decimal of an f32 might be rounded to another
    /// f32 on this path; such a number is written with all digits.
    fn argument(&self, x: f64) -> String {
        let short = self.literal(x);
        let read = short.parse::<f64>().unwrap_or(x);
        match self.precision {
            Precision::Single if (read as f32).to_bits() != (x as f32).to_bits() => format!("{x:?}"),
            Precision::Single | Precision::Double => short,
        }
    }
}

/// `live->gravity.x` for `live.gravity.x`.
fn by_pointer(name: &str) -> String {
    for structure in ["live", "reference"] {
        if let Some(field) = name.strip_prefix(structure).and_then(|rest| rest.strip_prefix('.')) {
            return format!("{structure}->{field}");
        }
    }
    name.to_owned()
}
