//! Functions of an arm's dynamics for one state and for many states at once.
//!
//! One state is computed by the recursions of `dynamics-core`. Many states run through a straight-line program, which the robot
//! compiler makes from the same recursions: each statement of the program is one loop over a [block](kernel::Block) of states,
//! compiled for several instruction sets. The set is chosen at run time.
//!
//! | module | holds |
//! |---|---|
//! | [`arm`] | an arm under gravity, with any number of joints and in two precisions |
//! | [`quantity`] | the functions: their inputs, their outputs, and their evaluation in any scalar |
//! | [`statements`] | from a function to the statements of a program |
//! | [`kernel`] | the program, run on one block of states |
//! | [`batch`] | many states, on one core or on all |
//!
//! # Bits
//! One state and many states give the same bits, on every processor. [`Quantity::InverseDynamics`] has the bits of the recursion. In
//! the results of the other functions, every zero is positive; all other numbers have the bits of the recursion.
#![forbid(unsafe_code)]

pub mod arm;
pub mod batch;
pub mod kernel;
pub mod quantity;
pub mod statements;

pub use arm::{Arm, ArmFloat};
pub use batch::evaluate;
pub use kernel::Float;
pub use quantity::Quantity;
