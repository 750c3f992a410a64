//! What robots and scenes are: their types, what is checked of them, and the numbers of the core that they stand for.
//!
//! Nothing here knows what a file looks like.

pub(crate) mod diagnostics;
mod dof;
pub mod drive;
mod hash;
pub(crate) mod linkage;
pub(crate) mod robot;
pub mod scene;
