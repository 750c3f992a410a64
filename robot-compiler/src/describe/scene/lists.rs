//! Lists with one number per joint.

/// One number per joint. The lengths were checked on loading; a list that is shortened later reads as zero beyond its end.
#[must_use]
pub fn joints<const N: usize>(list: &[f64]) -> [f64; N] {
    std::array::from_fn(|i| list.get(i).copied().unwrap_or(0.0))
}
