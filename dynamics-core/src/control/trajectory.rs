//! Reference motions.
