//! An arm as the texts of its library see it.

use crate::describe::scene::SceneFile;
use crate::kernel::{Function, Precision, Program};

/// Parts from which the texts of a library are made.
pub(super) struct Arm<'a> {
    pub(super) prefix: String,
    pub(super) file: &'a SceneFile,
    pub(super) joints: usize,
    pub(super) precision: Precision,
    pub(super) live: bool,
    /// Inverse dynamics first.
    pub(super) kernels: Vec<(Function, Program)>,
}

impl Arm<'_> {
    /// The type of numbers.
    pub(super) fn real(&self) -> &'static str {
        real(self.precision)
    }

    /// The prefix in capitals, for macros.
    pub(super) fn capitals(&self) -> String {
        self.prefix.to_ascii_uppercase()
    }

    pub(super) fn has_law(&self) -> bool {
        self.kernels.iter().any(|(function, _)| matches!(function, Function::ComputedTorque(_)))
    }
}

/// The name of a precision's type in C.
pub(super) const fn real(precision: Precision) -> &'static str {
    match precision {
        Precision::Single => "float",
        Precision::Double => "double",
    }
}

/// A literal; infinity is the greatest finite number, for which C needs no header.
pub(super) fn finite(x: f64, precision: Precision) -> String {
    match precision {
        Precision::Single => format!("{:?}f", (x as f32).clamp(f32::MIN, f32::MAX)),
        Precision::Double => format!("{:?}", x.clamp(f64::MIN, f64::MAX)),
    }
}
