//! Lists with one number per joint.

/// One number per joint. Loading has checked the lengths; a list shortened later reads as zero beyond its end.
#[must_use]
pub fn joints<const N: usize>(list: &[f64]) -> [f64; N] {
    std::array::from_fn(|i| list.get(i).copied().unwrap_or(0.0))
}
