//! Lists with a number per joint.

/// One number per joint. Loading has checked the lengths; a list that was changed since reads as zero where it is short.
pub(super) fn joints<const N: usize>(list: &[f64]) -> [f64; N] {
    std::array::from_fn(|i| list.get(i).copied().unwrap_or(0.0))
}
