//! A traced program as machine code for this processor, for several states at once.
//!
//! A program of the [robot compiler](robot_compiler::kernel) is straight-line arithmetic, so its machine code is one vector instruction per
//! statement: sum, difference, product or quotient of two registers, or of a register and a slot in memory. Each lane of a vector is one
//! state. No multiplication is fused with an addition, so every lane has the bits of [`Program::evaluate`].
//!
//! ```text
//! program --registers--> instructions --encoding--> bytes --memory, made executable--> code
//! ```
//!
//! Eight states are computed in parallel: in one vector of AVX-512, or in two of AVX, one after the other. A kernel of one state computes with single
//! numbers.
//!
//! Other processors, and systems that do not let a program generate code, have no [`Kernel`]: the caller then computes state by state.
//!
//! | module | holds |
//! |---|---|
//! | `registers` | which value is in which register, by Belady's rule |
//! | `encoding` | the bytes of an instruction |
//! | `frame` | inputs, numbers, values without a register, and outputs |
//! | `instructions` | the instruction sets that a processor may have |
//! | `code` | memory that holds the bytes, and the one call into it |
//! | `vectors` | the compiler's code for the same instructions |

#![cfg_attr(
    not(target_arch = "x86_64"),
    allow(
        dead_code,
        unused_imports,
        unfulfilled_lint_expectations,
        reason = "no kernel is ever made for another processor"
    )
)]

mod code;
mod encoding;
mod frame;
mod instructions;
mod registers;
mod vectors;

use code::Code;
use frame::Frame;
pub use instructions::{Instructions, LANES};
use registers::allocate;
use robot_compiler::kernel::Program;
use std::sync::Arc;
pub use vectors::Work;

/// A program that is ready to run on several states at once, with its memory.
///
/// A clone shares the code and has its own memory.
#[derive(Clone, Debug)]
pub struct Kernel {
    code: Arc<Code>,
    instructions: Instructions,
    frame: Frame,
    inputs: usize,
    outputs: usize,
}

impl Kernel {
    /// The program for the widest instructions that this processor has; `inputs` is the number of inputs that the caller will pass.
    /// `None` if it has none of these instruction sets, or the system does not let a program generate code.
    #[must_use]
    pub fn new(program: &Program, inputs: usize) -> Option<Self> {
        Instructions::ALL.into_iter().find_map(|instructions| Self::with(program, inputs, instructions))
    }

    /// The program for one state at a time, in lane 0: [`run_one`](Self::run_one) and [`run`](Self::run) leave the other lanes unchanged.
    #[must_use]
    pub fn of_one(program: &Program, inputs: usize) -> Option<Self> {
        Self::with(program, inputs, Instructions::AvxOne)
    }

    /// The program for these instructions; `None` as in [`Kernel::new`].
    #[must_use]
    pub fn with(program: &Program, inputs: usize, instructions: Instructions) -> Option<Self> {
        if !instructions.are_here() {
            return None;
        }
        let allocation = allocate(program, inputs, instructions.registers());
        let code = Code::new(&allocation, instructions)?;
        let frame = Frame::new(&allocation);
        let (inputs, outputs) = (allocation.inputs, allocation.outputs);
        Some(Self { code: Arc::new(code), instructions, frame, inputs, outputs })
    }

    /// Instructions that the kernel uses.
    #[must_use]
    pub const fn instructions(&self) -> Instructions {
        self.instructions
    }

    /// Size of the code, bytes.
    #[must_use]
    pub fn code_bytes(&self) -> usize {
        self.code.bytes()
    }

    /// Number of inputs.
    #[must_use]
    pub const fn input_count(&self) -> usize {
        self.inputs
    }

    /// All inputs, one after another, each with a number for every lane: number `k` in lane `l` is at `k * LANES + l`. They keep their values until
    /// they are written again.
    #[inline]
    pub fn inputs(&mut self) -> &mut [f64] {
        &mut self.frame.all_mut()[..self.inputs * LANES]
    }

    /// Runs the program on all lanes.
    #[inline]
    pub fn run(&mut self) {
        self.code.run(self.frame.all_mut(), self.instructions.vectors());
    }

    /// Runs the program on lane 0, and on the lanes that share its vector; there is one if the kernel is [of one](Self::of_one) state.
    #[inline]
    pub fn run_one(&mut self) {
        self.code.run(self.frame.all_mut(), 1);
    }

    /// All outputs of the last run, in the layout of the inputs.
    #[inline]
    #[must_use]
    pub fn outputs(&self) -> &[f64] {
        &self.frame.all()[self.inputs * LANES..(self.inputs + self.outputs) * LANES]
    }
}
