//! Scalar that records every operation done to it.
//!
//! [`Expr`] is a `Copy` handle into an arena that belongs to the thread while [`trace`] runs. Any public function written
//! on [`Scalar`] can be traced: call it with `Expr` arguments.

pub use super::arena::{Arena, Expr, Node};

use super::arena::Precision;
use super::rules::RuleSet;
use core::cell::RefCell;
use core::ops::{Add, Div, Mul, Neg, Sub};
use dynamics_core::scalar::Label;
use dynamics_core::{Field, Scalar, assign_by_operators};
use num_traits::{One, Zero};

thread_local! {
    static ARENA: RefCell<Arena> = RefCell::new(Arena::with_table(RuleSet::ALL, &[], Precision::Double));
}

/// Runs `function` on a tape, and returns its result and the tape.
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
