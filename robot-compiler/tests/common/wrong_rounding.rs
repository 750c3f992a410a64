//! Wrong rounding models of single precision; the tests must find their bounds wrong.
#![allow(unreachable_pub, reason = "a module of several test crates")]

use robot_compiler::precision::{Rounding, Single};

/// Single precision with a quarter of its true unit roundoff.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuarterUnit;

impl Rounding for QuarterUnit {
    const UNIT: f64 = Single::UNIT / 4.0;
    const LEAST: f64 = Single::LEAST;
    const MAX: f64 = Single::MAX;
    fn nearest(x: f64) -> f64 {
        Single::nearest(x)
    }
}

/// Single precision whose products are not rounded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FreeProducts;

impl Rounding for FreeProducts {
    const UNIT: f64 = Single::UNIT;
    const LEAST: f64 = Single::LEAST;
    const MAX: f64 = Single::MAX;
    fn nearest(x: f64) -> f64 {
        Single::nearest(x)
    }
    fn of_product(_: f64) -> f64 {
        0.0
    }
}
