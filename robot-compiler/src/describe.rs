//! Robots and scenes as data: their types, their checks, and their conversion to the numbers of the core.
//!
//! No module here depends on a file format.

pub(crate) mod cut;
pub(crate) mod diagnostics;
mod dof;
pub(crate) mod draft;
pub mod drive;
pub(crate) mod friction;
mod hash;
pub(crate) mod link_shape;
pub(crate) mod linkage;
pub(crate) mod robot;
pub mod scene;
mod snippet;
pub(crate) mod study;
